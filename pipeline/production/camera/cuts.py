"""Cuts: camera poses of every frame, from a take and the camera configuration of its scene."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.auto_framing import AutoFraming, lead_offset
from pipeline.production.camera.camera_path import CameraPath, smoothed
from pipeline.production.camera.camera_target import CameraTarget, follow
from pipeline.production.camera.clearance import Clearance, VisibleGround
from pipeline.production.camera.handheld import shaken
from pipeline.production.camera.keyframed_camera import animated_path, fields_of_view, has_direction
from pipeline.production.camera.lens import lenses
from pipeline.production.camera.moves import CameraMoves
from pipeline.production.camera.view_turn import ViewTurn, clear_path
from pipeline.production.camera.visibility import Visibility
from pipeline.production.surroundings.land import Land
from pipeline.simulation.clock import Clock
from pipeline.simulation.spatial import UP, Array
from pipeline.simulation.take import Take
from render.config import Camera
from render.shot import CameraPose


@dataclass(frozen=True, slots=True)
class FilmedCut:
    """A cut as it is filmed.

    Attributes:
        poses: of the camera, one for each frame of the cut.
        turn: of its view away from what hides the subject, None without any.
    """

    poses: tuple[CameraPose, ...] = ()
    turn: ViewTurn | None = None


def camera_poses(
    take: Take,
    cameras: Sequence[Camera],
    aspect: float,
    mounts: Sequence[int] | None = None,
    nodes: Mapping[str, int] | None = None,
) -> tuple[CameraPose, ...]:
    """Return the camera pose of every frame, see `filmed_cuts`."""
    cuts = filmed_cuts(take, cameras, aspect, mounts, nodes)
    return tuple(pose for cut in cuts for pose in cut.poses)


def filmed_cuts(
    take: Take,
    cameras: Sequence[Camera],
    aspect: float,
    mounts: Sequence[int] | None = None,
    nodes: Mapping[str, int] | None = None,
    clear: Collection[str] = (),
    land: Land | None = None,
) -> list[FilmedCut]:
    """Return the cuts of a film.

    Args:
        take: that is filmed.
        cameras: one for each cut in order of time, the first from the start.
        aspect: width by height of the frame.
        mounts: node that carries the camera of each cut, -1 for none.
        nodes: number of each node that a focus names.
        clear: materials that can be seen through.
        land: around the terrain; by default the terrain's own roughness goes on.
    """
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    ground = VisibleGround(land or Land(take.terrain))
    visibility = Visibility(take, ground, clear)
    filmed: list[FilmedCut] = []
    mounts = mounts or [-1] * len(cameras)
    frames = cut_frames(cameras, header.rate, header.frames)
    for camera, mount, shown in zip(cameras, mounts, frames, strict=True):
        if not shown:
            filmed.append(FilmedCut())
            continue
        rows = np.array([clock.row_of_frame(f) for f in shown], dtype=np.int64)
        seconds = float(shown[-1] / header.rate) - camera.start
        cut = _Cut(visibility, camera, rows, seconds, mount, nodes or {}, aspect)
        path, place, turn = _path(cut)
        path = shaken(path, cut.times, camera.handheld, header.seed)
        poses = path.poses(lenses(take, camera, rows, path, place, cut.nodes))
        filmed.append(FilmedCut(tuple(poses), turn))
    return filmed


def first_frames(cameras: Sequence[Camera], rate: Fraction) -> list[int]:
    """Return the first frame of each cut, which may lie after the last frame of the film."""
    # The decimal number as written, so that a time on a frame is exact.
    return [1 + math.ceil(Fraction(repr(camera.start)) * rate) for camera in cameras]


def cut_frames(cameras: Sequence[Camera], rate: Fraction, frames: int) -> list[range]:
    """Return the frames of each cut of a film of some `frames`; empty for a cut after its end."""
    starts = [min(start, frames + 1) for start in first_frames(cameras, rate)]
    return [range(*pair) for pair in itertools.pairwise([*starts, frames + 1])]


@dataclass(frozen=True, eq=False)
class _Cut:
    """One cut of a take.

    Attributes:
        visibility: of the take that is filmed, and its ground.
        camera: its configuration.
        rows: (F,) of its frames.
        seconds: its duration.
        mount: node that carries the camera, -1 for none.
        nodes: number of each node that a focus names.
        aspect: width by height of the frame.
    """

    visibility: Visibility
    camera: Camera
    rows: NDArray[np.int64]
    seconds: float
    mount: int
    nodes: Mapping[str, int]
    aspect: float

    @property
    def take(self) -> Take:
        return self.visibility.take

    @property
    def ground(self) -> VisibleGround:
        return self.visibility.ground

    @property
    def rate(self) -> float:
        return float(self.take.header.rate)

    @property
    def times(self) -> Array:
        return self.rows / (self.rate * self.take.header.samples)

    @property
    def look_at(self) -> Array | None:
        """The fixed point (F, 3) that the camera looks at, or None."""
        if self.camera.look_at is None:
            return None
        return np.tile(np.asarray(self.camera.look_at, dtype=float), (len(self.rows), 1))

    def follow(self) -> CameraTarget:
        """Return the performers that the cut follows."""
        return follow(self.take, self.camera.follow, self.rows)


def _path(cut: _Cut) -> tuple[CameraPath, Array, ViewTurn | None]:
    """Return the camera path of a cut, what it looks at before lead room (F, 3), and its turn."""
    if cut.camera.auto is not None:
        raise ValueError("a director has to decide the cuts of this camera first")
    if cut.camera.is_animated:
        return *_animated(cut), None
    if cut.camera.at is not None:
        return *_standing(cut), None
    return _framed(cut)


def _framed(cut: _Cut) -> tuple[CameraPath, Array, ViewTurn | None]:
    framing = _framing(cut)
    path, turn = clear_path(framing, cut.visibility, cut.rows)
    return path, framing.target, turn


def automatic_framing(
    visibility: Visibility, camera: Camera, rows: NDArray[np.int64], aspect: float
) -> AutoFraming:
    """Return the framing of a cut without moves, before its view is turned.

    Args:
        visibility: of the take that is filmed.
        camera: configuration of the cut.
        rows: (F,) of its frames.
        aspect: width by height of the frame.
    """
    return _framing(_Cut(visibility, camera, rows, 0.0, -1, {}, aspect))


def _framing(cut: _Cut) -> AutoFraming:
    camera, followed = cut.camera, cut.follow()
    look_at = cut.look_at
    return AutoFraming(
        cut=camera,
        followed=followed,
        target=followed.place if look_at is None else look_at,
        moves=CameraMoves.of(camera, followed.heading, cut.times - camera.start, cut.seconds),
        clearance=Clearance.of(cut.take, cut.ground, followed, cut.rows),
        aspect=cut.aspect,
        fov_deg=fields_of_view(camera, cut.times),
    )


def _standing(cut: _Cut) -> tuple[CameraPath, Array]:
    camera, count = cut.camera, len(cut.rows)
    eye, up = np.tile(np.asarray(camera.at, dtype=float), (count, 1)), np.tile(UP, (count, 1))
    fov_deg = fields_of_view(camera, cut.times)
    look_at = cut.look_at
    if look_at is not None:
        place, path = look_at, CameraPath(eye, look_at, up, fov_deg)
    else:
        followed = cut.follow()
        place = followed.place
        path = CameraPath(eye, place, up, fov_deg)
        offset = lead_offset(followed.velocity, path, camera.lead, cut.aspect)
        path = CameraPath(eye, place + offset, up, fov_deg)
    return cut.ground.cleared(path, cut.rate, with_target=False), place


def _animated(cut: _Cut) -> tuple[CameraPath, Array]:
    camera, target = cut.camera, cut.look_at
    follows = camera.follow is not None or (camera.parent is None and not has_direction(camera))
    if target is None and follows:
        target = cut.follow().place
    path = animated_path(cut.take, camera, cut.mount, cut.rows, target)
    if camera.steady > 0.0:
        path = path.smoothed(lambda points: smoothed(points, camera.steady * cut.rate))
    has_target = target is not None or any(key.target is not None for key in camera.keyframes)
    return cut.ground.cleared(path, cut.rate, with_target=not has_target), path.target
