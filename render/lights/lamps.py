"""Lamps as Mitsuba emitters, moved in place from moment to moment.

A visible lamp is an analytic sphere. Measured on lit ground at 4 samples, the same lamp as a
mesh has twice the variance in the same time, because half of its samples face away; a point
light is faster, but noisier on glossy bodies.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import mitsuba as mi
import numpy as np

from render.color import linear, luminance
from render.config import Lamp, Light, Moon, Studio
from render.errors import ShotError
from render.lights.environment_map import UP, Vector, resized
from render.lights.key_light import LightEnvironment, card_illuminance
from render.lights.outdoor_light import outdoor_light
from render.lights.panorama_light import panorama_light
from render.lights.studio_light import studio_light
from render.shot import LampPlace

# --- The emitters of a scene: an environment map and a key light, exposed for a grey card
# All light but that of lamps is scaled so that a grey card half turned to the key light shows as
# middle grey, or darker by some stops at night, as a photographer would expose it.

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


CARD_ILLUMINANCE = 1.25 * math.pi
"""Illuminance at which a grey card shows as middle grey."""


def lamp_emitters(lamps: Sequence[Lamp], places: Sequence[LampPlace]) -> dict[str, dict[str, Any]]:
    """Return lamps as dictionaries for `mi.load_dict`, named `lamp0`, `lamp1`, ...

    Raises:
        ShotError: a position is not finite.
    """
    found = {}
    for i, (lamp, place) in enumerate(zip(lamps, places, strict=True)):
        intensity = radiant_intensity(lamp)
        emitter: dict[str, Any] = {"type": "point", "position": list(place.p_WL)}
        if lamp.spot is not None:
            half = lamp.spot.angle_deg / 2
            emitter = {
                "type": "spot",
                "to_world": _pose(lamp, place),
                "cutoff_angle": half,
                # A beam as wide as the cone would divide by zero.
                "beam_width": half * min(1 - lamp.spot.softness, 0.999),
            }
        if lamp.visible_radius > 0:
            radiance = intensity / (math.pi * lamp.visible_radius**2)
            emitter = {
                "type": "sphere",
                "to_world": _pose(lamp, place),
                "emitter": {
                    "type": "area",
                    "radiance": {"type": "rgb", "value": radiance.tolist()},
                },
            }
        else:
            emitter["intensity"] = {"type": "rgb", "value": intensity.tolist()}
        found[f"lamp{i}"] = emitter
    return found


def move_lamps(values: Any, lamps: Sequence[Lamp], places: Sequence[LampPlace]) -> None:
    """Move lamps in the parameters of a scene.

    Raises:
        ShotError: a position is not finite.
    """
    for i, (lamp, place) in enumerate(zip(lamps, places, strict=True)):
        if lamp.spot is None and lamp.visible_radius == 0:
            name, value = f"lamp{i}.position", mi.ScalarPoint3f(*place.p_WL)
        else:
            name, value = f"lamp{i}.to_world", _pose(lamp, place)
        values[name] = type(values[name])(value)


def fixed_places(lamps: Sequence[Lamp]) -> tuple[LampPlace, ...]:
    """Return the places of lamps without a parent."""
    return tuple(LampPlace(x.at, None if x.spot is None else x.spot.toward) for x in lamps)


def radiant_intensity(lamp: Lamp) -> Vector:
    """Return the radiant intensity (3,) of a lamp, in units of the exposed frame."""
    color = blackbody(lamp.temperature_k) if lamp.color is None else linear(lamp.color)
    bright = float(luminance(color))
    # Black gives no light, whatever its brightness.
    if bright <= 0:
        return np.asarray(0.0 * color)
    return np.asarray(lamp.brightness * CARD_ILLUMINANCE * color / bright)


def blackbody(kelvin: float) -> Vector:
    """Return the colour of a black body in linear sRGB, as bright as white.

    Source: B. Kim et al., Design of Advanced Color Temperature Control System for HDTV
        Applications, 2002: a cubic fit of the Planckian locus, 1667 to 25000 K.
    """
    t = 1000.0 / max(kelvin, 1667.0)
    if kelvin < 4000:
        x = ((-0.2661239 * t - 0.2343589) * t + 0.8776956) * t + 0.179910
    else:
        x = ((-3.0258469 * t + 2.1070379) * t + 0.2226347) * t + 0.240390
    if kelvin < 2222:
        y = ((-1.1063814 * x - 1.34811020) * x + 2.18555832) * x - 0.20219683
    elif kelvin < 4000:
        y = ((-0.9549476 * x - 1.37418593) * x + 2.09137015) * x - 0.16748867
    else:
        y = ((3.0817580 * x - 5.87338670) * x + 3.75112997) * x - 0.37001483
    X, Z = x / y, (1 - x - y) / y
    color = np.array(
        [
            3.2406 * X - 1.5372 - 0.4986 * Z,
            -0.9689 * X + 1.8758 + 0.0415 * Z,
            0.0557 * X - 0.2040 + 1.0570 * Z,
        ]
    ).clip(0.0, None)
    return np.asarray(color / float(luminance(color)))


def _pose(lamp: Lamp, place: LampPlace) -> Any:
    aim = place.p_WL if place.p_WS is None else place.p_WS
    if not np.isfinite([*place.p_WL, *aim]).all():
        raise ShotError(f"a lamp at {place.p_WL} has a position that is not finite")
    T = mi.ScalarTransform4f()
    if lamp.spot is None:
        return T.translate(list(place.p_WL)).scale(lamp.visible_radius)
    sight = np.subtract(aim, place.p_WL)
    up = [0.0, 0.0, 1.0] if np.hypot(sight[0], sight[2]) < 1e-4 * abs(sight[1]) else [0.0, 1.0, 0.0]
    return T.look_at(list(place.p_WL), list(aim), up)
