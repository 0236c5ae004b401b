"""The key light (sun, moon or softbox), the map around it, and how both are metered.

The key light is a distant disc whose size alone softens its shadows. The integrator samples it
at each bounce and meets the sky by sampling the BSDF, so that sun-lit relief is free of noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np

from render.color import luminance
from render.lights.environment_map import UP, Map, Vector, illuminance, normalized, smoothstep

CARD_ILLUMINANCE = 1.25 * math.pi
"""Illuminance at which a grey card shows as middle grey."""

KEY_DISTANCE = 4000.0
"""Distance of the disc [m]: across a scene of 30 m its direction changes by 0.4 degrees."""

CARD_TURN_SHARE = 0.1
"""Share of the key light in the total from which the grey card is turned to it fully."""


@dataclass(frozen=True, eq=False)
class KeyLight:
    """A distant disc of light.

    Attributes:
        direction: unit vector to its centre.
        diameter_deg: angular diameter.
        irradiance: (3,) on a plane that faces it.
    """

    direction: Vector
    diameter_deg: float
    irradiance: Vector

    @property
    def is_lit(self) -> bool:
        """Whether it gives any light."""
        return bool(self.irradiance.max() > 0)

    def illuminance(self, normal: Vector) -> float:
        """Return the luminance of its irradiance on a plane with this normal."""
        return float(luminance(self.irradiance)) * max(float(normal @ self.direction), 0.0)

    def scaled(self, factor: float) -> KeyLight:
        """Return the light with its irradiance times a factor."""
        return KeyLight(self.direction, self.diameter_deg, self.irradiance * factor)

    def emitter(self, scale: float) -> dict[str, Any]:
        """Return the disc, its radiance times `scale`, as a dictionary for `mi.load_dict`."""
        half = math.radians(self.diameter_deg) / 2
        radiance = self.irradiance * scale / (math.pi * math.sin(half) ** 2)
        place = (self.direction * KEY_DISTANCE).tolist()
        up = [1.0, 0.0, 0.0] if abs(self.direction[1]) > 0.9 else [0.0, 1.0, 0.0]
        T = mi.ScalarTransform4f
        return {
            "type": "disk",
            "to_world": T()
            .look_at(place, [0.0, 0.0, 0.0], up)
            .scale(KEY_DISTANCE * math.tan(half)),
            "emitter": {
                "type": "area",
                "radiance": {"type": "rgb", "value": radiance.tolist()},
            },
        }


@dataclass(frozen=True, eq=False)
class LightEnvironment:
    """All light but that of lamps, in arbitrary units.

    Attributes:
        radiance: (H, W, 3) map of all directions.
        key: the key light.
        card: illuminance of the grey card that is to show as middle grey.
        stops: exposure relative to that card.
        stars: (H', W', 3) finer map of display radiance, which no exposure scales; or None.
    """

    radiance: Map
    key: KeyLight
    card: float
    stops: float = 0.0
    stars: Map | None = None


def card_turn(radiance: Map, key: KeyLight) -> float:
    """Return how far a grey card turns from the zenith (0) to half way to the key light (1).

    The weaker the key light, the more the card faces the zenith.
    """
    if not key.is_lit:
        return 0.0
    normal = normalized(key.direction + UP)
    own = key.illuminance(normal)
    share = own / (illuminance(radiance, normal) + own)
    return float(smoothstep(np.array(share / CARD_TURN_SHARE)))


def card_illuminance(radiance: Map, key: KeyLight, turn: float | None = None) -> float:
    """Return the illuminance of a grey card.

    Args:
        radiance: map of all directions.
        key: the key light.
        turn: of the card towards the key light, 0 to 1; `card_turn` if None.
    """
    turn = card_turn(radiance, key) if turn is None else turn
    level = illuminance(radiance, UP) + key.illuminance(UP)
    if turn == 0.0:
        return level
    normal = normalized(key.direction + UP)
    return level + turn * (illuminance(radiance, normal) + key.illuminance(normal) - level)
