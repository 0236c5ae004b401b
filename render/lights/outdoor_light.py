"""Outdoors: the sky above and the earth below it, by day, in twilight and at night.

By day the sky is the model's. From the lowest sun that the model knows on downward its
last sky fades and turns to the colours of twilight, while moon, stars and the glow of the
night stand in it unchanged; each is in proportion to its illuminance in nature. What a
photographer would open the aperture for is decided by the sum: less light is shown darker,
but by far less than it is. All is continuous in the hour.
"""

from __future__ import annotations

import math

import numpy as np

from render.color import luminance
from render.config import Moon, Sun
from render.lights.environment_map import (
    HEIGHT,
    UP,
    WIDTH,
    Image,
    Vector,
    angles,
    brightness,
    directions,
    headed,
    irradiance,
    smooth,
)
from render.lights.key_light import Key
from render.lights.night import MOON_LUX, moonlight, night_sky, star_map
from render.lights.sky_model import clear
from render.lights.surroundings import Surroundings, card_of, turn_of
from render.lights.twilight import SUNSET_DEG, SUNSET_LUX, fading, twilit

_HAZE = 0.22
"""Sine of the angle below the horizon at which the haze has thinned to 1/e."""
_GLOW = 0.06
"""The same above the horizon, where the haze glows before the sky."""
_SET_DEG = -0.85
"""Height of the sun's middle at which the last of it has set: its radius and refraction."""

_VEILED_DEG = 34.0
"""How far from the sun clouds before it are bright."""

_LAID_DEG = -8.0
"""Height of the sun at which all light comes from above."""

_LUX = (-3.0, -2.0, math.log10(MOON_LUX), 0.5, 2.0, math.log10(SUNSET_LUX))
_STOPS = (-4.8, -4.4, -1.8, -1.7, -1.25, 0.0)
"""How much darker than by day a picture is, by the logarithm of the illuminance [lx]."""


def outdoors(sun: Sun, moon: Moon, stars: float, ground: Vector) -> Surroundings:
    """Return sky and earth.

    Args:
        sun: where it stands, and the air.
        moon: where it stands, if the sun does not outshine it.
        stars: how bright they are.
        ground: (3,) linear colour of the ground.
    """
    height = sun.elevation_deg
    azimuth = math.atan2(-sun.direction[2], sun.direction[0])
    shown = np.array(sun.direction)
    if height < SUNSET_DEG:
        shown = headed(azimuth, math.radians(SUNSET_DEG))
    sky, sun_light = clear(shown, sun.turbidity)
    key = Key(shown, sun.softness_deg, sun_light)
    veil = (1 - sun.clouds) ** 2
    if height >= SUNSET_DEG:
        # Clouds hide the disc sooner than they whiten the sky.
        key = key.dimmed(veil)
        image = _earth(_clouded(sky, sun), ground, key)
        return Surroundings(image, key, card_of(image, key))
    unit = brightness(_above(sky), UP) / SUNSET_LUX
    turn = turn_of(_clouded(sky, sun), key.dimmed(veil))
    faded = twilit(sky, height, azimuth)
    lux = SUNSET_LUX * fading(height) / brightness(_above(faded), UP)
    sky = faded * (lux * unit) + night_sky(moon) * unit
    key = _setting(key, height, azimuth)
    if not key.lit:
        key = moonlight(moon, height, unit)
    seen = (brightness(_above(sky), UP) + key.brightness(UP)) / unit
    key = key.dimmed(veil)
    image = _earth(_clouded(sky, sun), ground, key)
    # As the day ends, the card that faced the sun is laid down.
    turn *= float(smooth(np.array((height - _LAID_DEG) / (SUNSET_DEG - _LAID_DEG))))
    facing = Key(shown, key.width_deg, key.irradiance if key.toward @ shown > 0.99 else 0 * UP)
    level = card_of(image, key, 0.0)
    half = card_of(image, facing, 1.0)
    return Surroundings(
        image,
        key,
        level + turn * (half - level),
        float(np.interp(math.log10(max(seen, 1e-9)), _LUX, _STOPS)),
        star_map(stars * veil, height),
    )


def _clouded(sky: Image, sun: Sun) -> Image:
    overcast = _overcast(float(luminance(sky[: HEIGHT // 2]).mean()), sun)
    return np.asarray((1 - sun.clouds) * sky + sun.clouds * overcast)


def _setting(key: Key, height: float, azimuth: float) -> Key:
    """Return the sun as it sets behind the horizon."""
    share = float(smooth(np.array((height - _SET_DEG) / (SUNSET_DEG - _SET_DEG))))
    # Redder with every degree.
    red = np.array([1.0, 0.62, 0.35]) ** (1 - share)
    toward = headed(azimuth, math.radians(max(height, 0.2)))
    return Key(toward, key.width_deg, key.irradiance * share * red)


def _above(sky: Image) -> Image:
    """Return a sky without what is below the horizon."""
    return np.concatenate([sky[: HEIGHT // 2], np.zeros_like(sky[HEIGHT // 2 :])])


def _overcast(mean: float, sun: Sun) -> Image:
    """Return an overcast sky: of the CIE, and brighter where the sun stands behind the clouds.

    The zenith is three times as bright as the horizon. Without the sun's share all would
    be lit from above alone, which shows no shape.

    Args:
        mean: luminance of the clear sky.
        sun: behind the clouds; by night they are as blue as all else.
    """
    up = directions(WIDTH, HEIGHT)[..., 1].clip(0, 1)
    night = float(smooth(np.array((SUNSET_DEG - sun.elevation_deg) / 9.0)))
    tint = (1 - night) * np.array([0.95, 1.0, 1.07]) + night * np.array([0.50, 0.76, 1.25])
    veiled = np.exp(-((angles(np.array(sun.direction)) / _VEILED_DEG) ** 2)) * (1 - night)
    warm = tint * (1 - veiled[..., None]) + veiled[..., None] * np.array([1.04, 1.0, 0.94])
    shape = (1 + 2 * up) / 3 * (0.75 + 2.6 * veiled)
    return np.asarray(mean * 1.3 * shape[..., None] * warm)


def _earth(sky: Image, ground: Vector, key: Key) -> Image:
    """Paint the ground below the horizon, in haze that thins with the angle downward."""
    lit = irradiance(sky, UP) + key.irradiance * max(float(key.toward[1]), 0.0)
    soil = ground * lit / math.pi
    rim = sky[HEIGHT // 2 - 2][None]
    # Distance takes on the colour of the sky above it, not only of its lowest degrees.
    high = sky[HEIGHT // 2 - HEIGHT // 9][None].mean(axis=1, keepdims=True)
    air = 0.4 * rim + 0.4 * rim.mean(axis=1, keepdims=True) + 0.35 * high
    up = directions()[..., 1:2]
    haze = np.exp(-np.abs(up) / np.where(up < 0, _HAZE, _GLOW))
    return np.asarray(haze * air + (1 - haze) * np.where(up < 0, soil, sky))
