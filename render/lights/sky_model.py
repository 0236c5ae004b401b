"""The sky by day, from the model of Hosek and Wilkie, and in twilight.

Sources: L. Hosek and A. Wilkie, An Analytic Model for Full Spectral Sky-Dome Radiance, 2012,
    as implemented by Mitsuba's `sunsky`, which holds for a sun above the horizon.
    R. Seidelmann (ed.), Explanatory Supplement to the Astronomical Almanac, 1992, table 9.3,
    for the illuminance of level ground by a clear moonless sky in twilight.
"""

from __future__ import annotations

import math
from typing import Any

import mitsuba as mi
import numpy as np

from render.lights.environment_map import (
    HEIGHT,
    WIDTH,
    Map,
    Vector,
    direction_of,
    normalized,
    pixel_directions,
    resized,
)

_MODEL_WIDTH, _MODEL_HEIGHT = 256, 128
_SUN_DIAMETER_DEG = 0.5358
"""Angular diameter of the sun in Mitsuba's model."""

MIN_MODEL_ELEVATION_DEG = 1.0
"""Lowest elevation of the sun at which the sky model is evaluated."""

# Seidelmann 1992, table 9.3: elevation of the sun [degrees], log10 of the illuminance [lx].
_ELEVATIONS = (-18.0, -12.0, -9.0, -6.0, -3.0, 0.0, MIN_MODEL_ELEVATION_DEG)
_LOG_LUX = (-3.2, -2.1, -0.8, 0.53, 1.7, 2.6, 2.84)

SUNSET_LUX = 10 ** _LOG_LUX[-1]
"""Illuminance of level ground by the sky when the twilight begins [lx]."""


def clear_sky(sun_direction: Vector, turbidity: float) -> tuple[Map, Vector]:
    """Return the clear sky without its sun, and the sun's irradiance on a plane that faces it.

    Args:
        sun_direction: unit vector, above the horizon.
        turbidity: haze of the air.
    """
    local = [float(sun_direction[0]), float(-sun_direction[2]), float(sun_direction[1])]
    model = {"type": "sunsky", "turbidity": turbidity, "sun_direction": local}
    sky = mi.load_dict({**model, "sun_scale": 0.0})
    disc = mi.load_dict({**model, "sky_scale": 0.0})
    upper = pixel_directions(_MODEL_WIDTH, _MODEL_HEIGHT)[: _MODEL_HEIGHT // 2]
    half = _radiance(sky, upper.reshape(-1, 3)).reshape(upper.shape)
    half = np.maximum(half, 0.0)
    # The lower half repeats the horizon; the ground is painted over it.
    image = resized(np.concatenate([half, np.repeat(half[-1:], _MODEL_HEIGHT // 2, 0)]))
    ring = np.array(
        [sun_direction + 0.002 * _perpendicular(sun_direction, a) for a in (0.3, 1.9, 3.5, 5.1)]
    )
    disc_radiance = _radiance(disc, ring / np.linalg.norm(ring, axis=1, keepdims=True)).mean(axis=0)
    return image, disc_radiance * 2 * math.pi * (1 - math.cos(math.radians(_SUN_DIAMETER_DEG / 2)))


def _perpendicular(direction: Vector, angle: float) -> Vector:
    other = np.array([1.0, 0.0, 0.0]) if abs(direction[0]) < 0.9 else np.array([0.0, 0.0, 1.0])
    u = normalized(np.cross(direction, other))
    return np.asarray(math.cos(angle) * u + math.sin(angle) * np.cross(direction, u))


def _radiance(model: Any, directions: Vector) -> Vector:
    """Return the radiance (N, 3) of an emitter from world directions (N, 3)."""
    local = np.stack([directions[:, 0], -directions[:, 2], directions[:, 1]], axis=1)
    si = mi.SurfaceInteraction3f()
    if "scalar" in str(mi.variant()):
        values = []
        for d in local:
            si.wi = mi.Vector3f(*(-d))
            values.append(np.array(model.eval(si)))
        return np.array(values, np.float64)
    import drjit as dr

    si = dr.zeros(mi.SurfaceInteraction3f, len(local))
    si.wi = -mi.Vector3f(np.ascontiguousarray(local.T, np.float32))
    return np.array(model.eval(si), np.float64).T


def twilight_brightness(sun_elevation_deg: float) -> float:
    """Return the brightness of twilight: 1 at `MIN_MODEL_ELEVATION_DEG`, 1e-6 at its end."""
    log_lux = np.interp(sun_elevation_deg, _ELEVATIONS, _LOG_LUX)
    return float(10 ** (log_lux - _LOG_LUX[-1]))


def twilight_sky(sunset_sky: Map, sun_elevation_deg: float, sun_azimuth: float) -> Map:
    """Return the sky at sunset in the colours of twilight, in arbitrary units.

    Ozone turns the zenith blue, the glow contracts around the azimuth of the sun, and the
    shadow of the earth rises opposite to it.

    Args:
        sunset_sky: (H, W, 3) with the sun at `MIN_MODEL_ELEVATION_DEG`.
        sun_elevation_deg: of the sun.
        sun_azimuth: of the sun [rad].
    """
    depth = min(max((MIN_MODEL_ELEVATION_DEG - sun_elevation_deg) / 12.0, 0.0), 1.0)
    if depth == 0.0:
        return sunset_sky
    d = pixel_directions(WIDTH, HEIGHT)
    up = d[..., 1].clip(0, 1)
    level = np.hypot(d[..., 0], d[..., 2]).clip(1e-9, None)
    facing = 0.5 + 0.5 * (d @ direction_of(sun_azimuth, 0.0)) / level
    # Smooth at the zenith, where azimuth is undefined.
    facing = 0.5 + (facing - 0.5) * np.sqrt(1 - up**2)
    low = np.exp(-up / (0.24 - 0.12 * depth))[..., None]
    warm = facing[..., None] ** 3
    blue = np.array([0.20, 0.42, 0.95]) * (0.7 + 0.3 * facing[..., None])
    glow = np.array([2.9, 0.85, 0.16]) * warm
    belt = np.array([0.62, 0.46, 0.62]) * (1 - facing[..., None])
    painted = blue * (1 - 0.45 * low) + low * (glow + belt)
    mean = float(sunset_sky[: HEIGHT // 2].mean())
    painted *= mean / float(painted[: HEIGHT // 2].mean())
    share = math.sin(0.5 * math.pi * min(1.0, 3.2 * depth)) ** 2
    return np.asarray((1 - share) * sunset_sky + share * painted)
