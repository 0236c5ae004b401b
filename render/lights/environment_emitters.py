"""Environment emitters: the environment map and the key light of a scene, exposed for a grey card.

All light but that of lamps is scaled so that a grey card half turned to the key light shows as
middle grey, or darker by some stops at night, as a photographer would expose it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mitsuba as mi
import numpy as np

from render.config import Light, Moon, Studio
from render.lights.environment_map import UP, resized
from render.lights.key_light import CARD_ILLUMINANCE, LightEnvironment, card_illuminance
from render.lights.outdoor_light import outdoor_light
from render.lights.panorama_light import panorama_light
from render.lights.studio_light import studio_light

_STRONG_KEY_SHARE = 0.02
"""Share of the card's light from which a key light alone is worth a shadow ray."""


def emitters(light: Light, ground: Sequence[float]) -> dict[str, dict[str, Any]]:
    """Return the emitters of a light, without its lamps, as dictionaries for `mi.load_dict`.

    Args:
        light: the light of the scene.
        ground: linear colour of the ground, which extends beyond the edge of the terrain.

    Returns:
        `sky`, an `envmap`, and `key`, a distant disc, if there is a key light.
    """
    environment = light_environment(light, ground)
    key, card = environment.key, environment.card
    scale = CARD_ILLUMINANCE * 2.0**environment.stops / card
    image = environment.radiance * scale
    if environment.stars is not None:
        height, width = environment.stars.shape[:2]
        image = resized(image, width, height) + environment.stars
    # Softboxes beside the key light are bright and narrow: without shadow rays they are noise.
    key_alone = not light.is_wide and key.illuminance(UP) > _STRONG_KEY_SHARE * card
    found = {
        "sky": {
            "type": "envmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(image, np.float32)),
            "sampling_weight": 0.0 if key_alone else 1.0,
        }
    }
    if key.is_lit:
        found["key"] = key.emitter(scale)
    return found


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
