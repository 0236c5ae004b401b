"""Lattice noise: smooth random heights, with their slopes, at places on a plane.

Places are hashed, never drawn in order, so that the noise at a place depends on nothing but the
place and a seed, and never repeats.

Sources: Perlin, Improving Noise, 2002, for the fade; Musgrave, Kolb, Mace, The Synthesis and
Rendering of Eroded Fractal Terrains, 1989, and Ebert et al., Texturing and Modeling, 2003, ch. 16,
for ridged multifractals; Quilez, Value Noise Derivatives, 2008, for detail held back by slope.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array

Plane = NDArray[np.float32]

LACUNARITY = 1.97
"""Ratio of the frequencies of two octaves: not 2, where all lattices would share points."""

_COSINE, _SINE = 0.8, 0.6
"""Of the turn from octave to octave, which hides the axes of the lattice."""


def hashed(i: NDArray[np.int32], j: NDArray[np.int32], seed: int) -> Plane:
    """Return a random number, 0 to 1, for each lattice point (...)."""
    word = i.astype(np.uint32) * np.uint32(0x9E3779B1)
    word ^= j.astype(np.uint32) * np.uint32(0x85EBCA77)
    word += np.uint32(seed * 0x27D4EB2F & 0xFFFFFFFF)
    word ^= word >> np.uint32(15)
    word *= np.uint32(0x2C1B3C6D)
    word ^= word >> np.uint32(12)
    word *= np.uint32(0x297A2D39)
    return np.asarray((word >> np.uint32(8)).astype(np.float32) * np.float32(2.0**-24))


def noise_with_slopes(places: Array, seed: int) -> tuple[Plane, Plane]:
    """Return smooth noise (...), -1 to 1, of unit wavelength and its slopes (..., 2).

    Args:
        places: (..., 2) in wavelengths.
        seed: of the lattice.
    """
    floor = np.floor(places)
    u, v = np.moveaxis((places - floor).astype(np.float32), -1, 0)
    i, j = np.moveaxis(floor.astype(np.int32), -1, 0)
    a, b, c, d = (hashed(i + di, j + dj, seed) for dj in (0, 1) for di in (0, 1))
    su, sv = (t * t * t * (t * (6 * t - 15) + 10) for t in (u, v))
    du, dv = (30 * t * t * (t - 1) * (t - 1) for t in (u, v))
    right, down, twist = b - a, c - a, a - b - c + d
    value = a + right * su + down * sv + twist * su * sv
    slopes = np.stack([du * (right + twist * sv), dv * (down + twist * su)], axis=-1)
    return 2 * value - 1, 2 * slopes


def noise(places: Array, seed: int) -> Array:
    """Return smooth noise (...), -1 to 1, of unit wavelength at places (..., 2)."""
    floor = np.floor(places)
    u, v = np.moveaxis((places - floor).astype(np.float32), -1, 0)
    i, j = np.moveaxis(floor.astype(np.int32), -1, 0)
    a, b, c, d = (hashed(i + di, j + dj, seed) for dj in (0, 1) for di in (0, 1))
    u, v = (t * t * t * (t * (6 * t - 15) + 10) for t in (u, v))
    upper = a + (b - a) * u
    return np.asarray(2 * (upper + (c + (d - c) * u - upper) * v) - 1, np.float32)


def _finer(places: Array) -> Array:
    """Return the places of the next octave."""
    x, z = places[..., 0], places[..., 1]
    c, s = LACUNARITY * _COSINE, LACUNARITY * _SINE
    return np.stack([c * x - s * z, s * x + c * z], axis=-1)


def _turned_back(slopes: Plane, octaves: int) -> Plane:
    """Return slopes along the axes of the first octave, given along those of a later one."""
    turn = complex(_COSINE, -_SINE) ** octaves
    c, s = np.float32(turn.real), np.float32(turn.imag)
    x, z = slopes[..., 0], slopes[..., 1]
    return np.stack([c * x - s * z, s * x + c * z], axis=-1)


def fractal(
    places: Array,
    seed: int,
    octaves: int = 5,
    gain: float = 0.5,
    spacing: Array | float = 0.0,
) -> Array:
    """Return fractal noise (...), about -1 to 1, whose largest features are one unit wide.

    Args:
        places: (..., 2) in widths of the largest features.
        seed: of the lattice.
        octaves: number of sizes.
        gain: ratio of the heights of two octaves.
        spacing: (...) between the places that are looked at, in the same unit; octaves too fine
            for it, which would be a random value a place, are left out.
    """
    total, share, span, width = np.zeros(places.shape[:-1]), 1.0, 0.0, 1.0
    for k in range(octaves):
        total += share * resolved(width, spacing) * noise(places, seed + k)
        span += share
        width /= LACUNARITY
        share *= gain
        places = _finer(places)
    return total / (0.7 * span)


def resolved(width: float, spacing: Array | float) -> Array:
    """Return which share (...), 0 to 1, of noise of a width places of a spacing can show."""
    return smoothstep(1.2, 2.8, width / np.maximum(spacing, 1e-9))


def eroded(places: Array, seed: int, octaves: int = 6) -> Array:
    """Return rounded hills (...), about 0 to 1, with calm slopes and rough tops and valleys."""
    total, share, span = np.zeros(places.shape[:-1]), 1.0, 0.0
    slopes = np.zeros(places.shape)
    for k in range(octaves):
        value, own = noise_with_slopes(places, seed + k)
        # Detail is held back where the land is steep already, as water has carried it away.
        slopes += _turned_back(own, k)
        total += share * value / (1.0 + 0.6 * (slopes**2).sum(axis=-1))
        span += share
        share *= 0.5
        places = _finer(places)
    return np.clip(0.5 + 0.75 * total / span, 0.0, 1.0)


def ridged(places: Array, seed: int, octaves: int = 7) -> Array:
    """Return ridges (...), 0 to 1: sharp crests with spurs, smooth valleys."""
    total, weight = np.zeros(places.shape[:-1]), np.ones(places.shape[:-1])
    share, span = 1.0, 0.0
    for k in range(octaves):
        crest = (1.0 - np.abs(noise(places, seed + k))) ** 2
        # The weight of detail follows the height before: spurs grow from crests alone.
        total += share * crest * weight
        weight = np.clip(1.6 * crest * weight, 0.0, 1.0)
        span += share
        share *= 0.52
        places = _finer(places)
    return np.clip(total / (0.8 * span), 0.0, 1.0)


def smoothstep(low: float, high: float, x: Array) -> Array:
    """Return 0 below `low`, 1 above `high` and a smooth step between."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))
