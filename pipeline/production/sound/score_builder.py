"""Score builder: take and camera -> events as the listener hears them, and markers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from math import inf
from operator import attrgetter
from pathlib import Path

from audio.music.scene_course import SceneCourse
from audio.music.song_file import Song, read_song
from audio.score import DanceBeat, Marker, Score, ScoreEvent
from pipeline.errors import Problem, SceneError
from pipeline.foreign_files.safe_file import ForeignFileError
from pipeline.production.camera.cuts import first_frames
from pipeline.production.sound.ambience_choice import ambience_of
from pipeline.production.sound.listener import Listener
from pipeline.production.sound.passing_touches import is_passing, touched_parts
from pipeline.production.sound.scene_course import scene_course
from pipeline.production.sound.struck_bodies import StruckBodies, hollow_walls
from pipeline.simulation.clock import Clock
from pipeline.simulation.take import NEVER_GIVEN, SoundEvent, Take
from pipeline.spec.dance import Dance
from pipeline.spec.dancer import Dancer
from pipeline.spec.scene import Scene
from pipeline.spec.sound_thresholds import NearCause
from render.config import Camera
from render.shot import CameraPose


def build_score(
    scene: Scene, take: Take, poses: Sequence[CameraPose], subframe: bool = False
) -> tuple[Score, int]:
    """Return the score of a take, and the number of events after its last frame.

    Args:
        scene: its sound and camera configuration is used.
        take: the recorded motion and sound events.
        poses: camera pose of each frame.
        subframe: place sounds at the exact times of their causes instead of on frames.

    Raises:
        SceneError: the song of the music cannot be read.
    """
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    listener = Listener(scene.sound.listener, scene.camera, clock, poses)
    bodies = StruckBodies(take, hollow_walls(scene.cast))
    audible = [event for event in take.events if event.frame <= header.frames]
    touched = touched_parts(scene)
    placed = (
        replace(_score_event(event, clock, listener, bodies), is_passing=is_passing(event, touched))
        for event in audible
    )
    score = Score(
        rate=header.rate,
        frames=header.frames,
        events=tuple(event for event in placed if event.distance <= _reach(scene, event.cause)),
        sound=scene.sound,
        seed=header.seed,
        title=scene.title,
        markers=film_markers(scene, take),
        subframe=subframe,
        dance=dance_beat(scene),
        ambience=ambience_of(scene),
        song=_song(scene),
        course=scene_course(take) if _is_generated(scene) else SceneCourse(),
    )
    return score, len(take.events) - len(audible)


def _reach(scene: Scene, cause: str) -> float:
    """Return the distance from the camera up to which a cause is heard [m]."""
    config = getattr(scene.sound.detect, cause, None)
    return config.within if isinstance(config, NearCause) else inf


def _is_generated(scene: Scene) -> bool:
    return scene.sound.music is not None and scene.sound.music.generate is not None


def _song(scene: Scene) -> Song | None:
    """Return the song that a scene names.

    Raises:
        SceneError: it cannot be read any more.
    """
    music = scene.sound.music
    if music is None or music.file is None:
        return None
    try:
        return read_song(Path(music.file))
    except ForeignFileError as error:
        problem = Problem("sound.music.file", f"{music.file} {error}")
        raise SceneError([scene.source_map.with_location(problem)]) from error


def dance_beat(scene: Scene) -> DanceBeat | None:
    """Return the beat of the dancers; None if none dances to beats, or each to its own."""
    beats = [
        DanceBeat(_tempo(member, dance), Fraction(str(member.start)), _meter(dance))
        for _, member in scene.dancers
        if (dance := scene.dances.get(member.dance)) is not None
        and (member.durations is None or member.tempo_bpm is not None)
    ]
    if not beats or (len({beat.tempo for beat in beats}) > 1 and scene.sound.tempo_bpm is None):
        return None
    return min(beats, key=lambda beat: beat.start)


def _tempo(member: Dancer, dance: Dance) -> Fraction:
    return Fraction(str(member.tempo_bpm or dance.tempo_bpm))


def _meter(dance: Dance) -> tuple[int, int]:
    """Return the meter of a dance: bars of three where four do not divide its beats, but three."""
    length = Fraction(str(dance.length))
    return next(((beats, 4) for beats in (4, 3, 2) if length % beats == 0), (4, 4))


def _score_event(
    event: SoundEvent, clock: Clock, listener: Listener, bodies: StruckBodies
) -> ScoreEvent:
    """Place an event at its start, or at the closest point of its path if it is sustained."""
    course = listener.course(event.track[0], event.places)
    start = listener.bearing(event.frame, event.place)
    nearest = min((start, *course), key=attrgetter("distance"))
    first, last = event.track
    body = bodies.body(event)
    return ScoreEvent(
        frame=event.frame,
        time=clock.time_of(event.step, event.fraction),
        cause=event.cause,
        who=event.who,
        # Tracks are named by performer, so the prefix is redundant.
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
        spot=body.spot if first == last else None,
        shape=body.shape,
        struck_shape=body.struck_shape,
    )


def film_markers(scene: Scene, take: Take) -> tuple[Marker, ...]:
    """Return the cuts and script instructions of a film by frame, cuts first."""
    markers = [*_cut_markers(scene, take), *_script_markers(take)]
    return tuple(sorted(markers, key=lambda marker: marker.frame))


def _cut_markers(scene: Scene, take: Take) -> Iterator[Marker]:
    """Yield the cuts after the first frame and before the end."""
    starts = first_frames(scene.camera, take.header.rate)
    for cut, frame, following in zip(scene.camera, starts, [*starts[1:], None], strict=True):
        # Of several cuts on one frame only the last is visible.
        if 1 < frame <= take.header.frames and frame != following:
            yield Marker(frame, "cut", _cut_description(cut))


def _cut_description(cut: Camera) -> str:
    """Return view and target of a cut, such as "side of bug"."""
    target = cut.follow if isinstance(cut.follow, str) else ", ".join(cut.follow or ("all",))
    if cut.parent is not None:
        return f"from {cut.parent}"
    if cut.is_animated:
        return "moving camera"
    if cut.at is not None:
        return "standing camera" if cut.look_at is not None else f"standing camera, {target}"
    if isinstance(cut.view, float | int):
        return f"{cut.view:g} degrees of {target}"
    return f"{cut.view or 'three-quarter'} of {target}"


def _script_markers(take: Take) -> Iterator[Marker]:
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    for order in take.orders:
        frame = clock.frame_of(order.step, 0.0)
        if frame <= header.frames and order.outcome != NEVER_GIVEN:
            yield Marker(frame, "script", f"{order.who}: {order.text}")
