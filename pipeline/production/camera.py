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
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from pipeline.production.moving_camera import looks_by_itself, seen_from
from pipeline.simulation.clock import Clock
from pipeline.simulation.reel import reel, rows_of
from pipeline.simulation.spatial import UP, Array, matrix, normalized
from pipeline.simulation.take import Mesh, Take
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.simulation.terrain.surfaces import surface_of_vertices
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

MARGIN = 1.06
"""Room left around performers, as a factor on their extent."""

CLEARANCE = 0.12
"""Least height of the camera over the ground, as a part of its distance."""

FITTINGS = 6
"""How often the distance is corrected until performers are in the picture."""

LEAD = 0.07
"""How far ahead of its performers a camera looks, as a part of its distance."""


@dataclass(frozen=True, eq=False)
class _Followed:
    """What a cut follows: its place (F, 3), its extent around that, its heading."""

    place: Array
    points: Array
    heading: Array


def camera_poses(
    take: Take, cuts: Sequence[Camera], aspect: float, mounts: Sequence[int] | None = None
) -> tuple[CameraPose, ...]:
    """Return the pose of the camera at every frame.

    Args:
        take: what is filmed.
        cuts: in the order of time, the first from the start.
        aspect: width by height of the picture.
        mounts: node that the camera of each cut goes along with, -1 for none.
    """
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    ground = _ground(take)
    starts = [min(start, header.frames + 1) for start in first_frames(cuts, header.rate)]
    ends = [*starts[1:], header.frames + 1]
    poses: list[CameraPose] = []
    mounts = mounts or [-1] * len(cuts)
    for cut, mount, first, end in zip(cuts, mounts, starts, ends, strict=True):
        rows = np.array([clock.row_of_frame(f) for f in range(first, end)], dtype=np.int64)
        if not len(rows):
            continue
        if cut.moved:
            poses.extend(_moved(take, cut, mount, rows))
        else:
            poses.extend(_cut(take, cut, rows, ground, aspect))
    return tuple(poses)


def first_frames(cuts: Sequence[Camera], rate: Fraction) -> list[int]:
    """Return the frame from which each cut is seen, which may lie after the last."""
    # A time is the decimal number that was written, which lies on a frame or does not.
    return [1 + math.ceil(Fraction(repr(cut.start)) * rate) for cut in cuts]


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
    if view == "top":
        level, direction = forward, UP
    if cut.distance is not None:
        return _stand(cut, followed, target, direction, cut.distance, ground, take)
    distance = 1.0
    for _ in range(FITTINGS):
        poses = _stand(cut, followed, target, direction, distance, ground, take)
        distance *= _too_near(followed.points, poses, aspect)
    return _stand(cut, followed, target, direction, distance, ground, take)


def _moved(take: Take, cut: Camera, mount: int, rows: NDArray[np.int64]) -> list[CameraPose]:
    """Return the poses of a camera that its author moves."""
    target = None
    if cut.look_at is not None:
        target = np.tile(cut.look_at, (len(rows), 1))
    elif cut.follow is not None or (cut.parent is None and not looks_by_itself(cut)):
        target = _follow(take, cut.follow, rows).place
    seen = seen_from(take, cut, mount, rows, target)
    if cut.steady > 0.0:
        seen = seen.smoothed(lambda path: _smoothed(path, cut.steady * _rate(take)))
    return [
        pose
        for i, fov_deg in enumerate(seen.fov_deg)
        for pose in _poses(seen.eye[[i]], seen.target[[i]], seen.up[i], float(fov_deg))
    ]


def _stand(
    cut: Camera,
    followed: _Followed,
    target: Array,
    direction: Array,
    distance: float,
    ground: HeightField,
    take: Take,
) -> list[CameraPose]:
    """Return the poses of a camera that stands at `distance` in `direction` of its target."""
    if cut.look_at is None:
        target = target + LEAD * distance * followed.heading
    eye = target + distance * direction
    if cut.view == "top":
        return _poses(eye, target, followed.heading, cut.fov_deg)
    return _poses(_clear(eye, target, ground, distance, _rate(take)), target, UP, cut.fov_deg)


def _follow(take: Take, names: str | tuple[str, ...] | None, rows: NDArray[np.int64]) -> _Followed:
    """Return the smoothed middle and the extent of the performers called `names`."""
    wanted = (names,) if isinstance(names, str) else names
    roots = [
        i
        for i, node in enumerate(take.nodes)
        if (wanted is None or node.performer in wanted)
        and (node.parent < 0 or take.nodes[node.parent].performer != node.performer)
    ]
    points = _corners(take, wanted, rows)
    middle = np.concatenate(
        [0.5 * (points[some].min(axis=1) + points[some].max(axis=1)) for some in rows_of(points)]
    )
    place = _smoothed(middle, SMOOTHING * _rate(take))
    # One heading for the whole cut: a camera that turned with every step would sway.
    ahead = matrix(take.rotations[np.ix_(rows, np.array(roots))])[..., 0].sum(axis=(0, 1))
    ahead[1] = 0.0
    heading = normalized(ahead) if np.linalg.norm(ahead) > 1e-6 else np.array([1.0, 0.0, 0.0])
    return _Followed(place, points, heading)


def _corners(take: Take, wanted: tuple[str, ...] | None, rows: NDArray[np.int64]) -> Array:
    """Return the corners (F, 8 P, 3) of boxes around all parts of the performers `wanted`."""
    boxes = [
        box
        for part in take.parts
        if wanted is None or part.performer in wanted
        for box in _boxes(take, take.meshes[part.mesh])
    ]
    nodes, corners = [node for node, _ in boxes], [box for _, box in boxes]
    scaled = [(j, take.scaled.index(n)) for j, n in enumerate(nodes) if n in set(take.scaled)]
    corners_W: Array = reel((len(rows), 8 * len(nodes), 3), float)
    for some in rows_of(corners_W):
        which = np.ix_(rows[some], np.array(nodes))
        R, p = matrix(take.rotations[which]), take.positions[which]
        for j, n in scaled:
            R[:, j] *= take.scales[rows[some], n][:, None]
        world = np.einsum("fpij,pcj->fpci", R, np.array(corners)) + p[:, :, None]
        corners_W[some] = world.reshape(-1, 8 * len(nodes), 3)
    return corners_W


def _boxes(take: Take, mesh: Mesh) -> list[tuple[int, Array]]:
    """Return the corners (8, 3) of a box around a mesh in the node it follows.

    The mesh of a group follows many nodes; each has a box then.
    """
    nodes = mesh.nodes[:, 0]
    several = bool((mesh.weights[:, 1] == 0.0).all()) and bool((nodes != nodes[0]).any())
    boxes = []
    for node in np.unique(nodes) if several else nodes[:1]:
        vertices = mesh.vertices[nodes == node] if several else mesh.vertices
        ends = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
        box = np.stack(np.meshgrid(*ends.T.astype(float)), axis=-1).reshape(8, 3)
        boxes.append((int(node), box - take.nodes[int(node)].rest))
    return boxes


def _too_near(points: Array, poses: Sequence[CameraPose], aspect: float) -> float:
    """Return by which factor the camera has to stand back to have all `points` (F, n, 3) in view.

    Less than one where it may come nearer. Judged on the poses themselves, because a
    camera that is raised over a hill looks down more steeply than it was asked to.
    """
    eye, target, up = (
        np.array([getattr(pose, name) for pose in poses]) for name in ("p_WC", "p_WT", "up")
    )
    forward = normalized(target - eye)
    right = normalized(np.cross(forward, up))
    upward = np.cross(right, forward)
    away = np.linalg.norm(target - eye, axis=-1)
    tan = math.tan(math.radians(poses[0].fov_deg) / 2.0)
    most = np.empty(len(poses))
    for some in rows_of(points):
        relative = points[some] - target[some, None]
        wide = np.abs(np.einsum("fnk,fk->fn", relative, right[some])) / (tan * aspect)
        high = np.abs(np.einsum("fnk,fk->fn", relative, upward[some])) / tan
        # What stands nearer to the camera than its target needs that much more distance.
        needed = MARGIN * np.maximum(wide, high)
        needed -= np.einsum("fnk,fk->fn", relative, forward[some])
        most[some] = needed.max(axis=-1) / away[some]
    return float(most.max().clip(0.1, 1e6))


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
    return surface_of_vertices(take.terrain.vertices, take.terrain.cells)
