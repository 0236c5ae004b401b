"""Outdoor light: the sky above and the ground below the horizon, by day, in twilight and at night.

By day the sky comes from the sky model. Below the model's lowest sun its last sky fades and takes
the colours of twilight, while moon, stars and airglow keep their brightness; each part has its
natural illuminance. The exposure follows the sum: a darker scene is shown darker, but by far
less than it is. All is continuous in the hour.
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
    Map,
    Vector,
    angles_from,
    direction_of,
    illuminance,
    irradiance,
    pixel_directions,
    smoothstep,
)
from render.lights.key_light import KeyLight, LightEnvironment, card_illuminance, card_turn
from render.lights.night_sky import MOON_LUX, moonlight, night_sky, star_map
from render.lights.sky_model import (
    MIN_MODEL_ELEVATION_DEG,
    SUNSET_LUX,
    clear_sky,
    twilight_brightness,
    twilight_sky,
)
from render.lights.sun_position import sun_direction, sun_elevation_deg

_HAZE_BELOW = 0.22
"""Sine of the angle below the horizon at which the haze has thinned to 1/e."""
_HAZE_ABOVE = 0.06
"""The same above the horizon, where the haze glows in front of the sky."""
_SUN_SET_DEG = -0.85
"""Elevation of the sun's centre when its upper limb sets: its radius and refraction."""

_VEIL_WIDTH_DEG = 34.0
"""Angle from the sun over which clouds in front of it are bright."""

_CARD_LEVEL_DEG = -8.0
"""Elevation of the sun below which the grey card lies level."""

# Exposure [stops] against the illuminance of level ground (log10 lux).
_EXPOSURE_LOG_LUX = (-3.0, -2.0, math.log10(MOON_LUX), 0.5, 2.0, math.log10(SUNSET_LUX))
_EXPOSURE_STOPS = (-4.8, -4.4, -1.8, -1.7, -1.25, 0.0)


def outdoor_light(sun: Sun, moon: Moon, stars: float, ground: Vector) -> LightEnvironment:
    """Return the light of sun, moon, stars, sky and ground.

    Args:
        sun: its position, and the air.
        moon: its position; it lights the scene once the sun has set.
        stars: their brightness, 0 to 1.
        ground: (3,) linear colour of the ground.
    """
    elevation = sun_elevation_deg(sun)
    direction = sun_direction(sun)
    azimuth = math.atan2(-direction[2], direction[0])
    shown = np.array(direction)
    if elevation < MIN_MODEL_ELEVATION_DEG:
        shown = direction_of(azimuth, math.radians(MIN_MODEL_ELEVATION_DEG))
    sky, sun_irradiance = clear_sky(shown, sun.turbidity)
    key = KeyLight(shown, sun.softness_deg, sun_irradiance)
    # Clouds hide the disc sooner than they whiten the sky.
    sun_transmittance = (1 - sun.clouds.overcast) ** 2
    if elevation >= MIN_MODEL_ELEVATION_DEG:
        key = key.scaled(sun_transmittance)
        image = _with_ground(_clouded(sky, sun), ground, key)
        return LightEnvironment(image, key, card_illuminance(image, key))
    unit = illuminance(_above_horizon(sky), UP) / SUNSET_LUX
    turn = card_turn(_clouded(sky, sun), key.scaled(sun_transmittance))
    faded = twilight_sky(sky, elevation, azimuth)
    lux = SUNSET_LUX * twilight_brightness(elevation) / illuminance(_above_horizon(faded), UP)
    sky = faded * (lux * unit) + night_sky(moon) * unit
    key = _setting_sun(key, elevation, azimuth)
    if not key.is_lit:
        key = moonlight(moon, elevation, unit)
    level_lux = (illuminance(_above_horizon(sky), UP) + key.illuminance(UP)) / unit
    key = key.scaled(sun_transmittance)
    image = _with_ground(_clouded(sky, sun), ground, key)
    # As the day ends, the card that faced the sun is laid level.
    turn *= float(
        smoothstep(
            np.array((elevation - _CARD_LEVEL_DEG) / (MIN_MODEL_ELEVATION_DEG - _CARD_LEVEL_DEG))
        )
    )
    is_sun = key.direction @ shown > 0.99
    facing = KeyLight(shown, key.diameter_deg, key.irradiance if is_sun else 0 * UP)
    level = card_illuminance(image, key, 0.0)
    half = card_illuminance(image, facing, 1.0)
    return LightEnvironment(
        image,
        key,
        level + turn * (half - level),
        float(np.interp(math.log10(max(level_lux, 1e-9)), _EXPOSURE_LOG_LUX, _EXPOSURE_STOPS)),
        star_map(stars * sun_transmittance, elevation),
    )


def _clouded(sky: Map, sun: Sun) -> Map:
    overcast = _overcast(float(luminance(sky[: HEIGHT // 2]).mean()), sun)
    return np.asarray((1 - sun.clouds.overcast) * sky + sun.clouds.overcast * overcast)


def _setting_sun(key: KeyLight, elevation: float, azimuth: float) -> KeyLight:
    """Return the sun while it sets: fading, and redder with every degree."""
    t = (elevation - _SUN_SET_DEG) / (MIN_MODEL_ELEVATION_DEG - _SUN_SET_DEG)
    share = float(smoothstep(np.array(t)))
    red = np.array([1.0, 0.62, 0.35]) ** (1 - share)
    direction = direction_of(azimuth, math.radians(max(elevation, 0.2)))
    return KeyLight(direction, key.diameter_deg, key.irradiance * share * red)


def _above_horizon(sky: Map) -> Map:
    return np.concatenate([sky[: HEIGHT // 2], np.zeros_like(sky[HEIGHT // 2 :])])


def _overcast(mean: float, sun: Sun) -> Map:
    """Return an overcast sky: the CIE's, brighter where the sun stands behind the clouds.

    The zenith is three times as bright as the horizon. Without the sun's share all light would
    come from above, which shows no shape.

    Args:
        mean: luminance of the clear sky.
        sun: behind the clouds; at night they are as blue as everything else.
    """
    up = pixel_directions(WIDTH, HEIGHT)[..., 1].clip(0, 1)
    night = float(smoothstep(np.array((MIN_MODEL_ELEVATION_DEG - sun_elevation_deg(sun)) / 9.0)))
    tint = (1 - night) * np.array([0.95, 1.0, 1.07]) + night * np.array([0.50, 0.76, 1.25])
    angle = angles_from(np.array(sun_direction(sun)))
    veiled = np.exp(-((angle / _VEIL_WIDTH_DEG) ** 2)) * (1 - night)
    warm = tint * (1 - veiled[..., None]) + veiled[..., None] * np.array([1.04, 1.0, 0.94])
    shape = (1 + 2 * up) / 3 * (0.75 + 2.6 * veiled)
    return np.asarray(mean * 1.3 * shape[..., None] * warm)


def _with_ground(sky: Map, ground: Vector, key: KeyLight) -> Map:
    """Return the map with ground below the horizon, in haze that thins with the angle downward."""
    lit = irradiance(sky, UP) + key.irradiance * max(float(key.direction[1]), 0.0)
    soil = ground * lit / math.pi
    rim = sky[HEIGHT // 2 - 2][None]
    # Distant ground takes the colour of the sky above it, not only of its lowest degrees.
    high = sky[HEIGHT // 2 - HEIGHT // 9][None].mean(axis=1, keepdims=True)
    air = 0.4 * rim + 0.4 * rim.mean(axis=1, keepdims=True) + 0.35 * high
    up = pixel_directions()[..., 1:2]
    haze = np.exp(-np.abs(up) / np.where(up < 0, _HAZE_BELOW, _HAZE_ABOVE))
    return np.asarray(haze * air + (1 - haze) * np.where(up < 0, soil, sky))
