"""Lights: a sky painted into a map of all directions, and one key light before it.

The key light (the sun, or the softbox of a studio) is a distant disc, so that
shadows are soft by its size alone. At each bounce the path tracer sends a ray to
the key light and meets the sky by following the surface: the sky then has no
weight in the choice of lights, and sun-lit relief is free of noise. Where there
is no key light the sky is sampled.

All is scaled so that a grey card half turned to the key light shows as middle
grey: noon and dusk are both well exposed, as a photographer would expose them.

Directions are world directions (Y up). Source of the clear sky and of the sun's
colour: the model of L. Hosek and A. Wilkie, as implemented by Mitsuba's `sunsky`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.color import linear, luminance
from render.words import Light, Studio, Sun

Image = NDArray[np.float64]
Vector = NDArray[np.float64]

WIDTH, HEIGHT = 512, 256
_SKY_WIDTH, _SKY_HEIGHT = 256, 128
_SUN_DEG = 0.5358
_CARD = 1.25 * math.pi
"""Irradiance on the card; at pi a grey of albedo 0.18 has radiance 0.18."""
_HAZE = 0.22
"""Sine of the angle below the horizon at which the haze has thinned to 1/e."""
_GLOW = 0.06
"""The same above the horizon, where the haze glows before the sky."""
_KEY = 2.6
"""Irradiance of a studio's key light; its backdrop has about 0.3 of radiance."""
_UP = np.array([0.0, 1.0, 0.0])
_FAR = 4000.0
"""Distance of the key light [m]: across a scene of 30 m its direction turns by 0.4 degrees."""


@dataclass(frozen=True, eq=False)
class _Key:
    """A distant disc of light.

    Attributes:
        toward: unit vector to its middle.
        width_deg: its width.
        irradiance: (3,) on a plane that faces it.
    """

    toward: Vector
    width_deg: float
    irradiance: Vector


def emitters(light: Light, ground: Sequence[float]) -> dict[str, dict[str, Any]]:
    """Return the emitters of a light as dictionaries for `mi.load_dict`.

    Args:
        light: the words.
        ground: linear colour of the ground, which goes on beyond the edge of the world.
    """
    if light.sun is not None:
        sky, key = _outdoors(light.sun, np.asarray(ground, np.float64))
    else:
        sky, key = _studio(light.studio or Studio())
    lit = bool(key.irradiance.max() > 0)
    toward = key.toward if lit else _UP
    normal = _unit(toward + _UP)
    card = _irradiance(sky, normal) + float(luminance(key.irradiance)) * float(normal @ toward)
    scale = _CARD / card
    pixels = np.ascontiguousarray(sky * scale, np.float32)
    found = {
        "sky": {
            "type": "envmap",
            "bitmap": mi.Bitmap(pixels),
            "sampling_weight": 0.0 if lit else 1.0,
        }
    }
    if lit:
        found["key"] = _disc(key, scale)
    return found


def _disc(key: _Key, scale: float) -> dict[str, Any]:
    half = math.radians(key.width_deg) / 2
    radiance = key.irradiance * scale / (math.pi * math.sin(half) ** 2)
    place = (key.toward * _FAR).tolist()
    up = [1.0, 0.0, 0.0] if abs(key.toward[1]) > 0.9 else [0.0, 1.0, 0.0]
    T = mi.ScalarTransform4f
    return {
        "type": "disk",
        "to_world": T().look_at(place, [0.0, 0.0, 0.0], up).scale(_FAR * math.tan(half)),
        "emitter": {
            "type": "area",
            "radiance": {"type": "rgb", "value": radiance.tolist()},
        },
    }


def _outdoors(sun: Sun, ground: Vector) -> tuple[Image, _Key]:
    toward = _unit(np.array(sun.direction))
    clear_sky, sun_light = _clear(sun, toward)
    overcast = _overcast(float(luminance(clear_sky[: HEIGHT // 2]).mean()))
    sky = (1 - sun.clouds) * clear_sky + sun.clouds * overcast
    # Clouds hide the disc sooner than they whiten the sky.
    key = _Key(toward, sun.softness_deg, sun_light * (1 - sun.clouds) ** 2)
    return _earth(sky, ground, key.irradiance * toward[1]), key


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
    rim = sky[HEIGHT // 2 - 2][None]
    # Distance takes on the colour of the sky above it, not only of its lowest degrees.
    high = sky[HEIGHT // 2 - HEIGHT // 9][None].mean(axis=1, keepdims=True)
    air = 0.4 * rim + 0.4 * rim.mean(axis=1, keepdims=True) + 0.35 * high
    up = d[..., 1:2]
    haze = np.exp(-np.abs(up) / np.where(up < 0, _HAZE, _GLOW))
    return np.asarray(haze * air + (1 - haze) * np.where(up < 0, soil, sky))


def _studio(studio: Studio) -> tuple[Image, _Key]:
    heading, height = math.radians(studio.heading_deg), math.radians(studio.elevation_deg)
    up = _directions(WIDTH, HEIGHT)[..., 1:2]
    # A paper backdrop: brightest a little above the horizon, darker overhead and below.
    paper = linear(studio.backdrop) * (0.45 + 0.55 * np.exp(-((up - 0.1) ** 2) / 0.25))
    fill = _box(_toward(heading + 2.0, 0.35), 70.0, np.array([0.85, 0.93, 1.0]))
    rim = _box(_toward(heading + 3.6, 0.6), 24.0, np.array([1.0, 0.98, 0.95]))
    image = paper + _KEY * (0.6 * studio.fill * fill + 0.7 * studio.rim * rim)
    key = _Key(_toward(heading, height), studio.softness_deg, _KEY * np.array([1.0, 0.95, 0.88]))
    return image, key


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
