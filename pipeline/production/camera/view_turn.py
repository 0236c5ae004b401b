"""View turn: turns an automatic camera about its target where something hides the target.

Hills and props that can be looked over raise the camera (see `clearance`). What is left, such as a
wall or a person in front of the lens, is judged by the meshes of the take. A view is turned for a
whole cut.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.auto_framing import AutoFraming
from pipeline.production.camera.camera_path import CameraPath
from pipeline.production.camera.camera_subjects import camera_subjects
from pipeline.production.camera.visibility import PosedCast, Visibility
from render.shot import CameraPose

SAMPLE_INTERVAL_S = 0.25
"""Time between the frames that are looked at [s]."""

MAX_SAMPLES = 48
"""Frames of a cut that are looked at."""

LEAST_LOST = 0.1
"""Share of a cut in which the target cannot be seen from which its view is turned."""

TURN_STEP_DEG = 20.0
"""Step of the turns that are tried [degrees]."""

MAX_TURN_DEG = 180.0
"""Greatest turn of a view that the author left open [degrees]."""

MAX_TURN_OF_VIEW_DEG = 40.0
"""Greatest turn of a view that the author named: more would make it another view [degrees]."""


def clear_path(framing: AutoFraming, visibility: Visibility, rows: NDArray[np.int64]) -> CameraPath:
    """Return the path of an automatic camera, turned by the least angle that clears its sight.

    Where no turn clears it, the best one is taken. A view from above, an orbit and a camera with a
    `look_at` are left as they are.

    Args:
        framing: of the cut.
        visibility: of the take that is filmed.
        rows: of the frames of the cut.
    """
    path, cut = framing.path(), framing.cut
    if cut.view == "top" or cut.orbit is not None or cut.look_at is not None:
        return path
    subjects = camera_subjects(visibility.take, cut, rows)
    interval = max(round(SAMPLE_INTERVAL_S * framing.followed.rate), -(-len(rows) // MAX_SAMPLES))
    sampled = np.arange(0, len(rows), max(interval, 1))

    def lost(paths: Sequence[CameraPath]) -> NDArray[np.int64]:
        """Return in how many of the frames that are looked at each path loses its subject."""
        poses = [path.poses((None,) * len(rows)) for path in paths]
        count = np.zeros(len(paths), dtype=np.int64)
        for frame in sampled:
            cast = visibility.at(int(rows[frame]))
            if cast is not None:
                count += [_loses(cast, subjects, p[frame], framing.aspect) for p in poses]
        return count

    (usual,) = lost([path])
    if usual < 2 or usual < LEAST_LOST * len(sampled):
        return path
    others = [_turned(framing, angle) for angle in _turns(named=cut.view is not None)]
    counts = lost(others)
    best = int(counts.argmin())
    return others[best] if counts[best] < usual else path


def _turns(*, named: bool) -> list[float]:
    """Return the turns that are tried, the smallest first [rad]."""
    most = MAX_TURN_OF_VIEW_DEG if named else MAX_TURN_DEG
    angles = [TURN_STEP_DEG * k for k in range(1, int(most / TURN_STEP_DEG) + 1)]
    return [math.radians(sign * angle) for angle in angles for sign in (1.0, -1.0)]


def _turned(framing: AutoFraming, angle: float) -> CameraPath:
    return replace(framing, moves=framing.moves.turned(angle)).path()


def _loses(
    cast: PosedCast, subjects: Sequence[frozenset[str]], pose: CameraPose, aspect: float
) -> bool:
    """Return whether a camera is inside something or does not see one of its subjects."""
    if cast.surrounding(np.array(pose.p_WC)):
        return True
    sights = [cast.sight(names, pose, aspect) for names in subjects]
    return any(sight is not None and sight.is_blocked for sight in sights)
