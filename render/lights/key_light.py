"""The key light: sun, moon or the softbox of a studio, as a distant disc.

Shadows are soft by its size alone. At each bounce the integrator sends a ray to it and
meets the sky by following the surface, so that sun-lit relief is free of noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mitsuba as mi

from render.color import luminance
from render.lights.environment_map import Vector

FAR = 4000.0
"""Distance of the key light [m]: across a scene of 30 m its direction turns by 0.4 degrees."""


@dataclass(frozen=True, eq=False)
class Key:
    """A distant disc of light.

    Attributes:
        toward: unit vector to its middle.
        width_deg: its width.
        irradiance: (3,) on a plane that faces it.
    """

    toward: Vector
    width_deg: float
    irradiance: Vector

    @property
    def lit(self) -> bool:
        """Whether it gives light at all."""
        return bool(self.irradiance.max() > 0)

    def brightness(self, normal: Vector) -> float:
        """Return the luminance of what it sends on a plane with this normal."""
        return float(luminance(self.irradiance)) * max(float(normal @ self.toward), 0.0)

    def dimmed(self, share: float) -> Key:
        """Return the same light so many times as bright."""
        return Key(self.toward, self.width_deg, self.irradiance * share)

    def emitter(self, scale: float) -> dict[str, Any]:
        """Return it, so many times as bright, as a dictionary for `mi.load_dict`."""
        half = math.radians(self.width_deg) / 2
        radiance = self.irradiance * scale / (math.pi * math.sin(half) ** 2)
        place = (self.toward * FAR).tolist()
        up = [1.0, 0.0, 0.0] if abs(self.toward[1]) > 0.9 else [0.0, 1.0, 0.0]
        T = mi.ScalarTransform4f
        return {
            "type": "disk",
            "to_world": T().look_at(place, [0.0, 0.0, 0.0], up).scale(FAR * math.tan(half)),
            "emitter": {
                "type": "area",
                "radiance": {"type": "rgb", "value": radiance.tolist()},
            },
        }
