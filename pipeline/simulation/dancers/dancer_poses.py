"""Posing: where hands and joints of a dancer are to be at certain times, whatever it dances."""

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

SOON = 0.3
"""How long waist and neck take to come where they are to be, about [s]."""


@dataclass(frozen=True, slots=True)
class PoseMove:
    """A hand goes to where it is posed, or back to what it did.

    Attributes:
        begin: when it sets out [s].
        land: when it is to be there [s].
        subtask: its number among all; None for back.
    """

    begin: float
    land: float
    subtask: int | None


@dataclass(frozen=True, slots=True)
class Poses:
    """All poses of a dancer.

    Attributes:
        hands: side -> its moves, in the order of time.
        trunk: when waist and neck go where: joint -> angle [rad], None for back [s].
    """

    hands: Mapping[str, Sequence[PoseMove]] = field(default_factory=dict)
    trunk: Sequence[tuple[float, Mapping[str, float] | None]] = ()


def pose_moves(
    keys: Sequence[PoseKey],
    who: Proportions,
    own: Callable[[Place], Place],
    first: int,
    path: str,
) -> tuple[Poses, list[PlacedSubtask]]:
    """Return the poses of a dancer, and the subtasks that they consist of.

    Args:
        keys: what its author wrote.
        who: the person.
        own: from a place in the world to where that is as the dancer stands [m].
        first: number of the first subtask.
        path: of the pose in the scene, for messages.

    Raises:
        SceneError: an angle is beyond what its joint does.
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
            words = _of_hand(key, side, who, own)
            if words is None:
                continue
            # The first takes over, the others follow one another.
            begin = last if held else max(key.at - key.blend, last)
            rows.append(PoseMove(begin, key.at, first + len(parts)))
            at = f"{path}[{k}]"
            parts.append(PlacedSubtask(at, words, still=True, said=f"{at}.reach"))
            held, last = True, key.at
    for at, some in groupby(order, key=lambda k: keys[k].at):
        for k in some:
            angles = {
                joint.removesuffix("_deg"): math.radians(value)
                for joint, value in (keys[k].joints or {}).items()
                if not side_of(joint)
            }
            if angles:
                trunk.append((max(at - SOON, 0.0), angles))
            if keys[k].release == TRUNK:
                trunk.append((at, None))
    return Poses(hands, sorted(trunk, key=lambda row: row[0])), parts


def _of_hand(
    key: PoseKey, side: Hand, who: Proportions, own: Callable[[Place], Place]
) -> Subtask | None:
    """Return what a key asks of a hand, None for nothing."""
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
            x, y, z = (np.array(place) + who.rest()[JOINTS.index("pelvis")]).tolist()
            place = x, y, z
        return Subtask.model_construct(hand=side, reach=place, joints=angles)
    if not angles:
        return None
    # Angles are for servos, whatever moves the arm else.
    return Subtask.model_construct(hand=side, joints=angles, controller="joint-torque")
