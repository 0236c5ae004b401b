"""Passing touches: what a dancing hand brushes on its way to what it is meant to touch."""

from __future__ import annotations

from collections.abc import Mapping

from pipeline.simulation.take import SoundEvent
from pipeline.spec.dance import BODY_PLACES, Dance
from pipeline.spec.scene import Scene
from pipeline.spec.script import Perform

PARTS: Mapping[str, str] = {
    "shoulder": "yoke",
    "head": "head",
    "nape": "neck",
    "chest": "breast",
    "belly": "belly",
    "ribs": "ribs",
    "low_ribs": "ribs",
    "hip": "pelvis",
}
"""Parts of a dancer's body by the start of the names of places on it."""

LIMBS = frozenset(
    f"{part}_{side}" for part in ("upper_arm", "forearm", "thigh", "shin") for side in "lr"
)
"""Parts of its limbs, on which no place is."""


HANDS = frozenset({"hand_l", "hand_r"})
"""Its hands."""


def touched_parts(scene: Scene) -> dict[str, frozenset[str]]:
    """Return the parts of their own body that dances touch, by the name of who dances them."""
    named = [(member.name, member.dance) for _, member in scene.dancers]
    named += [
        (instruction.who, instruction.do.dance)
        for instruction in scene.script
        if isinstance(instruction.do, Perform)
    ]
    touched = dict[str, frozenset[str]]()
    for name, dance in named:
        if name is not None and dance in scene.dances:
            parts = _touched_by(scene.dances[dance])
            touched[name] = touched.get(name, frozenset()) | parts
    return touched


def _touched_by(dance: Dance) -> frozenset[str]:
    """Return the parts of the body that a dance touches."""
    places = {task.touch for task in dance.subtasks if task.touch in BODY_PLACES}
    parts = {
        part
        for place in places
        for start, part in PARTS.items()
        if place is not None and place.startswith(start)
    }
    # Hands clap where they reach for places in the air.
    hands = HANDS if any(task.reach is not None for task in dance.subtasks) else frozenset[str]()
    return hands | parts


def is_passing(event: SoundEvent, touched: Mapping[str, frozenset[str]]) -> bool:
    """Return whether a dancing hand meets a part of its own body that its dances never touch.

    Args:
        event: of the take.
        touched: see `touched_parts`.
    """
    own = f"{event.who}."
    other = event.other.removeprefix(own)
    is_hand = event.part.removeprefix(own).startswith("hand_")
    if not is_hand or event.who not in touched or other not in {*PARTS.values(), *LIMBS, *HANDS}:
        return False
    return other not in touched[event.who]
