"""Camera: from the words of a scene and its take to a pose for every frame."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.camera_path import Seen
from pipeline.production.camera.camera_target import follow
from pipeline.production.camera.clearance import Ground, Surroundings
from pipeline.production.camera.focus import lenses
from pipeline.production.camera.framing import Framing
from pipeline.production.camera.keyframed_camera import (
    fields_of_view,
    looks_by_itself,
    seen_from,
)
from pipeline.production.camera.lead_room import ahead_of
from pipeline.production.camera.moves import Moves
from pipeline.production.camera.path_smoothing import smoothed
from pipeline.simulation.clock import Clock
from pipeline.simulation.spatial import UP, Array
from pipeline.simulation.take import Take
from render.config import Camera
from render.shot import CameraPose


@dataclass(frozen=True, eq=False)
class _Cut:
    """A cut, where it is in a take, and the node that its camera goes along with, -1 for none."""

    take: Take
    words: Camera
    rows: NDArray[np.int64]
    seconds: float
    mount: int
    nodes: Mapping[str, int]
    ground: Ground
    aspect: float

    @property
    def rate(self) -> float:
        return float(self.take.header.rate)

    @property
    def times(self) -> Array:
        return self.rows / (self.rate * self.take.header.samples)


def camera_poses(
    take: Take,
    cuts: Sequence[Camera],
    aspect: float,
    mounts: Sequence[int] | None = None,
    nodes: Mapping[str, int] | None = None,
) -> tuple[CameraPose, ...]:
    """Return the pose of the camera at every frame.

    Args:
        take: what is filmed.
        cuts: in the order of time, the first from the start.
        aspect: width by height of the picture.
        mounts: node that the camera of each cut goes along with, -1 for none.
        nodes: number of each node that a focus names.
    """
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    ground = Ground(take.terrain)
    starts = [min(start, header.frames + 1) for start in first_frames(cuts, header.rate)]
    ends = [*starts[1:], header.frames + 1]
    poses: list[CameraPose] = []
    mounts = mounts or [-1] * len(cuts)
    for words, mount, first, end in zip(cuts, mounts, starts, ends, strict=True):
        rows = np.array([clock.row_of_frame(f) for f in range(first, end)], dtype=np.int64)
        if not len(rows):
            continue
        seconds = float((end - 1) / header.rate) - words.start
        cut = _Cut(take, words, rows, seconds, mount, nodes or {}, ground, aspect)
        poses.extend(_poses(cut))
    return tuple(poses)


def first_frames(cuts: Sequence[Camera], rate: Fraction) -> list[int]:
    """Return the frame from which each cut is seen, which may lie after the last."""
    # A time is the decimal number that was written, which lies on a frame or does not.
    return [1 + math.ceil(Fraction(repr(cut.start)) * rate) for cut in cuts]


def _poses(cut: _Cut) -> list[CameraPose]:
    words = cut.words
    if words.is_animated:
        seen, place = _moved(cut)
    elif words.at is not None:
        seen, place = _standing(cut)
    else:
        seen, place = _framed(cut)
    return seen.poses(lenses(cut.take, words, cut.rows, seen, place, cut.nodes))


def _framed(cut: _Cut) -> tuple[Seen, Array]:
    """Return a camera that frames by itself, and what it looks at (F, 3)."""
    words = cut.words
    followed = follow(cut.take, words.follow, cut.rows)
    target = followed.place
    if words.look_at is not None:
        target = np.tile(np.asarray(words.look_at, dtype=float), (len(cut.rows), 1))
    framing = Framing(
        cut=words,
        followed=followed,
        target=target,
        moves=Moves.of(words, followed.heading, cut.times - words.start, cut.seconds),
        around=Surroundings.of(cut.take, cut.ground, followed, cut.rows),
        aspect=cut.aspect,
        fov_deg=fields_of_view(words, cut.times),
    )
    return framing.seen(), target


def _standing(cut: _Cut) -> tuple[Seen, Array]:
    """Return a camera that stands at a place, and what it looks at (F, 3)."""
    words, count = cut.words, len(cut.rows)
    eye, up = np.tile(np.asarray(words.at, dtype=float), (count, 1)), np.tile(UP, (count, 1))
    fov_deg = fields_of_view(words, cut.times)
    if words.look_at is not None:
        place = np.tile(np.asarray(words.look_at, dtype=float), (count, 1))
        seen = Seen(eye, place, up, fov_deg)
    else:
        followed = follow(cut.take, words.follow, cut.rows)
        place = followed.place
        seen = Seen(eye, place, up, fov_deg)
        ahead = ahead_of(followed.velocity, seen, words.lead, cut.aspect)
        seen = Seen(eye, place + ahead, up, fov_deg)
    return cut.ground.cleared(seen, cut.rate, along=False), place


def _moved(cut: _Cut) -> tuple[Seen, Array]:
    """Return a camera that its author moves, and what it looks at (F, 3)."""
    words, target = cut.words, None
    if words.look_at is not None:
        target = np.tile(np.asarray(words.look_at, dtype=float), (len(cut.rows), 1))
    elif words.follow is not None or (words.parent is None and not looks_by_itself(words)):
        target = follow(cut.take, words.follow, cut.rows).place
    seen = seen_from(cut.take, words, cut.mount, cut.rows, target)
    if words.steady > 0.0:
        seen = seen.smoothed(lambda path: smoothed(path, words.steady * cut.rate))
    aims = target is not None or any(key.target is not None for key in words.keyframes)
    return cut.ground.cleared(seen, cut.rate, along=not aims), seen.target
