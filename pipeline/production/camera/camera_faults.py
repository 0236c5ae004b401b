"""Camera faults: frames in which a camera does not show its subject, known before rendering.

The camera is inside something; the subject is out of the frame, tiny, or hidden. A view that the
author named and that had to be turned is told as well.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.production.camera.camera_subjects import camera_subjects
from pipeline.production.camera.cuts import FilmedCut, cut_frames
from pipeline.production.camera.view_turn import ViewTurn
from pipeline.production.camera.visibility import Sight, Visibility
from pipeline.simulation.clock import Clock
from render.config import Camera
from render.shot import CameraPose

SAMPLE_INTERVAL_S = 0.2
"""Time between the frames that are looked at [s]."""

MAX_SAMPLES = 300
"""Frames of a film that are looked at."""

LEAST_DURATION_S = 0.5
"""Duration from which a subject that cannot be seen is a fault [s]."""

LEAST_EXTENT = 0.04
"""Extent of a subject below which it is tiny, see `Sight.extent`."""

LEAST_RAISE = 0.02
"""Rise of an author's camera out of the ground from which it is told [m]."""


@dataclass(frozen=True, slots=True)
class CameraFault:
    """What is wrong with the camera of a cut.

    Attributes:
        kind: by which programs tell faults apart, such as "subject_blocked".
        cut: number of the cut, from 0.
        part: performer that it is about.
        frames: first and last frame of each run, in order.
        text: what is wrong, without the frames.
    """

    kind: str
    cut: int
    part: str
    frames: tuple[tuple[int, int], ...]
    text: str


@dataclass(frozen=True, slots=True)
class _Finding:
    """What is wrong at one frame."""

    kind: str
    part: str
    text: str
    value: float = 0.0


def camera_faults(
    visibility: Visibility,
    cameras: Sequence[Camera],
    filmed: Sequence[FilmedCut],
    aspect: float,
) -> list[CameraFault]:
    """Return the faults of all cuts in the order of time.

    Args:
        visibility: of the take that is filmed.
        cameras: one for each cut.
        filmed: the cuts with these cameras.
        aspect: width by height of the frame.
    """
    poses = [pose for cut in filmed for pose in cut.poses]
    header = visibility.take.header
    step = max(round(SAMPLE_INTERVAL_S * header.rate), -(-header.frames // MAX_SAMPLES), 1)
    faults: list[CameraFault] = []
    for number, frames in enumerate(cut_frames(cameras, header.rate, header.frames)):
        if frames:
            faults += _raised(cameras[number], number, frames, poses)
            faults += _turned(cameras[number], number, frames, filmed[number].turn)
            sampled = sorted({*frames[::step], frames[-1]})
            found = _findings(visibility, cameras[number], frames, sampled, poses, aspect)
            least = min(LEAST_DURATION_S * float(header.rate), len(frames))
            faults += _faults(number, sampled, found, least)
    return sorted(faults, key=lambda fault: fault.frames[0])


def _raised(
    camera: Camera, number: int, frames: range, poses: Sequence[CameraPose]
) -> Iterator[CameraFault]:
    """Yield the fault of an author's camera that had to be raised out of the ground."""
    if camera.at is None or camera.is_animated:
        return
    rise = max(poses[frame - 1].p_WC[1] for frame in frames) - camera.at[1]
    if rise > LEAST_RAISE:
        text = f"`at` lies in the ground, so that the camera is raised by {rise:.2f} m"
        yield CameraFault("camera_raised", number, "camera", ((frames[0], frames[-1]),), text)


def _turned(
    camera: Camera, number: int, frames: range, turn: ViewTurn | None
) -> Iterator[CameraFault]:
    """Yield the fault of a view that the author named, and that is turned."""
    if turn is not None and camera.view is not None:
        angle = abs(math.degrees(turn.angle))
        text = (
            f"`view: {camera.view}` is turned by {angle:.0f} degrees, because {turn.reason} "
            "(a camera with `at` is never turned)"
        )
        yield CameraFault("view_turned", number, "camera", ((frames[0], frames[-1]),), text)


def _findings(
    visibility: Visibility,
    camera: Camera,
    frames: range,
    sampled: Sequence[int],
    poses: Sequence[CameraPose],
    aspect: float,
) -> list[list[_Finding]]:
    """Return what is wrong at each of the frames of a cut that are looked at."""
    header = visibility.take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    rows = np.array([clock.row_of_frame(frame) for frame in frames], dtype=np.int64)
    subjects = camera_subjects(visibility.take, camera, rows)
    several = camera.follow is None
    result: list[list[_Finding]] = []
    for frame in sampled:
        cast, pose = visibility.at(int(rows[frame - frames[0]])), poses[frame - 1]
        if cast is None:
            result.append([])
            continue
        around = cast.surrounding(np.array(pose.p_WC))
        found = [_Finding("camera_inside", around, "the camera is inside it")] if around else []
        for names in subjects:
            sight = cast.sight(names, pose, aspect)
            name = "the cast" if several and len(names) > 1 else next(iter(names))
            if sight is not None and not around:
                found += _subject_findings(name, sight)
        result.append(found)
    return result


def _subject_findings(name: str, sight: Sight) -> Iterator[_Finding]:
    """Yield what is wrong with the sight of a subject."""
    if not sight.framed:
        yield _Finding("subject_out_of_frame", name, "nothing of it is in the picture")
        return
    if sight.extent < LEAST_EXTENT:
        text = "its size is down to {:.1%} of the picture's height"
        yield _Finding("subject_tiny", name, text, sight.extent)
    if sight.is_blocked:
        yield _Finding("subject_blocked", name, f"{sight.blocker} hides it")


def _faults(
    number: int, sampled: Sequence[int], found: Sequence[Sequence[_Finding]], least: float
) -> Iterator[CameraFault]:
    """Yield the faults of a cut whose runs last `least` frames; any run inside a body is one."""
    kinds = dict.fromkeys((f.kind, f.part, f.text) for findings in found for f in findings)
    for kind, part, text in kinds:
        same = [
            [f.value for f in findings if (f.kind, f.part, f.text) == (kind, part, text)]
            for findings in found
        ]
        runs = [
            (frames[0], frames[-1])
            for frames in _runs(sampled, [bool(values) for values in same])
            if kind == "camera_inside" or frames[-1] - frames[0] + 1 >= least
        ]
        if runs:
            smallest = min(value for values in same for value in values)
            yield CameraFault(kind, number, part, tuple(runs), text.format(smallest))


def _runs(sampled: Sequence[int], bad: Sequence[bool]) -> Iterator[list[int]]:
    """Yield the successive frames that are bad."""
    for is_bad, group in itertools.groupby(zip(sampled, bad, strict=True), lambda pair: pair[1]):
        if is_bad:
            yield [frame for frame, _ in group]
