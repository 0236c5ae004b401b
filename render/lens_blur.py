"""Lens blur: where a picture is out of focus.

There each pixel gathers the light of many places from few samples, and with it the noise of their
colours and of the sky between them, which the denoiser sees nowhere else.

Source: M. Potmesil and I. Chakravarty, A Lens and Aperture Camera Model for Synthetic Image
Generation, SIGGRAPH 1981, for the circle of confusion.
"""

from __future__ import annotations

import math
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.box_filter import box_mean
from render.shot import CameraPose
from render.tracing.camera_rays import central_ray
from render.tracing.tracer import PixelLanes

Image = NDArray[np.float32]

_SHARP, _SOFT = 0.6, 2.0
"""Radii of blur up to which a pixel is sharp, and from which it is soft [pixels]."""

_FAR = 1e4
"""Distance of the sky [m]."""


def softness(scene: Any, sensor: Any, pose: CameraPose, size: tuple[int, int]) -> Image:
    """Return how far each pixel is out of focus, (H, W, 1) from 0 to 1.

    Args:
        scene: of Mitsuba, or a `ScenePair`.
        sensor: of the pose, with a lens.
        pose: of the camera.
        size: width and height of the frame [pixels].
    """
    assert pose.lens is not None
    width, height = size
    depth = np.zeros(width * height, np.float32)
    axis = mi.Vector3f(*(float(c) for c in pose.axes[2]))
    for pixels in PixelLanes(size).chunks:
        ray = central_ray(sensor, pixels, size)
        hit = scene.ray_intersect_preliminary(ray, coherent=True)
        along = hit.t * dr.dot(ray.d, axis)
        depth[np.array(pixels)] = np.array(dr.select(hit.is_valid(), along, _FAR))
    depth = np.maximum(depth.reshape(height, width), 1e-3)
    pixel = 2.0 * pose.lens.focus * math.tan(math.radians(pose.fov_deg) / 2.0) / height
    radius = pose.lens.radius * np.abs(depth - pose.lens.focus) / depth / pixel
    soft = (_spread(radius) - _SHARP) / (_SOFT - _SHARP)
    return np.asarray(np.clip(soft, 0.0, 1.0)[..., None], np.float32)


def _spread(radius: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the largest blur (H, W) that reaches each pixel from those around it [pixels]."""
    found = np.asarray(radius, np.float64).copy()
    reach = 1
    while reach <= radius.max():
        reached = (
            box_mean((radius >= reach).astype(np.float64), reach) > 0.25 / (2 * reach + 1) ** 2
        )
        found = np.where(reached, np.maximum(found, reach), found)
        reach *= 2
    return found
