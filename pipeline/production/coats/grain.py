"""Grain: how large a pixel is at best on each part of a film, which decides what hair is worth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.production.shots.skinning import visible_parts
from pipeline.simulation.clock import Clock
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take
from render.shot import CameraPose

MAX_MOMENTS = 120
"""Frames of a film that are looked at."""


def pixel_sizes(pose: CameraPose, points: Array, height: int) -> Array:
    """Return the sizes (N,) of a pixel at points (N, 3) [m], in a frame of so many rows."""
    away = np.linalg.norm(points - np.array(pose.p_WC), axis=-1)
    return np.asarray(2.0 * np.tan(np.radians(pose.fov_deg) / 2.0) * away / height)


def finest_pixels(take: Take, poses: Sequence[CameraPose], height: int) -> NDArray[np.float64]:
    """Return the least size of a pixel on each visible part (P,) over a film [m].

    Args:
        take: of the film; rows of all its frames are read.
        poses: of the camera, one for each frame.
        height: of the frame in pixels.
    """
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    parts = visible_parts(take)
    nodes = np.array([_main_node(take, part.seen) for part in parts], dtype=int)
    finest = np.full(len(parts), np.inf)
    for frame in range(1, len(poses) + 1, -(-len(poses) // MAX_MOMENTS)):
        row = clock.row_of_frame(frame)
        pose, points = poses[frame - 1], take.positions[row][nodes]
        ahead = points @ pose.axes[2] > pose.axes[2] @ np.array(pose.p_WC)
        seen = ahead & take.alive[row][nodes]
        finest = np.minimum(finest, np.where(seen, pixel_sizes(pose, points, height), np.inf))
    return finest


def _main_node(take: Take, mesh: int) -> int:
    """Return the node that most vertices of a mesh follow."""
    return int(np.bincount(take.meshes[mesh].nodes[:, 0]).argmax())
