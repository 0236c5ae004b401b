"""The clear sky by day and its sun, from the model of Hosek and Wilkie.

Source: L. Hosek and A. Wilkie, An Analytic Model for Full Spectral Sky-Dome Radiance,
    2012, as implemented by Mitsuba's `sunsky`. It holds for a sun above the horizon.
"""

from __future__ import annotations

import math
from typing import Any

import mitsuba as mi
import numpy as np

from render.lights.environment_map import Image, Vector, directions, enlarged, unit

_WIDTH, _HEIGHT = 256, 128
_SUN_DEG = 0.5358


def clear(toward: Vector, turbidity: float) -> tuple[Image, Vector]:
    """Return the clear sky without sun, and the sun's irradiance on a plane that faces it.

    Args:
        toward: unit vector to the sun, above the horizon.
        turbidity: haze of the air.
    """
    local = [float(toward[0]), float(-toward[2]), float(toward[1])]
    model = {"type": "sunsky", "turbidity": turbidity, "sun_direction": local}
    sky = mi.load_dict({**model, "sun_scale": 0.0})
    disc = mi.load_dict({**model, "sky_scale": 0.0})
    upper = directions(_WIDTH, _HEIGHT)[: _HEIGHT // 2]
    half = _evaluated(sky, upper.reshape(-1, 3)).reshape(upper.shape)
    half = np.maximum(half, 0.0)
    # The lower half starts as a copy of the horizon; the earth is painted over it.
    image = enlarged(np.concatenate([half, np.repeat(half[-1:], _HEIGHT // 2, 0)]))
    ring = np.array([toward + 0.002 * _side(toward, a) for a in (0.3, 1.9, 3.5, 5.1)])
    seen = _evaluated(disc, ring / np.linalg.norm(ring, axis=1, keepdims=True)).mean(axis=0)
    return image, seen * 2 * math.pi * (1 - math.cos(math.radians(_SUN_DEG / 2)))


def _side(toward: Vector, angle: float) -> Vector:
    other = np.array([1.0, 0.0, 0.0]) if abs(toward[0]) < 0.9 else np.array([0.0, 0.0, 1.0])
    u = unit(np.cross(toward, other))
    return np.asarray(math.cos(angle) * u + math.sin(angle) * np.cross(toward, u))


def _evaluated(model: Any, points: Vector) -> Vector:
    """Return the radiance that an emitter sends from (N, 3) world directions, (N, 3)."""
    local = np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)
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
