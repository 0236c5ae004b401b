"""Cloud shadows: how much of the key light reaches each place under drifting clouds.

The heaps that are painted into the sky are patches of a kilometre and more, which would take
minutes to cross a scene. The shadows are those of smaller ones, of the same cover: a tile of smooth
noise that repeats unnoticed beyond the haze and drifts with the wind.

Source: R. Voss, Random Fractal Forgeries, 1985, for noise by spectral synthesis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from render.config import Light
from render.lights.environment_map import Vector, smoothstep

CELLS, LENGTH = 256, 1536.0
"""Of the tile: cells along a side, and length of the side [m]."""

_SHARE = 0.62
"""Share of the ground in shadow under clouds of cover 1."""
_EDGE = 0.45
"""Width of the soft edges, in standard deviations of the noise."""
_LONGEST, _SHORTEST = 520.0, 64.0
"""Wavelengths of the noise [m]."""
_FALL = 1.6
"""Power by which the amplitude falls off with the frequency."""
_STAGE = 34.0
"""Radius around the origin that lies in the sun when the film begins [m]."""


@dataclass(frozen=True, eq=False)
class CloudShadows:
    """Shadows over all of a scene at one moment.

    Attributes:
        passed: (CELLS, CELLS) share of the key light that arrives, rows along +Z.
        key: unit vector to the key light.
        drift: way of the clouds since the film began, along x and z [m].
    """

    passed: NDArray[np.float32]
    key: Vector
    drift: tuple[float, float]


def cloud_shadows(light: Light, key: Vector, time: float) -> CloudShadows | None:
    """Return the shadows of clouds at a time, None where there are none.

    Args:
        light: of the scene.
        key: unit vector to the key light.
        time: since the film began [s].
    """
    strength = light.cloud_shadows
    if strength == 0.0 or light.sun is None:
        return None
    passed = _tile(light.sun.clouds.cumulus, strength, light.sun.day)
    return CloudShadows(passed, key, drift(light, time))


def drift(light: Light, time: float) -> tuple[float, float]:
    """Return the way of the clouds along x and z since the film began [m]."""
    way, heading = light.weather.wind * time, math.radians(light.weather.wind_heading_deg)
    return way * math.cos(heading), -way * math.sin(heading)


@lru_cache(maxsize=4)
def _tile(cover: float, strength: float, seed: int) -> NDArray[np.float32]:
    noise = np.random.default_rng(seed).standard_normal((CELLS, CELLS))
    frequency = np.hypot(*np.meshgrid(*[np.fft.fftfreq(CELLS, LENGTH / CELLS)] * 2))
    kept = (frequency >= 1 / _LONGEST) & (frequency <= 1 / _SHORTEST)
    amplitude = np.where(kept, np.maximum(frequency, 1e-9) ** -_FALL, 0.0)
    spectrum = np.fft.fft2(noise)
    field = np.fft.ifft2(spectrum * amplitude).real
    field /= field.std()
    # The middle of the clearest place comes to the origin, where the scene is.
    around = np.fft.ifft2(np.fft.fft2(field) * np.exp(-((_STAGE * frequency * 1.8) ** 2))).real
    row, column = np.unravel_index(np.argmin(around), around.shape)
    field = np.roll(field, (-row, -column), axis=(0, 1))
    threshold = np.quantile(field, 1 - _SHARE * cover)
    shade = smoothstep((field - threshold) / _EDGE + 0.5)
    return np.asarray(1 - strength * shade, np.float32)
