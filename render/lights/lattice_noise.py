"""Lattice noise for Dr.Jit: random numbers at the points of a lattice, smooth between them.

Source: I. Quilez, Value noise derivatives, 2008.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi


def lattice(x: Any, y: Any, z: Any) -> Any:
    """Return a random number of each point of a lattice, 0 to 1."""
    h = x * mi.UInt32(0x8DA6B343) ^ y * mi.UInt32(0xD8163841) ^ z * mi.UInt32(0xCB1AB31F)
    h = (h ^ (h >> 13)) * mi.UInt32(0x85EBCA6B)
    h = (h ^ (h >> 15)) * mi.UInt32(0xC2B2AE35)
    return mi.Float((h >> 8) & 0xFFFF) * (1.0 / 65535.0)


def _cell(x: Any) -> tuple[Any, Any]:
    """Return the lattice point below, and the smoothed rest."""
    low = dr.floor(x)
    rest = x - low
    return mi.UInt32(mi.Int32(low)), rest * rest * (3.0 - 2.0 * rest)


def noise2(x: Any, y: Any, seed: int) -> Any:
    """Return smooth noise in the plane, 0 to 1, with features about 1 wide."""
    (i, u), (j, v) = _cell(x), _cell(y)
    k = mi.UInt32(seed)
    a, b = lattice(i, j, k), lattice(i + 1, j, k)
    c, d = lattice(i, j + 1, k), lattice(i + 1, j + 1, k)
    low, high = a + u * (b - a), c + u * (d - c)
    return low + v * (high - low)


def noise3(x: Any, y: Any, z: Any) -> Any:
    """Return smooth noise in space, 0 to 1, with features about 1 wide."""
    (i, u), (j, v), (k, w) = _cell(x), _cell(y), _cell(z)

    def plane(k: Any) -> Any:
        a, b = lattice(i, j, k), lattice(i + 1, j, k)
        c, d = lattice(i, j + 1, k), lattice(i + 1, j + 1, k)
        low, high = a + u * (b - a), c + u * (d - c)
        return low + v * (high - low)

    near = plane(k)
    return near + w * (plane(k + 1) - near)


def fbm2(x: Any, y: Any, octaves: int) -> Any:
    """Return noise of several octaves, 0 to 1; each is turned, or their lattices would show."""
    total, weight, sum_ = mi.Float(0.0), 0.5, 0.0
    for k in range(octaves):
        total += weight * noise2(x, y, 17 + k)
        sum_ += weight
        weight *= 0.5
        x, y = 1.62 * x + 1.18 * y + 5.3, -1.18 * x + 1.62 * y + 1.7
    return total / sum_


def puffs(x: Any, y: Any, z: Any, octaves: int) -> Any:
    """Return rounded puffs with creases between them, 0 to 1."""
    total, weight, sum_ = mi.Float(0.0), 0.5, 0.0
    for _ in range(octaves):
        total += weight * dr.abs(2.0 * noise3(x, y, z) - 1.0)
        sum_ += weight
        weight *= 0.52
        x, y, z = 1.7 * x + 1.1 * z + 3.1, 2.05 * y + 1.9, -1.1 * x + 1.7 * z + 7.7
    return dr.minimum(1.7 * total / sum_, 1.0)
