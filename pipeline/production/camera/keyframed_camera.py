"""A camera animated by the author: by keyframes, by velocity, or on a parent.

Its frame C has X ahead and Y up. Like a prop it moves relative to its parent, a node of the take,
or to the world.

Source: Sims 1987, 3.1 and 3.2.1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.camera_path import CameraPath
from pipeline.simulation.keyframe_track import Key, Track, rotation_from_angles
from pipeline.simulation.spatial import UP, Array, matrix, normalized, rotation, turn
from pipeline.simulation.take import Take
from render.config import Camera
from render.config.camera import CameraKey

AHEAD = np.array([1.0, 0.0, 0.0])

MIN_UP_SINE = 1e-3
"""Sine of the angle between sight and up below which another up is taken."""


def has_direction(cut: Camera) -> bool:
    """Return whether targets or rotations of the cut give the viewing direction."""
    keyed = any(key.target is not None or key.rotation_deg is not None for key in cut.keyframes)
    return keyed or cut.rotation_deg is not None or cut.spin_deg is not None


def animated_path(
    take: Take, cut: Camera, mount: int, rows: NDArray[np.int64], target: Array | None
) -> CameraPath:
    """Return the path of an animated camera.

    Args:
        take: that is filmed.
        cut: its configuration.
        mount: node that carries it, -1 for none.
        rows: (F,) of the frames of the cut.
        target: (F, 3) point of the world that it looks at, None if the cut has a direction.
    """
    header = take.header
    times = rows / float(header.rate * header.samples)
    R_WP, p_WP = np.tile(np.eye(3), (len(rows), 1, 1)), np.zeros((len(rows), 3))
    if mount >= 0:
        R_WP, p_WP = matrix(take.rotations[rows, mount]), take.positions[rows, mount]
    eye = p_WP + turn(R_WP, _positions(cut, times))
    up = np.tile(UP, (len(rows), 1))
    aims = _track(cut.keyframes, "target")
    if aims is not None:
        target, up = p_WP + turn(R_WP, aims(times)), R_WP[..., 1]
    elif target is None:
        R_WC = R_WP @ _rotations(cut, times)
        target, up = eye + R_WC[..., 0], R_WC[..., 1]
    return CameraPath(eye, *_valid_aim(eye, target, up), fields_of_view(cut, times))


def fields_of_view(cut: Camera, times: Array) -> Array:
    """Return the vertical field of view of a cut at `times` (F,) [degrees]."""
    wide = _track(cut.keyframes, "fov_deg")
    if wide is None:
        return np.full(len(times), cut.fov_deg)
    return wide(times)[:, 0].clip(1.0, 150.0)


def _positions(cut: Camera, times: Array) -> Array:
    """Return the positions (F, 3) of the camera in its parent [m]."""
    track = _track(cut.keyframes, "position")
    if track is not None:
        return track(times)
    velocity = np.array(cut.velocity or (0.0, 0.0, 0.0))
    return np.array(cut.at) + (times - cut.start)[:, None] * velocity


def _rotations(cut: Camera, times: Array) -> Array:
    """Return the rotations (F, 3, 3) of the camera in its parent."""
    track = _track(cut.keyframes, "rotation_deg")
    if track is not None:
        return rotation_from_angles(np.radians(track(times)))
    R = rotation_from_angles(np.radians(np.array(cut.rotation_deg or (0.0, 0.0, 0.0))))
    spin = np.radians(np.array(cut.spin_deg or (0.0, 0.0, 0.0)))
    rate = float(np.linalg.norm(spin))
    return rotation(normalized(spin), rate * (times - cut.start)) @ R


def _track(keyframes: Sequence[CameraKey], name: str) -> Track | None:
    """Return the track of a value over the keyframes that give it, None if none does."""
    given = [key for key in keyframes if getattr(key, name) is not None]
    if not given:
        return None
    row: list[Key] = [(key.at, _as_tuple(getattr(key, name)), key.ease) for key in given]
    rates = [getattr(key.tangent, name, None) for key in given]
    return Track.of(row, [None if rate is None else _as_tuple(rate) for rate in rates])


def _as_tuple(value: float | tuple[float, ...]) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,)


def _valid_aim(eye: Array, target: Array, up: Array) -> tuple[Array, Array]:
    """Return targets away from the eye and ups not along the sight, each (F, 3)."""
    away = target - eye
    target = np.where((away * away).sum(axis=-1, keepdims=True) > 1e-12, target, eye + AHEAD)
    forward = normalized(target - eye)
    across = np.cross(forward, up)
    flat = (across * across).sum(axis=-1, keepdims=True) < MIN_UP_SINE**2
    # Looking straight down or up, +X is up, or the vertical if that is along the sight.
    other = np.where(np.abs(forward[:, :1]) < 0.9, AHEAD, UP)
    return target, np.where(flat, other, up)
