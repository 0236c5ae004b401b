"""Natural terrains: level, fractal, hills, boulders."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.generators import generates
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.terrain.base import GridTerrain
from pipeline.spec.terrain.kinds import BouldersTerrain, FlatTerrain, FractalTerrain, HillsTerrain


@generates(FlatTerrain)
def flat(terrain: FlatTerrain, rng: np.random.Generator) -> HeightField:
    """Return level ground at height 0."""
    del rng
    return HeightField(np.zeros((terrain.cells[1] + 1, terrain.cells[0] + 1)), terrain.size)


@generates(FractalTerrain)
def fractal(terrain: FractalTerrain, rng: np.random.Generator) -> HeightField:
    """Return fractional Brownian ground, `height` from its lowest to its highest point.

    Each halving of the size of features keeps `roughness` of their height, so the
    Hurst exponent is H = -log2 roughness; the spectrum falls with the power H + 1 of
    the wave number and is level below the largest feature.

    Source: Voss 1985, spectral synthesis.
    """
    hurst = -math.log2(max(terrain.roughness, 1e-3))
    largest = terrain.scale if terrain.scale is not None else max(terrain.size) / 2
    k, spectrum = _noise(terrain, rng)
    spectrum *= np.maximum(k, 1.0 / largest) ** -(hurst + 1.0)
    return HeightField(_spanning(_to_heights(spectrum, terrain), terrain.height), terrain.size)


SMALLEST_SPAN = float(np.finfo(np.float64).tiny / np.finfo(np.float64).eps)
"""Heights that span less have lost their digits to underflow [m]."""


@generates(HillsTerrain)
def hills(terrain: HillsTerrain, rng: np.random.Generator) -> HeightField:
    """Return smooth hills, or dunes, about `spacing` apart and `height` high."""
    if terrain.crest > 0.0:
        return HeightField(_dunes(terrain, rng), terrain.size)
    return HeightField(swells(terrain, terrain.height, terrain.spacing, rng), terrain.size)


def swells(terrain: GridTerrain, height: float, spacing: float, rng: np.random.Generator) -> Array:
    """Return heights (n_z + 1, n_x + 1) of swells `spacing` apart, of mean 0, all `height` high."""
    k, spectrum = _noise(terrain, rng)
    spectrum *= _band(k, spacing)
    return _spanning(_to_heights(spectrum, terrain), height)


def _band(k: Array, spacing: float) -> Array:
    """Return the share of each wave number in waves `spacing` apart.

    The band is one third of its mean wide: regular enough to be hills, irregular enough not to be
    an egg box.
    """
    centre = 1.0 / spacing
    return np.asarray(np.exp(-0.5 * ((k - centre) / (centre / 3.0)) ** 2))


LEE = 0.35
"""Share of a wave's length below the lee slope of the sharpest dunes."""

CONCAVITY = 1.5
"""Power with which slopes of dunes rise from their trough to their crest."""


def _dunes(terrain: HillsTerrain, rng: np.random.Generator) -> Array:
    """Return heights (n_z + 1, n_x + 1) of dunes across the wind.

    The phase of waves along the wind is found by their analytic signal. Each wave gets a crest
    at phase 0, a steep slope ahead of it, and a gentle one behind.
    """
    n_x, _ = _domain(terrain)
    k, spectrum = _noise(terrain, rng)
    k_x = np.fft.rfftfreq(n_x, terrain.size[0] / terrain.cells[0])
    # Crests lie across the wind more or less.
    spectrum *= _band(k, terrain.spacing) * (k_x / np.maximum(k, 1e-9)) ** 2
    waves = np.fft.ifft(spectrum, axis=0)[: terrain.cells[1] + 1]
    # Without the waves of negative frequency what comes back is complex.
    signal = np.fft.ifft(waves, n_x)[:, : terrain.cells[0] + 1]
    # The wave goes up with the wind to the crest, and falls beyond it.
    ahead = np.mod(np.angle(signal), 2.0 * np.pi) / (2.0 * np.pi)
    lee = 0.5 + terrain.crest * (LEE - 0.5)
    slope = np.where(ahead < lee, 1.0 - ahead / lee, (ahead - lee) / (1.0 - lee))
    round_slope = 0.5 - 0.5 * np.cos(np.pi * slope)
    profile = round_slope + terrain.crest * (slope**CONCAVITY - round_slope)
    return _spanning(np.abs(signal) * (2.0 * profile - 1.0), terrain.height)


def _noise(terrain: GridTerrain, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return wave numbers [1/m] and white noise of the spectrum, both (n_z', n_x' // 2 + 1).

    The domain is a quarter larger than the ground, so that opposite edges do not match.
    """
    n_x, n_z = _domain(terrain)
    k_x = np.fft.rfftfreq(n_x, terrain.size[0] / terrain.cells[0])
    k_z = np.fft.fftfreq(n_z, terrain.size[1] / terrain.cells[1])
    k = np.hypot(k_x, k_z[:, None])
    # Part by part: of large ground each array takes hundreds of megabytes.
    spectrum = np.empty((n_z, n_x // 2 + 1), dtype=complex)
    spectrum.real = rng.standard_normal(spectrum.shape)
    spectrum.imag = rng.standard_normal(spectrum.shape)
    spectrum[0, 0] = 0.0
    return k, spectrum


def _domain(terrain: GridTerrain) -> tuple[int, int]:
    n_x, n_z = ((n + n // 4 + 2) // 2 * 2 for n in terrain.cells)
    return n_x, n_z


def _to_heights(spectrum: Array, terrain: GridTerrain) -> Array:
    n_x, _ = _domain(terrain)
    # Axis by axis, as `irfft2` does; rows beyond the ground are not needed.
    rows = np.fft.ifft(spectrum, axis=0)[: terrain.cells[1] + 1]
    return np.ascontiguousarray(np.fft.irfft(rows, n_x)[:, : terrain.cells[0] + 1])


def _spanning(heights: Array, height: float) -> Array:
    """Scale to `height` between lowest and highest point, with the mean at 0."""
    span = float(np.ptp(heights))
    # Hills far wider than the ground leave nothing of their waves but what underflows.
    if span < SMALLEST_SPAN:
        return np.zeros_like(heights)
    return (heights - heights.mean()) * (height / span)


MIN_WIDTH, MIN_HEIGHT, MAX_HEIGHT = 0.7, 0.55, 0.9
"""Bounds of a boulder's other axes, as fractions of its longest."""

BATCH_VERTICES = 1 << 20
"""Vertices under boulders that are computed together, to bound memory."""


@dataclass(frozen=True, eq=False)
class Boulders:
    """N boulders: upright ellipsoids.

    Attributes:
        xz: (N, 2) positions of their middles [m].
        axes: (N, 3) half their length, width and height [m].
        turn: (N, 2) cosine and sine of the length's direction from x towards z.
    """

    xz: Array
    axes: Array
    turn: Array

    def subset(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> Boulders:
        """Return the boulders of a mask or of indices."""
        return Boulders(self.xz[which], self.axes[which], self.turn[which])


@generates(BouldersTerrain)
def boulders(terrain: BouldersTerrain, rng: np.random.Generator) -> HeightField:
    """Return ground with boulders; their steep sides take one cell."""
    ground_rng, heap_rng = rng.spawn(2)
    ground = HeightField(swells(terrain, terrain.height, terrain.spacing, ground_rng), terrain.size)
    scattered = scattered_boulders(terrain, heap_rng)
    foot = ground.height(scattered.xz[:, 0], scattered.xz[:, 1])
    # From top to bottom a boulder measures twice its third axis.
    middle = foot + scattered.axes[:, 2] * (1.0 - 2.0 * terrain.buried)
    heights = ground.heights.copy().ravel()
    for part, reach in _by_size(scattered, ground.cell):
        places, tops = _tops(scattered.subset(part), middle[part], reach, ground)
        np.maximum.at(heights, places, tops)
    return HeightField(heights.reshape(ground.heights.shape), terrain.size)


def scattered_boulders(terrain: BouldersTerrain, rng: np.random.Generator) -> Boulders:
    """Return boulders that cover the requested share of the ground, where they may overlap.

    Diameters d have the density 1/d between the smallest and the largest, so there are as
    many from 0.2 m to 0.4 m as from 0.4 m to 0.8 m. N boulders strewn anywhere leave
    exp(-N a/A) of the area A free, where a is the mean area of one.
    """
    small, large = terrain.diameters
    ratio = math.log(large / small)
    square = (large**2 - small**2) / (2.0 * ratio) if ratio > 1e-6 else small**2
    area = math.pi / 4.0 * square * (MIN_WIDTH + 1.0) / 2.0
    n = round(-math.log(1.0 - terrain.cover) * terrain.size[0] * terrain.size[1] / area)
    draw = rng.random((6, n))
    long = 0.5 * small * np.exp(ratio * draw[0])
    wide = long * (MIN_WIDTH + (1.0 - MIN_WIDTH) * draw[1])
    tall = long * (MIN_HEIGHT + (MAX_HEIGHT - MIN_HEIGHT) * draw[2])
    angle = math.pi * draw[3]
    xz = (draw[4:].T - 0.5) * np.array(terrain.size)
    free = np.hypot(*xz.T) - long >= terrain.clearing
    turn = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return Boulders(xz, np.stack([long, wide, tall], axis=-1), turn).subset(free)


def _by_size(
    scattered: Boulders, cell: tuple[float, float]
) -> Iterator[tuple[NDArray[np.int64], tuple[int, int]]]:
    """Yield boulders of similar size together, with the cells that they reach along x and z."""
    reach = np.ceil(scattered.axes[:, 0] / min(cell))
    for k in np.unique(reach):
        (members,) = np.nonzero(reach == k)
        longest = float(scattered.axes[members, 0].max())
        r_x, r_z = (math.ceil(longest / side) for side in cell)
        few = max(1, BATCH_VERTICES // ((2 * r_x + 2) * (2 * r_z + 2)))
        for start in range(0, len(members), few):
            yield members[start : start + few], (r_x, r_z)


def _tops(
    scattered: Boulders, middle: Array, reach: tuple[int, int], ground: HeightField
) -> tuple[NDArray[np.int64], Array]:
    """Return vertices under boulders, as places in the ravelled grid, and the surfaces there."""
    n_x, n_z = ground.cells
    dx, dz = ground.cell
    low = np.floor((scattered.xz / np.array(ground.size) + 0.5) * np.array([n_x, n_z]))
    i = low[:, 0, None, None] + np.arange(-reach[0], reach[0] + 2)
    j = low[:, 1, None, None] + np.arange(-reach[1], reach[1] + 2)[:, None]
    x = i * dx - ground.size[0] / 2.0 - scattered.xz[:, 0, None, None]
    z = j * dz - ground.size[1] / 2.0 - scattered.xz[:, 1, None, None]
    c, s = scattered.turn.T[..., None, None]
    a, b, tall = scattered.axes.T[..., None, None]
    left = 1.0 - ((c * x + s * z) / a) ** 2 - ((c * z - s * x) / b) ** 2
    under = (left >= 0.0) & (i >= 0) & (i <= n_x) & (j >= 0) & (j <= n_z)
    tops = middle[:, None, None] + tall * np.sqrt(np.maximum(left, 0.0))
    places = (j * (n_x + 1) + i).astype(np.int64)
    return places[under], tops[under]
