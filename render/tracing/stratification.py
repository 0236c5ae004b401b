"""Draws: the numbers by which paths choose, stratified pass by pass.

They come from a hash of the pixel and of a key, without any state: the same seed gives the same
numbers whatever was drawn before, in any order and on any number of threads.

Source: Kensler, Correlated Multi-Jittered Sampling, 2013.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

ON_LAMP, ALONG = 0, 1
"""The pairs that a step draws: a point on a lamp and a direction along the surface. At the eye
they are a place in the pixel and one on the lens."""

ROUNDS = 8
"""Of the hash; with fewer, numbers of neighbouring keys have been seen to hang together."""


@dataclass
class Draws:
    """What one step of one pass draws its samples by.

    Attributes:
        key: of the numbers that pixels draw in this pass.
        base: of those that they keep over all passes.
        k: number of the pass.
        grid: columns and rows of cells in each pair of dimensions, one for every pass.
        together: whether all pixels have the same cell along the surface in the same pass. Only
            one step may: two would have the same cell together, always.
    """

    key: mi.UInt32
    base: mi.UInt32
    k: mi.UInt32
    grid: tuple[int, int]
    together: mi.Bool


@dataclass(frozen=True)
class Chance:
    """Where the samples of one pass of a picture lie."""

    seed: int
    k: int
    grid: tuple[int, int]

    def draws(self, step: int) -> Draws:
        """Return what step `step` of the paths draws by; 0 is at the eye."""
        key = self.seed * 0x9E3779B1 + step * 0xC2B2AE3D
        drawn = Draws(
            mi.UInt32((key + (self.k + 1) * 0x85EBCA77) & 0xFFFFFFFF),
            mi.UInt32(key & 0xFFFFFFFF),
            mi.UInt32(self.k),
            self.grid,
            mi.Bool(step == 1),
        )
        # Numbers that a kernel had to be compiled for would cost more than they say.
        dr.make_opaque(drawn)
        return drawn


def pair(pixel: Any, draws: Draws, i: int) -> Any:
    """Return the `i`-th pair of numbers that a pixel draws, each pass in a cell of its own.

    Source: Kensler, Correlated Multi-Jittered Sampling, 2013.
    """
    columns, rows = draws.grid
    k: Any = draws.k
    u, v = _uniform(pixel, draws.key + i)
    shuffle, across = _hash(pixel, draws.base + (2 * i + 1) * 0x1000193)
    cell = mi.permute_kensler(k, columns * rows, shuffle)
    if i == ALONG:
        cell = dr.select(draws.together, k, cell)
    column, row = cell // rows, cell % rows
    down = _hash(pixel, draws.base + (2 * i + 2) * 0x1000193 + row)[0]
    # Within a column each row has a strip of its own, and within a row each column.
    x = mi.Float(mi.permute_kensler(row, rows, across + column)) + u
    y = mi.Float(mi.permute_kensler(column, columns, down)) + v
    return mi.Point2f((mi.Float(column) + x / rows) / columns, (mi.Float(row) + y / columns) / rows)


def line(pixel: Any, draws: Draws) -> Any:
    """Return the single number that a pixel draws, each pass in an interval of its own."""
    count = draws.grid[0] * draws.grid[1]
    k: Any = draws.k
    place = mi.permute_kensler(k, count, _hash(pixel, draws.base)[0])
    return (mi.Float(place) + _uniform(pixel, draws.key + 2)[0]) / count


def _uniform(pixel: Any, key: Any) -> tuple[Any, Any]:
    """Return two numbers in [0, 1) of a pixel, by a hash and without a state."""
    a, b = _hash(pixel, key)
    scale = 1.0 / (1 << 24)
    return mi.Float(a >> 8) * scale, mi.Float(b >> 8) * scale


def _hash(pixel: Any, key: Any) -> Any:
    return mi.sample_tea_32(pixel, key, ROUNDS)
