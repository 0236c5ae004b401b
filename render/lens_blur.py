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
from render.frame import Image, LensBlur
from render.shot import CameraPose
from render.tracing.camera_rays import central_ray
from render.tracing.tracer import PixelLanes

_SHARP, _SOFT = 0.6, 2.0
"""Radii of blur up to which a pixel is sharp, and from which it is soft [pixels]."""

_FINE, _COARSE = 1.2, 2.4
"""Radii, in pixels of a picture of half the size, up to which this lacks details, and from which
it holds all that there are; again for each further halving."""

_HALVINGS = 2
"""Of the picture where it is most out of focus."""

_FAR = 1e4
"""Distance of the sky [m]."""


def lens_blur(scene: Any, sensor: Any, pose: CameraPose, size: tuple[int, int]) -> LensBlur:
    """Return where a picture is out of focus.

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
    coarse = []
    for k in range(1, _HALVINGS + 1):
        # What is sharp must not bleed into what is not.
        within = _least(radius, 3 << (k - 1)) / (1 << k)
        coarse.append(_share(within, _FINE, _COARSE))
    return LensBlur(_share(_spread(radius), _SHARP, _SOFT), tuple(coarse))


def _share(radius: NDArray[np.floating], low: float, high: float) -> Image:
    """Return how far radii (H, W) have come from the one to the other, (H, W, 1)."""
    return np.asarray(np.clip((radius - low) / (high - low), 0.0, 1.0)[..., None], np.float32)


def _least(radius: NDArray[np.floating], reach: int) -> NDArray[np.floating]:
    """Return the smallest blur (H, W) within a square of `2 reach + 1` pixels around each."""
    for axis in (0, 1):
        border = [(reach, reach) if k == axis else (0, 0) for k in (0, 1)]
        padded, span, width = np.pad(radius, border, "edge"), 1, 2 * reach + 1
        # The minimum of two windows that overlap is that of one twice as long.
        while span < width:
            step = min(span, width - span)
            count = padded.shape[axis] - step
            padded = np.minimum(
                padded.take(range(count), axis), padded.take(range(step, step + count), axis)
            )
            span += step
        radius = padded
    return radius


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
