"""Scene run: one run on one scene, with its outputs open and its errors and notes reported."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from audio.errors import AudioError
from pipeline.atomic_file import write_if_changed
from pipeline.errors import FilmingError, ScoringError, StoreError
from pipeline.production.run.file_records import FileRecords
from pipeline.production.run.manifest import Manifest, library_versions
from pipeline.production.run.notes import Note, NotesRefused, read_notes, refuse_notes
from pipeline.production.run.order import Order
from pipeline.production.run.outputs import Outputs, opened
from pipeline.production.run.progress import Reporter, Stage
from pipeline.simulation.take import Take
from render.errors import FrameFileError, RenderError


@dataclass(slots=True)
class SceneRun:
    """One run on one scene.

    Attributes:
        order: settings of the run.
        outputs: files of the scene.
        reporter: of progress.
        manifest: of the run before, with the entries of this one.
        records: of the files of the outputs, which the manifest lists.
        notes: on the scene, its take, its camera and the frames of the run.
        frames: of the run.
    """

    order: Order
    outputs: Outputs
    reporter: Reporter
    manifest: Manifest
    records: FileRecords
    notes: list[Note] = field(default_factory=list)
    frames: tuple[int, ...] = ()

    def record_time(self, stage: Stage) -> None:
        """Record the time of a stage that had something to do."""
        self.manifest.seconds[stage.name] = round(stage.seconds, 3)

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

    def describe(self, take: Take) -> None:
        """Enter the take, which is stored, into the manifest."""
        header = take.header
        self.manifest.entries |= {
            "scene": self.order.name,
            "title": header.title,
            "seed": header.seed,
            "rate": str(header.rate),
            "frames": header.frames,
            "versions": {**header.versions, **library_versions()},
            "digests": {"take": take.digest},
        }

    def finish(self) -> None:
        """Enter the notes of a run that has come to its end into the manifest."""
        notes = [note.facts for note in (*self.notes, *self.kept_notes())]
        self.manifest.entries["notes"] = notes
        self.records.forget_missing()

    def write(self, path: Path, data: bytes) -> Path:
        """Write a file of the outputs, record it and return its path."""
        write_if_changed(path, data)
        self.records.update(path)
        return path


@contextmanager
def working(order: Order, reporter: Reporter) -> Iterator[SceneRun]:
    """Open the outputs of `order`, translate errors inside the block and report its notes.

    Raises:
        PronkError: for any error inside.
    """
    outputs = Outputs(order.out / order.name, order.name)
    with opened(outputs):
        manifest = Manifest.read(outputs.manifest)
        manifest.files = records = FileRecords(outputs.folder, manifest.files)
        run = SceneRun(order, outputs, reporter, manifest, records)
        with write_errors(outputs), translated_errors(), _reported_notes(run), _saved(run):
            yield run


@contextmanager
def _saved(run: SceneRun) -> Iterator[None]:
    """Write the manifest at the end of a run if it has changed, also where the run fails.

    Files are then recorded that were written before it failed.
    """
    before = run.manifest.encoded()
    try:
        yield
    except BaseException as error:
        if isinstance(error, FrameFileError):
            # By size and time it is as it was, so the next run would fail likewise.
            run.records.distrust(error.path)
        # What failed is the message, even if the disk is full now.
        with suppress(OSError):
            _save(run, before)
        raise
    _save(run, before)


def _save(run: SceneRun, before: bytes) -> None:
    outputs, entries = run.outputs, run.manifest.entries
    if "digests" in entries:
        files = {"midi": outputs.midi, "wav": outputs.wav, "events": outputs.events}
        found = {name: run.records.of(path) for name, path in files.items()}
        digests = {name: record.digest for name, record in found.items() if record is not None}
        entries["digests"] |= digests
    data = run.manifest.encoded()
    if data != before:
        write_if_changed(outputs.manifest, data)


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
def write_errors(outputs: Outputs) -> Iterator[None]:
    """Translate what the system says when files cannot be written.

    Raises:
        StoreError: for an OSError inside.
    """
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise StoreError(f"{error.filename or outputs.folder}: {reason}") from error


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
