"""Repertoire: everything a dancer does in a scene: its dance, requested dances, reaches and poses.

One torso holds all the sites. Subtasks are numbered in one sequence, starting with the dancer's own
dance.
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
from pipeline.simulation.spatial import Array
from pipeline.spec.dance import Dance, Drum, Hand, Subtask
from pipeline.spec.dancer import Dancer
from pipeline.spec.model_base import Target
from pipeline.spec.script import Do, Perform, Reach

SIDES: Mapping[str, tuple[Hand, ...]] = {"right": ("r",), "left": ("l",), "both": ("r", "l")}
"""Sides of the hands by their names in scripts."""


@dataclass(frozen=True, eq=False)
class Repertoire:
    """Everything a dancer does.

    Attributes:
        dances: dances by name, the dancer's own first.
        first: number of the first subtask of each dance.
        drums: drums by name.
        hang: side -> number of the subtask that lets the arm hang; empty if it is never needed.
        reaches: (place or its name, side) -> number of the subtask that holds a hand there.
        poses: poses at given times.
        choreography: all subtasks on the person.
    """

    dances: Mapping[str, Dance]
    first: Mapping[str, int]
    drums: Mapping[str, Drum]
    hang: Mapping[str, int]
    reaches: Mapping[tuple[Target, str], int]
    poses: Poses
    choreography: Choreography


def build_repertoire(
    member: Dancer,
    person: Proportions,
    dances: Mapping[str, Dance],
    orders: Sequence[tuple[str, Do]],
    directed: bool,
    places: Mapping[str, Array],
    own: Callable[[Place], Place],
    path: str,
) -> Repertoire:
    """Returns the repertoire of a dancer.

    Args:
        member: the dancer in the scene.
        person: proportions of the person.
        dances: dances of the scene by name.
        orders: to the dancer by the scene, with the paths of their instructions.
        directed: whether instructions may come from outside.
        places: named places (3,) of the scene [m].
        own: converts a world position to the dancer's frame [m].
        path: path of the dancer in the scene, for messages.

    Raises:
        SceneError: A place cannot be reached, or two dances have different drums of one name.
    """
    known = _known(member, dances, (do for _, do in orders), bool(orders) or directed)
    drums = _drums(known)
    parts, first = list[PlacedSubtask](), dict[str, int]()
    for name, dance in known.items():
        first[name] = len(parts)
        parts += placed_subtasks(dance, name)
    reaches, hang = dict[tuple[Target, str], int](), dict[str, int]()
    for (target, side), place_path in sorted(_reaches(orders).items(), key=_reach_order):
        reaches[target, side] = len(parts)
        x, y, z = places[target].tolist() if isinstance(target, str) else target
        subtask = Subtask.model_construct(hand=side, reach=own((x, y, z)))
        parts.append(PlacedSubtask(place_path, subtask, is_fixed=True, place_path=place_path))
    poses, posed = pose_moves(member.pose, person, own, len(parts), f"{path}.pose")
    parts += posed
    if orders or directed or member.pose:
        hang = {side: len(parts) + k for k, side in enumerate(HANDS)}
        parts += [PlacedSubtask(path, subtask) for subtask in _hanging()]
    ready = ReadyPlaces(f"dances.{member.dance}", dances[member.dance].ready)
    choreography = build_choreography(person, parts, drums, ready, member.compensate_gravity)
    refused = list(unreachable_places(choreography, parts, ready.path))
    if refused:
        raise SceneError(refused)
    return Repertoire(known, first, drums, hang, reaches, poses, choreography)


def _known(
    member: Dancer, dances: Mapping[str, Dance], orders: Iterable[Do], may: bool
) -> dict[str, Dance]:
    """Returns the dances that a dancer may dance, its own first.

    Dances with drums count only if the script names them, since drums exist from the start. All
    others count for every dancer that may get instructions, in a fixed order, so that instructions
    from outside give the same motion as the same script.
    """
    named = {do.dance for do in orders if isinstance(do, Perform)}
    others = sorted(name for name in dances if may and (name in named or not dances[name].drums))
    return {name: dances[name] for name in dict.fromkeys([member.dance, *others])}


def _reaches(orders: Iterable[tuple[str, Do]]) -> dict[tuple[Target, Hand], str]:
    """Returns the places that instructions reach for, with the path of the first one."""
    found = dict[tuple[Target, Hand], str]()
    for path, do in orders:
        if isinstance(do, Reach):
            for side in SIDES[do.hand]:
                found.setdefault((do.reach, side), f"{path}.do.reach")
    return found


def _reach_order(reach: tuple[tuple[Target, Hand], str]) -> tuple[bool, tuple[Target, Hand]]:
    """Returns the rank of a reach: places by their coordinates, then those with names."""
    return isinstance(reach[0][0], str), reach[0]


def _drums(dances: Mapping[str, Dance]) -> dict[str, Drum]:
    """Returns the drums of several dances.

    Raises:
        SceneError: Different drums have one name.
    """
    found, owners = dict[str, Drum](), dict[str, str]()
    for name, dance in dances.items():
        for drum, config in dance.drums.items():
            if found.setdefault(drum, config) != config:
                message = f"conflicts with the drum of '{owners[drum]}'; rename one"
                raise SceneError([Problem(f"dances.{name}.drums.{drum}", message)])
            owners.setdefault(drum, name)
    return found


def _hanging() -> Iterable[Subtask]:
    """Returns the subtasks that let the arms hang, in the order of `HANDS`."""
    angles = {f"{joint}_deg": HANGING_ANGLES.get(joint, 0.0) for joint in (*ARM, *WRIST)}
    return [Subtask.model_construct(hand=side, joints=angles) for side in ("r", "l")]
