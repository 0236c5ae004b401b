"""Scoring: take and camera -> the score, its events placed as the listener hears them."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter

from audio.score import Score, ScoreEvent
from pipeline.production.listening import Listener
from pipeline.production.markers import markers_of
from pipeline.production.sound.strike_position import ContactSpots
from pipeline.simulation.clock import Clock
from pipeline.simulation.take import SoundEvent, Take
from pipeline.spec.scene import Scene
from render.shot import CameraPose


def score_of(
    scene: Scene, take: Take, poses: Sequence[CameraPose], subframe: bool = False
) -> tuple[Score, int]:
    """Return the score of `take`, and how many events fell after its last frame.

    Args:
        scene: for its words on sound.
        take: what happened.
        poses: of the camera, by frame.
        subframe: whether sounds stand at the exact times of their causes.
    """
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    listener = Listener(scene.sound.listener, scene.camera, clock, poses)
    spots = ContactSpots(take)
    heard = [event for event in take.events if event.frame <= header.frames]
    score = Score(
        rate=header.rate,
        frames=header.frames,
        events=tuple(_placed(event, clock, listener, spots) for event in heard),
        sound=scene.sound,
        seed=header.seed,
        title=scene.title,
        markers=markers_of(scene, take),
        subframe=subframe,
    )
    return score, len(take.events) - len(heard)


def _placed(event: SoundEvent, clock: Clock, listener: Listener, spots: ContactSpots) -> ScoreEvent:
    """Return an event as it is heard: where it begins, or where what lasts comes nearest."""
    course = listener.course(event.track[0], event.places)
    begin = listener.bearing(event.frame, event.place)
    nearest = min((begin, *course), key=attrgetter("distance"))
    first, last = event.track
    return ScoreEvent(
        frame=event.frame,
        time=clock.time_of(event.step, event.fraction),
        cause=event.cause,
        who=event.who,
        # Within a performer its own name says nothing.
        part=event.part.removeprefix(f"{event.who}."),
        other=event.other,
        material=event.material,
        surface=event.surface,
        strength=event.strength,
        energy=event.energy,
        size=event.size,
        distance=nearest.distance,
        azimuth=nearest.azimuth,
        duration=float((last - first) / (clock.rate * clock.samples)),
        speeds=event.strengths,
        course=course,
        spot=spots.spot(event) if first == last else None,
    )
