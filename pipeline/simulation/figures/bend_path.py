"""Bend path: the bends of a limb as a function of the distance from its base to its tip.

The tip goes on the straight line from its place at rest to the base, and away from it to full
extension. Limbs that hang, as those of mammals, bend along their `fold_curve`. Limbs that sprawl,
as those of insects, would turn their first link past the upright by that: theirs are the joint
values nearest to the preferred ones, the base included, in parts of each joint's range. So every
distance has one set of bends, neighbouring distances have neighbouring ones, and a knee turns as
fast as one of two equal links would, whatever path the foot takes.

Source: Sims 1987, 6.2 and 6.3.1, which goes such a path near full extension alone; weights after
B.3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.ball_aim import ball_joints
from pipeline.simulation.figures.fold_curve import distances, fold_curves
from pipeline.simulation.figures.kinematics import IDENTITY, LimbBatch
from pipeline.simulation.spatial import Array

CELLS = 64
"""Cells of the table from distances to bends."""

SHORTEST = 0.05
"""Distance from base to tip at which the path ends at the latest, in lengths of the limb."""

STRETCHED = 0.98
"""Distance beyond which bends go straight to full extension, in the longest."""

STRAIGHT_STEPS = 16
"""Measured distances from there to full extension."""

PARALLEL = 0.9
"""Cosine of the angle between parallel axes."""

FREE_BASE = 100.0
"""Weight of joints at the base of a hanging limb, which follow its bends."""

CORNER = 4
"""Places on either side over which corners of a path are rounded."""

MISS = 1e-4
"""Distance of tip from place beyond which the path has ended, in lengths of the limb."""


@dataclass(frozen=True, slots=True)
class PathSearch:
    """Constants of the way from one place on a path to the next.

    Attributes:
        iterations: bound on the steps.
        still: movement of joints below which a place is reached [rad or m].
        holds: passes of a step, each without the joints that the one before held at a limit.
        longest: greatest movement of a joint in one step [rad or m].
        damping: λ², in squared ranges of joints and lengths of the limb.
    """

    iterations: int = 8
    still: float = 1e-4
    holds: int = 3
    longest: float = 0.3
    damping: float = 1e-9


PATH_SEARCH = PathSearch()


@dataclass(frozen=True, eq=False)
class BendPath:
    """The paths of L limbs with k joints each.

    Attributes:
        longest, shortest: (L,) distances at its ends [m].
        values: (CELLS + 1, k, L) joint values by depth, see `_depth`; those of joints that do not
            bend the limb lead nowhere [rad or m].
        slopes: (CELLS + 1, k, L) their derivatives, per cell.
    """

    longest: Array
    shortest: Array
    values: Array
    slopes: Array

    @staticmethod
    def of(batch: LimbBatch) -> BendPath:
        """Return the paths of limbs with as many joints each."""
        bending = bending_joints(batch)
        hanging: list[int] = np.flatnonzero(hangs(batch)).tolist()
        some = np.array(hanging, dtype=np.int64)
        curves = dict(zip(hanging, fold_curves(batch.rows(some), bending[some]), strict=True))
        aims = ball_joints(batch)
        straight = np.where(bending, batch.extended, batch.preferred)
        straight = np.clip(straight, batch.lower, batch.upper)
        longest, shortest = np.empty((2, len(straight)))
        values = np.empty((CELLS + 1, straight.shape[1], len(straight)))
        depth = np.linspace(0.0, 1.0, CELLS + 1)
        bent = _bent_poses(batch, bending, _distance(batch, straight), curves)
        for row, kept in enumerate(bent):
            q = straight[row : row + 1]
            if row in curves and aims[row]:
                q = curves[row]
            elif len(kept):
                part = np.linspace(0.0, 1.0, STRAIGHT_STEPS + 1)[:-1, None]
                q = np.concatenate([q + part * (kept[0] - q), kept])
            far = _distance(batch.rows(np.full(len(q), row)), q)
            falls = np.diff(far) < 0.0
            q = q[: len(q) if falls.all() else int(falls.argmin()) + 1]
            longest[row], shortest[row] = far[0], far[len(q) - 1]
            deep = _depth(far[: len(q)], longest[row], shortest[row])
            for j, own in enumerate(q.T):
                values[:, j, row] = np.interp(depth, deep, own)
        slopes = np.asarray(np.gradient(values, axis=0))
        return BendPath(longest, shortest, values, slopes)

    def at(self, own: NDArray[np.int64], distance: Array) -> Array:
        """Return joint values (k, l, m) at distances from base to tip (l, m) [rad or m].

        Args:
            own: (l, 1) numbers of the limbs.
            distance: [m]; beyond the ends of the path, those of its ends.
        """
        return self.at_depth(own, self.depth(own, distance))

    def depth(self, own: NDArray[np.int64], distance: Array) -> Array:
        """Return how far limbs are bent (l, m) at distances (l, m) [m], 0 to 1."""
        return _depth(distance, self.longest[own], self.shortest[own])

    def distance(self, own: NDArray[np.int64], depth: Array) -> Array:
        """Return the distances (l, m) of limbs that are bent by `depth` (l, m) [m]."""
        longest, shortest = self.longest[own] ** 2, self.shortest[own] ** 2
        result: Array = np.sqrt(longest - depth**2 * (longest - shortest))
        return result

    def at_depth(self, own: NDArray[np.int64], depth: Array) -> Array:
        """Return joint values (k, l, m) of limbs that are bent by `depth` (l, m) [rad or m]."""
        deep = CELLS * depth
        cell = np.minimum(deep.astype(np.int64), CELLS - 1)
        u = deep - cell
        result = np.empty((self.values.shape[1], *u.shape))
        for j in range(len(result)):
            values, slopes = self.values[:, j], self.slopes[:, j]
            a, b = values[cell, own], values[cell + 1, own]
            v, w = slopes[cell, own], slopes[cell + 1, own]
            # A cubic through both ends with their slopes.
            result[j] = a + u * (
                v + u * (3.0 * (b - a) - 2.0 * v - w + u * (2.0 * (a - b) + v + w))
            )
        return result


def bending_joints(batch: LimbBatch) -> NDArray[np.bool_]:
    """Return the joints (L, n) that change the distance from base to tip."""
    away = np.abs(batch.places - batch.places[:, :1]).max(axis=-1) > 1e-9 * batch.lengths[:, None]
    result: NDArray[np.bool_] = batch.is_joint & (away | batch.prismatic)
    return result


def _depth(distance: Array, longest: Array, shortest: Array) -> Array:
    """Return how far a limb is bent, from 0 stretched to 1.

    Near full extension bends are in proportion to it, because the distance falls with their square.
    """
    span = np.maximum(longest**2 - shortest**2, 1e-300)
    return np.sqrt(np.clip((longest**2 - distance**2) / span, 0.0, 1.0))


def _bent_poses(
    batch: LimbBatch,
    bending: NDArray[np.bool_],
    longest: Array,
    curves: Mapping[int, Array],
) -> list[Array]:
    """Return joint values (m, n) of each limb, from `STRETCHED` to as near as its tip comes.

    Args:
        batch: L limbs.
        bending: (L, n) joints that change the distance.
        longest: (L,) distances at full extension [m].
        curves: joint values (m, n) that limbs keep near, by their numbers.
    """
    count = len(longest)
    # Dense near full extension, where bends change most.
    t = np.linspace(0.0, 1.0, CELLS + 1)[:, None]
    places = longest * (1.0 - (1.0 - SHORTEST) * t * t * (2.0 - t))
    at_rest = np.abs(places - _distance(batch, batch.preferred)).argmin(axis=0)
    # From rest towards the base and away from it, side by side.
    number, way = np.tile(np.arange(count), 2), np.repeat([1, -1], count)
    both = batch.rows(number)
    hanging = hangs(batch)[:, None]
    wishes = np.broadcast_to(batch.preferred, (CELLS + 1, *batch.preferred.shape)).copy()
    for row, curve in curves.items():
        far = distances(batch.rows(np.array([row])), curve)
        for j, own in enumerate(curve.T):
            wishes[:, row, j] = np.interp(-places[:, row], -far, own)
    weights = np.where(bending | ~hanging, 1.0, FREE_BASE)[number]
    values = np.tile(batch.preferred, (CELLS + 1, 1, 1))
    reached = np.zeros((CELLS + 1, count), dtype=bool)
    q, before = both.preferred, both.preferred
    going = np.ones(2 * count, dtype=bool)
    for k in range(CELLS + 1):
        cell = at_rest[number] + way * k
        going &= (cell >= 0) & (cell <= CELLS)
        if not going.any():
            break
        at = np.clip(cell, 0, CELLS), number
        start = 2.0 * q - before if k > 1 else q
        after, miss = _nearest_pose(both, start, places[at], wishes[at], weights)
        going &= miss < MISS * both.lengths
        q, before = np.where(going[:, None], after, q), q
        values[cell[going], number[going]] = q[going]
        reached[cell[going], number[going]] = True
    reached &= places < STRETCHED * longest
    return [_rounded(values[reached[:, row], row]) for row in range(count)]


def hangs(batch: LimbBatch) -> NDArray[np.bool_]:
    """Return which limbs (L,) turn first about the axis that they bend about."""
    first = batch.axes[:, :1]
    along = np.abs((batch.axes * first).sum(axis=-1)) * bending_joints(batch)
    result: NDArray[np.bool_] = along.max(axis=1, initial=0.0) > PARALLEL
    return result


def _rounded(q: Array) -> Array:
    """Return joint values (m, n) along a path with its corners rounded, where a limit is met."""
    m = min(CORNER, len(q) - 1)
    if m < 1:
        return q
    # Reflected at both ends, which stay.
    long = np.concatenate([2.0 * q[0] - q[m:0:-1], q, 2.0 * q[-1] - q[-2 : -m - 2 : -1]])
    weights = np.hanning(2 * m + 3)[1:-1]
    sums = sum(w * long[k : k + len(q)] for k, w in enumerate(weights))
    return np.asarray(sums / weights.sum())


def _nearest_pose(
    batch: LimbBatch, q: Array, distance: Array, wish: Array, weights: Array
) -> tuple[Array, Array]:
    """Return joint values (L, n) nearest to `wish` that bring tips to distances (L,) [m].

    Also returns by how much the tips miss their places (L,) [m].

    Args:
        batch: the limbs.
        q: (L, n) joint values near them.
        distance: from base to tip, in its direction at rest [m].
        wish: (L, n) joint values.
        weights: (L, n) 1, or more for joints that have no wish and follow the others.
    """
    search = PATH_SEARCH
    rest = batch.pose(batch.preferred).tips - batch.places[:, 0]
    way = rest / np.maximum(np.linalg.norm(rest, axis=-1, keepdims=True), 1e-300)
    places = batch.places[:, 0] + distance[:, None] * way
    scale = weights * (batch.upper - batch.lower) ** 2
    damping = search.damping * scale.max(axis=1) * batch.lengths**2
    q = np.clip(q, batch.lower, batch.upper)
    for k in range(search.iterations):
        pose = batch.pose(q)
        pull, free = np.where(weights > 1.0, 0.0, wish - q), batch.is_joint
        step = np.zeros_like(q)
        for _ in range(search.holds):
            # Joints that would exceed a limit are held there, and the others carry the motion.
            J, W = pose.jacobian * free[..., None], scale * free
            moved = np.where(free, pull, step)
            square = np.einsum("ln,lni,lnj->lij", W, J, J) + damping[:, None, None] * IDENTITY
            left = places - pose.tips - np.einsum("lni,ln->li", pose.jacobian, moved)
            y = np.linalg.solve(square, left[..., None])[..., 0]
            wanted = moved + W * np.einsum("lni,li->ln", J, y)
            step = np.clip(wanted, batch.lower - q, batch.upper - q)
            if (step == wanted).all():
                break
            free = free & (step == wanted)
        largest = np.abs(step).max(axis=1, keepdims=True)
        q = q + step * (search.longest / np.maximum(largest, search.longest))
        if k > 1 and (largest < search.still).all():
            break
    return q, np.linalg.norm(places - batch.pose(q).tips, axis=-1)


def _distance(batch: LimbBatch, q: Array) -> Array:
    """Return the distances (L,) from base to tip [m]."""
    result: Array = np.linalg.norm(batch.pose(q).tips - batch.places[:, 0], axis=-1)
    return result
