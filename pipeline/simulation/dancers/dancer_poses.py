"""Dancer poses: targets of hands and joints at given times, which override the dance."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from pipeline.errors import SceneError
from pipeline.simulation.dancers.dance_goals import PlacedSubtask
from pipeline.simulation.dancers.reach_limits import beyond_limits
from pipeline.simulation.people.proportions import JOINTS, Proportions
from pipeline.spec.dance import Hand, Subtask
from pipeline.spec.dancer import ARMS, TRUNK, side_of
from pipeline.spec.keyframes import PoseKey

Place = tuple[float, float, float]

BOTH: tuple[Hand, ...] = ("r", "l")

TRUNK_LEAD = 0.3
"""Time by which waist and neck start ahead of a pose, about their lag [s]."""


@dataclass(frozen=True, slots=True)
class PoseMove:
    """A hand moves to a pose, or back to the dance.

    Attributes:
        begin: start [s].
        land: arrival [s].
        subtask: number of its subtask; None for back to the dance.
    """

    begin: float
    land: float
    subtask: int | None


@dataclass(frozen=True, slots=True)
class Poses:
    """All poses of a dancer.

    Attributes:
        hands: side -> its moves, in order of time.
        trunk: (time [s], joint -> angle of waist and neck [rad]); None for back to the dance.
    """

    hands: Mapping[str, Sequence[PoseMove]] = field(default_factory=dict)
    trunk: Sequence[tuple[float, Mapping[str, float] | None]] = ()


def pose_moves(
    keys: Sequence[PoseKey],
    person: Proportions,
    own: Callable[[Place], Place],
    first: int,
    path: str,
) -> tuple[Poses, list[PlacedSubtask]]:
    """Returns the poses of a dancer and their subtasks.

    Args:
        keys: pose keys of the scene.
        person: proportions of the person.
        own: converts a world position to the dancer's frame [m].
        first: number of the first subtask.
        path: path of the poses in the scene, for messages.

    Raises:
        SceneError: if an angle is beyond the limits of its joint.
    """
    problems = [
        problem
        for k, key in enumerate(keys)
        for problem in beyond_limits(key.joints or {}, f"{path}[{k}]")
    ]
    if problems:
        raise SceneError(problems)
    parts, hands = list[PlacedSubtask](), dict[str, list[PoseMove]]()
    trunk = list[tuple[float, Mapping[str, float] | None]]()
    order = sorted(range(len(keys)), key=lambda k: keys[k].at)
    for side in BOTH:
        held, last, rows = False, 0.0, hands.setdefault(side, [])
        for k in order:
            key = keys[k]
            if key.release is not None and ARMS.get(key.release) == side and held:
                rows.append(PoseMove(key.at, key.at + key.blend, None))
                held, last = False, key.at
            subtask = _hand_subtask(key, side, person, own)
            if subtask is None:
                continue
            # The first pose blends in; later ones start where the previous ended.
            begin = last if held else max(key.at - key.blend, last)
            rows.append(PoseMove(begin, key.at, first + len(parts)))
            at = f"{path}[{k}]"
            parts.append(PlacedSubtask(at, subtask, is_fixed=True, place_path=f"{at}.reach"))
            held, last = True, key.at
    for at, some in groupby(order, key=lambda k: keys[k].at):
        for k in some:
            angles = {
                joint.removesuffix("_deg"): math.radians(value)
                for joint, value in (keys[k].joints or {}).items()
                if not side_of(joint)
            }
            if angles:
                trunk.append((max(at - TRUNK_LEAD, 0.0), angles))
            if keys[k].release == TRUNK:
                trunk.append((at, None))
    return Poses(hands, sorted(trunk, key=lambda row: row[0])), parts


def _hand_subtask(
    key: PoseKey, side: Hand, person: Proportions, own: Callable[[Place], Place]
) -> Subtask | None:
    """Returns the subtask of a pose key for a hand; None if it has none."""
    angles = {}
    for joint, value in (key.joints or {}).items():
        if side_of(joint) == side:
            stem, _, what = joint.split("_", 2)
            angles[f"{stem}_{what}"] = value
    limb = ARMS.get(key.limb or key.node or "")
    if key.reach is not None and limb == side:
        place = key.reach
        if key.frame == "world":
            place = own(place)
        elif key.frame == "body":
            x, y, z = (np.array(place) + person.rest()[JOINTS.index("pelvis")]).tolist()
            place = x, y, z
        return Subtask.model_construct(hand=side, reach=place, joints=angles)
    if not angles:
        return None
    # Angles need servos, whatever controller the dance uses.
    return Subtask.model_construct(hand=side, joints=angles, controller="joint-torque")
