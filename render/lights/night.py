"""Night: moonlight, the sky that it leaves dark, and stars.

Moonlight is as grey as sunlight, yet eyes that are used to the dark see it blue, and
films show it so.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from render.config import Moon
from render.lights.environment_map import (
    UP,
    Image,
    angles,
    brightness,
    directions,
    headed,
    smooth,
)
from render.lights.key_light import Key

MOON_LUX = 0.25
"""Illuminance of a plane that faces a full moon [lx]."""

AIRGLOW_LUX = 0.003
"""Illuminance of level ground by a sky without moon [lx]: stars and the glow of the air."""

_SCATTERED = 0.13
"""Part of the moon's light that comes by way of the sky; more than there is, as in films."""

_MOON = np.array([0.56, 0.92, 1.45])
_SKY = np.array([0.42, 0.66, 1.30])

STARS_WIDTH, STARS_HEIGHT = 2048, 1024
_STARS = 2200
_SEED = 1987


def moonlight(moon: Moon, sun_deg: float, unit: float) -> Key:
    """Return the moon as key light, fading in behind the sun that has set.

    Args:
        moon: where it stands.
        sun_deg: height of the sun.
        unit: irradiance of one lux.
    """
    toward = headed(math.radians(moon.heading_deg), math.radians(moon.elevation_deg))
    risen = float(smooth(np.array((-1.0 - sun_deg) / 5.0)))
    return Key(toward, moon.softness_deg, _MOON * (_moon_lux(moon) * unit * risen))


def night_sky(moon: Moon) -> Image:
    """Return the sky at night without stars, in lux on level ground."""
    up = directions()[..., 1].clip(0, 1)
    gradient = (0.55 + 0.9 * (1 - up) ** 3)[..., None] * _SKY
    gradient = gradient + (0.5 * np.exp(-up / 0.12))[..., None] * np.array([0.55, 0.8, 1.1])
    # As in `outdoors`, all that is below the horizon is painted later.
    gradient[directions()[..., 1] < 0] = 0.0
    gradient = gradient / brightness(gradient, UP)
    toward = headed(math.radians(moon.heading_deg), math.radians(moon.elevation_deg))
    away = angles(toward)
    halo = 1.0 + 2.2 * np.exp(-away / 9.0) + 7.0 * np.exp(-away / 2.2)
    lit = _SCATTERED * _moon_lux(moon) * math.sin(math.radians(moon.elevation_deg)) ** 0.5
    return np.asarray(gradient * (AIRGLOW_LUX + lit * halo[..., None]))


def _moon_lux(moon: Moon) -> float:
    # A half moon gives a tenth of the light of a full one, for its relief is all in shadow.
    return float(MOON_LUX * moon.phase**2.5)


def star_map(stars: float, sun_deg: float) -> Image | None:
    """Return the stars as radiance to be shown, None where none is to be seen.

    Args:
        stars: how bright they are, 0 to 1.
        sun_deg: height of the sun.
    """
    seen = stars * float(smooth(np.array((-6.0 - sun_deg) / 7.0)))
    return _catalogue() * seen if seen > 0 else None


@cache
def _catalogue() -> Image:
    """Return the stars of this world: always the same, each over several pixels of a map.

    A star is wider than a pixel of the picture, so that it neither sparkles as the camera
    moves nor is lost between samples.
    """
    random = np.random.default_rng(_SEED)
    up = random.uniform(0.02, 1.0, _STARS)
    around = random.uniform(0, 2 * math.pi, _STARS)
    # One magnitude fainter there are about three times as many stars.
    bright = (0.05 * random.uniform(1e-4, 1.0, _STARS) ** -0.7).clip(0, 2.5)
    hue = random.uniform(-1, 1, _STARS)[:, None]
    tint = 1 + hue * np.array([0.22, 0.02, -0.22])
    # Air takes their light near the horizon.
    light = (bright * smooth(up / 0.3))[:, None] * tint
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
