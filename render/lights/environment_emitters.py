"""Environment emitters: the environment map and the key light of a scene, exposed for a grey card.

All light but that of lamps is scaled so that a grey card half turned to the key light shows as
middle grey, or darker by some stops at night, as a photographer would expose it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.config import Light, Moon, Studio, Sun
from render.lights.cloud_shadows import drift
from render.lights.clouds import CloudLight, Heaps, cloud_seed, has_clouds, heaps, painted
from render.lights.drifting_sky import DriftingSky
from render.lights.environment_map import (
    UP,
    Map,
    Vector,
    irradiance,
    irradiance_slopes,
    resized,
    solid_angles,
)
from render.lights.haze import Haze, haze_of, haze_strength, sun_glow
from render.lights.key_light import CARD_ILLUMINANCE, KeyLight, LightEnvironment, card_illuminance
from render.lights.outdoor_light import outdoor_light
from render.lights.panorama_light import panorama_light
from render.lights.studio_light import studio_light

_KEPT_WIDTH, _KEPT_SKIES = 2048, 6
"""Largest width [pixels] and number of paintings that are remembered."""

_PAINTED: dict[str, Any] = {}

Painting = TypeVar("Painting")

_SNOW_LIGHT = 0.5
"""Share of the light of level ground that comes back from the sky, over white ground and under
clouds."""

_STRONG_KEY_SHARE = 0.02
"""Share of the card's light from which a key light alone is worth a shadow ray."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What lights a scene from afar, and the air in it.

    Attributes:
        emitters: for `mi.load_dict`: `sky`, an `envmap`, or `DriftingSky.emitter` where it
            changes in time, and `key`, a distant disc, if there is a key light.
        haze: of the air, or None.
        key: the key light, or None.
        ambient: (3,) mean radiance from all directions, without the key light.
        slopes: (3, 3) of its irradiance, see `irradiance_slopes`.
        drifting: the sky in time, where it changes, or None.
        downwelling: (3,) irradiance of level ground by sky and key light.
    """

    emitters: dict[str, Any]
    haze: Haze | None
    key: KeyLight | None
    ambient: Vector
    slopes: Map
    drifting: DriftingSky | None
    downwelling: Vector


def surroundings(light: Light, ground: Sequence[float], width: int = 1024) -> Surroundings:
    """Return all light but that of lamps, and the haze.

    Args:
        light: the light of the scene.
        ground: linear colour of the ground, which extends beyond the edge of the terrain.
        width: of the map of a sky with clouds [pixels]; see `sky_width`.
    """
    environment = light_environment(light, ground)
    key, card = environment.key, environment.card
    scale = CARD_ILLUMINANCE * 2.0**environment.stops / card
    image = environment.radiance * scale
    if light.weather.snow > 0.0:
        image = _with_snow_light(image, key.scaled(scale), light.weather.snow)
    is_sunny = light.sun is not None and key.is_lit
    glow = sun_glow(key.direction, key.irradiance * scale) if is_sunny else 0.0
    haze = haze_of(haze_strength(light), image, glow)
    if environment.stars is not None:
        height, across = environment.stars.shape[:2]
        image = resized(image, across, height) + environment.stars
    drifting = None
    if light.sun is not None and has_clouds(light.sun.clouds):
        lit = _cloud_light(image, key.scaled(scale))
        shown = _with_veils(light.sun, image, lit, width)
        if light.sun.clouds.cumulus > 0.0 and dr.is_jit_v(mi.Float):
            drifting = _drifting(light, image, lit, shown)
            shown = drifting.image(0.0)
    else:
        shown = image
    # Softboxes beside the key light are bright and narrow: without shadow rays they are noise.
    key_alone = not light.is_wide and key.illuminance(UP) > _STRONG_KEY_SHARE * card
    weight = 0.0 if key_alone else 1.0
    found: dict[str, Any] = {
        "sky": {
            "type": "envmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(shown, np.float32)),
            "sampling_weight": weight,
        }
        if drifting is None
        else drifting.emitter(weight)
    }
    if key.is_lit:
        found["key"] = key.emitter(scale)
    even = solid_angles() / (4 * np.pi)
    seen = resized(np.asarray(shown, np.float64))
    ambient, slopes = (seen * even[..., None]).sum(axis=(0, 1)), irradiance_slopes(seen)
    shown_key = key.scaled(scale) if key.is_lit else None
    falling = key.irradiance * scale * max(float(key.direction[1]), 0.0)
    downwelling = irradiance(image, UP) + falling
    return Surroundings(found, haze, shown_key, ambient, slopes, drifting, downwelling)


def _with_snow_light(sky: Map, key: KeyLight, snow: float) -> Map:
    """Return a sky with the light that snow on the ground throws up and clouds throw back."""
    up = irradiance(sky, UP) + key.irradiance * max(float(key.direction @ UP), 0.0)
    half = len(sky) // 2
    lit = sky.copy()
    lit[:half] += _SNOW_LIGHT * min(snow / 0.6, 1.0) * up / np.pi
    return lit


def _cloud_light(sky: Map, key: KeyLight) -> CloudLight:
    half = len(sky) // 2
    above, below = sky[:half].mean(axis=(0, 1)), sky[half + half // 3 :].mean(axis=(0, 1))
    return CloudLight(key, above, below)


def _with_veils(sun: Sun, sky: Map, lit: CloudLight, width: int) -> NDArray[np.floating]:
    """Return a sky with its clouds except heaps."""
    name = _name(sun, sky, lit, (width, "veils"))
    return _remembered(name, width, lambda: painted(sky, sun.clouds, lit, cloud_seed(sun), width))


def _drifting(light: Light, sky: Map, lit: CloudLight, behind: NDArray[np.floating]) -> DriftingSky:
    """Return a sky whose heaps drift before what is behind them."""
    sun, width = light.sun or Sun(), behind.shape[1]

    def paint(moved: tuple[float, float]) -> Heaps:
        now = partial(heaps, sky, sun.clouds, lit, cloud_seed(sun), width, moved)
        return _remembered(_name(sun, sky, lit, (width, moved)), width, now)

    return DriftingSky(behind, paint, light.weather.wind, partial(drift, light))


def _name(sun: Sun, sky: Map, lit: CloudLight, what: object) -> str:
    """Return a digest of a painting, which is remembered by it."""
    values = sun.model_dump_json(exclude={"clouds": {"shadows"}})
    state = hashlib.blake2b(values.encode(), digest_size=16)
    state.update(repr((what, mi.variant(), lit.key.direction, lit.key.irradiance)).encode())
    state.update(sky.tobytes())
    return state.hexdigest()


def _remembered(name: str, width: int, paint: Callable[[], Painting]) -> Painting:
    """Return a painting, which is remembered while it is small."""
    if name in _PAINTED:
        found: Painting = _PAINTED[name]
        return found
    image = paint()
    if width <= _KEPT_WIDTH:
        if len(_PAINTED) >= _KEPT_SKIES:
            _PAINTED.pop(next(iter(_PAINTED)))
        _PAINTED[name] = image
    return image


def light_environment(light: Light, ground: Sequence[float]) -> LightEnvironment:
    """Return the map and the key light of a sky, a panorama or a studio."""
    if light.sun is not None:
        soil = np.asarray(ground, np.float64)
        stars = 0.5 if light.stars is None else light.stars
        return outdoor_light(light.sun, light.moon or Moon(), stars, soil)
    if light.hdr is not None:
        image, key = panorama_light(light.hdr)
        # A black panorama stays black.
        card = card_illuminance(image, key) or 1.0
        strength = light.hdr.strength
        return LightEnvironment(image * strength, key.scaled(strength), card)
    image, key = studio_light(light.studio or Studio())
    return LightEnvironment(image, key, card_illuminance(image, key))
