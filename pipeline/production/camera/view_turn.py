"""View turn: turns an automatic camera about its target where something hides the target.

Hills and props that can be looked over raise the camera (see `clearance`). What is left, such as a
wall or a person in front of the lens, is judged by the meshes of the take. A view is turned for a
whole cut.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

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


@dataclass(frozen=True, slots=True)
class ViewTurn:
    """A turn of the view of a cut.

    Attributes:
        angle: positive about +Y [rad].
        reason: what most often obstructs the usual view.
    """

    angle: float
    reason: str


def clear_path(
    framing: AutoFraming, visibility: Visibility, rows: NDArray[np.int64]
) -> tuple[CameraPath, ViewTurn | None]:
    """Return the path of an automatic camera, turned by the least angle that clears its sight.

    The turn is None where the view is as usual. Where no turn clears it, the best one is taken. A
    view from above, an orbit and a camera with a `look_at` are left as they are.

    Args:
        framing: of the cut.
        visibility: of the take that is filmed.
        rows: of the frames of the cut.
    """
    path, cut = framing.path(), framing.cut
    if cut.view == "top" or cut.orbit is not None or cut.look_at is not None:
        return path, None
    subjects = camera_subjects(visibility.take, cut, rows)
    interval = max(round(SAMPLE_INTERVAL_S * framing.followed.rate), -(-len(rows) // MAX_SAMPLES))
    sampled = np.arange(0, len(rows), max(interval, 1))

    reasons: list[Counter[str]] = []

    def lost(paths: Sequence[CameraPath]) -> NDArray[np.int64]:
        """Return in how many of the frames that are looked at each path loses its subject."""
        poses = [path.poses((None,) * len(rows)) for path in paths]
        found: list[Counter[str]] = [Counter() for _ in paths]
        for frame in sampled:
            cast = visibility.at(int(rows[frame]))
            for k, p in enumerate(poses if cast is not None else ()):
                assert cast is not None
                found[k].update(_obstructions(cast, subjects, p[frame], framing.aspect))
        reasons.extend(found)
        return np.array([counter.total() for counter in found], dtype=np.int64)

    (usual,) = lost([path])
    if usual < 2 or usual < LEAST_LOST * len(sampled):
        return path, None
    angles = _turns(named=cut.view is not None)
    others = [_turned(framing, angle) for angle in angles]
    counts = lost(others)
    best = int(counts.argmin())
    if counts[best] >= usual:
        return path, None
    ((reason, _),) = reasons[0].most_common(1)
    return others[best], ViewTurn(angles[best], reason)


def _turns(*, named: bool) -> list[float]:
    """Return the turns that are tried, the smallest first [rad]."""
    most = MAX_TURN_OF_VIEW_DEG if named else MAX_TURN_DEG
    angles = [TURN_STEP_DEG * k for k in range(1, int(most / TURN_STEP_DEG) + 1)]
    return [math.radians(sign * angle) for angle in angles for sign in (1.0, -1.0)]


def _turned(framing: AutoFraming, angle: float) -> CameraPath:
    return replace(framing, moves=framing.moves.turned(angle)).path()


def _obstructions(
    cast: PosedCast, subjects: Sequence[frozenset[str]], pose: CameraPose, aspect: float
) -> list[str]:
    """Return what a camera is inside of, or what hides one of its subjects; at most one."""
    around = cast.surrounding(np.array(pose.p_WC))
    if around:
        return [f"the camera would be inside {around}"]
    for names in subjects:
        sight = cast.sight(names, pose, aspect)
        if sight is not None and sight.is_blocked:
            hidden = "the cast" if len(names) > 1 else next(iter(names))
            return [f"{sight.blocker} hides {hidden}"]
    return []
