"""Seamless noise, Worley cells and pebbles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Plane = NDArray[np.float32]

TILE = 1024
"""Width and height of a tile [pixels]."""

BAND = 32
"""Rows of a tile that are worked on at once."""


def noise(
    rng: np.random.Generator,
    slope: float,
    first: float = 4,
    last: float = 1e9,
    size: int = TILE,
    stretch: float = 1.0,
    turn_deg: float = 0.0,
) -> Plane:
    """Return tiling noise of unit deviation with power proportional to frequency^(-2 slope).

    Args:
        rng: source of the noise.
        slope: 1 is rough, 2 is smooth.
        first: lowest frequency [cycles per tile]; below it the power fades.
        last: highest frequency [cycles per tile].
        size: width and height [pixels].
        stretch: factor on the length of features along the rows.
        turn_deg: angle from the rows by which these are turned [degrees].
    """
    white = np.fft.rfft2(rng.standard_normal((size, size)))
    fy = np.fft.fftfreq(size, 1 / size)[:, None]
    fx = np.fft.rfftfreq(size, 1 / size)[None, :]
    if turn_deg:
        c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
        fx, fy = c * fx + s * fy, c * fy - s * fx
    f = np.hypot(fx * stretch, fy)
    gain = np.maximum(f, first) ** -slope * (f / first).clip(0, 1) ** 2 * (f <= last)
    field = np.fft.irfft2(white * gain, s=(size, size))
    return np.asarray(field / field.std(), np.float32)


def cells(
    rng: np.random.Generator, across: int, warp: float = 0.0
) -> tuple[Plane, Plane, NDArray[np.intp]]:
    """Return distances to the nearest and second nearest seed [cells], and the nearest cell."""
    seed_y, seed_x = rng.uniform(0.05, 0.95, (2, across * across)).astype(np.float32)
    y, x = np.mgrid[0:TILE, 0:TILE].astype(np.float32) * np.float32(across / TILE)
    if warp:
        x = x + np.float32(warp) * noise(rng, 1.6, first=across / 2)
        y = y + np.float32(warp) * noise(rng, 1.6, first=across / 2)
    first, second = np.empty_like(x), np.empty_like(x)
    owner = np.empty(x.shape, np.intp)
    # Bands of rows fit into the cache of a processor.
    for band in np.split(np.arange(TILE), TILE // BAND):
        rows = slice(band[0], band[-1] + 1)
        first[rows], second[rows], owner[rows] = _nearest(x[rows], y[rows], seed_x, seed_y, across)
    return np.sqrt(first), np.sqrt(second), owner


def _nearest(
    x: Plane, y: Plane, seed_x: Plane, seed_y: Plane, across: int
) -> tuple[Plane, Plane, NDArray[np.intp]]:
    """Return squared distances to the nearest and second nearest seed [cells], and its cell."""
    row, column = np.floor(y).astype(np.int32), np.floor(x).astype(np.int32)
    y, x = y - row.astype(np.float32), x - column.astype(np.float32)
    first = np.full(x.shape, 81.0, np.float32)
    second = first.copy()
    owner = np.zeros(x.shape, np.int32)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            cell = (row + dy) % across * across + (column + dx) % across
            d = (seed_y[cell] + dy - y) ** 2 + (seed_x[cell] + dx - x) ** 2
            nearer = d < first
            np.minimum(second, np.maximum(first, d), out=second)
            np.copyto(owner, cell, where=nearer)
            np.minimum(first, d, out=first)
    return first, second, owner.astype(np.intp)


def pebbles(rng: np.random.Generator, across: int, share: float) -> tuple[Plane, Plane]:
    """Return domes, 0 to 1, on a share of the cells, and a random value for each stone."""
    first, second, owner = cells(rng, across, warp=0.12)
    size = rng.uniform(0.25, 0.85, across * across) * (rng.random(across * across) < share)
    edge = (second - first) / np.maximum(size[owner], 1e-3)
    dome = np.sqrt(np.clip(edge, 0, 1)) * (size[owner] > 0) * (first < 0.6 * size[owner] + 0.1)
    stone = rng.uniform(-1, 1, across * across)[owner]
    return np.asarray(dome * size[owner], np.float32), np.asarray(stone, np.float32)
