"""Scene run: one run on one scene, with its outputs open and its errors and notes reported."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from audio.errors import AudioError
from pipeline.atomic_file import write_if_changed
from pipeline.errors import FilmingError, ScoringError, StoreError
from pipeline.production.run.manifest import Manifest, library_versions
from pipeline.production.run.notes import Note, NotesRefused, read_notes, refuse_notes
from pipeline.production.run.order import Order
from pipeline.production.run.outputs import Outputs, opened
from pipeline.production.run.progress import Reporter, Stage
from pipeline.simulation.take import Take
from render.errors import RenderError


@dataclass(slots=True)
class SceneRun:
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

    @property
    def whole_film(self) -> Path:
        """The film of all frames."""
        return self.outputs.film(suffix=self.order.scene.film.resolved().suffix)

    def finish(self, take: Take) -> None:
        """Write the manifest if anything has changed."""
        outputs, header = self.outputs, take.header
        digests = {"take": take.digest}
        files = {"midi": outputs.midi, "wav": outputs.wav, "events": outputs.events}
        for name, path in files.items():
            if path.is_file():
                digests[name] = hashlib.blake2b(path.read_bytes(), digest_size=20).hexdigest()
        entries: dict[str, Any] = {
            **self.manifest.entries,
            "scene": self.order.name,
            "title": header.title,
            "seed": header.seed,
            "rate": str(header.rate),
            "frames": header.frames,
            "versions": {**header.versions, **library_versions()},
            "digests": digests,
            "notes": [note.facts for note in (*self.notes, *self.kept_notes())],
        }
        seconds = {**self.manifest.seconds, **self.seconds}
        if self.changed or entries != self.manifest.entries:
            write_if_changed(outputs.manifest, Manifest(entries, seconds).encoded())


@contextmanager
def working(order: Order, reporter: Reporter) -> Iterator[SceneRun]:
    """Open the outputs of `order`, translate errors inside the block and report its notes.

    Raises:
        PronkError: for any error inside.
    """
    outputs = Outputs(order.out / order.name, order.name)
    with opened(outputs):
        run = SceneRun(order, outputs, reporter, Manifest.read(outputs.manifest))
        try:
            with translated_errors(), _reported_notes(run):
                yield run
        except OSError as error:
            reason = error.strerror or str(error)
            raise StoreError(f"{error.filename or outputs.folder}: {reason}") from error


@contextmanager
def _reported_notes(run: SceneRun) -> Iterator[None]:
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


def _report_notes(run: SceneRun) -> None:
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
