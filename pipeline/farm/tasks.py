"""Tasks of a farm, and the runner that carries them out in a worker."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from pipeline.errors import FilmingError, PronkError, StoreError
from pipeline.farm.assembly import assemble
from pipeline.farm.film import Film, read_film, scene_of
from pipeline.farm.frame_index import MixedClasses
from pipeline.farm.frame_worker import ChunkCost, FrameWorker
from pipeline.farm.preparation import prepare
from pipeline.farm.segments import encode_segment
from pipeline.farm.store import Store
from pipeline.farm.stored_frames import FramesMissing
from pipeline.farm.take_object import TakeLost
from pipeline.production.run.notes import Note
from pipeline.production.run.order import Order
from pipeline.production.run.outputs import OutputsBusy
from pipeline.production.run.progress import Reporter, Stage
from pipeline.unexpected_error import told_error
from render.backend import Choice


@dataclass(frozen=True, slots=True)
class Nothing:
    """A task without work, by which the rate of tasks is measured."""


@dataclass(frozen=True, slots=True)
class Simulation:
    """The preparation of a film.

    Attributes:
        film: its key.
    """

    film: str


@dataclass(frozen=True, slots=True)
class Rendering:
    """Some frames of a film.

    Attributes:
        film: its key.
        frames: ascending.
    """

    film: str
    frames: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Encoding:
    """A segment of a film, of frames that are all in the store.

    Attributes:
        film: its key.
        frames: of the segment.
    """

    film: str
    frames: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Assembling:
    """A film of frames that are all in the store.

    Attributes:
        order: of the film.
        film: that it is made of.
    """

    order: Order
    film: Film


Task = Nothing | Simulation | Rendering | Encoding | Assembling

Fault = Literal["class", "store", "take", "frame", "missing", "busy", "film"]
"""Whom an error concerns: a class of renderers, the store, the take, a frame, frames that the store
does not have, outputs at which another run works, or the whole film."""


@dataclass(frozen=True, slots=True)
class TaskError:
    """The error of a task, as it passes between processes.

    Attributes:
        fault: whom it concerns.
        message: of the error.
        exit_code: of a command that ends with it.
        facts: for other programs.
    """

    fault: Fault
    message: str
    exit_code: int
    facts: dict[str, object]

    @property
    def told(self) -> PronkError:
        """The error to tell."""
        return RemoteError(self)


class RemoteError(PronkError):
    """An error of a task."""

    def __init__(self, error: TaskError) -> None:
        super().__init__(error.message)
        self.exit_code = error.exit_code  # type: ignore[misc] # that of the error it stands for
        self._facts = error.facts

    @property
    def facts(self) -> dict[str, object]:
        """Those of the error that it stands for."""
        return self._facts


@dataclass(frozen=True, slots=True)
class StageReport:
    """A stage of a task: name, number of things, seconds, result, and its unit."""

    name: str
    total: int
    seconds: float
    result: str
    unit: str


@dataclass(frozen=True, slots=True)
class TaskResult:
    """What became of a task.

    Attributes:
        error: None for a task that was carried out.
        cost: of its frames.
        notes: on the film.
        stages: that it went through.
        lines: notes of its run for people.
        place: folder of the outputs.
    """

    error: TaskError | None = None
    cost: ChunkCost = field(default_factory=ChunkCost)
    notes: tuple[Note, ...] = ()
    stages: tuple[StageReport, ...] = ()
    lines: tuple[tuple[str, bool], ...] = ()
    place: str = ""


@dataclass(frozen=True, slots=True)
class WorkerSettings:
    """All that a worker needs besides its tasks.

    Attributes:
        store: address of the store.
        backend: of the renderer.
        threads: of the renderer, None for all processors.
        mixed: whether classes of renderers may be mixed.
    """

    store: str
    backend: Choice = "auto"
    threads: int | None = None
    mixed: bool = False


class _Recorder(Reporter):
    """Keeps what is reported."""

    def __init__(self) -> None:
        self.stages: list[StageReport] = []
        self.lines: list[tuple[str, bool]] = []
        self.found: tuple[Note, ...] = ()

    def end(self, stage: Stage) -> None:
        self.stages.append(
            StageReport(stage.name, stage.total, stage.seconds, stage.result, stage.unit)
        )

    def note(self, text: str, detail: bool = False) -> None:
        self.lines.append((text, detail))

    def notes(self, scene: str, notes: Sequence[Note], manifest: Path | None) -> None:
        self.found = tuple(notes)


class TaskRunner:
    """Carries out tasks one after the other.

    Args:
        settings: of the worker.
    """

    def __init__(self, settings: WorkerSettings) -> None:
        self._settings = settings
        self._store: Store | None = None
        self._frames: FrameWorker | None = None

    def run(self, task: Task) -> TaskResult:
        """Return what became of a task; errors are results as well."""
        recorder = _Recorder()
        cost, place = ChunkCost(), ""
        error: TaskError | None = None
        try:
            match task:
                case Simulation():
                    film = read_film(self._opened(), task.film)
                    scene = scene_of(self._opened(), film)
                    prepared = prepare(self._opened(), film, scene, {}, recorder)
                    recorder.found = prepared.notes
                case Rendering():
                    film = read_film(self._opened(), task.film)
                    cost = self._worker().render(film, task.frames)
                case Encoding():
                    film = read_film(self._opened(), task.film)
                    encode_segment(self._opened(), film, task.frames, self._settings.mixed)
                case Assembling():
                    mixed = self._settings.mixed
                    outputs = assemble(task.order, self._opened(), task.film, recorder, mixed)
                    place = str(outputs.folder)
        except Exception as found:
            error = task_error(found, task)
        return TaskResult(
            error, cost, recorder.found, tuple(recorder.stages), tuple(recorder.lines), place
        )

    def _opened(self) -> Store:
        if self._store is None:
            self._store = Store(self._settings.store)
        return self._store

    def _worker(self) -> FrameWorker:
        if self._frames is None:
            settings = self._settings
            self._frames = FrameWorker(
                self._opened(), settings.backend, settings.threads, settings.mixed
            )
        return self._frames


def task_error(error: Exception, task: Task) -> TaskError:
    """Return the error of a task and whom it concerns."""
    told = told_error(error)
    fault: Fault
    match told:
        case MixedClasses():
            fault = "class" if isinstance(task, Rendering) else "film"
        case FramesMissing():
            fault = "missing"
        case OutputsBusy():
            fault = "busy"
        case TakeLost():
            fault = "take"
        case StoreError():
            fault = "store"
        case FilmingError():
            fault = "frame" if isinstance(task, Rendering) else "film"
        case _:
            # Whatever a library raises while it renders may be the fault of one frame.
            is_frame = isinstance(task, Rendering) and not isinstance(error, PronkError)
            fault = "frame" if is_frame else "film"
    return TaskError(fault, str(told), told.exit_code, told.facts)
