"""Film stage: frames and their sound as a film."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from pipeline.production.run.film_source import FilmSource
from pipeline.production.run.frame_ranges import contiguous, counted, described
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.progress import Stage, stage
from pipeline.production.run.scene_run import SceneRun
from render.film_encoder import Segment, join_film
from render.film_segments import Picture

EncodedSegment = Callable[[FilmSource], Path | None]
"""Returns the file of a segment, None if there is none; it is used before the next is asked for."""


def make_film(
    run: SceneRun, frames: tuple[int, ...], encoded: EncodedSegment = lambda segment: None
) -> None:
    """Encode the frames, which are recorded, and their sound into a film.

    Args:
        run: with the outputs.
        frames: of the film.
        encoded: of the segments; those that it does not have are encoded.
    """
    order, outputs = run.order, run.outputs
    film = order.scene.film.resolved()
    whole = len(frames) == order.scene.n_frames
    place = run.whole_film if whole else outputs.film(described(frames), film.suffix)
    has_sound = order.sound and contiguous(frames)
    if order.sound and not has_sound:
        run.reporter.note("film: frames with gaps between them have no sound")
    source = FilmSource.of(order.scene, frames, has_sound)
    key = source.key(outputs, run.records)
    with stage(run.reporter, "film", len(frames), "frames") as current:
        if run.records.is_intact(place, key):
            current.result = f"{place.name} is up to date"
            return
        sound = outputs.wav if has_sound else None
        segments = _segments(source, outputs, encoded, current)
        join_film(place, segments, source.rate, sound, source.sound_from, key, film.codec)
        _record(run, place, key, source)
        run.record_time(current)
        current.result = f"{place.name}, {counted(len(frames))}" + (", with sound" if sound else "")


def _segments(
    source: FilmSource, outputs: Outputs, encoded: EncodedSegment, current: Stage
) -> Iterator[Segment]:
    """Yield the segments of a film, as files or pictures, and report them."""
    done = 0
    for frames in source.segments:
        segment = replace(source, frames=frames)
        yield encoded(segment) or _reported(segment.pictures(outputs), current, done)
        done += len(frames)
        current.advance(done)


def _reported(pictures: Iterator[Picture], current: Stage, before: int) -> Iterator[Picture]:
    """Yield pictures and report each, after those before."""
    for done, picture in enumerate(pictures, before):
        current.advance(done)
        yield picture


def _record(run: SceneRun, place: Path, key: str, source: FilmSource) -> None:
    run.records.add(place, key)
    films = run.manifest.entries.get("films")
    known = films if isinstance(films, dict) else {}
    there = {name: facts for name, facts in known.items() if name in run.records}
    run.manifest.entries["films"] = {**there, place.name: source.facts}
