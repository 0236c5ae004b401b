"""Director: replaces each camera with `auto` by the cuts that it decides from a take."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pipeline.production.camera.cuts import cut_frames
from pipeline.production.camera.director.edit_decision import EditDecision
from pipeline.production.camera.director.editing_pace import PACES
from pipeline.production.camera.director.key_light import KeyLight
from pipeline.production.camera.director.performer_tracks import PerformerTracks
from pipeline.production.camera.director.planned_shot import PlannedShot
from pipeline.production.camera.director.shot_plan import ShotPlan
from pipeline.production.camera.director.story import story_of
from pipeline.production.camera.director.view_choice import ViewChoice
from pipeline.production.camera.director.view_finder import ViewFinder
from pipeline.production.camera.visibility import Visibility
from render.config import Camera, Light


def edit_decisions(
    visibility: Visibility, cameras: Sequence[Camera], light: Light, aspect: float
) -> tuple[EditDecision, ...]:
    """Return the cuts of a film: those of the author, and those of a director in place of `auto`.

    Args:
        visibility: of the take that is filmed.
        cameras: of the scene, in the order of time.
        light: of the scene.
        aspect: width by height of the frame.
    """
    if all(camera.auto is None for camera in cameras):
        return tuple(EditDecision(camera, "", i) for i, camera in enumerate(cameras))
    header = visibility.take.header
    tracks = PerformerTracks.of(visibility.take)
    decisions: list[EditDecision] = []
    spans = cut_frames(cameras, header.rate, header.frames)
    for i, (camera, frames) in enumerate(zip(cameras, spans, strict=True)):
        if camera.auto is None:
            decisions.append(EditDecision(camera, "", i))
        elif not frames:
            # It starts after the end of the film.
            plain = Camera(start=camera.start, follow=camera.follow, handheld=camera.handheld)
            decisions.append(EditDecision(plain, "after the end of the film", i))
        else:
            key, actors = KeyLight.of(light), _actors(tracks, camera)
            finder = ViewFinder(visibility, tracks, actors, key, aspect, camera.handheld)
            decisions += _directed(finder, camera, range(frames[0] - 1, frames[-1]), i)
    return tuple(decisions)


def _directed(finder: ViewFinder, camera: Camera, frames: range, source: int) -> list[EditDecision]:
    """Return the cuts of the frames of one camera, counted from 0."""
    assert camera.auto is not None
    tracks, actors = finder.tracks, finder.actors
    take = finder.visibility.take
    story = [
        event
        for event in story_of(take, tracks, actors)
        if frames.start <= event.time * finder.rate < frames.stop
    ]
    plan = ShotPlan(tracks, actors, _named(camera), PACES[camera.auto], finder.rate)
    shots = plan.shots(frames.start, frames.stop, story)
    chosen = ViewChoice(finder).chosen(shots)
    return [EditDecision(view.camera, _told(shot, view.light), source) for shot, view in chosen]


def _named(camera: Camera) -> tuple[str, ...] | None:
    """Return the performers that the author asked for, None for all."""
    return (camera.follow,) if isinstance(camera.follow, str) else camera.follow


def _actors(tracks: PerformerTracks, camera: Camera) -> tuple[str, ...]:
    """Return the performers that the film is about."""
    named = _named(camera)
    return tracks.actors() if named is None else tuple(n for n in named if n in tracks.names)


def _told(shot: PlannedShot, light: float | None) -> str:
    """Return the reason of a shot with what its view keeps to."""
    if light is None:
        return shot.reason
    return f"{shot.reason}; key light {math.degrees(light):.0f} degrees from the camera"
