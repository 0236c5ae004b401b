"""Twilight: how bright and of what colour the sky is while the sun is below the horizon.

Source of the illuminances: R. Seidelmann (ed.), Explanatory Supplement to the Astronomical
    Almanac, 1992, table 9.3: a clear sky without moon lights level ground by so many lux.
"""

from __future__ import annotations

import math

import numpy as np

from render.lights.environment_map import HEIGHT, WIDTH, Image, directions, headed

SUNSET_DEG = 1.0
"""Height of the lowest sun that the model of the sky is asked for."""

_HEIGHTS = (-18.0, -12.0, -9.0, -6.0, -3.0, 0.0, SUNSET_DEG)
_LOG_LUX = (-3.2, -2.1, -0.8, 0.53, 1.7, 2.6, 2.84)

SUNSET_LUX = 10 ** _LOG_LUX[-1]
"""Illuminance of level ground by the sky as the twilight begins [lx]."""


def fading(height_deg: float) -> float:
    """Return how bright the twilight is, 1 at `SUNSET_DEG` and 0.000001 at its end."""
    return float(10 ** (np.interp(height_deg, _HEIGHTS, _LOG_LUX) - _LOG_LUX[-1]))


def twilit(sky: Image, height_deg: float, azimuth: float) -> Image:
    """Return the last sky of the day in the colours of twilight; how bright it is means nothing.

    Ozone turns the zenith blue, the glow draws together about the place where the sun has
    set, and the shadow of the earth rises opposite to it.

    Args:
        sky: (H, W, 3) with the sun at `SUNSET_DEG`.
        height_deg: of the sun.
        azimuth: heading of the sun [rad].
    """
    depth = min(max((SUNSET_DEG - height_deg) / 12.0, 0.0), 1.0)
    if depth == 0.0:
        return sky
    d = directions(WIDTH, HEIGHT)
    up = d[..., 1].clip(0, 1)
    level = np.hypot(d[..., 0], d[..., 2]).clip(1e-9, None)
    facing = 0.5 + 0.5 * (d @ headed(azimuth, 0.0)) / level
    # Smooth at the zenith, where there is no azimuth.
    facing = 0.5 + (facing - 0.5) * np.sqrt(1 - up**2)
    low = np.exp(-up / (0.24 - 0.12 * depth))[..., None]
    warm = facing[..., None] ** 3
    blue = np.array([0.20, 0.42, 0.95]) * (0.7 + 0.3 * facing[..., None])
    glow = np.array([2.9, 0.85, 0.16]) * warm
    belt = np.array([0.62, 0.46, 0.62]) * (1 - facing[..., None])
    painted = blue * (1 - 0.45 * low) + low * (glow + belt)
    mean = float(sky[: HEIGHT // 2].mean())
    painted *= mean / float(painted[: HEIGHT // 2].mean())
    share = math.sin(0.5 * math.pi * min(1.0, 3.2 * depth)) ** 2
    return np.asarray((1 - share) * sky + share * painted)
