"""Follow-through: tails, feelers, heads and arms that swing on after what they hang on.

The tip of such a limb, were it stiff, would move with what the limb hangs on. For each of its
joints a point on a spring trails behind that tip, and turns the joint as far as it lies off.
Springs get softer towards the tip. A limb that hangs on another one follows that one's swinging
too.

Source: Lasseter 1987.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import bounded
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.network import ARM, FEELER, HEAD, HORN, TAIL, WING
from pipeline.simulation.figures.skeleton import BODY, Limb, Skeleton
from pipeline.simulation.locomotion.body_motion.damped_springs import Oscillators, SpringFollower
from pipeline.simulation.spatial import Array, cross, turn, turn_inverse

# Least room of a joint that rests at its limit [rad or m].
MIN_JOINT_ROOM = 1e-6

# Frequencies of the springs, in that of a hanging rod as long as the limb, and damping ratios:
# muscles hold heads, and hardly tails; horns are stiff.
FREQUENCY = {TAIL: 1.6, FEELER: 2.2, ARM: 2.0, HEAD: 4.5, HORN: 40.0, WING: 2.0}
DAMPING = {TAIL: 0.30, FEELER: 0.25, ARM: 0.45, HEAD: 0.60, HORN: 0.9, WING: 0.60}

# Frequency of a joint's spring, in that of the joint before.
FREQUENCY_RATIO = 0.85

# How far all joints of a limb turn together for its tip to be on its spring: a little more, because
# the joints far out come later than the others.
TOTAL_TURN = 1.3


@dataclass(frozen=True, eq=False)
class SoftJointLimits:
    """Joints whose limits are approached ever more slowly and never reached.

    Attributes:
        lower, preferred, upper: (...) [rad or m].
    """

    lower: Array
    preferred: Array
    upper: Array

    def at(self, wish: Array) -> Array:
        """Return joint values for wishes (...) relative to rest, of any size."""
        room = self._room(wish)
        return self.preferred + room * bounded(wish / room)

    def slope(self, wish: Array) -> Array:
        """Return the derivatives of joint values by their wishes, 0 to 1."""
        x = wish / self._room(wish)
        return (1.0 + (x * x) * (x * x)) ** -1.25

    def _room(self, wish: Array) -> Array:
        rooms = np.where(wish < 0.0, self.preferred - self.lower, self.upper - self.preferred)
        return np.maximum(rooms, MIN_JOINT_ROOM)


@dataclass(frozen=True, eq=False)
class FreeLimb:
    """A limb that carries nothing.

    Attributes:
        kind: any but leg.
        joints: numbers of its joints in the tree, from base to tip.
        turns: yaw, pitch, roll or bend, of each joint.
        tip: (3,) in the creation frame [m].
        length: [m].
        tip_radius: of the solid around the tip [m].
    """

    kind: str
    joints: Sequence[int]
    turns: Sequence[str]
    tip: Array
    length: float
    tip_radius: float

    def tip_at(self, tree: JointTree, frames: Array) -> Array:
        """Return the tip (3,) for frames (M, 4, 4) of the tree's joints [m]."""
        last = self.joints[-1]
        return frames[last, :3, 3] + frames[last, :3, :3] @ (self.tip - tree.places[last])


def joint_turns(skeleton: Skeleton, limb: Limb) -> list[str]:
    """Return yaw, pitch, roll or bend, for each joint of a limb."""
    return [skeleton.joint_names[j].rsplit("_", 1)[1] for j in limb.joints]


class FollowThrough:
    """The follow-through of a herd's free joints; remembers the row before.

    Attributes:
        tree: the joints, M of them.
        limits: (M,) of the joints.
        owner: (M,) creature of each.
        springs: (M,) of each.
    """

    def __init__(
        self,
        tree: JointTree,
        limits: SoftJointLimits,
        owner: NDArray[np.int64],
        limbs: Sequence[FreeLimb],
        dt: float,
    ) -> None:
        self.tree, self.limits, self.owner = tree, limits, owner
        count = len(owner)
        self._tip, self._lever = np.zeros((2, count, 3))
        self._carrier = np.full(count, BODY, dtype=np.int64)
        frequency, damping = np.ones(count), np.zeros(count)
        rest = tree.pose(limits.preferred)
        for limb in limbs:
            own, ranks = list(limb.joints), np.arange(len(limb.joints))
            self._carrier[own] = tree.parents[own[0]]
            rod = np.sqrt(1.5 * GRAVITY / limb.length)
            frequency[own] = FREQUENCY[limb.kind] * rod * FREQUENCY_RATIO**ranks
            damping[own] = DAMPING[limb.kind]
            self._tip[own], self._lever[own] = self._levers(limb, rest)
        self.springs = Oscillators(frequency, damping, dt)
        self._followers = [
            SpringFollower(Oscillators(frequency[tier], damping[tier], dt)) for tier in self._tiers
        ]

    def _levers(self, limb: FreeLimb, rest: Array) -> tuple[Array, Array]:
        """Return the tip (3,), and the turns of the joints per offset (k, 3) [rad/m].

        Both relative to what the limb hangs on.
        """
        own = list(limb.joints)
        X, carrier = rest[own], int(self.tree.parents[own[0]])
        tip = limb.tip_at(self.tree, rest)
        along = tip - X[:, :3, 3]
        along = along / np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-9)
        lever = cross(turn(X[:, :3, :3], self.tree.axes[own]), along) / limb.length
        lever = _turn_shares(limb, self.tree.prismatic[own])[:, None] * lever
        if carrier == BODY:
            return tip, lever
        R, p = rest[carrier, :3, :3], rest[carrier, :3, 3]
        return R.T @ (tip - p), lever @ R

    @cached_property
    def _tiers(self) -> list[NDArray[np.int64]]:
        """Joints of limbs on bodies, of limbs on these, and so on."""
        depth = np.zeros(len(self.owner), dtype=np.int64)
        above = self._carrier
        while (inner := above != BODY).any():
            depth += inner
            above = np.where(inner, self._carrier[above], BODY)
        return [np.flatnonzero(depth == d) for d in range(int(depth.max(initial=-1)) + 1)]

    @cached_property
    def _carriers(self) -> tuple[NDArray[np.int64], JointTree, NDArray[np.int64]]:
        """Joints that carry limbs, with all before them, their tree, and their numbers in it."""
        carries, above = np.zeros(len(self.owner), dtype=bool), np.unique(self._carrier)
        while (above := above[above != BODY]).size:
            carries[above] = True
            above = self.tree.parents[above]
        chosen = np.flatnonzero(carries)
        number = np.full(len(carries) + 1, BODY, dtype=np.int64)
        number[chosen] = np.arange(len(chosen))
        t = self.tree
        # Number -1, the last entry, stands for the body.
        tree = JointTree(
            number[t.parents[chosen]], t.axes[chosen], t.places[chosen], t.prismatic[chosen]
        )
        return chosen, tree, number

    def apply(self, wishes: Array, R_WB: Array, p_WB: Array, looseness: Array) -> Array:
        """Return the wishes of the joints (n, M) with follow-through, see `SoftJointLimits` [rad].

        Args:
            wishes: (n, M) without it [rad].
            R_WB: (n, C, 3, 3) and
            p_WB: (n, C, 3) of the bodies [m].
            looseness: (n, C) factor.
        """
        wishes = wishes.copy()
        frames = self._carrier_frames(wishes, R_WB, p_WB)
        for follower, (tier, R, p) in zip(self._followers, frames, strict=True):
            late = follower.follow(p + turn(R, self._tip[tier]))
            turned = (turn_inverse(R, late) * self._lever[tier]).sum(axis=-1)
            wishes[:, tier] += looseness[:, self.owner[tier]] * turned
        return wishes

    def _carrier_frames(
        self, wishes: Array, R_WB: Array, p_WB: Array
    ) -> Iterator[tuple[NDArray[np.int64], Array, Array]]:
        """Yield each tier and the frames (n, T, 3, 3), (n, T, 3) of what its limbs hang on.

        Changes of the wishes between tiers move what the next tier hangs on.
        """
        for depth, tier in enumerate(self._tiers):
            R, p = R_WB[:, self.owner[tier]], p_WB[:, self.owner[tier]]
            if depth:
                chosen, tree, number = self._carriers
                X = tree.pose(self.limits.at(wishes)[:, chosen])[:, number[self._carrier[tier]]]
                R, p = R @ X[..., :3, :3], p + turn(R, X[..., :3, 3])
            yield tier, R, p


def _turn_shares(limb: FreeLimb, prismatic: NDArray[np.bool_]) -> Array:
    """Return each joint's share (k,) of the limb's turn; none for joints that slide."""
    shares = np.zeros(len(limb.joints))
    for turns in (("yaw",), ("roll",), ("pitch", "bend")):
        own = np.flatnonzero(np.isin(np.array(limb.turns), turns) & ~prismatic)
        weights = 1.0 + np.arange(len(own))
        shares[own] = (TOTAL_TURN if len(own) > 1 else 1.0) * weights / max(weights.sum(), 1.0)
    return shares
