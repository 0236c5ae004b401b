"""Overlap: tails, feelers, heads and arms that follow what they hang on, and swing on after it.

Where the tip of such a limb would be, were it stiff, goes with what the limb hangs on. A
point on a spring trails behind it for each of the joints, and turns its joint as far as
it lies off. The farther out a joint is, the softer is its spring and the later it comes. A
limb that hangs on another one follows that one's swinging too.

Source: Lasseter 1987.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import bounded
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.network import ARM, FEELER, HEAD, TAIL
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.locomotion.body_motion.damped_springs import Oscillators, Trailing
from pipeline.simulation.spatial import Array, cross, turn, unturn

LEAST = 1e-6
"""Room of a joint that rests on its limit [rad or m]."""


@dataclass(frozen=True, eq=False)
class SoftJointLimits:
    """Joints between their limits.

    Attributes:
        lower, preferred, upper: (...) [rad or m].
    """

    lower: Array
    preferred: Array
    upper: Array

    def at(self, wish: Array) -> Array:
        """Return joint values for wishes (..., relative to rest) of any size.

        Small wishes are met; a limit is come to ever more slowly and is never reached.
        """
        room = self._towards(wish)
        result: Array = self.preferred + room * bounded(wish / room)
        return result

    def slope(self, wish: Array) -> Array:
        """Return how much joint values change with their wishes, 0 to 1."""
        x = wish / self._towards(wish)
        result: Array = (1.0 + (x * x) * (x * x)) ** -1.25
        return result

    def _towards(self, wish: Array) -> Array:
        rooms = np.where(wish < 0.0, self.preferred - self.lower, self.upper - self.preferred)
        return np.maximum(rooms, LEAST)


STIFF = {TAIL: 1.6, FEELER: 2.2, ARM: 2.0, HEAD: 4.5}
"""Frequencies of the springs, in that of a rod as long as the limb that hangs: muscles hold
heads, and hardly tails."""

DAMPING = {TAIL: 0.30, FEELER: 0.25, ARM: 0.45, HEAD: 0.60}
"""Ratios to the critical damping."""

SOFTER = 0.85
"""Frequency of a joint's spring, in that of the joint before."""

FOLLOWS = 1.3
"""How far all joints of a limb together turn, for its tip to be where its spring has it: a
little more, because the joints far out come later than the others."""

GRAVITY = 9.81


@dataclass(frozen=True, eq=False)
class FreeLimb:
    """A limb that carries nothing.

    Attributes:
        kind: head, tail, feeler or arm.
        joints: its joints, by their numbers in the tree, from base to tip.
        turns: what each of them does: yaw, pitch, roll or bend.
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


class FollowThrough:
    """How the joints of a herd that carry nothing trail; remembers the row before.

    Attributes:
        tree: these joints, M of them.
        room: (M,) what they may do.
        owner: (M,) creature of each.
        springs: (M,) of each.
    """

    def __init__(
        self,
        tree: JointTree,
        room: SoftJointLimits,
        owner: NDArray[np.int64],
        limbs: Sequence[FreeLimb],
        dt: float,
    ) -> None:
        self.tree, self.room, self.owner = tree, room, owner
        count = len(owner)
        self._tip, self._lever = np.zeros((2, count, 3))
        self._carrier = np.full(count, BODY, dtype=np.int64)
        frequency, damping = np.ones(count), np.zeros(count)
        rest = tree.pose(room.preferred)
        for limb in limbs:
            own, steps = list(limb.joints), np.arange(len(limb.joints))
            self._carrier[own] = tree.parents[own[0]]
            slow = np.sqrt(1.5 * GRAVITY / limb.length)
            frequency[own] = STIFF[limb.kind] * slow * SOFTER**steps
            damping[own] = DAMPING[limb.kind]
            self._tip[own], self._lever[own] = self._levers(limb, rest)
        self.springs = Oscillators(frequency, damping, dt)
        self._trailing = [Trailing(self._springs_of(tier)) for tier in self._tiers]

    def _levers(self, limb: FreeLimb, rest: Array) -> tuple[Array, Array]:
        """Return the tip (3,) and how the joints follow it (k, 3) [rad/m], by what it hangs on."""
        own = list(limb.joints)
        X, carrier = rest[own], int(self.tree.parents[own[0]])
        tip = X[-1, :3, 3] + X[-1, :3, :3] @ (limb.tip - self.tree.places[own[-1]])
        along = tip - X[:, :3, 3]
        along = along / np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-9)
        lever = cross(turn(X[:, :3, :3], self.tree.axes[own]), along) / limb.length
        lever = _shares(limb, self.tree.prismatic[own])[:, None] * lever
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
        """Joints that something hangs on, with all before them, their tree, and their places."""
        carry, above = np.zeros(len(self.owner), dtype=bool), np.unique(self._carrier)
        while (above := above[above != BODY]).size:
            carry[above] = True
            above = self.tree.parents[above]
        chosen = np.flatnonzero(carry)
        place = np.full(len(carry) + 1, BODY, dtype=np.int64)
        place[chosen] = np.arange(len(chosen))
        t = self.tree
        # Place -1, the last entry, stands for the body.
        tree = JointTree(
            place[t.parents[chosen]], t.axes[chosen], t.places[chosen], t.prismatic[chosen]
        )
        return chosen, tree, place

    def _springs_of(self, tier: NDArray[np.int64]) -> Oscillators:
        s = self.springs
        return Oscillators(s.frequency[tier], s.damping[tier], s.dt)

    def trail(self, wishes: Array, R_WB: Array, p_WB: Array, looseness: Array) -> Array:
        """Return what the joints (n, M) do, trailing, as `SoftJointLimits` takes it [rad].

        Args:
            wishes: (n, M) what they would do otherwise [rad].
            R_WB: (n, C, 3, 3) and
            p_WB: (n, C, 3) of the bodies [m].
            looseness: (n, C) factor.
        """
        wishes = wishes.copy()
        frames = self._frames(wishes, R_WB, p_WB)
        for trailing, (tier, R, p) in zip(self._trailing, frames, strict=True):
            late = trailing.follow(p + turn(R, self._tip[tier]))
            turned = (unturn(R, late) * self._lever[tier]).sum(axis=-1)
            wishes[:, tier] += looseness[:, self.owner[tier]] * turned
        return wishes

    def _frames(
        self, wishes: Array, R_WB: Array, p_WB: Array
    ) -> Iterator[tuple[NDArray[np.int64], Array, Array]]:
        """Yield each tier and the frames (n, T, 3, 3), (n, T, 3) of what its limbs hang on.

        Wishes may be changed between tiers, which moves what the next one hangs on.
        """
        for depth, tier in enumerate(self._tiers):
            R, p = R_WB[:, self.owner[tier]], p_WB[:, self.owner[tier]]
            if depth:
                chosen, tree, place = self._carriers
                X = tree.pose(self.room.at(wishes)[:, chosen])[:, place[self._carrier[tier]]]
                R, p = R @ X[..., :3, :3], p + turn(R, X[..., :3, 3])
            yield tier, R, p


def _shares(limb: FreeLimb, prismatic: NDArray[np.bool_]) -> Array:
    """Return by which part of what the limb does each joint (k,) turns; none that slides does."""
    shares = np.zeros(len(limb.joints))
    groups: Mapping[str, tuple[str, ...]] = {"yaw": ("yaw",), "roll": ("roll",)}
    for turns in (*groups.values(), ("pitch", "bend")):
        own = np.flatnonzero(np.isin(np.array(limb.turns), turns) & ~prismatic)
        weights = 1.0 + np.arange(len(own))
        shares[own] = (FOLLOWS if len(own) > 1 else 1.0) * weights / max(weights.sum(), 1.0)
    return shares
