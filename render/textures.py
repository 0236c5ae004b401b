"""Patterns of the ground and of things: tiles of colour and relief, made by numpy.

A tile is square and continues over its edges. Its relief is in metres for a tile
of its natural size, so that the slopes which the light sees are those of real
soil, sand or rock. All patterns come from fixed seeds.

Slow variation is kept out of the tiles on purpose (see `_noise`): a light or dark
spot the size of the tile is what the eye finds when a tile is laid again and again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Plane = NDArray[np.float32]

TILE = 1024
"""Width and height of a tile [pixels]."""


@dataclass(frozen=True, eq=False)
class Tile:
    """One pattern.

    Attributes:
        shade: (TILE, TILE) factor on the linear base colour, about 1 on average.
        warmth: (TILE, TILE) -1 to 1, shifts the colour from blue to red.
        relief: (TILE, TILE) height [m] of a tile of natural size.
        size: natural size of the tile [m].
    """

    shade: Plane
    warmth: Plane
    relief: Plane
    size: float


@lru_cache(maxsize=16)
def tile(pattern: str) -> Tile:
    """Return the tile of a pattern of `render.words.material.Texture`."""
    shade, warmth, relief, size = _PATTERNS[pattern](np.random.default_rng(_SEED))
    shade = shade / shade.mean()
    planes = [np.asarray(plane, np.float32) for plane in (shade, warmth, _softened(relief))]
    return Tile(planes[0], planes[1], planes[2], size)


@lru_cache(maxsize=4)
def patches(size: int = 512) -> Plane:
    """Return a (size, size) map of slow patches, 0 to 1 with soft borders, mean near 0.5."""
    rng = np.random.default_rng(_SEED + 1)
    field = _noise(rng, 2.2, first=2, size=size) + 0.35 * _noise(rng, 1.2, first=24, size=size)
    return (1 / (1 + np.exp(-2.2 * field))).astype(np.float32)


_SEED = 19870501


def _softened(relief: Plane) -> Plane:
    """Return the relief without slopes from pixel to pixel, which only sparkle."""
    for axis in (0, 1):
        relief = 0.5 * relief + 0.25 * (np.roll(relief, 1, axis) + np.roll(relief, -1, axis))
    return relief


def _noise(
    rng: np.random.Generator,
    slope: float,
    first: float = 4,
    last: float = 1e9,
    size: int = TILE,
    stretch: float = 1.0,
) -> Plane:
    """Return tiling noise of unit deviation with power falling as frequency^(-2 slope).

    Args:
        rng: source of the noise.
        slope: 1 is rough, 2 is smooth.
        first: lowest frequency [cycles a tile]; below it the power fades.
        last: highest frequency [cycles a tile].
        size: width and height [pixels].
        stretch: above 1 draws the noise out along the rows.
    """
    white = np.fft.rfft2(rng.standard_normal((size, size)))
    fy = np.fft.fftfreq(size, 1 / size)[:, None]
    fx = np.fft.rfftfreq(size, 1 / size)[None, :] * stretch
    f = np.hypot(fx, fy)
    gain = np.maximum(f, first) ** -slope * (f / first).clip(0, 1) ** 2 * (f <= last)
    field = np.fft.irfft2(white * gain, s=(size, size))
    return np.asarray(field / field.std(), np.float32)


def _cells(
    rng: np.random.Generator, across: int, warp: float = 0.0
) -> tuple[Plane, Plane, NDArray[np.intp]]:
    """Return distances to the nearest and second nearest seed [cells], and whose cell it is."""
    seed_y, seed_x = rng.uniform(0.05, 0.95, (2, across * across)).astype(np.float32)
    y, x = np.mgrid[0:TILE, 0:TILE].astype(np.float32) * np.float32(across / TILE)
    if warp:
        x = x + np.float32(warp) * _noise(rng, 1.6, first=across / 2)
        y = y + np.float32(warp) * _noise(rng, 1.6, first=across / 2)
    row, column = np.floor(y).astype(np.int32), np.floor(x).astype(np.int32)
    y, x = y - row, x - column
    first = np.full((TILE, TILE), 81.0, np.float32)
    second = first.copy()
    owner = np.zeros((TILE, TILE), np.intp)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            cell = (row + dy) % across * across + (column + dx) % across
            d = (seed_y[cell] + dy - y) ** 2 + (seed_x[cell] + dx - x) ** 2
            nearer = d < first
            second = np.where(nearer, first, np.minimum(second, d))
            owner = np.where(nearer, cell, owner)
            first = np.where(nearer, d, first)
    return np.sqrt(first), np.sqrt(second), owner


def _pebbles(rng: np.random.Generator, across: int, share: float) -> tuple[Plane, Plane]:
    """Return domes 0 to 1 on a share of the cells, and a random value for each stone."""
    first, second, owner = _cells(rng, across, warp=0.12)
    size = rng.uniform(0.25, 0.85, across * across) * (rng.random(across * across) < share)
    edge = (second - first) / np.maximum(size[owner], 1e-3)
    dome = np.sqrt(np.clip(edge, 0, 1)) * (size[owner] > 0) * (first < 0.6 * size[owner] + 0.1)
    stone = rng.uniform(-1, 1, across * across)[owner]
    return np.asarray(dome * size[owner], np.float32), np.asarray(stone, np.float32)


def _soil(rng: np.random.Generator) -> tuple[Plane, Plane, Plane, float]:
    clods, grain = _noise(rng, 1.7, first=6), _noise(rng, 0.8, first=50)
    gravel, gravel_tint = _pebbles(rng, 90, 0.35)
    stones, stone_tint = _pebbles(rng, 26, 0.16)
    relief = 0.008 * clods + 0.0002 * grain + 0.0035 * gravel + 0.013 * stones
    shade = 1 + 0.13 * clods + 0.09 * grain
    shade += np.where(gravel > 0, 0.22 * gravel_tint, 0) + np.where(
        stones > 0, 0.15 + 0.22 * stone_tint, 0
    )
    warmth = 0.25 * _noise(rng, 1.4, first=5) - 0.5 * (stones > 0) - 0.3 * (gravel > 0)
    return shade.clip(0.3, 1.9), warmth.clip(-1, 1), relief, 2.6


def _sand(rng: np.random.Generator) -> tuple[Plane, Plane, Plane, float]:
    bend, grain = _noise(rng, 2.4, first=2), _noise(rng, 0.3, first=90)
    y, x = np.mgrid[0:TILE, 0:TILE] / TILE
    phase = 2 * np.pi * (17 * y + 4 * x) + 1.9 * bend
    # The lee side of a ripple is steeper than the windward one.
    ripple = np.sin(phase + 0.45 * np.sin(phase))
    height = 0.6 + 0.4 * np.tanh(_noise(rng, 2.0, first=2))
    relief = 0.0055 * ripple * height + 0.0028 * _noise(rng, 1.6, first=5) + 0.0003 * grain
    shade = 1 + 0.05 * ripple * height + 0.05 * grain + 0.03 * _noise(rng, 1.2, first=6)
    return shade.clip(0.5, 1.5), 0.2 * _noise(rng, 1.3, first=5), relief, 2.2


def _grass(rng: np.random.Generator) -> tuple[Plane, Plane, Plane, float]:
    blades, points = 52_000, 30
    along = np.linspace(0, 1, points)[None, :]
    clump = _noise(rng, 1.8, first=5)
    root = rng.uniform(0, TILE, (2, blades, 1))
    lean = 1.3 * _noise(rng, 2.2, first=3)
    at = root[:, :, 0].astype(np.intp)
    heading = lean[at[0], at[1]][:, None] + rng.normal(0, 0.9, (blades, 1))
    heading = heading + rng.normal(0, 0.5, (blades, 1)) * along
    length = rng.uniform(14, 38, (blades, 1))
    row = (root[0] + length * along * np.sin(heading)).astype(np.intp) % TILE
    column = (root[1] + length * along * np.cos(heading)).astype(np.intp) % TILE
    tall = rng.uniform(0.4, 1.0, (blades, 1)) * np.sin(np.pi * (0.15 + 0.75 * along))
    height = np.zeros((TILE, TILE))
    np.maximum.at(height, (row, column), tall)
    np.maximum.at(height, (row, (column + 1) % TILE), tall * 0.97)
    tint = np.zeros((TILE, TILE))
    top = tall >= height[row, column]
    tint[row[top], column[top]] = np.broadcast_to(rng.normal(0, 1, (blades, 1)), row.shape)[top]
    relief = 0.006 * height + 0.01 * clump
    shade = (0.35 + 0.85 * height) * (1 + 0.16 * tint) * (1 + 0.12 * clump)
    warmth = 0.3 * tint + 0.25 * _noise(rng, 1.5, first=4)
    return shade.clip(0.15, 2.0), warmth.clip(-1, 1), relief, 1.9


def _snow(rng: np.random.Generator) -> tuple[Plane, Plane, Plane, float]:
    drift, crust, grain = (
        _noise(rng, 2.4, first=3),
        _noise(rng, 1.2, first=20),
        _noise(rng, 0.2, first=120),
    )
    relief = 0.012 * drift + 0.0012 * crust + 0.0003 * grain
    return 1 + 0.015 * crust + 0.02 * grain, 0.1 * drift, relief, 2.4


def _rock(rng: np.random.Generator) -> tuple[Plane, Plane, Plane, float]:
    first, second, owner = _cells(rng, 9, warp=0.35)
    fine_first, fine_second, _ = _cells(rng, 31, warp=0.3)
    crack = np.exp(-(((second - first) / 0.035) ** 2))
    chip = np.exp(-(((fine_second - fine_first) / 0.06) ** 2))
    rough = _noise(rng, 1.55, first=6)
    facet = rng.uniform(-1, 1, 81)[owner]
    relief = 0.018 * rough + 0.008 * facet - 0.009 * crack - 0.001 * chip
    shade = 1 + 0.16 * rough + 0.08 * facet - 0.4 * crack - 0.1 * chip
    shade += 0.07 * _noise(rng, 0.5, first=60)
    warmth = 0.45 * _noise(rng, 1.5, first=4)
    return shade.clip(0.25, 1.8), warmth.clip(-1, 1), relief, 2.9


def _wood(rng: np.random.Generator) -> tuple[Plane, Plane, Plane, float]:
    fibre = _noise(rng, 0.9, first=14, stretch=24.0)
    flow = _noise(rng, 2.2, first=2, stretch=5.0)
    y = np.mgrid[0:TILE, 0:TILE][0] / TILE
    ring = np.sin(2 * np.pi * 7 * y + 2.2 * flow) ** 3
    shade = 1 + 0.2 * ring + 0.1 * fibre
    return shade.clip(0.4, 1.6), 0.3 * ring, 0.0003 * fibre + 0.0004 * ring, 0.5


def _mottle(rng: np.random.Generator) -> tuple[Plane, Plane, Plane, float]:
    spots = np.tanh(1.6 * _noise(rng, 1.8, first=5))
    fine = _noise(rng, 0.8, first=40)
    return 1 + 0.22 * spots + 0.05 * fine, 0.3 * spots, 0.002 * fine, 1.0


_PATTERNS: dict[str, Callable[[np.random.Generator], tuple[Plane, Plane, Plane, float]]] = {
    "soil": _soil,
    "sand": _sand,
    "grass": _grass,
    "snow": _snow,
    "rock": _rock,
    "wood": _wood,
    "mottle": _mottle,
}
