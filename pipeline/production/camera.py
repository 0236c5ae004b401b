"""Camera: from the words of a scene and its take to a pose for every frame.

A camera that follows looks at the middle of its performers, smoothed over time in
both directions, so that it neither lags nor shares their bounce. Where it is not
told its distance it stands so far that they are in the picture at every frame of
the cut, and it never goes below the ground or loses sight of them behind a hill.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.clock import Clock
from pipeline.simulation.spatial import UP, Array, matrix, normalized
from pipeline.simulation.take import Take
from pipeline.simulation.terrain.heightfield import HeightField
from render.shot import CameraPose
from render.words import Camera, View

VIEWS: dict[View, tuple[float, float]] = {
    "three-quarter": (38.0, 15.0),
    "side": (90.0, 9.0),
    "front": (0.0, 10.0),
    "back": (180.0, 18.0),
    "top": (0.0, 89.0),
}
"""Where a view looks from: azimuth from the heading, to the right, and elevation [degrees]."""

SMOOTHING = 0.45
"""Standard deviation in time of a followed path [s]."""

MARGIN = 1.08
"""Room left around performers, as a factor on their extent."""

CLEARANCE = 0.12
"""Least height of the camera over the ground, as a part of its distance."""

LEAD = 0.07
"""How far ahead of its performers a camera looks, as a part of its distance."""


@dataclass(frozen=True, eq=False)
class _Followed:
    """What a cut follows: its place (F, 3), its extent around that, its heading."""

    place: Array
    points: Array
    heading: Array


def camera_poses(take: Take, cuts: Sequence[Camera], aspect: float) -> tuple[CameraPose, ...]:
    """Return the pose of the camera at every frame.

    Args:
        take: what is filmed.
        cuts: in the order of time, the first from the start.
        aspect: width by height of the picture.
    """
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    ground = _ground(take)
    starts = [min(1 + math.ceil(cut.start * float(header.rate)), header.frames) for cut in cuts]
    ends = [*starts[1:], header.frames + 1]
    poses: list[CameraPose] = []
    for cut, first, end in zip(cuts, starts, ends, strict=True):
        rows = np.array([clock.row_of_frame(f) for f in range(first, end)], dtype=np.int64)
        if len(rows):
            poses.extend(_cut(take, cut, rows, ground, aspect))
    return tuple(poses)


def _cut(
    take: Take, cut: Camera, rows: NDArray[np.int64], ground: HeightField, aspect: float
) -> list[CameraPose]:
    followed = _follow(take, cut.follow, rows)
    target = followed.place if cut.look_at is None else np.tile(cut.look_at, (len(rows), 1))
    if cut.at is not None:
        eye = np.tile(np.asarray(cut.at, dtype=float), (len(rows), 1))
        return _poses(eye, target, UP, cut.fov_deg)
    view = cut.view or "three-quarter"
    azimuth, elevation = (math.radians(angle) for angle in VIEWS[view])
    if cut.elevation_deg is not None:
        elevation = math.radians(cut.elevation_deg)
    forward = followed.heading
    right = np.cross(forward, UP)
    level = math.cos(azimuth) * forward + math.sin(azimuth) * right
    direction = math.cos(elevation) * level + math.sin(elevation) * UP
    distance = cut.distance or _distance(followed, target, direction, cut.fov_deg, aspect)
    if view == "top":
        return _poses(target + distance * UP, target, forward, cut.fov_deg)
    if cut.look_at is None:
        target = target + LEAD * distance * forward
    if cut.distance is None:
        # Whoever is followed no longer stands in the middle and needs some more room.
        distance = _distance(followed, target, direction, cut.fov_deg, aspect)
    eye = _clear(target + distance * direction, target, ground, distance, _rate(take))
    return _poses(eye, target, UP, cut.fov_deg)


def _follow(take: Take, names: str | tuple[str, ...] | None, rows: NDArray[np.int64]) -> _Followed:
    """Return the smoothed middle and the extent of the performers called `names`."""
    wanted = (names,) if isinstance(names, str) else names
    nodes = [i for i, n in enumerate(take.nodes) if wanted is None or n.performer in wanted]
    roots = [i for i in nodes if take.nodes[i].parent < 0]
    points = take.positions[rows][:, nodes]
    middle = 0.5 * (points.min(axis=1) + points.max(axis=1))
    place = _smoothed(middle, SMOOTHING * _rate(take))
    # One heading for the whole cut: a camera that turned with every step would sway.
    ahead = matrix(take.rotations[rows][:, roots])[..., 0].sum(axis=(0, 1))
    ahead[1] = 0.0
    heading = normalized(ahead) if np.linalg.norm(ahead) > 1e-6 else np.array([1.0, 0.0, 0.0])
    return _Followed(place, points, heading)


def _distance(
    followed: _Followed, target: Array, direction: Array, fov_deg: float, aspect: float
) -> float:
    """Return the least distance from which all points are in the picture at all frames."""
    across = normalized(np.cross(UP, direction)) if abs(direction[1]) < 0.999 else followed.heading
    upward = np.cross(direction, across)
    relative = followed.points - target[:, None]
    tan = math.tan(math.radians(fov_deg) / 2.0)
    wide = np.abs(relative @ across) * MARGIN / (tan * aspect)
    high = np.abs(relative @ upward) * MARGIN / tan
    # A point nearer to the camera than the target needs that much more distance.
    return float((np.maximum(wide, high) + relative @ direction).max()) * 1.05


def _clear(eye: Array, target: Array, ground: HeightField, distance: float, rate: float) -> Array:
    """Raise `eye` (F, 3) over the ground and over what hides `target`, smoothly."""
    least = np.full(len(eye), -np.inf)
    for part in np.linspace(0.0, 0.75, 16):
        # The line of sight at this part of the way from the eye to the target.
        p = eye + part * (target - eye)
        room = CLEARANCE * distance * (1.0 - part)
        needed = ground.height(p[:, 0], p[:, 2]) + room - p[:, 1]
        least = np.maximum(least, needed / (1.0 - part))
    lift = np.maximum(least, 0.0)
    if not lift.any():
        return eye
    # The highest lift within the window, then smoothed: never less than what is needed.
    window = max(1, round(3 * SMOOTHING * rate))
    padded = np.pad(lift, window, mode="edge")
    crest = np.lib.stride_tricks.sliding_window_view(padded, 2 * window + 1).max(axis=-1)
    raised = eye.copy()
    raised[:, 1] += _smoothed(crest[:, None], SMOOTHING * rate)[:, 0]
    return raised


def _smoothed(path: Array, sigma: float) -> Array:
    """Return `path` (F, d) under a gaussian of `sigma` frames, carried on straight at its ends."""
    reach = max(1, math.ceil(3.0 * sigma))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    kernel /= kernel.sum()
    # Point reflection at both ends keeps position and speed.
    padded = (
        np.pad(path, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
        if len(path) > 1
        else np.repeat(path, 2 * reach + 1, axis=0)
    )
    return np.stack([np.convolve(column, kernel, mode="valid") for column in padded.T], axis=-1)


def _poses(eye: Array, target: Array, up: Array, fov_deg: float) -> list[CameraPose]:
    def plain(v: Array) -> tuple[float, float, float]:
        # Rounded to a micrometre: the last bits of a processor's arithmetic are no
        # reason to render a frame again.
        x, y, z = (round(float(c), 6) + 0.0 for c in v)
        return x, y, z

    return [
        CameraPose(plain(e), plain(t), plain(up), fov_deg) for e, t in zip(eye, target, strict=True)
    ]


def _rate(take: Take) -> float:
    return float(take.header.rate)


def _ground(take: Take) -> HeightField:
    n_x, n_z = take.terrain.cells
    low, high = take.terrain.vertices[0], take.terrain.vertices[-1]
    heights = take.terrain.vertices[:, 1].reshape(n_z + 1, n_x + 1)
    return HeightField(heights, (float(high[0] - low[0]), float(high[2] - low[2])))
