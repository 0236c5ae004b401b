"""Camera sweep: how the camera moves within one moment of an exposure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from render.shot import CameraPose

_LEAST = 1e-7
"""Motion over a moment [m, rad] below which a camera stands still."""


@dataclass(frozen=True)
class CameraSweep:
    """The camera's motion over one moment, taken as uniform.

    Attributes:
        place: of the camera in the middle of the moment [m].
        shift: by which it moves meanwhile [m].
        turn: rotation vector by which it turns meanwhile [rad].
    """

    place: tuple[float, float, float]
    shift: tuple[float, float, float]
    turn: tuple[float, float, float]


def camera_sweep(poses: Sequence[CameraPose], k: int) -> CameraSweep | None:
    """Return the sweep at the k-th of evenly spaced poses, None where the camera stands still."""
    if len(poses) < 2:
        return None
    first, last = poses[max(k - 1, 0)], poses[min(k + 1, len(poses) - 1)]
    steps = min(k + 1, len(poses) - 1) - max(k - 1, 0)
    shift = np.subtract(last.p_WC, first.p_WC) / steps
    turn = _rotation_vector(last.axes.T @ first.axes) / steps
    if max(np.abs(shift).max(), np.abs(turn).max()) < _LEAST:
        return None
    x, y, z = (float(value) for value in shift)
    a, b, c = (float(value) for value in turn)
    return CameraSweep(poses[k].p_WC, (x, y, z), (a, b, c))


def _rotation_vector(R: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation vector (3,) of a small rotation (3, 3) [rad]."""
    twice = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = 0.5 * float(np.linalg.norm(twice))
    angle = float(np.arctan2(sine, 0.5 * (np.trace(R) - 1.0)))
    return 0.5 * twice * (angle / sine if sine > 1e-12 else 1.0)
