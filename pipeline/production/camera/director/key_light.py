"""Key light: the brightest light of a scene, and the sides of a subject that it models.

Light from behind the camera flattens what it falls on; from the side it models, from behind the
subject it outlines.

Source: Alton 1949.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.spatial import Array, normalized
from render.config import Light
from render.lights.sun_position import sun_direction

LEAST_ANGLE = math.radians(40.0)
"""Angle between camera and key light, as the subject sees them, below which it is flat [rad]."""

MODELLING = (math.radians(60.0), math.radians(110.0))
"""Range of that angle in which the light models best [rad]."""

LEAST_ELEVATION = math.sin(math.radians(1.0))
"""Sine of the elevation of the sun below which there is twilight or night."""

MOST_OVERCAST = 0.5
"""Cover of clouds from which the sun throws no shadows."""


@dataclass(frozen=True, eq=False)
class KeyLight:
    """The key light of a scene.

    Attributes:
        direction: (3,) unit vector towards it.
    """

    direction: Array

    @staticmethod
    def of(light: Light) -> KeyLight | None:
        """Return the key light; None by night, under clouds and in a panorama."""
        if light.studio is not None:
            heading = math.radians(light.studio.heading_deg)
            rise = math.radians(light.studio.elevation_deg)
            level = (math.cos(heading), math.tan(rise), -math.sin(heading))
            steep = rise > math.radians(89.0)
            return KeyLight(np.array([0.0, 1.0, 0.0]) if steep else normalized(np.array(level)))
        if light.sun is None or light.sun.clouds.overcast >= MOST_OVERCAST:
            return None
        direction = np.array(sun_direction(light.sun))
        return KeyLight(direction) if direction[1] > LEAST_ELEVATION else None

    def angle(self, towards_camera: Array) -> float:
        """Return the angle between the light and a direction (3,) to the camera [rad]."""
        cosine = float(self.direction @ normalized(towards_camera))
        return math.acos(max(-1.0, min(1.0, cosine)))


def light_cost(angle: float) -> float:
    """Return how badly light at an angle from the camera models: 0 well, 1 barely, more: flat."""
    low, high = MODELLING
    if angle < low:
        return ((low - angle) / (low - LEAST_ANGLE)) ** 2
    return 2.0 * ((angle - high) / (math.pi - high)) ** 2 if angle > high else 0.0
