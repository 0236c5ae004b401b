"""Idle motion: tails and feelers that sway with the gait and never quite rest.

The legs carry a creature; what else it has sways with its gait and wanders a little
of its own accord. Where heads look is said by `gaze`, what trails behind by `overlap`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.network import ARM, FEELER, HEAD, LEG, TAIL
from pipeline.simulation.figures.skeleton import BODY, Limb
from pipeline.simulation.locomotion.body_motion.follow_through import (
    FreeLimb,
    SoftJointLimits,
)
from pipeline.simulation.locomotion.gaits.moods import MotionStyle
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array

SWAY = {
    (TAIL, "yaw"): (0.09, 1.0),
    (TAIL, "pitch"): (0.03, 2.0),
    (ARM, "pitch"): (0.32, 1.0),
    (ARM, "bend"): (0.06, 1.0),
}
"""With the gait: amplitude [rad] and how many times a cycle."""

WANDER = {
    (HEAD, "yaw"): 0.05,
    (HEAD, "pitch"): 0.03,
    (FEELER, "yaw"): 0.20,
    (FEELER, "pitch"): 0.16,
    (FEELER, "bend"): 0.10,
}
"""Of its own accord: amplitude [rad]. Heads wander as a whole, in where they look."""

SLOW, FAST = 0.25, 0.95
"""Range of the frequencies of wandering [1/s]."""


@dataclass(frozen=True, eq=False)
class FreeJoints:
    """The joints of a herd that carry nothing, as arrays (M,).

    Attributes:
        tree: these joints.
        owner: creature of each.
        names: such as "bug.head.base_yaw".
        number: its number in its own figure's skeleton.
        room: what they may do.
        limbs: which of them make up a limb.
        sway, lag, times: how far they go with the gait [rad], by which part of a cycle later,
            and how many times a cycle.
        wander, frequency, offset: how far they go of their own accord [rad], how often a
            second, and where they begin [rad].
        raises: whether they raise a tail.
    """

    tree: JointTree
    owner: NDArray[np.int64]
    names: tuple[str, ...]
    number: NDArray[np.int64]
    room: SoftJointLimits
    limbs: tuple[FreeLimb, ...]
    sway: Array
    lag: Array
    times: Array
    wander: Array
    frequency: Array
    offset: Array
    raises: NDArray[np.bool_]

    @property
    def numbers(self) -> dict[tuple[int, int], int]:
        """Creature and number of a joint in its skeleton -> number of the joint here."""
        pairs = zip(self.owner.tolist(), self.number.tolist(), strict=True)
        return {pair: i for i, pair in enumerate(pairs)}

    def sways(self, phase: Array, drive: Array, bearing: MotionStyle) -> Array:
        """Return what the joints (n, M) do with the gait and to hold a tail up [rad].

        Args:
            phase: (n, C) of the creatures' gaits.
            drive: (n, C) part of their speed at which they go: who rests does not sway.
            bearing: (n, C).
        """
        own = self.owner
        strength = (bearing.sway * np.minimum(drive, 1.0))[:, own] * self.sway
        result: Array = strength * np.sin(2.0 * np.pi * self.times * (phase[:, own] - self.lag))
        result += self.raises * bearing.tail_raise[:, own]
        return result

    def wanders(self, time: Array, bearing: MotionStyle) -> Array:
        """Return what the joints (n, M) do of their own accord [rad].

        Args:
            time: (n,) since the start [s].
            bearing: (n, C).
        """
        # Two waves of incommensurable length never come round.
        angle = 2.0 * np.pi * self.frequency * time[:, None] + self.offset
        waves = 0.65 * np.sin(angle) + 0.35 * np.sin(1.618 * angle + 1.0)
        result: Array = bearing.wander[:, self.owner] * self.wander * waves
        return result


def collect_free_joints(herd: Herd, seed: int) -> FreeJoints:
    """Collect all joints that belong to no leg.

    Args:
        herd: the creatures; each draws its own chances, by its name.
        seed: of the scene.
    """
    names, figures = herd.names, herd.figures
    rows: list[tuple[int, int, int, str, str]] = []  # creature, joint, parent, kind, turn
    limbs, lags = list[FreeLimb](), list[float]()
    for c, figure in enumerate(figures):
        skeleton = figure.skeleton
        place = {}
        for limb in (limb for limb in skeleton.limbs if limb.kind != LEG):
            first = len(rows)
            for j in limb.joints:
                parent = int(skeleton.parents[j])
                place[j] = len(rows)
                turn = skeleton.joint_names[j].rsplit("_", 1)[1]
                rows.append((c, j, place.get(parent, BODY), limb.kind, turn))
            turns = [turn for *_, turn in rows[first:]]
            own = range(first, len(rows))
            limbs.append(FreeLimb(limb.kind, own, turns, limb.tip, limb.length, limb.tip_radius))
            lags += [_lag(herd, c, limb)] * len(own)
    skeletons = [figures[c].skeleton for c, *_ in rows]
    number = np.array([j for _, j, *_ in rows], dtype=np.int64)

    def taken(field: str, *shape: int) -> Array:
        values = [getattr(s, field)[j] for s, j in zip(skeletons, number, strict=True)]
        return np.array(values, dtype=float).reshape(len(rows), *shape)

    kinds = [(kind, turn) for *_, kind, turn in rows]
    chances = [
        generator(seed, f"{names[c]}.idle.{s.joint_names[j]}").random(2)
        for (c, j, *_), s in zip(rows, skeletons, strict=True)
    ]
    chance = np.array(chances).reshape(-1, 2)
    return FreeJoints(
        tree=JointTree(
            np.array([parent for _, _, parent, *_ in rows], dtype=np.int64),
            taken("axes", 3),
            taken("places", 3),
            taken("prismatic").astype(bool),
        ),
        owner=np.array([c for c, *_ in rows], dtype=np.int64),
        names=tuple(
            f"{names[c]}.{s.joint_names[j]}" for (c, j, *_), s in zip(rows, skeletons, strict=True)
        ),
        number=number,
        room=SoftJointLimits(taken("lower"), taken("preferred"), taken("upper")),
        limbs=tuple(limbs),
        sway=np.array([SWAY.get(k, (0.0, 1.0))[0] for k in kinds]),
        lag=np.array(lags),
        times=np.array([SWAY.get(k, (0.0, 1.0))[1] for k in kinds]),
        wander=np.array([WANDER.get(k, 0.0) for k in kinds]),
        frequency=SLOW + (FAST - SLOW) * chance[:, 0],
        offset=2.0 * np.pi * chance[:, 1],
        raises=np.array([k == (TAIL, "pitch") for k in kinds], dtype=bool),
    )


def _lag(herd: Herd, c: int, limb: Limb) -> float:
    """Return when a limb comes forward in the cycle, a quarter early: an arm with the other leg."""
    other = {"l": "r", "r": "l"}.get(limb.side)
    legs = np.flatnonzero((herd.owner == c) & (limb.kind == ARM))
    across = [leg for leg in legs if herd.leg_names[leg][0] == other]
    # A foot is farthest ahead where it comes down.
    return float(herd.down[across[0]]) - 0.25 if across else 0.0
