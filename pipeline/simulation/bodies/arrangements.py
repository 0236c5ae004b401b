"""Arrangements: initial poses of the bodies of a wall, a stack, a row, a pyramid or a heap.

A new arrangement is a model in `pipeline/spec/body.py`, a function here and a line in `LAYOUTS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.keyframe_track import Track
from pipeline.simulation.spatial import Array, heading, matrix
from pipeline.spec.body import Heap, Pyramid, Row, Stack, Wall


@dataclass(frozen=True, eq=False)
class Placements:
    """Where n bodies begin, relative to the place and the heading of the whole.

    Attributes:
        p: (n, 3) middles of the boxes around them; y from the ground [m].
        R: (n, 3, 3).
        on_ground: whether each is put on the ground below it, y left aside.
    """

    p: Array
    R: Array
    on_ground: bool = False


Extent = Array
"""(3,) of one body along its axes [m]."""

SAMPLES_PER_POINT = 64
"""Places on a smooth line for each that it was drawn through."""

ROW_OFFSET = 0.4
"""How far neighbouring rows of a wall are moved, in bodies: those at the ends, which are
whole, would fall from half of one."""

HEAP_SPACING = 1.05
"""Between bodies in a heap, in their greatest extent."""


def _wall(words: Wall, extent: Extent, chance: np.random.Generator) -> Placements:
    """Return the places of a wall."""
    rows, columns = np.divmod(np.arange(words.rows * words.columns), words.columns)
    moved = columns - 0.5 * (words.columns - 1) + ROW_OFFSET * (rows % 2 - 0.5)
    return _stacked_rows(rows, moved, words.gap, extent)


def _pyramid(words: Pyramid, extent: Extent, chance: np.random.Generator) -> Placements:
    """Return the places of a pyramid that is one body deep."""
    return _centred_rows(np.arange(words.rows, 0, -1), words.gap, extent)


def _centred_rows(lengths: NDArray[np.int64], gap: float, extent: Extent) -> Placements:
    """Return rows of such lengths, each in the middle of the one below."""
    rows = np.repeat(np.arange(len(lengths)), lengths)
    columns = np.concatenate([np.arange(n) - 0.5 * (n - 1) for n in lengths])
    return _stacked_rows(rows, columns, gap, extent)


def _stack(words: Stack, extent: Extent, chance: np.random.Generator) -> Placements:
    """Return the places of a stack."""
    rows = np.arange(words.count)
    return _stacked_rows(rows, np.zeros(words.count), 0.0, extent)


def _stacked_rows(rows: Any, columns: Any, gap: float, extent: Extent) -> Placements:
    p = np.zeros((len(rows), 3))
    p[:, 0] = columns * (extent[0] + gap)
    p[:, 1] = (rows + 0.5) * extent[1]
    return Placements(p, np.tile(np.eye(3), (len(p), 1, 1)))


def _row(words: Row, extent: Extent, chance: np.random.Generator) -> Placements:
    """Return the places of a row, each looking along it."""
    way = _smooth_line(np.array([(0.0, 0.0), *words.along]))
    gone = np.r_[0.0, np.cumsum(np.hypot(*np.diff(way, axis=0).T))]
    at = np.arange(words.count) * words.spacing
    x, z = (np.interp(at, gone, way[:, k]) for k in (0, 1))
    ahead = (way[-1] - way[-2]) / np.hypot(*(way[-1] - way[-2]))
    beyond = np.maximum(at - gone[-1], 0.0)
    p = np.stack([x + beyond * ahead[0], np.zeros(len(at)), z + beyond * ahead[1]], axis=1)
    part = np.clip(np.searchsorted(gone, at, side="right") - 1, 0, len(way) - 2)
    run = np.diff(way, axis=0)[part]
    return Placements(p, heading(np.arctan2(-run[:, 1], run[:, 0])), on_ground=True)


def _smooth_line(points: Array) -> Array:
    """Return many places (m, 2) along a smooth line through places (n, 2), none twice."""
    if len(points) == 1:
        return np.array([(0.0, 0.0), (1.0, 0.0)])
    gone = np.r_[0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))]
    track = Track.of([(t, p, "spline") for t, p in zip(gone, points.tolist(), strict=True)])
    return track(np.linspace(0.0, gone[-1], SAMPLES_PER_POINT * len(points)))


def _heap(words: Heap, extent: Extent, chance: np.random.Generator) -> Placements:
    """Return places in a column of air, layer upon layer, and chance attitudes."""
    cell = HEAP_SPACING * float(np.sqrt((extent * extent).sum()))
    side = np.arange(-(words.radius // cell), words.radius // cell + 1.0) * cell
    x, z = (values.ravel() for values in np.meshgrid(side, side))
    inside = np.hypot(x, z) <= words.radius
    x, z = x[inside], z[inside]
    layer, place = np.divmod(np.arange(words.count), len(x))
    p = np.stack([x[place], words.above + (layer + 0.5) * cell, z[place]], axis=1)
    q = chance.normal(size=(words.count, 4))
    return Placements(p, matrix(q / np.sqrt((q * q).sum(axis=1, keepdims=True))))


LAYOUTS: dict[type[Any], Callable[[Any, Extent, np.random.Generator], Placements]] = {
    Wall: _wall,
    Pyramid: _pyramid,
    Stack: _stack,
    Row: _row,
    Heap: _heap,
}


def arrange(words: Any, extent: Extent, chance: np.random.Generator) -> Placements:
    """Return where the bodies of an arrangement begin.

    Args:
        words: of the arrangement.
        extent: of one body.
        chance: whence heaps have their attitudes.
    """
    return LAYOUTS[type(words)](words, extent, chance)
