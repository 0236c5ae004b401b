"""Lights, baked into one picture of all directions.

Sky, sun and softboxes are painted into an environment map once for a build:
Mitsuba then has a single light to sample, and the sun casts soft shadows by its
size alone. The map is scaled so that a grey card half turned to the key light
shows as middle grey: noon and dusk are both well exposed, as a photographer
would expose them.

Directions are world directions (Y up). Source of the clear sky and of the sun's
colour: A. Wilkie et al., A fitted radiance and attenuation model for realistic
atmospheres, and L. Hosek, A. Wilkie, as implemented by Mitsuba's `sunsky`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.color import linear, luminance
from render.words import Light, Studio, Sun

Image = NDArray[np.float64]
Vector = NDArray[np.float64]

WIDTH, HEIGHT = 1024, 512
_SKY_WIDTH, _SKY_HEIGHT = 256, 128
_SUN_DEG = 0.5358
_CARD = math.pi
"""Irradiance on the card: grey of albedo 0.18 then has radiance 0.18."""


def emitter(light: Light, ground: Sequence[float]) -> dict[str, Any]:
    """Return the environment of a light as a dictionary for `mi.load_dict`.

    Args:
        light: the words.
        ground: linear colour of the ground, which goes on beyond the edge of the world.
    """
    image, key = _studio(light.studio) if light.studio else _outdoors(_sun(light), ground)
    card = _irradiance(image, _unit(key + np.array([0.0, 1.0, 0.0])))
    pixels = (image * (_CARD / card)).astype(np.float32)
    return {"type": "envmap", "bitmap": mi.Bitmap(np.ascontiguousarray(pixels))}


def _sun(light: Light) -> Sun:
    return light.sun or Sun()


def _outdoors(sun: Sun, ground: Sequence[float]) -> tuple[Image, Vector]:
    toward = _unit(np.array(sun.direction))
    clear_sky, sun_light = _clear(sun, toward)
    overcast = _overcast(float(luminance(clear_sky[: HEIGHT // 2]).mean()))
    sky = (1 - sun.clouds) * clear_sky + sun.clouds * overcast
    disc = _cap(toward, sun.softness_deg / 2, feather_deg=0.2)
    power = sun_light * (1 - sun.clouds) ** 2
    below = _earth(sky, np.asarray(ground), power * toward[1])
    full = below + disc[..., None] * power / (disc * _solid_angles()).sum()
    key = toward if sun.clouds < 1 else np.array([0.0, 1.0, 0.0])
    return full, key


def _clear(sun: Sun, toward: Vector) -> tuple[Image, Vector]:
    """Return the clear sky without sun, and the sun's irradiance on a plane that faces it."""
    local = [float(toward[0]), float(-toward[2]), float(toward[1])]
    model = {"type": "sunsky", "turbidity": sun.turbidity, "sun_direction": local}
    sky = mi.load_dict({**model, "sun_scale": 0.0})
    disc = mi.load_dict({**model, "sky_scale": 0.0})
    upper = _directions(_SKY_WIDTH, _SKY_HEIGHT)[: _SKY_HEIGHT // 2]
    half = _evaluated(sky, upper.reshape(-1, 3)).reshape(upper.shape)
    half = np.maximum(half, 0.0)
    # The lower half starts as a copy of the horizon; `_earth` paints it.
    image = _enlarged(np.concatenate([half, np.repeat(half[-1:], _SKY_HEIGHT // 2, 0)]))
    ring = np.array([toward + 0.002 * _side(toward, a) for a in (0.3, 1.9, 3.5, 5.1)])
    seen = _evaluated(disc, ring / np.linalg.norm(ring, axis=1, keepdims=True)).mean(axis=0)
    return image, seen * 2 * math.pi * (1 - math.cos(math.radians(_SUN_DEG / 2)))


def _side(toward: Vector, angle: float) -> Vector:
    other = np.array([1.0, 0.0, 0.0]) if abs(toward[0]) < 0.9 else np.array([0.0, 0.0, 1.0])
    u = _unit(np.cross(toward, other))
    return np.asarray(math.cos(angle) * u + math.sin(angle) * np.cross(toward, u))


def _evaluated(model: Any, directions: Vector) -> Vector:
    """Return the radiance that an emitter sends from (N, 3) world directions, (N, 3)."""
    local = np.stack([directions[:, 0], -directions[:, 2], directions[:, 1]], axis=1)
    si = mi.SurfaceInteraction3f()
    if "scalar" in str(mi.variant()):
        values = []
        for d in local:
            si.wi = mi.Vector3f(*(-d))
            values.append(np.array(model.eval(si)))
        return np.array(values, np.float64)
    import drjit as dr

    si = dr.zeros(mi.SurfaceInteraction3f, len(local))
    si.wi = -mi.Vector3f(np.ascontiguousarray(local.T, np.float32))
    return np.array(model.eval(si), np.float64).T


def _overcast(mean: float) -> Image:
    """Return the CIE overcast sky: the zenith is three times as bright as the horizon."""
    up = _directions(WIDTH, HEIGHT)[..., 1].clip(0, 1)
    tint = np.array([0.95, 1.0, 1.07])
    return np.asarray(mean * ((1 + 2 * up) / 3)[..., None] * 1.3 * tint)


def _earth(sky: Image, ground: Vector, sun_on_ground: Vector) -> Image:
    """Paint the ground below the horizon, in haze that thins with the angle downward."""
    d = _directions(WIDTH, HEIGHT)
    weight = (_solid_angles() * d[..., 1].clip(0, None))[..., None]
    irradiance = (sky * weight).sum(axis=(0, 1)) + sun_on_ground
    soil = ground * irradiance / math.pi
    horizon = sky[HEIGHT // 2 - 2].mean(axis=0)
    haze = np.exp(-np.maximum(-d[..., 1], 0) / 0.035)[..., None]
    air = 0.5 * horizon + 0.5 * sky[HEIGHT // 2 - 2][None]
    return np.where(d[..., 1:2] < 0, haze * air + (1 - haze) * soil, sky)


def _studio(studio: Studio) -> tuple[Image, Vector]:
    heading, height = math.radians(studio.heading_deg), math.radians(studio.elevation_deg)
    key = _toward(heading, height)
    d = _directions(WIDTH, HEIGHT)
    backdrop = linear(studio.backdrop) * (0.55 + 0.45 * np.exp(-((d[..., 1:2] - 0.15) ** 2) / 0.3))
    image = np.where(d[..., 1:2] < -0.2, 0.6 * backdrop, backdrop)
    image = image + 2.6 * _box(key, studio.softness_deg, np.array([1.0, 0.95, 0.88]))
    fill = _toward(heading + 2.0, 0.35)
    image = image + 2.6 * studio.fill * _box(fill, 70.0, np.array([0.85, 0.93, 1.0]))
    rim = _toward(heading + 3.6, 0.6)
    return image + 2.6 * studio.rim * _box(rim, 24.0, np.array([1.0, 0.98, 0.95])), key


def _box(toward: Vector, width_deg: float, color: Vector) -> Image:
    """Return a soft light of unit irradiance on a plane that faces it."""
    cap = _cap(toward, width_deg / 2, feather_deg=width_deg / 8)
    return np.asarray(cap[..., None] * color / (cap * _solid_angles()).sum())


def _cap(toward: Vector, radius_deg: float, feather_deg: float) -> Image:
    cosine = (_directions(WIDTH, HEIGHT) @ toward).clip(-1, 1)
    away = np.degrees(np.arccos(cosine))
    edge = ((radius_deg + feather_deg - away) / (2 * feather_deg)).clip(0, 1)
    return np.asarray(edge * edge * (3 - 2 * edge))


def _directions(width: int, height: int) -> Vector:
    """Return the world directions of the pixels of Mitsuba's `envmap`, (height, width, 3)."""
    theta = (np.arange(height) + 0.5) * (math.pi / height)
    phi = (np.arange(width) + 0.5) * (2 * math.pi / width)
    sin = np.sin(theta)[:, None]
    up = np.broadcast_to(np.cos(theta)[:, None], (height, width))
    return np.stack([sin * np.sin(phi), up, -sin * np.cos(phi)], axis=-1)


def _solid_angles() -> Image:
    theta = (np.arange(HEIGHT) + 0.5) * (math.pi / HEIGHT)
    ring = 2 * math.pi / WIDTH * math.pi / HEIGHT * np.sin(theta)
    return np.broadcast_to(ring[:, None], (HEIGHT, WIDTH))


def _irradiance(image: Image, normal: Vector) -> float:
    weight = _solid_angles() * (_directions(WIDTH, HEIGHT) @ normal).clip(0, None)
    return float((luminance(image) * weight).sum())


def _enlarged(image: Image) -> Image:
    """Return the image at full size: linear between pixels, around in azimuth."""
    rows = (np.arange(HEIGHT) + 0.5) * (len(image) / HEIGHT) - 0.5
    columns = (np.arange(WIDTH) + 0.5) * (image.shape[1] / WIDTH) - 0.5
    r0, c0 = np.floor(rows).astype(int), np.floor(columns).astype(int)
    fr, fc = (rows - r0)[:, None, None], (columns - c0)[None, :, None]
    r1, r0 = (r0 + 1).clip(0, len(image) - 1), r0.clip(0, len(image) - 1)
    wide = image[r0] * (1 - fr) + image[r1] * fr
    return np.asarray(
        wide[:, c0 % image.shape[1]] * (1 - fc) + wide[:, (c0 + 1) % image.shape[1]] * fc
    )


def _toward(heading: float, height: float) -> Vector:
    """Return the unit vector of a heading (0 is +X, positive turns about +Y) and a height."""
    return np.array(
        [
            math.cos(height) * math.cos(heading),
            math.sin(height),
            -math.cos(height) * math.sin(heading),
        ]
    )


def _unit(v: Vector) -> Vector:
    return np.asarray(v / np.linalg.norm(v))
