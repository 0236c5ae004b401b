"""Haze: how dense the air is, and what light it scatters.

Source: R. Hoffman and A. Preetham, Rendering Outdoor Light Scattering in Real Time, 2002, for
    haze as extinction and in-scattered sky light; the density falls off exponentially.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from render.config import Light, Sun
from render.lights.environment_map import Map, Vector, smoothstep
from render.lights.sun_position import sun_elevation_deg

COLUMNS, ROWS = 64, 12
"""Size of the table of scattered light: columns once around, rows from the horizon up."""

TOP = 0.5
"""Sine of the elevation of the uppermost row."""

HEIGHT_M = 85.0
"""Height in which the density falls to 1/e [m]: hills stand in mist with their tops clear."""

_DENSEST = 0.036
"""Extinction of haze 1 [1/m]: fog through which one sees 130 m."""
_POWER = 2.2
"""Of the extinction against the number that authors write: small numbers are fine steps."""

_TINT = np.array([0.80, 1.0, 1.32])
"""Extinction by colour: the far is bluer than it is, and its own light redder."""

_CLEAR, _PER_TURBIDITY = 0.085, 0.03
_OVERCAST, _MORNING, _LOW_SUN = 0.06, 0.07, 0.04
_RAIN, _SNOW = 0.16, 0.34

_FORWARD, _FORWARD_SHARE = 0.72, 0.22
"""Asymmetry of the light that haze scatters forward, and the share of the key light in it."""

_LOW_BELOW = 0.42
"""Sine of the elevation of a sun from which no glow is seen: haze lies in its way at a slant."""

_STUDIO = 0.8
"""Of a studio: 9 % at 5 m, so that a floor goes over into the backdrop without a seam."""


@dataclass(frozen=True, eq=False)
class Haze:
    """Haze over all of a scene.

    Attributes:
        extinction: (3,) at height 0, by colour [1/m].
        height: in which the density falls to 1/e [m].
        light: (ROWS, COLUMNS, 3) radiance of endless haze. Columns run as in an environment map,
            the first at -Z; rows by the sine of the elevation, from 0 to `TOP`.
    """

    extinction: Vector
    height: float
    light: Map


def haze_strength(light: Light) -> float:
    """Return the strength of the haze, 0 to 1: as written, of a studio, or by weather and hour."""
    if light.haze is not None:
        return light.haze
    if light.studio is not None:
        return _STUDIO
    if light.sun is None:
        return 0.0
    fallen = _RAIN * light.weather.rain + _SNOW * light.weather.snow
    return min(natural_strength(light.sun) + fallen, 1.0)


def natural_strength(sun: Sun) -> float:
    """Return the haze of the weather and the hour: more of it in the early morning."""
    low = 1.0 - float(smoothstep(np.array(sun_elevation_deg(sun) / 25.0)))
    morning = low * (sun.hour < 12)
    strength = _CLEAR + _PER_TURBIDITY * sun.turbidity + _OVERCAST * sun.clouds.overcast
    return float(strength + _LOW_SUN * low + _MORNING * morning)


def haze_of(strength: float, sky: Map, glow: Map | float = 0.0) -> Haze | None:
    """Return the haze of a strength under a clear sky, None without any.

    Args:
        strength: 0 to 1.
        sky: (H, W, 3) map as it lights the scene, without clouds.
        glow: (ROWS, COLUMNS, 3) light of a low sun in it; see `sun_glow`.
    """
    if strength <= 0.0:
        return None
    extinction = _DENSEST * strength**_POWER * _TINT
    return Haze(extinction, HEIGHT_M, _low_sky(sky) + glow)


def sun_glow(direction: Vector, irradiance: Vector) -> Map:
    """Return the light of a low sun that haze scatters forward, at the table's directions.

    Source: L. Henyey and J. Greenstein, Diffuse radiation in the galaxy, 1941.

    Args:
        direction: (3,) unit vector to it.
        irradiance: (3,) on a plane that faces it, scaled as the map of the sky.
    """
    up = np.linspace(0.0, TOP, ROWS)[:, None]
    around = 2.0 * np.pi * np.arange(COLUMNS) / COLUMNS
    level = np.sqrt(1.0 - up**2)
    x, y, z = direction
    cosine = level * (np.sin(around) * x - np.cos(around) * z) + up * y
    g = _FORWARD
    phase = (1.0 - g * g) / (4.0 * np.pi * (1.0 + g * g - 2.0 * g * cosine) ** 1.5)
    low = 1.0 - float(smoothstep(np.array(y / _LOW_BELOW)))
    return np.asarray(_FORWARD_SHARE * low * phase[..., None] * irradiance)


def _low_sky(sky: Map) -> Map:
    """Return the radiance of a map at the directions of the table, averaged over its columns."""
    height, width = sky.shape[:2]
    across = width // COLUMNS
    # The centres of a column's pixels lie around its left edge, where the table has its value.
    shifted = np.roll(sky, across // 2, axis=1)
    columns = shifted[: height // 2].reshape(height // 2, COLUMNS, across, 3).mean(axis=2)
    elevation = np.arcsin(np.linspace(0.0, TOP, ROWS))
    row = (0.5 - elevation / np.pi) * height - 0.5
    top = np.clip(np.floor(row).astype(int), 0, height // 2 - 1)
    below = np.minimum(top + 1, height // 2 - 1)
    part = (row - top).clip(0, 1)[:, None, None]
    return np.asarray(columns[top] * (1 - part) + columns[below] * part)
