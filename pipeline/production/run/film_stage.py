"""Film stage: frames and their sound as a film."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pipeline.production.run.film_source import FilmSource
from pipeline.production.run.frame_ranges import contiguous, counted, described
from pipeline.production.run.progress import Stage, stage
from pipeline.production.run.scene_run import SceneRun
from render.film_encoder import Picture, write_film


def make_film(run: SceneRun, frames: tuple[int, ...]) -> None:
    """Encode the frames, which are recorded, and their sound into a film."""
    order, outputs = run.order, run.outputs
    film = order.scene.film.resolved()
    whole = len(frames) == order.scene.n_frames
    place = run.whole_film if whole else outputs.film(described(frames), film.suffix)
    has_sound = order.sound and contiguous(frames)
    if order.sound and not has_sound:
        run.reporter.note("film: frames with gaps between them have no sound")
    rate = order.scene.rate
    source = FilmSource(frames, rate, film.format, film.exposure, has_sound, film.codec)
    key = source.key(outputs, run.records)
    with stage(run.reporter, "film", len(frames), "frames") as current:
        if run.records.is_intact(place, key):
            current.result = f"{place.name} is up to date"
            return
        sound = outputs.wav if has_sound else None
        pictures = _reported(source.pictures(outputs), current)
        write_film(place, pictures, rate, sound, source.sound_from, key, film.codec)
        _record(run, place, key, source)
        run.record_time(current)
        current.result = f"{place.name}, {counted(len(frames))}" + (", with sound" if sound else "")


def _reported(pictures: Iterator[Picture], current: Stage) -> Iterator[Picture]:
    """Yield pictures and report each."""
    for done, picture in enumerate(pictures):
        current.advance(done)
        yield picture


def _record(run: SceneRun, place: Path, key: str, source: FilmSource) -> None:
    run.records.add(place, key)
    films = run.manifest.entries.get("films")
    known = films if isinstance(films, dict) else {}
    there = {name: facts for name, facts in known.items() if name in run.records}
    run.manifest.entries["films"] = {**there, place.name: source.facts}
