"""A panorama (EXR or HDR) as light: its sun is cut out and becomes the key light.

A sun of a few pixels in a map is hit by chance alone, or needs a shadow ray at every bounce;
as a distant disc of the same irradiance it is free of noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from render.color import luminance
from render.config import Hdr
from render.lights.environment_map import UP, Map, normalized, pixel_directions, solid_angles
from render.lights.key_light import KeyLight
from render.panorama_file import read_panorama


@dataclass(frozen=True)
class SunDetection:
    """How the sun of a panorama is found.

    Attributes:
        radius_deg: angle from the brightest pixel within which pixels may belong to the sun.
        ring_deg: outer radius of the ring whose median is the sky around it.
        contrast: brightness relative to that sky from which a pixel belongs to the sun.
        min_share: share of the map's light from which its sun becomes a key light.
        min_diameter_deg: of the key light; that of the real sun.
    """

    radius_deg: float = 4.0
    ring_deg: float = 7.0
    contrast: float = 8.0
    min_share: float = 0.1
    min_diameter_deg: float = 0.53


_SUN = SunDetection()


def panorama_light(panorama: Hdr) -> tuple[Map, KeyLight]:
    """Return the map of a panorama without its sun, turned as asked, and the sun.

    Raises:
        ShotError: the file cannot be read.
    """
    return split_sun(_turned(read_panorama(Path(panorama.file)), panorama.turn_deg))


def _turned(image: Map, turn_deg: float) -> Map:
    """Return a map turned about +Y, linear between columns."""
    # Columns run from -Z over +X, against positive turns.
    shift = -turn_deg / 360.0 * image.shape[1]
    whole = math.floor(shift)
    part = shift - whole
    near, far = np.roll(image, whole, axis=1), np.roll(image, whole + 1, axis=1)
    return np.asarray((1 - part) * near + part * far)


def split_sun(image: Map) -> tuple[Map, KeyLight]:
    """Return a map without its sun, and the sun; an unlit key light if there is none."""
    height, width = image.shape[:2]
    d, angle = pixel_directions(width, height), solid_angles(width, height)
    bright = luminance(image)
    dark = KeyLight(UP, _SUN.radius_deg, np.zeros(3))
    total = float((bright * angle).sum())
    top = np.unravel_index(int(bright.argmax()), bright.shape)
    near = d @ d[top]
    inside = near > math.cos(math.radians(_SUN.radius_deg))
    ring = ~inside & (near > math.cos(math.radians(_SUN.ring_deg)))
    if total <= 0 or not ring.any():
        return image, dark
    sky = np.median(image[ring], axis=0)
    sun = inside & (bright > _SUN.contrast * float(luminance(sky)))
    extra = np.where(sun[..., None], (image - sky).clip(0, None), 0.0) * angle[..., None]
    if float(luminance(extra).sum()) < _SUN.min_share * total:
        return image, dark
    direction = normalized((d * luminance(extra)[..., None]).sum(axis=(0, 1)))
    diameter = 2 * math.degrees(math.sqrt(float(angle[sun].sum()) / math.pi))
    rest = np.where(sun[..., None], np.minimum(image, sky), image)
    return rest, KeyLight(direction, max(diameter, _SUN.min_diameter_deg), extra.sum(axis=(0, 1)))
