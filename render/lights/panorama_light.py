"""A picture of a place as light: its sun is taken out of it and becomes the key light.

A sun of a few pixels in a map is met by chance alone, or wants rays of its own at every
bounce; as a distant disc of the same irradiance it is free of noise.
"""

from __future__ import annotations

import math
from pathlib import Path

import mitsuba as mi
import numpy as np

from render.color import luminance
from render.config import Hdr
from render.errors import ShotError
from render.lights.environment_map import UP, Image, directions, solid_angles, unit
from render.lights.key_light import Key

_WIDEST = 2048
_SUN_DEG = 4.0
"""How far from its brightest place the sun of a map is looked for [degrees]."""
_RING_DEG = 7.0
_TIMES = 8.0
"""What is so many times as bright as the sky around it belongs to the sun."""
_SHARE = 0.1
"""Part of the light of a map from which on its sun is worth a light of its own."""


def panorama(words: Hdr) -> tuple[Image, Key]:
    """Return the map of a picture without its sun, turned as asked, and the sun.

    Raises:
        ShotError: the picture cannot be read.
    """
    image = _turned(_smaller(_read(Path(words.file))), words.turn_deg)
    return _parted(image)


def _read(path: Path) -> Image:
    try:
        bitmap = mi.Bitmap(str(path)).convert(
            mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False
        )
    except RuntimeError as error:
        raise ShotError(f"{path} cannot be read as a picture of light: {error}") from error
    image = np.array(bitmap, np.float64)
    if not np.isfinite(image).all():
        raise ShotError(f"{path} holds light that is not finite")
    return image.clip(0.0, None)


def _smaller(image: Image) -> Image:
    """Return a map of at most so many pixels, of the same light in every direction."""
    times = math.ceil(image.shape[1] / _WIDEST)
    height, width = image.shape[0] // times, image.shape[1] // times
    if times == 1 or height == 0:
        return image
    cut = image[: height * times, : width * times]
    # Not weighted by solid angle, which hardly changes within one pixel of the result.
    return np.asarray(cut.reshape(height, times, width, times, 3).mean(axis=(1, 3)))


def _turned(image: Image, turn_deg: float) -> Image:
    """Return a map turned about +Y, mixing two neighbouring columns."""
    # Columns run from -Z over +X, against positive turns.
    shift = -turn_deg / 360.0 * image.shape[1]
    whole = math.floor(shift)
    part = shift - whole
    near, far = np.roll(image, whole, axis=1), np.roll(image, whole + 1, axis=1)
    return np.asarray((1 - part) * near + part * far)


def _parted(image: Image) -> tuple[Image, Key]:
    """Return a map without its sun, and the sun; without light if the map has none."""
    height, width = image.shape[:2]
    d, angle = directions(width, height), solid_angles(width, height)
    bright = luminance(image)
    dark = Key(UP, _SUN_DEG, np.zeros(3))
    total = float((bright * angle).sum())
    top = np.unravel_index(int(bright.argmax()), bright.shape)
    near = d @ d[top]
    inside = near > math.cos(math.radians(_SUN_DEG))
    ring = ~inside & (near > math.cos(math.radians(_RING_DEG)))
    if total <= 0 or not ring.any():
        return image, dark
    sky = np.median(image[ring], axis=0)
    sun = inside & (bright > _TIMES * float(luminance(sky)))
    extra = np.where(sun[..., None], (image - sky).clip(0, None), 0.0) * angle[..., None]
    if float(luminance(extra).sum()) < _SHARE * total:
        return image, dark
    toward = unit((d * luminance(extra)[..., None]).sum(axis=(0, 1)))
    width_deg = _width_of(float(angle[sun].sum()))
    rest = np.where(sun[..., None], np.minimum(image, sky), image)
    return rest, Key(toward, width_deg, extra.sum(axis=(0, 1)))


def _width_of(solid_angle: float) -> float:
    """Return the width of a disc [degrees]; no sun of a picture is sharper than the real one."""
    return max(2 * math.degrees(math.sqrt(solid_angle / math.pi)), 0.53)
