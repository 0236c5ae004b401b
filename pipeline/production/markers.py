"""Markers: where the film is cut, and where the script tells somebody something."""

from __future__ import annotations

from collections.abc import Iterator

from audio.score import Marker
from pipeline.production.camera.cuts import first_frames
from pipeline.simulation.clock import Clock
from pipeline.simulation.take import Take
from pipeline.spec.scene import Scene
from render.config import Camera


def markers_of(scene: Scene, take: Take) -> tuple[Marker, ...]:
    """Return the markers of a film in the order of its frames, cuts before instructions."""
    found = [*_cuts(scene, take), *_told(take)]
    return tuple(sorted(found, key=lambda marker: marker.frame))


def _cuts(scene: Scene, take: Take) -> Iterator[Marker]:
    """Give the cuts; what the film begins with is none, nor what would begin after its end."""
    starts = first_frames(scene.camera, take.header.rate)
    for cut, frame, after in zip(scene.camera, starts, [*starts[1:], None], strict=True):
        # Of cuts between two frames only the last is seen.
        if 1 < frame <= take.header.frames and frame != after:
            yield Marker(frame, "cut", _seen(cut))


def _seen(cut: Camera) -> str:
    """Return what a cut shows from where, such as "side of bug"."""
    whom = cut.follow if isinstance(cut.follow, str) else ", ".join(cut.follow or ("all",))
    if cut.parent is not None:
        return f"from {cut.parent}"
    if cut.moved:
        return "moving camera"
    if cut.at is not None:
        return "standing camera" if cut.look_at is not None else f"standing camera, {whom}"
    return f"{cut.view or 'three-quarter'} of {whom}"


def _told(take: Take) -> Iterator[Marker]:
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    for told in take.told:
        frame = clock.frame_of(told.step, 0.0)
        if frame <= header.frames:
            yield Marker(frame, "script", f"{told.who}: {told.text}")
