"""Studio light: a softbox as key light, fill and rim lights, in front of a paper backdrop."""

from __future__ import annotations

import math

import numpy as np

from render.color import linear
from render.config import Studio
from render.lights.environment_map import (
    Map,
    Vector,
    direction_of,
    pixel_directions,
    smoothstep,
    soft_disc,
    solid_angles,
)
from render.lights.key_light import KeyLight

_KEY_IRRADIANCE = 4.2
"""Irradiance of the key light; the backdrop has a radiance of about 0.3."""

_LOWEST = 0.42
"""Sine of the elevation below which softboxes fade out down to the horizon."""


def studio_light(studio: Studio) -> tuple[Map, KeyLight]:
    """Return the map of a studio, and its key light."""
    heading, height = math.radians(studio.heading_deg), math.radians(studio.elevation_deg)
    up = pixel_directions()[..., 1:2]
    # Paper is brightest above the horizon, where lamps on the floor light it; darker overhead and
    # below. At the horizon it is as bright as the floor.
    lit = 0.75 * np.exp(-((up - 0.36) ** 2) / 0.035)
    paper = linear(studio.backdrop) * (0.45 + 0.55 * np.exp(-((up - 0.1) ** 2) / 0.25) + lit)
    fill = _softbox(direction_of(heading + 2.0, 0.35), 70.0, np.array([0.85, 0.93, 1.0]), 0.5)
    rim = _softbox(direction_of(heading + 3.6, 0.6), 24.0, np.array([1.0, 0.98, 0.95]))
    image = paper + _KEY_IRRADIANCE * (0.45 * studio.fill * fill + 0.4 * studio.rim * rim)
    key = KeyLight(
        direction_of(heading, height),
        studio.softness_deg,
        _KEY_IRRADIANCE * np.array([1.0, 0.95, 0.88]),
    )
    return image, key


def _softbox(direction: Vector, diameter_deg: float, color: Vector, feather: float = 0.125) -> Map:
    """Return a soft light of unit irradiance on a plane that faces it.

    Args:
        direction: in which it is.
        diameter_deg: of its disc.
        color: linear.
        feather: half the width of its soft edge, relative to the diameter.
    """
    shape = soft_disc(direction, diameter_deg / 2, feather_deg=feather * diameter_deg)
    # It ends above the horizon: where the floor goes over into the paper no edge of it is seen.
    shape = shape * smoothstep(pixel_directions()[..., 1] / _LOWEST)
    return np.asarray(shape[..., None] * color / (shape * solid_angles()).sum())
