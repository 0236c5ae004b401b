"""Stratification: the random numbers of paths, correlated multi-jittered over the passes.

They come from a hash of the pixel and of a key, without state: the same seed gives the same
numbers in any order and on any number of threads.

Source: Kensler, Correlated Multi-Jittered Sampling, 2013.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

EMITTER_PAIR, BSDF_PAIR = 0, 1
"""Pairs of numbers of a step: a point on an emitter and a direction of the BSDF. At the camera
they are a point in the pixel and one on the lens."""

HASH_ROUNDS = 8
"""With fewer rounds, numbers of neighbouring keys have been seen to correlate."""


def stratum_grid(count: int) -> tuple[int, int]:
    """Return columns and rows, as near to a square as possible, of exactly `count` strata."""
    rows = next(k for k in range(math.isqrt(count), 0, -1) if count % k == 0)
    return count // rows, rows


@dataclass
class StepStrata:
    """The strata of one step of one pass, for Dr.Jit.

    Attributes:
        key: of the numbers that differ between passes.
        base: of the permutations that all passes share.
        k: number of the pass.
        grid: columns and rows of strata in each pair of dimensions, one for every pass.
        shared: whether all pixels have the same BSDF stratum in the same pass. At most one step
            may: two would be correlated.
    """

    key: mi.UInt32
    base: mi.UInt32
    k: mi.UInt32
    grid: tuple[int, int]
    shared: mi.Bool


@dataclass(frozen=True)
class PassStrata:
    """The strata of one pass of a frame.

    Attributes:
        seed: of the frame.
        k: number of the pass.
        grid: columns and rows of strata.
    """

    seed: int
    k: int
    grid: tuple[int, int]

    def step(self, step: int) -> StepStrata:
        """Return the strata of a step of the paths; 0 is at the camera."""
        key = self.seed * 0x9E3779B1 + step * 0xC2B2AE3D
        strata = StepStrata(
            mi.UInt32((key + (self.k + 1) * 0x85EBCA77) & 0xFFFFFFFF),
            mi.UInt32(key & 0xFFFFFFFF),
            mi.UInt32(self.k),
            self.grid,
            mi.Bool(step == 1),
        )
        # Literals would compile a kernel for each value.
        dr.make_opaque(strata)
        return strata


def sample_2d(pixel: Any, strata: StepStrata, i: int) -> Any:
    """Return the `i`-th pair of numbers of a pixel, in another stratum in each pass."""
    columns, rows = strata.grid
    k: Any = strata.k
    u, v = _uniform(pixel, strata.key + i)
    shuffle, across = _hash(pixel, strata.base + (2 * i + 1) * 0x1000193)
    cell = mi.permute_kensler(k, columns * rows, shuffle)
    if i == BSDF_PAIR:
        cell = dr.select(strata.shared, k, cell)
    column, row = cell // rows, cell % rows
    down = _hash(pixel, strata.base + (2 * i + 2) * 0x1000193 + row)[0]
    # Within a column each row has a strip of its own, and within a row each column.
    x = mi.Float(mi.permute_kensler(row, rows, across + column)) + u
    y = mi.Float(mi.permute_kensler(column, columns, down)) + v
    return mi.Point2f((mi.Float(column) + x / rows) / columns, (mi.Float(row) + y / columns) / rows)


def sample_1d(pixel: Any, strata: StepStrata, i: int = 0) -> Any:
    """Return the `i`-th single number of a pixel, in another stratum in each pass."""
    count = strata.grid[0] * strata.grid[1]
    k: Any = strata.k
    shuffle = _hash(pixel, strata.base + i * 0x3C6EF372)[0]
    place = mi.permute_kensler(k, count, shuffle)
    return (mi.Float(place) + _uniform(pixel, strata.key + 2 + i)[0]) / count


def _uniform(pixel: Any, key: Any) -> tuple[Any, Any]:
    """Return two numbers in [0, 1) by a hash of pixel and key."""
    a, b = _hash(pixel, key)
    scale = 1.0 / (1 << 24)
    return mi.Float(a >> 8) * scale, mi.Float(b >> 8) * scale


def _hash(pixel: Any, key: Any) -> Any:
    return mi.sample_tea_32(pixel, key, HASH_ROUNDS)
