"""Repertoire: all that a dancer does in a scene: its dance, others that it is told, its poses.

One torso has the places of all of it, and one row numbers the subtasks: those of its own dance
first, so that who is told nothing has that alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from pipeline.errors import Problem, SceneError
from pipeline.simulation.dancers.dance_goals import (
    HANGING_ANGLES,
    Choreography,
    PlacedSubtask,
    ReadyPlaces,
    build_choreography,
    placed_subtasks,
)
from pipeline.simulation.dancers.dancer_poses import Place, Poses, pose_moves
from pipeline.simulation.dancers.reachability import unreachable_places
from pipeline.simulation.dancers.torso import ARM, HANDS, WRIST
from pipeline.simulation.people.proportions import Proportions
from pipeline.spec.dance import Dance, Drum, Hand, Subtask
from pipeline.spec.dancer import Dancer
from pipeline.spec.script import Do, Instruction, Perform, Reach

SIDES: Mapping[str, tuple[Hand, ...]] = {"right": ("r",), "left": ("l",), "both": ("r", "l")}
"""Hands, by what the script calls them."""


@dataclass(frozen=True, eq=False)
class Repertoire:
    """What a dancer does.

    Attributes:
        dances: that it may dance, its own first, by name.
        first: number of the first subtask of each.
        drums: that stand before it.
        hang: side -> number of the subtask that lets the arm hang; empty if nothing can ask it.
        told: (place as told, side) -> number of the subtask that holds a hand there.
        poses: that it takes at certain times.
        choreography: all of it, on its person.
    """

    dances: Mapping[str, Dance]
    first: Mapping[str, int]
    drums: Mapping[str, Drum]
    hang: Mapping[str, int]
    told: Mapping[tuple[Place, str], int]
    poses: Poses
    choreography: Choreography


def build_repertoire(
    member: Dancer,
    who: Proportions,
    dances: Mapping[str, Dance],
    script: Sequence[Instruction],
    directed: bool,
    own: Callable[[Place], Place],
    path: str,
) -> Repertoire:
    """Return what a dancer does.

    Args:
        member: its words.
        who: the person.
        dances: of the scene, by name.
        script: of the scene.
        directed: whether more may be asked from outside.
        own: from a place in the world to where that is as the dancer stands [m].
        path: of the dancer in the scene, for messages.

    Raises:
        SceneError: a place is out of reach or where no arm goes, or two dances have different
            drums of one name.
    """
    asked = {i: one.do for i, one in enumerate(script) if one.who == member.name}
    known = _known(member, dances, asked.values(), bool(asked) or directed)
    drums = _drums(known)
    parts, first = list[PlacedSubtask](), dict[str, int]()
    for name, dance in known.items():
        first[name] = len(parts)
        parts += placed_subtasks(dance, name)
    told, hang = dict[tuple[Place, str], int](), dict[str, int]()
    for (place, side), said in sorted(_reaches(asked).items()):
        told[place, side] = len(parts)
        words = Subtask.model_construct(hand=side, reach=own(place))
        parts.append(PlacedSubtask(said, words, still=True, said=said))
    poses, posed = pose_moves(member.pose, who, own, len(parts), f"{path}.pose")
    parts += posed
    if asked or directed or member.pose:
        hang = {side: len(parts) + k for k, side in enumerate(HANDS)}
        parts += [PlacedSubtask(path, words) for words in _hanging()]
    ready = ReadyPlaces(f"dances.{member.dance}", dances[member.dance].ready)
    choreography = build_choreography(who, parts, drums, ready, member.compensate_gravity)
    refused = list(unreachable_places(choreography, parts, ready.path))
    if refused:
        raise SceneError(refused)
    return Repertoire(known, first, drums, hang, told, poses, choreography)


def _known(
    member: Dancer, dances: Mapping[str, Dance], asked: Iterable[Do], may: bool
) -> dict[str, Dance]:
    """Return the dances that a dancer may dance, its own first.

    Drums stand before it from the begin: only for dances that its script names. All others of
    the scene are learnt by whoever may be told anything, in one order whoever tells it when, so
    that what is told from outside goes the same way when it is written into the scene.
    """
    named = {do.dance for do in asked if isinstance(do, Perform)}
    others = sorted(name for name in dances if may and (name in named or not dances[name].drums))
    return {name: dances[name] for name in dict.fromkeys([member.dance, *others])}


def _reaches(asked: Mapping[int, Do]) -> dict[tuple[Place, Hand], str]:
    """Return the places that hands are told to reach, with the path of what says so first."""
    found = dict[tuple[Place, Hand], str]()
    for i, do in asked.items():
        if isinstance(do, Reach) and not isinstance(do.reach, str):
            for side in SIDES[do.hand]:
                found.setdefault((do.reach, side), f"script[{i}].do.reach")
    return found


def _drums(dances: Mapping[str, Dance]) -> dict[str, Drum]:
    """Return all drums of several dances.

    Raises:
        SceneError: two that differ have one name.
    """
    found, whose = dict[str, Drum](), dict[str, str]()
    for name, dance in dances.items():
        for drum, words in dance.drums.items():
            if found.setdefault(drum, words) != words:
                message = f"is another in '{whose[drum]}', which is danced by the same; rename one"
                raise SceneError([Problem(f"dances.{name}.drums.{drum}", message)])
            whose.setdefault(drum, name)
    return found


def _hanging() -> Iterable[Subtask]:
    """Return the subtasks that let the arms hang, in the order of `HANDS`."""
    angles = {f"{joint}_deg": HANGING_ANGLES.get(joint, 0.0) for joint in (*ARM, *WRIST)}
    return [Subtask.model_construct(hand=side, joints=angles) for side in ("r", "l")]
