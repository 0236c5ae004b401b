"""A studio: a softbox as key light, fill and rim lights, before a paper backdrop."""

from __future__ import annotations

import math

import numpy as np

from render.color import linear
from render.config import Studio
from render.lights.environment_map import (
    Image,
    Vector,
    cap,
    directions,
    headed,
    solid_angles,
)
from render.lights.key_light import Key

_KEY = 4.2
"""Irradiance of a studio's key light; its backdrop has about 0.3 of radiance."""


def studio_lights(studio: Studio) -> tuple[Image, Key]:
    """Return all directions of a studio, and its key light."""
    heading, height = math.radians(studio.heading_deg), math.radians(studio.elevation_deg)
    up = directions()[..., 1:2]
    # A paper backdrop: brightest a little above the horizon, darker overhead and below.
    paper = linear(studio.backdrop) * (0.45 + 0.55 * np.exp(-((up - 0.1) ** 2) / 0.25))
    fill = _box(headed(heading + 2.0, 0.35), 70.0, np.array([0.85, 0.93, 1.0]))
    rim = _box(headed(heading + 3.6, 0.6), 24.0, np.array([1.0, 0.98, 0.95]))
    image = paper + _KEY * (0.45 * studio.fill * fill + 0.4 * studio.rim * rim)
    key = Key(headed(heading, height), studio.softness_deg, _KEY * np.array([1.0, 0.95, 0.88]))
    return image, key


def _box(toward: Vector, width_deg: float, color: Vector) -> Image:
    """Return a soft light of unit irradiance on a plane that faces it."""
    shape = cap(toward, width_deg / 2, feather_deg=width_deg / 8)
    return np.asarray(shape[..., None] * color / (shape * solid_angles()).sum())
