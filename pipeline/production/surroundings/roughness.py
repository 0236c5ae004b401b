"""Roughness: goes on with the heights of a terrain beyond its edge, without repeating them.

Near the edge the terrain is reflected in its edge points, which keeps height and slope. Farther
out patches of the terrain, taken from random places, are mixed at constant variance.

Source: Heitz, Neyret, High-Performance By-Example Noise, 2018, for the mixing of patches.
"""

from __future__ import annotations

import numpy as np

from pipeline.production.surroundings.lattice_noise import hashed, smoothstep
from pipeline.simulation.spatial import Array

PATCH = 0.42
"""Distance between the middles of patches, as a share of the terrain's extent."""

REFLECTED = 0.16
"""Distance within which the reflection fades, as a share of the terrain's lesser extent."""


class Roughness:
    """Heights beyond the edge of a terrain with the same roughness.

    Args:
        heights: (n_z + 1, n_x + 1) of the terrain [m].
        size: its extent along x and z [m].
        seed: of the places from which patches are taken.
    """

    def __init__(self, heights: Array, size: tuple[float, float], seed: int) -> None:
        self._heights, self._size, self._seed = heights, np.array(size), seed
        self.mean = float(heights.mean())

    def at(self, places: Array) -> Array:
        """Return heights (N,) at places (N, 2) in the frame of the grid, outside it [m]."""
        half = self._size / 2.0
        on_edge = np.clip(places, -half, half)
        out = np.hypot(*(places - on_edge).T)
        share = 1.0 - smoothstep(0.0, REFLECTED * float(self._size.min()), out)
        result = self._patched(places)
        near = share > 0.0
        # Reflected in the edge point itself, so that the slope goes on too.
        mirrored = 2.0 * on_edge[near] - places[near]
        reflected = 2.0 * self._sampled(on_edge[near]) - self._sampled(mirrored)
        result[near] += share[near] * (reflected - result[near])
        return result

    def _patched(self, places: Array) -> Array:
        patch = PATCH * self._size
        spot = places / patch
        low = np.floor(spot)
        part = spot - low
        room = np.maximum(self._size / 2.0 - patch, 0.0)
        total, squares = np.zeros(len(places)), np.zeros(len(places))
        for corner in ((0, 0), (1, 0), (0, 1), (1, 1)):
            i, j = (low + corner).astype(np.int64).T
            weight = np.prod(np.where(corner, part, 1.0 - part), axis=1)
            weight = weight * weight * (3.0 - 2.0 * weight)
            middle = np.stack([hashed(i, j, self._seed + k) for k in (0, 1)], axis=-1)
            taken = (2.0 * middle - 1.0) * room + (part - corner) * patch
            total += weight * (self._sampled(taken) - self.mean)
            squares += weight * weight
        return self.mean + total / np.sqrt(squares)

    def _sampled(self, places: Array) -> Array:
        """Return the terrain's heights, bilinear, at places in its frame; its edge beyond it."""
        rows, columns = self._heights.shape
        cells = np.array([columns - 1, rows - 1])
        spot = np.clip((places / self._size + 0.5) * cells, 0.0, cells)
        low = np.minimum(spot.astype(np.int64), cells - 1)
        u, v = (spot - low).T
        i, j = low.T
        grid = self._heights
        before = grid[j, i] * (1.0 - u) + grid[j, i + 1] * u
        after = grid[j + 1, i] * (1.0 - u) + grid[j + 1, i + 1] * u
        return np.asarray(before * (1.0 - v) + after * v)
