"""Idle motion: free joints that sway with the gait and never quite rest.

Free joints belong to no leg. Where heads look is decided by `gaze`, follow-through is added by
`follow_through`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.network import ARM, FEELER, HEAD, LEG, TAIL, WING
from pipeline.simulation.figures.skeleton import BODY, Limb
from pipeline.simulation.locomotion.body_motion.follow_through import (
    FreeLimb,
    SoftJointLimits,
    joint_turns,
)
from pipeline.simulation.locomotion.body_motion.gaze import BodyMotion
from pipeline.simulation.locomotion.gaits.moods import MotionStyle
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array

# Sway with the gait: amplitude [rad] and oscillations in a cycle.
SWAY = {
    (TAIL, "yaw"): (0.09, 1.0),
    (TAIL, "pitch"): (0.03, 2.0),
    (ARM, "pitch"): (0.32, 1.0),
    (ARM, "bend"): (0.06, 1.0),
}

# How far the elbows of arms bend in a run, and how much farther the arms sway (Novacheck 1998)
# [rad].
RUNNING_BEND, RUNNING_SWAY = 1.0, 0.25

# Idle motion: amplitude [rad]. Heads wander as a whole, in where they look.
WANDER = {
    (HEAD, "yaw"): 0.05,
    (HEAD, "pitch"): 0.03,
    (FEELER, "yaw"): 0.20,
    (FEELER, "pitch"): 0.16,
    (FEELER, "bend"): 0.10,
    (WING, "pitch"): 0.05,
}

# Carriage of a creature that stands: greatest turn [rad], to a side drawn by its name. An animal at
# rest looks aside a little, and its tail hangs to one side.
CARRIAGE = {
    (HEAD, "yaw"): 0.30,
    (HEAD, "pitch"): 0.06,
    (TAIL, "yaw"): 0.18,
}

# Least part of it, and what is left of it for heads on short necks, of those that are no mammals.
LEAST_CARRIAGE, SHORT_NECK_CARRIAGE = 0.6, 0.35

# Range of the frequencies of idle motion [1/s].
MIN_FREQUENCY, MAX_FREQUENCY = 0.25, 0.95


@dataclass(frozen=True, eq=False)
class FreeJoints:
    """The free joints of a herd as arrays (M,).

    Attributes:
        tree: the joints.
        owner: creature of each.
        names: such as "bug.head.base_yaw".
        number: in the figure's skeleton.
        limits: of the joints.
        limbs: that they make up.
        sway, lag, times: amplitude of the sway [rad], its lag in cycles, and oscillations in a
            cycle.
        carriage: turn while its creature stands [rad].
        wander, frequency, offset: amplitude [rad], frequency [1/s] and start phase [rad] of the
            idle motion.
        raises: whether they raise a tail.
        elbow: way in which the elbows of arms bend, 0 for other joints.
    """

    tree: JointTree
    owner: NDArray[np.int64]
    names: tuple[str, ...]
    number: NDArray[np.int64]
    limits: SoftJointLimits
    limbs: tuple[FreeLimb, ...]
    sway: Array
    lag: Array
    times: Array
    carriage: Array
    wander: Array
    frequency: Array
    offset: Array
    raises: NDArray[np.bool_]
    elbow: Array

    @property
    def numbers(self) -> dict[tuple[int, int], int]:
        """Creature and number of a joint in its skeleton -> number of the joint here."""
        pairs = zip(self.owner.tolist(), self.number.tolist(), strict=True)
        return {pair: i for i, pair in enumerate(pairs)}

    def swaying(self, motion: BodyMotion) -> Array:
        """Return the sway of the joints (n, M), with what raises tails and bends elbows [rad].

        A creature at rest does not sway.
        """
        own, style = self.owner, motion.style
        part = np.minimum(motion.speed_fraction, 1.0)
        runs = (part * motion.running)[:, own]
        strength = (style.sway * part)[:, own] * self.sway * (1.0 + RUNNING_SWAY * runs)
        turns = self.times * (motion.phase[:, own] - self.lag)
        result: Array = strength * np.sin(2.0 * np.pi * turns)
        result += self.raises * style.tail_raise[:, own] + RUNNING_BEND * runs * self.elbow
        return result

    def standing(self, motion: BodyMotion) -> Array:
        """Return the carriage of the joints (n, M), which is lost as a creature walks off [rad]."""
        part = np.minimum(motion.speed_fraction, 1.0)[:, self.owner]
        return motion.style.wander[:, self.owner] * (1.0 - part) * self.carriage

    def wandering(self, time: Array, style: MotionStyle) -> Array:
        """Return the idle motion of the joints (n, M) [rad].

        Args:
            time: (n,) since the start [s].
            style: (n, C).
        """
        # Two waves of incommensurable length never repeat.
        angle = 2.0 * np.pi * self.frequency * time[:, None] + self.offset
        waves = 0.65 * np.sin(angle) + 0.35 * np.sin(1.618 * angle + 1.0)
        return style.wander[:, self.owner] * self.wander * waves


def collect_free_joints(herd: Herd, seed: int) -> FreeJoints:
    """Collect all joints that belong to no leg.

    Args:
        herd: the creatures; each has its own random numbers, by its name.
        seed: of the scene.
    """
    names, figures = herd.names, herd.figures
    rows: list[tuple[int, int, int, str, str]] = []  # creature, joint, parent, kind, turn
    limbs, lags = list[FreeLimb](), list[float]()
    for c, figure in enumerate(figures):
        skeleton, number_of = figure.skeleton, dict[int, int]()
        for limb in (limb for limb in skeleton.limbs if limb.kind != LEG):
            turns, own = joint_turns(skeleton, limb), range(len(rows), len(rows) + len(limb.joints))
            for j, turn in zip(limb.joints, turns, strict=True):
                parent = number_of.get(int(skeleton.parents[j]), BODY)
                number_of[j] = len(rows)
                rows.append((c, j, parent, limb.kind, turn))
            limbs.append(FreeLimb(limb.kind, own, turns, limb.tip, limb.length, limb.tip_radius))
            lags += [_lag(herd, c, limb)] * len(own)
    skeletons = [figures[c].skeleton for c, *_ in rows]
    number = np.array([j for _, j, *_ in rows], dtype=np.int64)
    joints = [
        (names[c], skeleton.joint_names[j])
        for (c, j, *_), skeleton in zip(rows, skeletons, strict=True)
    ]

    def collected(field: str, *shape: int) -> Array:
        values = [getattr(s, field)[j] for s, j in zip(skeletons, number, strict=True)]
        return np.array(values, dtype=float).reshape(len(rows), *shape)

    kinds = [(kind, turn) for *_, kind, turn in rows]
    chances = [generator(seed, f"{name}.idle.{joint}").random(2) for name, joint in joints]
    chance = np.array(chances).reshape(-1, 2)
    shares = [_carriage_share(figures[c], kind) for c, _, _, kind, _ in rows]
    return FreeJoints(
        tree=JointTree(
            np.array([parent for _, _, parent, *_ in rows], dtype=np.int64),
            collected("axes", 3),
            collected("places", 3),
            collected("prismatic").astype(bool),
        ),
        owner=np.array([c for c, *_ in rows], dtype=np.int64),
        names=tuple(f"{name}.{joint}" for name, joint in joints),
        number=number,
        limits=SoftJointLimits(collected("lower"), collected("preferred"), collected("upper")),
        limbs=tuple(limbs),
        sway=np.array([SWAY.get(k, (0.0, 1.0))[0] for k in kinds]),
        lag=np.array(lags),
        times=np.array([SWAY.get(k, (0.0, 1.0))[1] for k in kinds]),
        carriage=np.array(
            [
                share * CARRIAGE.get(k, 0.0) * _side(seed, name, joint)
                for k, share, (name, joint) in zip(kinds, shares, joints, strict=True)
            ]
        ),
        wander=np.array([WANDER.get(k, 0.0) for k in kinds]),
        frequency=MIN_FREQUENCY + (MAX_FREQUENCY - MIN_FREQUENCY) * chance[:, 0],
        offset=2.0 * np.pi * chance[:, 1],
        raises=np.array([k == (TAIL, "pitch") for k in kinds], dtype=bool),
        elbow=_elbows(limbs, collected("lower"), collected("preferred"), collected("upper")),
    )


def _carriage_share(figure: Figure, kind: str) -> float:
    """Return the part of its carriage that a kind of limb has: abdomens of shells have none."""
    if figure.style == "mammal":
        return 1.0
    return SHORT_NECK_CARRIAGE if kind == HEAD else float(figure.skin.shell == "plain")


def _side(seed: int, name: str, joint: str) -> float:
    """Return the part of its carriage that a joint has, with the sign of its side."""
    side, part = generator(seed, f"{name}.carriage.{joint}").random(2)
    return float((1.0 if side < 0.5 else -1.0) * (LEAST_CARRIAGE + (1.0 - LEAST_CARRIAGE) * part))


def _elbows(limbs: Sequence[FreeLimb], lower: Array, preferred: Array, upper: Array) -> Array:
    """Return the way (M,) in which the first bend of each arm turns, 0 for other joints."""
    result = np.zeros(len(preferred))
    for limb in limbs:
        if limb.kind == ARM and "bend" in limb.turns:
            j = limb.joints[limb.turns.index("bend")]
            result[j] = 1.0 if upper[j] - preferred[j] > preferred[j] - lower[j] else -1.0
    return result


def _lag(herd: Herd, c: int, limb: Limb) -> float:
    """Return the phase of a limb's sway in cycles: an arm swings with the leg of the other side."""
    other = {"l": "r", "r": "l"}.get(limb.side)
    legs = np.flatnonzero((herd.owner == c) & (limb.kind == ARM))
    across = [leg for leg in legs if herd.leg_names[leg][0] == other]
    # A foot is farthest ahead where it comes down; the limb comes forward a quarter early.
    return float(herd.down[across[0]]) - 0.25 if across else 0.0
