"""Arrangements: initial poses of the bodies of a wall, a stack, a row, a pyramid or a heap.

A new arrangement is a model in `pipeline/spec/body.py`, a function here and a line in `LAYOUTS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.simulation.keyframe_track import Track
from pipeline.simulation.spatial import Array, heading, matrix
from pipeline.spec.body import Heap, Pyramid, Row, Stack, Wall


@dataclass(frozen=True, eq=False)
class Placements:
    """Initial poses of n bodies, relative to place and heading of the arrangement.

    Attributes:
        p: (n, 3) centres of their bounding boxes; y from the ground [m].
        R: (n, 3, 3).
        on_ground: whether each body is put on the ground below it; y is then ignored.
    """

    p: Array
    R: Array
    on_ground: bool = False


Extent = Array
"""(3,) of one body along its axes [m]."""

SAMPLES_PER_POINT = 64
"""Points on a smooth line for each point that it passes."""

ROW_OFFSET = 0.4
"""Offset of neighbouring rows of a wall, in bodies: at one half the whole bodies at the ends would
fall."""

HEAP_SPACING = 1.05
"""Spacing of bodies in a heap, in their diagonals."""


def _wall(config: Wall, extent: Extent, rng: np.random.Generator) -> Placements:
    rows, columns = np.divmod(np.arange(config.rows * config.columns), config.columns)
    moved = columns - 0.5 * (config.columns - 1) + ROW_OFFSET * (rows % 2 - 0.5)
    return _stacked_rows(rows, moved, config.gap, extent)


def _pyramid(config: Pyramid, extent: Extent, rng: np.random.Generator) -> Placements:
    lengths = np.arange(config.rows, 0, -1)
    rows = np.repeat(np.arange(len(lengths)), lengths)
    columns = np.concatenate([np.arange(n) - 0.5 * (n - 1) for n in lengths])
    return _stacked_rows(rows, columns, config.gap, extent)


def _stack(config: Stack, extent: Extent, rng: np.random.Generator) -> Placements:
    return _stacked_rows(np.arange(config.count), np.zeros(config.count), 0.0, extent)


def _stacked_rows(rows: Any, columns: Any, gap: float, extent: Extent) -> Placements:
    p = np.zeros((len(rows), 3))
    p[:, 0] = columns * (extent[0] + gap)
    p[:, 1] = (rows + 0.5) * extent[1]
    return Placements(p, np.tile(np.eye(3), (len(p), 1, 1)))


def _row(config: Row, extent: Extent, rng: np.random.Generator) -> Placements:
    """Returns the poses of a row whose bodies face along it."""
    way = _smooth_line(np.array([(0.0, 0.0), *config.along]))
    gone = np.r_[0.0, np.cumsum(np.hypot(*np.diff(way, axis=0).T))]
    at = np.arange(config.count) * config.spacing
    x, z = (np.interp(at, gone, way[:, k]) for k in (0, 1))
    ahead = (way[-1] - way[-2]) / np.hypot(*(way[-1] - way[-2]))
    beyond = np.maximum(at - gone[-1], 0.0)
    p = np.stack([x + beyond * ahead[0], np.zeros(len(at)), z + beyond * ahead[1]], axis=1)
    part = np.clip(np.searchsorted(gone, at, side="right") - 1, 0, len(way) - 2)
    run = np.diff(way, axis=0)[part]
    return Placements(p, heading(np.arctan2(-run[:, 1], run[:, 0])), on_ground=True)


def _smooth_line(points: Array) -> Array:
    """Returns many points (m, 2) along a smooth line through points (n, 2)."""
    if len(points) == 1:
        return np.array([(0.0, 0.0), (1.0, 0.0)])
    gone = np.r_[0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))]
    track = Track.of([(t, p, "spline") for t, p in zip(gone, points.tolist(), strict=True)])
    return track(np.linspace(0.0, gone[-1], SAMPLES_PER_POINT * len(points)))


def _heap(config: Heap, extent: Extent, rng: np.random.Generator) -> Placements:
    """Returns positions in layers above the ground, and random attitudes."""
    cell = HEAP_SPACING * float(np.sqrt((extent * extent).sum()))
    side = np.arange(-(config.radius // cell), config.radius // cell + 1.0) * cell
    x, z = (values.ravel() for values in np.meshgrid(side, side))
    inside = np.hypot(x, z) <= config.radius
    x, z = x[inside], z[inside]
    layer, place = np.divmod(np.arange(config.count), len(x))
    p = np.stack([x[place], config.above + (layer + 0.5) * cell, z[place]], axis=1)
    q = rng.normal(size=(config.count, 4))
    return Placements(p, matrix(q / np.sqrt((q * q).sum(axis=1, keepdims=True))))


LAYOUTS: dict[type[Any], Callable[[Any, Extent, np.random.Generator], Placements]] = {
    Wall: _wall,
    Pyramid: _pyramid,
    Stack: _stack,
    Row: _row,
    Heap: _heap,
}


def arrange(config: Any, extent: Extent, rng: np.random.Generator) -> Placements:
    """Returns the initial poses of the bodies of an arrangement.

    Args:
        config: of the arrangement.
        extent: of one body.
        rng: for the attitudes in heaps.
    """
    return LAYOUTS[type(config)](config, extent, rng)
