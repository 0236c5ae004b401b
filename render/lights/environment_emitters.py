"""Environment emitters: the environment map and the key light of a scene, exposed for a grey card.

All light but that of lamps is scaled so that a grey card half turned to the key light shows as
middle grey, or darker by some stops at night, as a photographer would expose it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.config import Light, Moon, Studio, Sun
from render.lights.clouds import CloudLight, has_clouds, painted
from render.lights.environment_map import UP, Map, resized
from render.lights.haze import Haze, haze_of, haze_strength
from render.lights.key_light import CARD_ILLUMINANCE, KeyLight, LightEnvironment, card_illuminance
from render.lights.outdoor_light import outdoor_light
from render.lights.panorama_light import panorama_light
from render.lights.studio_light import studio_light

_KEPT_WIDTH, _KEPT_SKIES = 2048, 4
"""Largest width [pixels] and number of skies that are remembered."""

_PAINTED: dict[str, NDArray[np.floating]] = {}

_STRONG_KEY_SHARE = 0.02
"""Share of the card's light from which a key light alone is worth a shadow ray."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What lights a scene from afar, and the air in it.

    Attributes:
        emitters: dictionaries for `mi.load_dict`: `sky`, an `envmap`, and `key`, a distant disc,
            if there is a key light.
        haze: of the air, or None.
    """

    emitters: dict[str, dict[str, Any]]
    haze: Haze | None


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
    haze = haze_of(haze_strength(light), image)
    if environment.stars is not None:
        height, across = environment.stars.shape[:2]
        image = resized(image, across, height) + environment.stars
    if light.sun is not None and has_clouds(light.sun.clouds):
        shown = _with_clouds(light.sun, image, key.scaled(scale), width)
    else:
        shown = image
    # Softboxes beside the key light are bright and narrow: without shadow rays they are noise.
    key_alone = not light.is_wide and key.illuminance(UP) > _STRONG_KEY_SHARE * card
    found = {
        "sky": {
            "type": "envmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(shown, np.float32)),
            "sampling_weight": 0.0 if key_alone else 1.0,
        }
    }
    if key.is_lit:
        found["key"] = key.emitter(scale)
    return Surroundings(found, haze)


def _with_clouds(sun: Sun, sky: Map, key: KeyLight, width: int) -> NDArray[np.floating]:
    """Return a sky with clouds, which is remembered while it is small."""
    state = hashlib.blake2b(sun.model_dump_json().encode(), digest_size=16)
    state.update(repr((width, mi.variant(), key.direction, key.irradiance)).encode())
    state.update(sky.tobytes())
    name = state.hexdigest()
    if name in _PAINTED:
        return _PAINTED[name]
    half = len(sky) // 2
    lit = CloudLight(key, sky[:half].mean(axis=(0, 1)), sky[half + half // 3 :].mean(axis=(0, 1)))
    image = painted(sky, sun.clouds, lit, sun.day, width)
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
