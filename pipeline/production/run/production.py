"""Production: one scene to its take, score, frames and film, doing only what is due."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from audio.errors import AudioError
from audio.midi_file import write_midi
from audio.score import Score
from audio.wav_file import write_wav
from pipeline.atomic_file import PARTIAL, replace_folder, write_if_changed
from pipeline.errors import FilmingError, ScoringError, StoreError
from pipeline.production.run.compile_progress import compile_progress
from pipeline.production.run.encoder_check import require_encoders
from pipeline.production.run.film_end import notes_after_end
from pipeline.production.run.frame_ranges import contiguous, counted, described, parse_frames
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.notes import (
    Note,
    NotesRefused,
    clock_of,
    read_notes,
    refuse_notes,
    take_notes,
)
from pipeline.production.run.order import Order
from pipeline.production.run.outputs import Manifest, Outputs, library_versions, opened
from pipeline.production.run.picture_notes import camera_notes, level_notes
from pipeline.production.run.progress import Reporter, Stage, stage
from pipeline.production.run.workers import FrameBatch, film_in_processes, with_gpu_fallback
from pipeline.production.shots.frame_rendering import (
    frame_levels,
    outdated_frames,
    render_frames,
)
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.sound.cue_files import write_cues
from pipeline.production.sound.event_files import write_events
from pipeline.production.sound.score_builder import build_score
from pipeline.production.sound.sound_report import (
    loudness_summary,
    midi_facts,
    quantisation_summary,
    wav_facts,
)
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.simulation.take_store import read_key, read_take, write_take
from pipeline.simulation.versions import versions
from pipeline.spec import Scene, simulation_key
from render.backend import Backend
from render.color import developed, developed16
from render.errors import RenderError
from render.film_codecs import CODECS
from render.film_encoder import Picture, write_film
from render.film_file import film_key
from render.image_files import read_exr, read_png
from render.renderer import Renderer, Timings


@dataclass(slots=True)
class Production:
    """One run on one scene.

    Attributes:
        order: settings of the run.
        outputs: files of the scene.
        reporter: of progress.
        manifest: of the run before, with the entries of this one.
        notes: on the scene, its take, its camera and the frames of the run.
        frames: of the run.
        seconds: time of each stage that had something to do.
        changed: whether any output changed.
    """

    order: Order
    outputs: Outputs
    reporter: Reporter
    manifest: Manifest
    notes: list[Note] = field(default_factory=list)
    frames: tuple[int, ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)
    changed: bool = False

    def record_time(self, stage: Stage) -> None:
        """Record the time of a stage that had something to do."""
        self.seconds[stage.name] = round(stage.seconds, 3)
        self.changed = True

    def kept_notes(self) -> list[Note]:
        """Return the notes that earlier runs had on pictures which this one leaves alone."""
        again = {None, *self.frames}
        last = self.order.scene.n_frames
        return [
            note
            for note in read_notes(self.manifest.entries.get("notes"))
            if note.source == "picture" and note.frame not in again and (note.frame or 0) <= last
        ]

    def refuse_notes(self) -> None:
        """Refuse to go on if there are notes and the order is strict.

        Raises:
            NotesRefused: there are some.
        """
        if self.order.strict:
            refuse_notes(self.notes)


def render(order: Order, reporter: Reporter) -> Outputs:
    """Make the film of a scene, its score and the files beside them.

    Raises:
        PronkError: something cannot be made; earlier outputs stay.
    """
    frames = parse_frames(order.frames, order.scene.n_frames)
    require_encoders(order.scene)
    with working(order, reporter) as run:
        run.frames = frames
        shooting = shooting_of(run)
        take = shooting.take
        if order.sound:
            write_score(run, take, shooting)
        keys = _frames(run, shooting, frames)
        note_levels(run, shooting, frames)
        run.refuse_notes()
        _film(run, frames, keys)
        _finish(run, take)
        return run.outputs


def simulate_only(order: Order, reporter: Reporter) -> tuple[Outputs, Take]:
    """Simulate a scene and store its take and events."""
    with working(order, reporter) as run:
        take = take_of(run)
        write_events(run.outputs, take)
        _finish(run, take)
        return run.outputs, take


def store_only(order: Order, take: Take, reporter: Reporter) -> Outputs:
    """Store a take that was made elsewhere, and its events."""
    with working(order, reporter) as run:
        run.notes = [*notes_after_end(order.scene), *take_notes(take, clock_of(order.scene))]
        _store_take(run, take)
        write_events(run.outputs, take)
        _finish(run, take)
        return run.outputs


def score_only(order: Order, reporter: Reporter) -> Outputs:
    """Write the score of a scene, simulating if necessary."""
    with working(order, reporter) as run:
        shooting = shooting_of(run)
        write_score(run, shooting.take, shooting)
        _finish(run, shooting.take)
        return run.outputs


@contextmanager
def working(order: Order, reporter: Reporter) -> Iterator[Production]:
    """Open the outputs of `order`, translate errors inside the block and report its notes.

    Raises:
        PronkError: for any error inside.
    """
    outputs = Outputs(order.out / order.name, order.name)
    with opened(outputs):
        run = Production(order, outputs, reporter, Manifest.read(outputs.manifest))
        try:
            with translated_errors(), _reported_notes(run):
                yield run
        except OSError as error:
            reason = error.strerror or str(error)
            raise StoreError(f"{error.filename or outputs.folder}: {reason}") from error


@contextmanager
def _reported_notes(run: Production) -> Iterator[None]:
    """Report the notes of a run at its end, also where it fails: they may tell why."""
    try:
        yield
    except NotesRefused:
        # They are its message.
        raise
    except Exception:
        _report_notes(run)
        raise
    _report_notes(run)


def _report_notes(run: Production) -> None:
    if run.notes:
        manifest = run.outputs.manifest
        run.reporter.notes(run.order.name, run.notes, manifest if manifest.is_file() else None)


@contextmanager
def translated_errors() -> Iterator[None]:
    """Translate errors of `render` and `audio` into those of the pipeline.

    Raises:
        FilmingError, ScoringError: for a RenderError or an AudioError inside.
    """
    try:
        yield
    except RenderError as error:
        raise FilmingError(str(error)) from error
    except AudioError as error:
        raise ScoringError(str(error)) from error


# --- simulate ---------------------------------------------------------------------


def take_key(scene: Scene) -> str:
    """Return the key of a scene's take: a digest of the simulated settings and the versions."""
    text = f"{simulation_key(scene)}|{sorted(versions().items())}"
    return hashlib.blake2b(text.encode(), digest_size=20).hexdigest()


def take_of(run: Production) -> Take:
    """Return the take of the scene, simulating only if the stored one does not fit.

    Raises:
        NotesRefused: there are notes and the order is strict; a new take is not stored.
        SimulationError: the scene cannot be simulated.
    """
    scene = run.order.scene
    clock = clock_of(scene)
    key = take_key(scene)
    run.notes = notes_after_end(scene)
    with stage(run.reporter, "simulate", scene.n_frames, "s", float(1 / scene.rate)) as current:
        stored = _stored_take(run, key)
        if stored is not None:
            current.keep(scene.n_frames)
            current.result = "take is up to date"
            run.notes += take_notes(stored, clock)
            run.refuse_notes()
            return stored
        with compile_progress(run.reporter, current) as compiling:

            def progress(done: int, _: int) -> None:
                compiling.close()
                current.advance(done)

            take = simulate(scene, key, progress)
        current.done = scene.n_frames
        current.result = (
            f"{counted(scene.n_frames)}, playing for {float(scene.n_frames / scene.rate):.1f} s"
        )
        run.notes += take_notes(take, clock)
        run.refuse_notes()
        run.record_time(current)
        _store_take(run, take)
    return take


def shooting_of(run: Production) -> ShotBuilder:
    """Return the shots of the scene's take, with notes on what its cameras do not show.

    Raises:
        NotesRefused: there are notes and the order is strict.
        SimulationError: the scene cannot be simulated.
    """
    shooting = ShotBuilder(run.order.scene, take_of(run))
    run.notes += camera_notes(run.order.scene, shooting)
    run.refuse_notes()
    return shooting


def note_levels(run: Production, shooting: ShotBuilder, frames: Sequence[int]) -> None:
    """Note which of the frames, all of them written, are black or blown out."""
    levels = frame_levels(shooting, run.outputs, frames)
    run.notes += level_notes(run.order.scene, frames, levels)


def _store_take(run: Production, take: Take) -> None:
    place = run.outputs.take
    new = place.with_name(f".{place.name}{PARTIAL}")
    write_take(take, new)
    replace_folder(new, place)
    run.changed = True


def _stored_take(run: Production, key: str) -> Take | None:
    """Return the take that an earlier run stored under `key`, None if there is none."""
    place = run.outputs.take
    try:
        return read_take(place) if read_key(place) == key else None
    except StoreError as error:
        run.reporter.note(f"{error}; it is made again")
    except Exception as error:
        # A damaged file can raise anything, and a take can be made again.
        run.reporter.note(f"{place}: is no take that can be read ({error}); it is made again")
    return None


# --- score ------------------------------------------------------------------------


def write_score(run: Production, take: Take, shooting: ShotBuilder) -> Score:
    """Write MIDI, WAV, events, edit list and labels, inside `working`."""
    with stage(run.reporter, "score", 3, "files") as current:
        score, late = build_score(run.order.scene, take, shooting.poses, run.order.subframe)
        changed = write_events(run.outputs, take) | write_cues(
            run.outputs, score, _whole_film(run).name
        )
        current.advance(1)
        midi = write_midi(score, run.outputs.midi)
        current.advance(2)
        wav = write_wav(score, run.outputs.wav)
        if changed or midi.changed or wav.changed:
            run.record_time(current)
        current.result = f"{len(score.events)} events, {loudness_summary(wav)}" + (
            f", {late} after the last frame" if late else ""
        )
    if not run.outputs.edit_list.exists():
        run.reporter.note(
            f"score: {score.rate} frames a second have no timecode, or the film lasts longer than "
            "a day; no edit list is written"
        )
    moved = quantisation_summary(midi.shifts, score)
    if moved is not None:
        run.reporter.note(moved)
    run.manifest.entries["events"] = {"written": len(score.events), "after_the_last_frame": late}
    run.manifest.entries["midi"] = midi_facts(midi, score.subframe, score.rate)
    run.manifest.entries["wav"] = wav_facts(wav)
    return score


# --- frames -----------------------------------------------------------------------


def _frames(run: Production, shooting: ShotBuilder, frames: tuple[int, ...]) -> dict[int, str]:
    """Render the frames that are due and return the keys of all."""
    with stage(run.reporter, "render", len(frames), "frames") as current:
        return with_gpu_fallback(
            run.order.backend,
            run.reporter,
            lambda backend: _rendered_on(backend, run, shooting, frames, current),
        )


def _rendered_on(
    backend: Backend,
    run: Production,
    shooting: ShotBuilder,
    frames: tuple[int, ...],
    current: Stage,
) -> dict[int, str]:
    """Render the frames that are due on one backend and return the keys of all."""
    order, outputs = run.order, run.outputs
    for line in backend.describe():
        run.reporter.note(line, detail=True)
    with held_back():
        renderer = Renderer(backend)
    keys, missing = outdated_frames(shooting, outputs, frames, renderer.key_extra)
    kept = len(frames) - len(missing)
    run.manifest.entries["renderer"] = renderer.key_extra
    current.keep(kept)
    if not missing:
        current.result = "frames are up to date"
        return keys
    wanted = {frame: keys[frame] for frame in missing}
    jobs = min(order.jobs, len(missing))
    if jobs > 1:
        batch = FrameBatch(order.scene, outputs.take, outputs, backend, wanted)
        split = film_in_processes(
            batch, jobs, lambda done, pace: current.advance_together(kept + done, pace)
        )
    else:
        for done, _ in enumerate(render_frames(renderer, shooting, outputs, wanted), start=1):
            current.advance(kept + done)
        split = renderer.timings
    run.record_time(current)
    current.result = _render_summary(split, current.seconds * jobs, kept)
    return keys


def _render_summary(split: Timings, seconds: float, kept: int) -> str:
    inside = split.build + split.update + split.trace + split.denoise
    return (
        f"{counted(split.frames)}, {seconds / split.frames:.2f} s each, "
        f"{100 * inside / seconds:.0f}% in Mitsuba and the denoiser "
        f"(trace {split.trace:.1f} s, denoise {split.denoise:.1f} s, build {split.build:.1f} s)"
    ) + (f", {kept} kept" if kept else "")


# --- film -------------------------------------------------------------------------


def _film(run: Production, frames: tuple[int, ...], keys: dict[int, str]) -> None:
    """Encode the frames and their sound into a film."""
    order, outputs = run.order, run.outputs
    whole = len(frames) == order.scene.n_frames
    film = order.scene.film.resolved()
    place = _whole_film(run) if whole else outputs.film(described(frames), film.suffix)
    sound = outputs.wav if order.sound and contiguous(frames) else None
    if order.sound and sound is None:
        run.reporter.note("film: frames with gaps between them have no sound")
    key = _film_key(run, [keys[frame] for frame in frames], sound, frames[0])
    with stage(run.reporter, "film", len(frames), "frames") as current:
        if film_key(place) == key:
            current.result = f"{place.name} is up to date"
            return
        rate = order.scene.rate
        began_at = (frames[0] - 1) / rate
        pictures = _pictures(run, frames, current)
        write_film(place, pictures, rate, sound, began_at, key, film.codec)
        run.record_time(current)
        current.result = f"{place.name}, {counted(len(frames))}" + (", with sound" if sound else "")


def _whole_film(run: Production) -> Path:
    return run.outputs.film(suffix=run.order.scene.film.resolved().suffix)


def _pictures(run: Production, frames: tuple[int, ...], current: Stage) -> Iterator[Picture]:
    """Yield the pictures of `frames` at the bit depth of the film's codec, and report each."""
    film = run.order.scene.film.resolved()
    deep = CODECS[film.codec].bits == 16
    for done, frame in enumerate(frames):
        current.advance(done)
        path = run.outputs.frame(frame, film.format)
        if film.format == "png":
            picture = read_png(path)
            # 257 = 65535 / 255, so that white stays white.
            yield picture.astype(np.uint16) * 257 if deep else picture
        else:
            light = read_exr(path)
            develop = developed16 if deep else developed
            yield develop(light, film.exposure)


def _film_key(run: Production, keys: list[str], sound: Path | None, first: int) -> str:
    state = hashlib.blake2b(digest_size=20)
    # An MP4 file holds one of several codecs.
    codec = repr(CODECS[run.order.scene.film.resolved().codec])
    state.update("\n".join([codec, str(run.order.scene.rate), str(first), *keys]).encode())
    if sound is not None:
        state.update(sound.read_bytes())
    return state.hexdigest()


# --- manifest ---------------------------------------------------------------------


def _finish(run: Production, take: Take) -> None:
    """Write the manifest if anything has changed."""
    outputs, header = run.outputs, take.header
    digests = {"take": take.digest}
    files = {"midi": outputs.midi, "wav": outputs.wav, "events": outputs.events}
    for name, path in files.items():
        if path.is_file():
            digests[name] = hashlib.blake2b(path.read_bytes(), digest_size=20).hexdigest()
    entries: dict[str, Any] = {
        **run.manifest.entries,
        "scene": run.order.name,
        "title": header.title,
        "seed": header.seed,
        "rate": str(header.rate),
        "frames": header.frames,
        "versions": {**header.versions, **library_versions()},
        "digests": digests,
        "notes": [note.facts for note in (*run.notes, *run.kept_notes())],
    }
    seconds = {**run.manifest.seconds, **run.seconds}
    if run.changed or entries != run.manifest.entries:
        write_if_changed(outputs.manifest, Manifest(entries, seconds).encoded())
