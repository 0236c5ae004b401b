"""Moving camera: one that its author moves, by keyframes, by velocity, or on a parent.

Its frame C has X ahead and Y up. Like a prop it is moved relative to its parent, which is a
node of the take, or to the world; so it moves with what is filmed and is no part of it.

Source: Sims 1987, 3.1 and 3.2.1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.camera_path import Seen
from pipeline.simulation.keyframe_track import Key, Track, rotation_from_angles
from pipeline.simulation.spatial import UP, Array, matrix, normalized, rotation, turn
from pipeline.simulation.take import Take
from render.config import Camera
from render.config.camera import CameraKey

AHEAD = np.array([1.0, 0.0, 0.0])

UPRIGHT = 1e-3
"""Sine of the angle to the vertical below which it cannot say what is up in the picture."""


def looks_by_itself(cut: Camera) -> bool:
    """Tell whether a cut's own words say where the camera looks."""
    said = any(key.target is not None or key.rotation_deg is not None for key in cut.keyframes)
    return said or cut.rotation_deg is not None or cut.spin_deg is not None


def seen_from(
    take: Take, cut: Camera, mount: int, rows: NDArray[np.int64], target: Array | None
) -> Seen:
    """Return where the camera of a cut is.

    Args:
        take: what is filmed.
        cut: its words.
        mount: node that it goes along with, -1 for none.
        rows: (F,) of the frames of the cut.
        target: (F, 3) point of the world that it looks at, None where it says so itself.
    """
    header = take.header
    times = rows / float(header.rate * header.samples)
    R_WP, p_WP = np.tile(np.eye(3), (len(rows), 1, 1)), np.zeros((len(rows), 3))
    if mount >= 0:
        R_WP, p_WP = matrix(take.rotations[rows, mount]), take.positions[rows, mount]
    eye = p_WP + turn(R_WP, _places(cut, times))
    up = np.tile(UP, (len(rows), 1))
    aims = _track(cut.keyframes, "target")
    if aims is not None:
        target, up = p_WP + turn(R_WP, aims(times)), R_WP[..., 1]
    elif target is None:
        R_WC = R_WP @ _looks(cut, times)
        target, up = eye + R_WC[..., 0], R_WC[..., 1]
    return Seen(eye, *_seeing(eye, target, up), fields_of_view(cut, times))


def fields_of_view(cut: Camera, times: Array) -> Array:
    """Return how wide the camera of a cut sees, vertically, at `times` (F,) [degrees]."""
    wide = _track(cut.keyframes, "fov_deg")
    if wide is None:
        return np.full(len(times), cut.fov_deg)
    result: Array = wide(times)[:, 0].clip(1.0, 150.0)
    return result


def _places(cut: Camera, times: Array) -> Array:
    """Return where the camera is (F, 3) in its parent [m]."""
    track = _track(cut.keyframes, "position")
    if track is not None:
        return track(times)
    velocity = np.array(cut.velocity or (0.0, 0.0, 0.0))
    result: Array = np.array(cut.at) + (times - cut.start)[:, None] * velocity
    return result


def _looks(cut: Camera, times: Array) -> Array:
    """Return how the camera is turned (F, 3, 3) in its parent."""
    track = _track(cut.keyframes, "rotation_deg")
    if track is not None:
        return rotation_from_angles(np.radians(track(times)))
    R = rotation_from_angles(np.radians(np.array(cut.rotation_deg or (0.0, 0.0, 0.0))))
    spin = np.radians(np.array(cut.spin_deg or (0.0, 0.0, 0.0)))
    rate = float(np.linalg.norm(spin))
    result: Array = rotation(normalized(spin), rate * (times - cut.start)) @ R
    return result


def _track(keys: Sequence[CameraKey], word: str) -> Track | None:
    """Return the track of those keys that say `word`, None if none does."""
    said = [key for key in keys if getattr(key, word) is not None]
    if not said:
        return None
    row: list[Key] = [(key.at, _listed(getattr(key, word)), key.ease) for key in said]
    given = [getattr(key.tangent, word, None) for key in said]
    return Track.of(row, [None if rate is None else _listed(rate) for rate in given])


def _listed(value: float | tuple[float, ...]) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,)


def _seeing(eye: Array, target: Array, up: Array) -> tuple[Array, Array]:
    """Return targets and ups (F, 3) of which every one says how the picture stands."""
    away = target - eye
    target = np.where((away * away).sum(axis=-1, keepdims=True) > 1e-12, target, eye + AHEAD)
    forward = normalized(target - eye)
    across = np.cross(forward, up)
    flat = (across * across).sum(axis=-1, keepdims=True) < UPRIGHT**2
    # Straight down or up: its top is then where +X is, or the vertical where that is no help.
    other = np.where(np.abs(forward[:, :1]) < 0.9, AHEAD, UP)
    return target, np.where(flat, other, up)
