"""Sight loss: the frames at which cameras do not show whom they follow."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.camera_faults import LEAST_EXTENT
from pipeline.production.camera.camera_path import CameraPath
from pipeline.production.camera.visibility import PosedCast, Visibility
from pipeline.simulation.row_storage import row_chunks
from pipeline.simulation.spatial import Array
from render.shot import CameraPose

MAX_LOST_S = 0.3
"""Time for which the followed may be blocked, cropped or lost [s]."""

CROPPED = 1.0
"""Edge of the frame, beyond which the followed are cropped."""


def lost_frames(
    visibility: Visibility,
    paths: Sequence[CameraPath],
    rows: NDArray[np.int64],
    sampled: NDArray[np.int64],
    subjects: Sequence[frozenset[str]],
    points: Array,
    aspect: float,
) -> NDArray[np.bool_]:
    """Return at which sampled frames paths lose whom they follow, (paths, samples).

    They are lost where the camera is inside something, or where one of them is blocked, cropped,
    out of the frame or tiny.

    Args:
        visibility: of the take that is filmed.
        paths: of cameras.
        rows: (F,) of the frames of the shot.
        sampled: (S,) numbers of frames of the shot.
        subjects: groups of performers; a group is lost if all of it is.
        points: (F, n, 3) extreme points of the followed [m].
        aspect: width by height of the frame.
    """
    lost = np.array([cropped_frames(path, points, aspect)[sampled] for path in paths])
    poses = [path.poses((None,) * len(rows)) for path in paths]
    # Row by row, because the cast is posed once for all paths.
    for s, frame in enumerate(sampled.tolist()):
        cast = visibility.at(int(rows[frame]))
        for k, pose in enumerate(poses):
            if cast is not None and not lost[k, s]:
                lost[k, s] = _is_lost(cast, subjects, pose[frame], aspect)
    return lost


def cropped_frames(path: CameraPath, points: Array, aspect: float) -> NDArray[np.bool_]:
    """Return at which frames (F,) the frame crops points (F, n, 3)."""
    ahead, right, upward = path.axes
    tangent = path.tangent[:, None]
    beyond = np.zeros(len(points), dtype=bool)
    for some in row_chunks(points):
        relative = points[some] - path.eye[some, None]
        depth = np.einsum("fnk,fk->fn", relative, ahead[some])
        wide = np.abs(np.einsum("fnk,fk->fn", relative, right[some]))
        high = np.abs(np.einsum("fnk,fk->fn", relative, upward[some]))
        edge = CROPPED * tangent[some] * depth
        beyond[some] = ((depth <= 0.0) | (wide > edge * aspect) | (high > edge)).any(axis=-1)
    return beyond


def longest_run(lost: NDArray[np.bool_]) -> int:
    """Return the number of successive samples (S,) in the longest loss."""
    return max(
        (sum(1 for _ in run) for bad, run in itertools.groupby(lost.tolist()) if bad), default=0
    )


def _is_lost(
    cast: PosedCast, subjects: Sequence[frozenset[str]], pose: CameraPose, aspect: float
) -> bool:
    if cast.surrounding(np.array(pose.p_WC)):
        return True
    for names in subjects:
        sight = cast.sight(names, pose, aspect)
        if sight is not None and (
            not sight.framed or sight.is_blocked or sight.extent < LEAST_EXTENT
        ):
            return True
    return False
