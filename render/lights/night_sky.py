"""The night sky: moonlight, airglow and stars.

Moonlight is as grey as sunlight; it is tinted blue, as dark-adapted eyes see it and films show it.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from render.config import Moon
from render.lights.environment_map import (
    UP,
    Map,
    Vector,
    angles_from,
    direction_of,
    illuminance,
    pixel_directions,
    smoothstep,
)
from render.lights.key_light import KeyLight

MOON_LUX = 0.25
"""Illuminance of a plane that faces a full moon [lx]."""

AIRGLOW_LUX = 0.003
"""Illuminance of level ground by a moonless sky, from stars and airglow [lx]."""

_MOON_SCATTERED_SHARE = 0.13
"""Share of the moonlight that the sky scatters; more than in nature, as in films."""

_MOON_TINT = np.array([0.56, 0.92, 1.45])
_SKY_TINT = np.array([0.42, 0.66, 1.30])

STARS_WIDTH, STARS_HEIGHT = 2048, 1024
_STAR_COUNT = 2200
_STAR_SEED = 1987


def moonlight(moon: Moon, sun_elevation_deg: float, unit: float) -> KeyLight:
    """Return the moon as key light, faded in after sunset.

    Args:
        moon: its position, phase and size.
        sun_elevation_deg: of the sun.
        unit: irradiance of one lux.
    """
    risen = float(smoothstep(np.array((-1.0 - sun_elevation_deg) / 5.0)))
    irradiance = _MOON_TINT * (_moon_lux(moon) * unit * risen)
    return KeyLight(_moon_direction(moon), moon.softness_deg, irradiance)


def night_sky(moon: Moon) -> Map:
    """Return the radiance of the night sky without stars, in lux on level ground."""
    up = pixel_directions()[..., 1].clip(0, 1)
    gradient = (0.55 + 0.9 * (1 - up) ** 3)[..., None] * _SKY_TINT
    gradient = gradient + (0.5 * np.exp(-up / 0.12))[..., None] * np.array([0.55, 0.8, 1.1])
    # As in `outdoor_light`, the ground is painted later.
    gradient[pixel_directions()[..., 1] < 0] = 0.0
    gradient = gradient / illuminance(gradient, UP)
    away = angles_from(_moon_direction(moon))
    halo = 1.0 + 2.2 * np.exp(-away / 9.0) + 7.0 * np.exp(-away / 2.2)
    elevation = math.radians(moon.elevation_deg)
    lit = _MOON_SCATTERED_SHARE * _moon_lux(moon) * math.sin(elevation) ** 0.5
    return np.asarray(gradient * (AIRGLOW_LUX + lit * halo[..., None]))


def star_map(brightness: float, sun_elevation_deg: float) -> Map | None:
    """Return the stars as display radiance, None while none is visible.

    Args:
        brightness: of the stars, 0 to 1.
        sun_elevation_deg: of the sun.
    """
    visible = brightness * float(smoothstep(np.array((-6.0 - sun_elevation_deg) / 7.0)))
    return _star_catalogue() * visible if visible > 0 else None


def _moon_direction(moon: Moon) -> Vector:
    return direction_of(math.radians(moon.heading_deg), math.radians(moon.elevation_deg))


def _moon_lux(moon: Moon) -> float:
    # A half moon gives a tenth of the light of a full one, because its relief is in shadow.
    return float(MOON_LUX * moon.phase**2.5)


@cache
def _star_catalogue() -> Map:
    """Return the same random stars always, each spread over several pixels of a map.

    A star is wider than a pixel of the frame, so that it neither sparkles as the camera moves
    nor falls between samples.
    """
    random = np.random.default_rng(_STAR_SEED)
    up = random.uniform(0.02, 1.0, _STAR_COUNT)
    around = random.uniform(0, 2 * math.pi, _STAR_COUNT)
    # One magnitude fainter there are about three times as many stars.
    bright = (0.05 * random.uniform(1e-4, 1.0, _STAR_COUNT) ** -0.7).clip(0, 2.5)
    hue = random.uniform(-1, 1, _STAR_COUNT)[:, None]
    tint = 1 + hue * np.array([0.22, 0.02, -0.22])
    # Extinction near the horizon.
    light = (bright * smoothstep(up / 0.3))[:, None] * tint
    image = np.zeros((STARS_HEIGHT, STARS_WIDTH, 3))
    row = np.arccos(up) / math.pi * STARS_HEIGHT - 0.5
    column = around / (2 * math.pi) * STARS_WIDTH - 0.5
    for r, c, color in zip(row, column, light, strict=True):
        stretch = 1 / max(math.sin((r + 0.5) * math.pi / STARS_HEIGHT), 0.05)
        for i in range(math.floor(r) - 1, math.floor(r) + 3):
            for j in range(math.floor(c - stretch), math.ceil(c + stretch) + 1):
                far = math.hypot(i - r, (j - c) / stretch)
                if 0 <= i < STARS_HEIGHT:
                    image[i, j % STARS_WIDTH] += color * max(1 - far, 0.0)
    image.flags.writeable = False
    return image
