"""Ground as nature makes it: level, fractal, hills."""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.terrain import FlatTerrain, FractalTerrain, Grid, HillsTerrain


def flat(words: FlatTerrain, chance: np.random.Generator) -> HeightField:
    """Return level ground at height 0."""
    del chance
    return HeightField(np.zeros((words.cells[1] + 1, words.cells[0] + 1)), words.size)


def fractal(words: FractalTerrain, chance: np.random.Generator) -> HeightField:
    """Return fractional Brownian ground, `height` from its lowest to its highest point.

    Each halving of the size of features keeps `roughness` of their height, so the
    Hurst exponent is H = -log2 roughness; the spectrum falls with the power H + 1 of
    the wave number and is level below the largest feature.

    Source: Voss 1985, spectral synthesis.
    """
    hurst = -math.log2(max(words.roughness, 1e-3))
    largest = words.scale if words.scale is not None else max(words.size) / 2
    k, spectrum = _noise(words, chance)
    spectrum *= np.maximum(k, 1.0 / largest) ** -(hurst + 1.0)
    return HeightField(_spanning(_to_heights(spectrum, words), words.height), words.size)


VANISHES = float(np.finfo(np.float64).tiny / np.finfo(np.float64).eps)
"""Heights under this have lost their digits."""


def hills(words: HillsTerrain, chance: np.random.Generator) -> HeightField:
    """Return smooth hills about `spacing` apart and `height` high."""
    return HeightField(swells(words, words.height, words.spacing, chance), words.size)


def swells(words: Grid, height: float, spacing: float, chance: np.random.Generator) -> Array:
    """Return heights (n_z + 1, n_x + 1) of swells `spacing` apart, of mean 0, all `height` high."""
    k, spectrum = _noise(words, chance)
    # A band of waves one third of their mean wide: regular enough to be hills,
    # irregular enough not to be an egg box.
    centre = 1.0 / spacing
    spectrum *= np.exp(-0.5 * ((k - centre) / (centre / 3.0)) ** 2)
    return _spanning(_to_heights(spectrum, words), height)


def _noise(words: Grid, chance: np.random.Generator) -> tuple[Array, Array]:
    """Return wave numbers [1/m] and white noise of the spectrum, both (n_z', n_x' // 2 + 1).

    The domain is a quarter larger than the ground, so that opposite edges do not match.
    """
    n_x, n_z = _domain(words)
    k_x = np.fft.rfftfreq(n_x, words.size[0] / words.cells[0])
    k_z = np.fft.fftfreq(n_z, words.size[1] / words.cells[1])
    k = np.hypot(*np.meshgrid(k_x, k_z))
    noise = chance.standard_normal((2, n_z, n_x // 2 + 1))
    spectrum = noise[0] + 1j * noise[1]
    spectrum[0, 0] = 0.0
    return k, spectrum


def _domain(words: Grid) -> tuple[int, int]:
    n_x, n_z = ((n + n // 4 + 2) // 2 * 2 for n in words.cells)
    return n_x, n_z


def _to_heights(spectrum: Array, words: Grid) -> Array:
    n_x, n_z = _domain(words)
    whole = np.fft.irfft2(spectrum, s=(n_z, n_x))
    return np.ascontiguousarray(whole[: words.cells[1] + 1, : words.cells[0] + 1])


def _spanning(heights: Array, height: float) -> Array:
    """Scale to `height` between lowest and highest point, with the mean at 0."""
    span = float(np.ptp(heights))
    # Hills far wider than the ground leave nothing of their waves but what underflows.
    if span < VANISHES:
        return np.zeros_like(heights)
    result: Array = (heights - heights.mean()) * (height / span)
    return result
