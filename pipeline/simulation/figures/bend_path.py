"""Bend path: the bends of a limb as a function of the distance from its base to its tip.

The tip goes on the straight line from its place at rest to the base, and away from it to full
extension. Of all joint values that bring it there those are taken that are nearest to the preferred
ones, in parts of each joint's range. So every distance has one set of bends, neighbouring distances
have neighbouring ones, and a knee turns as fast as one of two equal links would, whatever path the
foot takes.

Source: Sims 1987, 6.2 and 6.3.1, which goes such a path near full extension alone; weights after
B.3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.kinematics import IDENTITY, LimbBatch
from pipeline.simulation.spatial import Array

CELLS = 64
"""Cells of the table from distances to bends."""

SHORTEST = 0.05
"""Distance from base to tip at which the path ends at the latest, in lengths of the limb."""

STRETCHED = 0.98
"""Distance beyond which bends go straight to full extension, in the longest."""

ITERATIONS = 8
"""Steps from each place on the path to the next."""

STILL = 1e-4
"""Movement of joints below which a place is reached [rad or m]."""

HOLDS = 3
"""Passes of a step, each without the joints that the one before held at a limit."""

LONGEST = 0.3
"""Greatest movement of a joint in one step [rad or m]."""

MISS = 1e-4
"""Distance of tip from place beyond which the path has ended, in lengths of the limb."""

DAMPING = 1e-9
"""λ², in squared lengths of the limb."""


def bending_joints(batch: LimbBatch) -> NDArray[np.bool_]:
    """Return the joints (L, n) that change the distance from base to tip."""
    away = np.abs(batch.places - batch.places[:, :1]).max(axis=-1) > 1e-9 * batch.lengths[:, None]
    result: NDArray[np.bool_] = batch.is_joint & (away | batch.prismatic)
    return result


@dataclass(frozen=True, eq=False)
class BendPath:
    """The paths of L limbs with k joints each.

    Attributes:
        longest, shortest: (L,) distances at its ends [m].
        values: (CELLS + 1, k, L) joint values by depth, see `_depth`; those of joints that do not
            bend the limb are the preferred ones [rad or m].
        slopes: (CELLS + 1, k, L) their derivatives, per cell.
    """

    longest: Array
    shortest: Array
    values: Array
    slopes: Array

    @staticmethod
    def of(batch: LimbBatch) -> BendPath:
        """Return the paths of limbs with as many joints each."""
        inner = bending_joints(batch)
        stretched = np.clip(np.where(inner, batch.extended, batch.preferred), batch.lower, batch.upper)
        longest = _distance(batch, stretched)
        rest = _distance(batch, batch.preferred)
        # Dense near full extension, where bends change most.
        t = np.linspace(0.0, 1.0, CELLS + 1)[:, None]
        asked = longest * (1.0 - (1.0 - SHORTEST) * t * t * (2.0 - t))
        count = len(rest)
        at_rest = np.abs(asked - rest).argmin(axis=0)
        # From rest towards the base and away from it, side by side.
        number = np.tile(np.arange(count), 2)
        way = np.repeat([1, -1], count)
        both = batch.rows(number)
        values = np.tile(batch.preferred, (CELLS + 1, 1, 1))
        reached = np.zeros((CELLS + 1, count), dtype=bool)
        q, before = both.preferred, both.preferred
        going = np.ones(2 * count, dtype=bool)
        for k in range(CELLS + 1):
            cell = at_rest[number] + way * k
            going &= (cell >= 0) & (cell <= CELLS)
            if not going.any():
                break
            goal = asked[np.clip(cell, 0, CELLS), number]
            after, miss = _nearest(both, 2.0 * q - before if k > 1 else q, goal)
            going &= miss < MISS * both.lengths
            q, before = np.where(going[:, None], after, q), q
            values[cell[going], number[going]] = q[going]
            reached[cell[going], number[going]] = True
        return _table(batch, stretched, values, reached & (asked < STRETCHED * longest))

    def at(self, own: NDArray[np.int64], distance: Array) -> Array:
        """Return joint values (k, l, m) at distances from base to tip (l, m) [rad or m].

        Args:
            own: (l, 1) numbers of the limbs.
            distance: [m]; beyond the ends of the path, those of its ends.
        """
        deep = CELLS * _depth(distance, self.longest[own], self.shortest[own])
        cell = np.minimum(deep.astype(np.int64), CELLS - 1)
        u = deep - cell
        result = np.empty((self.values.shape[1], *u.shape))
        for j, (values, slopes) in enumerate(
            zip(self.values.swapaxes(0, 1), self.slopes.swapaxes(0, 1), strict=True)
        ):
            a, b = values[cell, own], values[cell + 1, own]
            v, w = slopes[cell, own], slopes[cell + 1, own]
            # A cubic through both ends with their slopes.
            result[j] = a + u * (
                v + u * (3.0 * (b - a) - 2.0 * v - w + u * (2.0 * (a - b) + v + w))
            )
        return result


def _depth(distance: Array, longest: Array, shortest: Array) -> Array:
    """Return how far a limb is bent, from 0 stretched to 1.

    Near full extension bends are in proportion to it, because the distance falls with their square.
    """
    span = np.maximum(longest**2 - shortest**2, 1e-300)
    return np.sqrt(np.clip((longest**2 - distance**2) / span, 0.0, 1.0))


def _table(
    batch: LimbBatch, stretched: Array, values: Array, chosen: NDArray[np.bool_]
) -> BendPath:
    """Return the path from `stretched` (L, n) through those `chosen` of `values` (m, L, n)."""
    depth = np.linspace(0.0, 1.0, CELLS + 1)
    longest, shortest = np.empty((2, len(stretched)))
    table = np.empty((CELLS + 1, values.shape[2], len(stretched)))
    for row, (end, own) in enumerate(zip(stretched, values.swapaxes(0, 1), strict=True)):
        kept, q = own[chosen[:, row]], end[None]
        if len(kept):
            first = end + np.linspace(0.0, 1.0, 17)[:-1, None] * (kept[0] - end)
            q = np.concatenate([first, kept])
        far = _distance(batch.rows(np.full(len(q), row)), q)
        falls = np.concatenate([[True], np.diff(far) < 0.0])
        last = len(q) if falls.all() else int(falls.argmin())
        q, far = q[:last], far[:last]
        longest[row], shortest[row] = far[0], far[-1]
        deep = _depth(far, far[0], far[-1])
        for j in range(q.shape[1]):
            table[:, j, row] = np.interp(depth, deep, q[:, j]) if last > 1 else q[0, j]
    return BendPath(longest, shortest, table, np.gradient(table, axis=0))


def _nearest(batch: LimbBatch, q: Array, distance: Array) -> tuple[Array, Array]:
    """Return joint values (L, n) that bring tips to distances (L,) on their ways at rest [m].

    Also returns by how much the tips miss them (L,) [m].
    """
    rest = batch.pose(batch.preferred).tips - batch.places[:, 0]
    way = rest / np.maximum(np.linalg.norm(rest, axis=-1, keepdims=True), 1e-300)
    goals = batch.places[:, 0] + distance[:, None] * way
    weight = (batch.upper - batch.lower) ** 2
    damping = (DAMPING * (weight.max(axis=1) * batch.lengths**2))[:, None, None] * IDENTITY
    q = np.clip(q, batch.lower, batch.upper)
    for k in range(ITERATIONS):
        pose = batch.pose(q)
        wish, free = batch.preferred - q, batch.is_joint
        low, high = batch.lower - q, batch.upper - q
        step = np.zeros_like(q)
        for _ in range(HOLDS):
            # Joints that would exceed a limit are held there, and the others carry the motion.
            J, W = pose.jacobian * free[..., None], weight * free
            moved = np.where(free, wish, step)
            square = np.einsum("ln,lni,lnj->lij", W, J, J) + damping
            left = goals - pose.tips - np.einsum("lni,ln->li", pose.jacobian, moved)
            y = np.linalg.solve(square, left[..., None])[..., 0]
            wanted = moved + W * np.einsum("lni,li->ln", J, y)
            step = np.clip(wanted, low, high)
            if (step == wanted).all():
                break
            free = free & (step == wanted)
        largest = np.abs(step).max(axis=1, keepdims=True)
        q = q + step * (LONGEST / np.maximum(largest, LONGEST))
        if k >= 2 and (largest < STILL).all():
            break
    return q, np.linalg.norm(goals - batch.pose(q).tips, axis=-1)


def _distance(batch: LimbBatch, q: Array) -> Array:
    return np.linalg.norm(batch.pose(q).tips - batch.places[:, 0], axis=-1)
