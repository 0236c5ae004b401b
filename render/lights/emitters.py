"""Lights: what surrounds the scene as a map of all directions, a key light, and lamps.

All but the lamps is scaled so that a grey card half turned to the key light shows as middle
grey, or darker by so many stops at night, as a photographer would expose it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mitsuba as mi
import numpy as np

from render.config import Light, Moon, Studio
from render.lights.environment_map import UP, enlarged
from render.lights.lamps import CARD
from render.lights.outdoor_light import outdoors
from render.lights.panorama_light import panorama
from render.lights.studio import studio_lights
from render.lights.surroundings import Surroundings, card_of

_STRONG = 0.02
"""Share of the card's light from which on a key light is alone worth a shadow ray."""


def emitters(light: Light, ground: Sequence[float]) -> dict[str, dict[str, Any]]:
    """Return the emitters of a light as dictionaries for `mi.load_dict`; lamps come beside them.

    Args:
        light: the words.
        ground: linear colour of the ground, which goes on beyond the edge of the world.

    Returns:
        `sky`, an `envmap`, and `key`, a distant disc, where there is a key light.
    """
    around = _surroundings(light, ground)
    key = around.key
    card = around.card
    scale = CARD * 2.0**around.stops / card
    image = around.image * scale
    if around.points is not None:
        height, width = around.points.shape[:2]
        image = enlarged(image, width, height) + around.points
    # Softboxes beside the key light are strong and narrow: met by chance alone they are grain.
    alone = not light.is_wide and key.brightness(UP) > _STRONG * card
    found = {
        "sky": {
            "type": "envmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(image, np.float32)),
            "sampling_weight": 0.0 if alone else 1.0,
        }
    }
    if key.lit:
        found["key"] = key.emitter(scale)
    return found


def _surroundings(light: Light, ground: Sequence[float]) -> Surroundings:
    if light.sun is not None:
        soil = np.asarray(ground, np.float64)
        stars = 0.5 if light.stars is None else light.stars
        return outdoors(light.sun, light.moon or Moon(), stars, soil)
    if light.hdr is not None:
        image, key = panorama(light.hdr)
        # A black picture stays black.
        card = card_of(image, key) or 1.0
        strength = light.hdr.strength
        return Surroundings(image * strength, key.dimmed(strength), card)
    image, key = studio_lights(light.studio or Studio())
    return Surroundings(image, key, card_of(image, key))
