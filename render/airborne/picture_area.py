"""Picture area: the pixels in which a camera may see something, from spheres around it.

The outline of a sphere in a picture lies in the rectangle of its tangents: seen from above, and
from the side, it is a circle, whose two tangents through the camera are its borders.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from render.shot import CameraPose

Floats = NDArray[np.float64]

_MARGIN = 2
"""Pixels around each rectangle, more than a ray is off the middle of its own."""


def picture_area(camera: CameraPose, spheres: Floats, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Return whether a pixel may show a sphere, (H, W); true of some that do not.

    Args:
        camera: pinhole or lens.
        spheres: (n, 4) middles in the world and radii [m].
        size: width and height of the frame [pixels].
    """
    width, height = size
    area = np.zeros((height, width), bool)
    if len(spheres) == 0:
        return area
    across, up, ahead = (camera.axes @ (spheres[:, :3] - camera.p_WC).T).astype(float)
    radius = spheres[:, 3].copy()
    if camera.lens is not None:
        # As far as rays through the rim of the lens are off those through its middle.
        away = np.abs(ahead - camera.lens.focus) + radius
        radius += camera.lens.radius * away / camera.lens.focus
    half = math.tan(math.radians(camera.fov_deg) / 2)
    left, right = _span(across, ahead, radius, half * width / height)
    bottom, top = _span(up, ahead, radius, half)
    columns = _pixels(left, right, width)
    rows = _pixels(-top, -bottom, height)
    for i in np.flatnonzero(ahead > -radius):
        area[rows[0][i] : rows[1][i], columns[0][i] : columns[1][i]] = True
    return area


def _span(aside: Floats, ahead: Floats, radius: Floats, half: float) -> tuple[Floats, Floats]:
    """Return where tangents meet the picture, -1 to 1 in it; all of it beside the camera.

    Args:
        aside: places of the middles to the right or above [m].
        ahead: before the camera [m].
        radius: [m].
        half: tangent of half of the angle of view.
    """
    away = np.hypot(aside, ahead)
    middle = np.arctan2(aside, ahead)
    wide = np.arcsin(np.minimum(radius / np.maximum(away, 1e-9), 1.0))
    low, high = middle - wide, middle + wide
    # Beyond a right angle a tangent meets no picture.
    edge = 0.49 * math.pi
    is_around = away <= radius
    first = np.where(is_around | (low < -edge), -1.0, np.tan(np.clip(low, -edge, edge)) / half)
    last = np.where(is_around | (high > edge), 1.0, np.tan(np.clip(high, -edge, edge)) / half)
    return first, last


def _pixels(low: Floats, high: Floats, count: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first of the pixels between two borders, -1 to 1, and the end."""
    first = np.floor((0.5 * low + 0.5) * count) - _MARGIN
    end = np.ceil((0.5 * high + 0.5) * count) + _MARGIN
    return first.clip(0, count).astype(np.intp), end.clip(0, count).astype(np.intp)
