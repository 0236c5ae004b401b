"""Support: the smooth surface that bodies follow, made of the ground that can be stood on.

Heights are averaged over the cells that count, by a normalised convolution, so that a
body goes level over a ditch or between stones. Where nothing that counts is near, the
average of ever wider surroundings takes over. A second surface says how far anything at
all, stood on or not, rises above the first.

Both are quadratic B-splines over a grid as coarse as their smoothness allows: one time
differentiable, nine products a place.

Source: Knutsson and Westin 1993 (normalised convolution).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.ground import Ground
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.simulation.terrain.islands import cell_heights

NODES_PER_BLUR = 1.5
"""Nodes per standard deviation of the blur."""

SPLINE_VARIANCE = 0.25 + 1.0 / 12.0
"""Variance of a quadratic B-spline and a block average [squares of the node distance]."""

LEVEL_TOLERANCE = 1e-9
"""Largest rise of level ground [m]."""

NEIGHBOURS = np.array([-1, 0, 1])

SURROUNDINGS_WEIGHT = 1e-2
"""Weight of the wider surroundings relative to ground that can be stood on."""


@dataclass(frozen=True, eq=False)
class SmoothGround:
    """Two smooth surfaces over the rectangle of a height field.

    Attributes:
        field: where the rectangle lies.
        side: distance of nodes along x and z [m].
        nodes: (2, n_z, n_x) height, and how far anything rises above it [m].
        walls: (n_z, n_x) nodes near which something rises too high to pass above.
    """

    field: HeightField
    side: tuple[float, float]
    nodes: Array
    walls: NDArray[np.bool_]

    @staticmethod
    def of(
        ground: Ground, counts: NDArray[np.bool_], blur: float, wide: float, room: float
    ) -> SmoothGround:
        """Build the surfaces.

        Args:
            ground: what is walked over.
            counts: (n_z, n_x) cells that can be stood on.
            blur: standard deviation of the average [m].
            wide: half the width of what must pass above all that rises [m].
            room: what rises more than this is a wall, which nothing passes above [m].
        """
        cell = ground.field.cell
        many = tuple(max(1, int(blur / (NODES_PER_BLUR * side))) for side in cell)
        side = many[0] * cell[0], many[1] * cell[1]
        weight = counts.astype(float)
        sums = [_blocks(f, many) for f in (weight * cell_heights(ground), weight)]
        # Blocks at the far edges may hang over; what counts is the share that is there.
        passes = [max(1, round(2.0 * ((blur / s) ** 2 - SPLINE_VARIANCE))) for s in side]
        height, share = (_blurred(f / (many[0] * many[1]), passes) for f in sums)
        surface = filled(height, share)
        above = _above(ground.field, surface, side)
        high = above > room
        if not high.any():
            excess = _blocks(above, many, highest=True)
            walls = np.zeros_like(excess)
        else:
            excess = _blocks(np.where(high, 0.0, above), many, highest=True)
            walls = _blocks(high.astype(float), many, highest=True)
        # The spline at a place looks at nodes up to one and a half sides away.
        near = [1 + int(np.ceil(wide / s)) for s in side]
        nodes = np.stack([surface, _dilated(excess, near)])
        return SmoothGround(ground.field, side, nodes, _dilated(walls, near) > 0.0)

    @cached_property
    def is_level(self) -> bool:
        """Whether the whole surface is level."""
        return bool(
            np.ptp(self.nodes[0]) < LEVEL_TOLERANCE and self.nodes[1].max() < LEVEL_TOLERANCE
        )

    @cached_property
    def has_walls(self) -> bool:
        """Whether the surface has walls."""
        return bool(self.walls.any())

    def barred(self, x: Array, z: Array) -> NDArray[np.bool_]:
        """Return which world (x, z) are beside walls; any equal shapes."""
        x, z = self.field.to_grid(x, z)
        n_z, n_x = self.walls.shape
        i = np.rint((x + 0.5 * self.field.size[0]) / self.side[0] - 0.5).astype(np.int64)
        j = np.rint((z + 0.5 * self.field.size[1]) / self.side[1] - 0.5).astype(np.int64)
        return self.walls[np.clip(j, 0, n_z - 1), np.clip(i, 0, n_x - 1)]

    def at(self, x: Array, z: Array) -> tuple[Array, Array]:
        """Return height and rise above it [m] at world (x, z); any equal shapes."""
        x, z = np.asarray(x, dtype=float), np.asarray(z, dtype=float)
        which = np.zeros(1, dtype=np.int64)
        height, excess = self._alone.at(which, x.reshape(1, -1), z.reshape(1, -1))
        return height.reshape(x.shape), excess.reshape(x.shape)

    @cached_property
    def _alone(self) -> SmoothGrounds:
        return SmoothGrounds([self])


class SmoothGrounds:
    """Several supports over one height field, looked up together.

    Attributes:
        field: where their rectangle lies.
    """

    def __init__(self, supports: Sequence[SmoothGround]) -> None:
        self.field = supports[0].field
        shapes = np.array([support.walls.shape for support in supports])
        # Along x and z, with an axis for places and one for more of each.
        self._side = np.array([support.side for support in supports]).T[..., None]
        self._most = shapes[:, ::-1].T[..., None]
        self._first = np.cumsum([0, *shapes.prod(axis=1)[:-1]])[:, None]
        self._nodes = np.concatenate([s.nodes.reshape(2, -1) for s in supports], axis=1)
        self._half = 0.5 * np.reshape(self.field.size, (2, 1, 1))

    def at(self, which: NDArray[np.int64], x: Array, z: Array) -> tuple[Array, Array]:
        """Return height and rise above it (N, m) [m].

        Args:
            which: (N,) of the supports.
            x: (N, m) and
            z: (N, m) places in the world [m].
        """
        u = np.array(self.field.to_grid(x, z))
        u += self._half
        u /= self._side[:, which]
        u -= 0.5
        most = self._most[:, which]
        taps, weights = _taps(u, most)
        places = (taps[:, None, 1] * most[0] + self._first[which]) + taps[None, :, 0]
        parts = weights[:, None, 1] * weights[None, :, 0]
        products = self._nodes.take(places.reshape(9, *x.shape), axis=1)
        products *= parts.reshape(9, *x.shape)
        # One after the other: how `sum` adds up depends on how many places there are.
        height, excess = _in_turn(products)
        return height, excess


def _in_turn(terms: Array) -> Array:
    total: Array = terms[:, 0].copy()
    for k in range(1, terms.shape[1]):
        total += terms[:, k]
    return total


def _taps(u: Array, n: NDArray[np.int64]) -> tuple[NDArray[np.int64], Array]:
    """Return the nodes (3, ...) nearest to places `u`, counted in nodes, and their weights.

    Args:
        u: places.
        n: how many nodes there are.
    """
    u = np.minimum(np.maximum(u, -0.5), n - 0.5)
    nearest = np.rint(u)
    t = u - nearest
    weights = np.empty((3, *u.shape))
    weights[0], weights[1], weights[2] = 0.5 * (0.5 - t) ** 2, 0.75 - t * t, 0.5 * (0.5 + t) ** 2
    i = nearest.astype(np.int64) + NEIGHBOURS.reshape(3, *(1,) * u.ndim)
    return np.minimum(np.maximum(i, 0), n - 1), weights


def _blocks(values: Array, many: tuple[int, ...], highest: bool = False) -> Array:
    """Return sums (or the highest) over blocks of `many` cells along x and z."""
    (m_x, m_z), (n_z, n_x) = many, values.shape
    out = (-n_z % m_z, -n_x % m_x)
    padded = np.pad(values, ((0, out[0]), (0, out[1])), mode="edge" if highest else "constant")
    joined = np.maximum if highest else np.add
    # Whole rows of the grid at once, which is quicker than block by block.
    rows = padded[::m_z].copy()
    for k in range(1, m_z):
        joined(rows, padded[k::m_z], out=rows)
    result: Array = rows[:, ::m_x].copy()
    for k in range(1, m_x):
        joined(result, rows[:, k::m_x], out=result)
    return result


def _blurred(values: Array, passes: list[int]) -> Array:
    """Blur by passes of (1, 2, 1) / 4 along x and z, with zeros beyond the edges."""
    for axis, count in ((1, passes[0]), (0, passes[1])):
        v = np.moveaxis(values, axis, 0)
        for _ in range(count):
            wide = np.zeros((len(v) + 2, v.shape[1]))
            wide[1:-1] = v
            v = 0.5 * wide[1:-1] + 0.25 * (wide[:-2] + wide[2:])
        values = np.moveaxis(v, 0, axis)
    return values


def filled(height: Array, share: Array) -> Array:
    """Return height / share, filled from the surroundings where the share is small.

    Args:
        height: (n_z, n_x) blurred heights, each times its weight [m].
        share: (n_z, n_x) blurred weights.
    """
    if min(height.shape) < 2 or (share > 1.0 - SURROUNDINGS_WEIGHT).all():
        total = float(share.sum())
        mean = float(height.sum()) / total if total > 0.0 else 0.0
        safe = np.where(share > 0.0, share, 1.0)
        return np.where(share > 0.0, height / safe, mean)
    half = [_blocks(f, (2, 2)) / 4.0 for f in (height, share)]
    coarse = filled(*half)
    wide = np.repeat(np.repeat(coarse, 2, axis=0), 2, axis=1)[: height.shape[0], : height.shape[1]]
    # That of ones is a product of what it is along x and along z.
    ones = (_blurred(np.ones((n, 1)), [0, 2]) for n in wide.shape)
    one = np.multiply.outer(*(blurred[:, 0] for blurred in ones))
    smooth = _blurred(wide, [2, 2]) / one
    return (height + SURROUNDINGS_WEIGHT * smooth) / (share + SURROUNDINGS_WEIGHT)


def _above(field: HeightField, surface: Array, side: tuple[float, float]) -> Array:
    """Return how far the highest corner of each cell (n_z, n_x) rises above the surface [m]."""
    n_x, n_z = field.cells
    # Between the nodes straight lines are near enough, along x and then along z.
    for axis, n in ((1, n_x), (0, n_z)):
        u = np.arange(n + 1) * field.cell[1 - axis] / side[1 - axis] - 0.5
        last = surface.shape[axis] - 1
        u = np.clip(u, 0.0, last)
        i = np.minimum(u.astype(np.int64), max(last - 1, 0))
        low, high = np.take(surface, i, axis), np.take(surface, np.minimum(i + 1, last), axis)
        part = (u - i)[:, None] if axis == 0 else u - i
        surface = low + part * (high - low)
    h = field.heights - surface
    rows = np.maximum(h[:-1], h[1:])
    return np.maximum(rows[:, :-1], rows[:, 1:])


def _dilated(values: Array, near: list[int]) -> Array:
    """Return the highest of all nodes up to `near` away along x and z."""
    for axis, reach in ((1, near[0]), (0, near[1])):
        v = np.moveaxis(values, axis, 0)
        best = v.copy()
        for k in range(1, min(reach, len(v) - 1) + 1):
            np.maximum(best[k:], v[:-k], out=best[k:])
            np.maximum(best[:-k], v[k:], out=best[:-k])
        values = np.moveaxis(best, 0, axis)
    return np.ascontiguousarray(values)
