"""Latitude-longitude maps of all directions, laid out as Mitsuba's `envmap`.

Rows run from straight up to straight down, columns once around from -Z over +X.
Directions are in the world frame (Y up).
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from render.color import luminance

Map = NDArray[np.float64]
Vector = NDArray[np.float64]

WIDTH, HEIGHT = 512, 256
"""Size of the maps that skies are computed at [pixels]."""

CLOUD_WIDTHS = (1024, 2048, 3072)
"""Widths of maps of skies with clouds [pixels]: a view of 50 degrees shows a seventh of one."""

UP = np.array([0.0, 1.0, 0.0])


@cache
def pixel_directions(width: int = WIDTH, height: int = HEIGHT) -> Vector:
    """Return the unit direction of each pixel of a map, (height, width, 3)."""
    theta = (np.arange(height) + 0.5) * (math.pi / height)
    phi = (np.arange(width) + 0.5) * (2 * math.pi / width)
    sin = np.sin(theta)[:, None]
    up = np.broadcast_to(np.cos(theta)[:, None], (height, width))
    found = np.stack([sin * np.sin(phi), up, -sin * np.cos(phi)], axis=-1)
    found.flags.writeable = False
    return found


def sky_width(film_width: int) -> int:
    """Return the width of the map of a sky with clouds for frames of a width [pixels]."""
    return next((width for width in CLOUD_WIDTHS if film_width < 0.32 * width), CLOUD_WIDTHS[-1])


def solid_angles(width: int = WIDTH, height: int = HEIGHT) -> Map:
    """Return the solid angle of each pixel of a map, (height, width) [sr]."""
    theta = (np.arange(height) + 0.5) * (math.pi / height)
    ring = 2 * math.pi / width * math.pi / height * np.sin(theta)
    return np.broadcast_to(ring[:, None], (height, width))


def irradiance(radiance: Map, normal: Vector) -> Vector:
    """Return the irradiance (3,) of a map (H, W, 3) on a plane with this normal."""
    height, width = radiance.shape[:2]
    cosine = (pixel_directions(width, height) @ normal).clip(0, None)
    weight = solid_angles(width, height) * cosine
    return np.asarray((radiance * weight[..., None]).sum(axis=(0, 1)))


def irradiance_slopes(radiance: Map) -> Map:
    """Return how much irradiance grows as a plane turns, (axis, colour), relative to its mean.

    It is half the difference of the irradiance on planes that face along an axis and against it.

    Args:
        radiance: a map (H, W, 3).

    Source: Ramamoorthi, Hanrahan, An Efficient Representation for Irradiance Environment Maps,
        2001, of which this is the linear part.
    """
    # Irradiance is so soft that a small map will do.
    small = resized(radiance, 64, 32)
    both = np.array([[irradiance(small, s * axis) for s in (1, -1)] for axis in np.eye(3)])
    mean = np.maximum(both.mean(axis=(0, 1)), 1e-9)
    return np.asarray(0.5 * (both[:, 0] - both[:, 1]) / mean)


def illuminance(radiance: Map, normal: Vector) -> float:
    """Return the luminance of the irradiance of a map on a plane with this normal."""
    return float(luminance(irradiance(radiance, normal)))


def resized(image: Map, width: int = WIDTH, height: int = HEIGHT) -> Map:
    """Return a map at another size: bilinear, periodic in azimuth."""
    rows = (np.arange(height) + 0.5) * (len(image) / height) - 0.5
    columns = (np.arange(width) + 0.5) * (image.shape[1] / width) - 0.5
    r0, c0 = np.floor(rows).astype(int), np.floor(columns).astype(int)
    fr, fc = (rows - r0)[:, None, None], (columns - c0)[None, :, None]
    r1, r0 = (r0 + 1).clip(0, len(image) - 1), r0.clip(0, len(image) - 1)
    wide = image[r0] * (1 - fr) + image[r1] * fr
    return np.asarray(
        wide[:, c0 % image.shape[1]] * (1 - fc) + wide[:, (c0 + 1) % image.shape[1]] * fc
    )


def soft_disc(center: Vector, radius_deg: float, feather_deg: float) -> Map:
    """Return a map that is 1 within an angle of a direction and 0 beyond a soft edge."""
    angle = angles_from(center)
    return smoothstep((radius_deg + feather_deg - angle) / (2 * feather_deg))


def angles_from(direction: Vector) -> Map:
    """Return the angle of each pixel of a map from a direction [degrees]."""
    return np.asarray(np.degrees(np.arccos((pixel_directions() @ direction).clip(-1, 1))))


def smoothstep(t: Map) -> Map:
    """Return 3t² - 2t³ with `t` clipped to 0..1."""
    edge = np.asarray(t).clip(0, 1)
    return np.asarray(edge * edge * (3 - 2 * edge))


def direction_of(azimuth: float, elevation: float) -> Vector:
    """Return the unit vector of an azimuth (0 is +X, positive about +Y) and elevation [rad]."""
    return np.array(
        [
            math.cos(elevation) * math.cos(azimuth),
            math.sin(elevation),
            -math.cos(elevation) * math.sin(azimuth),
        ]
    )


def normalized(v: Vector) -> Vector:
    """Return a vector scaled to length 1."""
    return np.asarray(v / np.linalg.norm(v))
