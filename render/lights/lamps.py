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
from render.config import Lamp
from render.errors import ShotError
from render.lights.environment_map import Vector
from render.lights.key_light import CARD_ILLUMINANCE
from render.shot import LampPlace


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
            intensity = place.gain * intensity
            emitter["intensity"] = {"type": "rgb", "value": intensity.tolist()}
        found[f"lamp{i}"] = emitter
    return found


def move_lamps(values: Any, lamps: Sequence[Lamp], places: Sequence[LampPlace]) -> None:
    """Move lamps in the parameters of a scene, and make invisible ones as bright as they are.

    Raises:
        ShotError: a position is not finite.
    """
    for i, (lamp, place) in enumerate(zip(lamps, places, strict=True)):
        if lamp.spot is None and lamp.visible_radius == 0:
            name, value = f"lamp{i}.position", mi.ScalarPoint3f(*place.p_WL)
        else:
            name, value = f"lamp{i}.to_world", _pose(lamp, place)
        values[name] = type(values[name])(value)
        if lamp.visible_radius == 0:
            name = f"lamp{i}.intensity.value"
            values[name] = type(values[name])((place.gain * radiant_intensity(lamp)).tolist())


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
