"""Directions: maps of all directions around the scene, laid out as Mitsuba's `envmap`.

Rows run from straight up to straight down, columns once around from -Z over +X.
Directions are world directions (Y up).
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from render.color import luminance

Image = NDArray[np.float64]
Vector = NDArray[np.float64]

WIDTH, HEIGHT = 512, 256
"""Size of the maps that skies are painted in."""

UP = np.array([0.0, 1.0, 0.0])


@cache
def directions(width: int = WIDTH, height: int = HEIGHT) -> Vector:
    """Return the directions of the pixels of a map, (height, width, 3)."""
    theta = (np.arange(height) + 0.5) * (math.pi / height)
    phi = (np.arange(width) + 0.5) * (2 * math.pi / width)
    sin = np.sin(theta)[:, None]
    up = np.broadcast_to(np.cos(theta)[:, None], (height, width))
    found = np.stack([sin * np.sin(phi), up, -sin * np.cos(phi)], axis=-1)
    found.flags.writeable = False
    return found


def solid_angles(width: int = WIDTH, height: int = HEIGHT) -> Image:
    """Return the solid angles of the pixels of a map, (height, width) [sr]."""
    theta = (np.arange(height) + 0.5) * (math.pi / height)
    ring = 2 * math.pi / width * math.pi / height * np.sin(theta)
    return np.broadcast_to(ring[:, None], (height, width))


def irradiance(image: Image, normal: Vector) -> Vector:
    """Return what a map (H, W, 3) sends on a plane with this normal, (3,)."""
    height, width = image.shape[:2]
    cosine = (directions(width, height) @ normal).clip(0, None)
    weight = solid_angles(width, height) * cosine
    return np.asarray((image * weight[..., None]).sum(axis=(0, 1)))


def brightness(image: Image, normal: Vector) -> float:
    """Return the luminance of `irradiance`."""
    return float(luminance(irradiance(image, normal)))


def enlarged(image: Image, width: int = WIDTH, height: int = HEIGHT) -> Image:
    """Return a map at another size: linear between pixels, around in azimuth."""
    rows = (np.arange(height) + 0.5) * (len(image) / height) - 0.5
    columns = (np.arange(width) + 0.5) * (image.shape[1] / width) - 0.5
    r0, c0 = np.floor(rows).astype(int), np.floor(columns).astype(int)
    fr, fc = (rows - r0)[:, None, None], (columns - c0)[None, :, None]
    r1, r0 = (r0 + 1).clip(0, len(image) - 1), r0.clip(0, len(image) - 1)
    wide = image[r0] * (1 - fr) + image[r1] * fr
    return np.asarray(
        wide[:, c0 % image.shape[1]] * (1 - fc) + wide[:, (c0 + 1) % image.shape[1]] * fc
    )


def cap(toward: Vector, radius_deg: float, feather_deg: float) -> Image:
    """Return a map that is 1 around a direction and 0 elsewhere, with a soft edge."""
    away = angles(toward)
    return smooth((radius_deg + feather_deg - away) / (2 * feather_deg))


def angles(toward: Vector) -> Image:
    """Return how far each pixel of a map is from a direction [degrees]."""
    return np.asarray(np.degrees(np.arccos((directions() @ toward).clip(-1, 1))))


def smooth(t: Image) -> Image:
    """Return the smooth step of values, 0 below 0 and 1 above 1."""
    edge = np.asarray(t).clip(0, 1)
    return np.asarray(edge * edge * (3 - 2 * edge))


def headed(heading: float, height: float) -> Vector:
    """Return the unit vector of a heading (0 is +X, positive turns about +Y) and a height."""
    return np.array(
        [
            math.cos(height) * math.cos(heading),
            math.sin(height),
            -math.cos(height) * math.sin(heading),
        ]
    )


def unit(v: Vector) -> Vector:
    """Return a vector at length 1."""
    return np.asarray(v / np.linalg.norm(v))
