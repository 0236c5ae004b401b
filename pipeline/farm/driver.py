"""Driver: films of many scenes as tasks with dependencies, on the workers of an engine.

The store is the truth: the driver keeps nothing that it could not read there again, so one that
was stopped or killed goes on when it is started again, and two that make one film do no harm.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from fileseq import FrameSet

from pipeline.errors import FilmingError, PronkError
from pipeline.farm.assignment import Given, frames_of, late_copy, next_task
from pipeline.farm.engine import Ended, Engine
from pipeline.farm.film import film_of, store_film
from pipeline.farm.film_run import MAX_REPAIRS, MAX_STORE_ERRORS, FilmRun
from pipeline.farm.frame_index import FrameIndex
from pipeline.farm.preparation import is_prepared, stored_notes
from pipeline.farm.segments import due_segments
from pipeline.farm.store import Store
from pipeline.farm.tasks import (
    Assembling,
    Encoding,
    Rendering,
    Simulation,
    TaskError,
    TaskResult,
)
from pipeline.production.run.batch import shortened
from pipeline.production.run.encoder_check import require_encoders
from pipeline.production.run.frame_ranges import counted, parse_frames
from pipeline.production.run.interrupts import INTERRUPTED, is_interrupt
from pipeline.production.run.notes import refuse_notes
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter, SceneRow
from pipeline.spec import find_scene
from pipeline.unexpected_error import told_error

POLL = 0.1
"""Longest time that the driver waits for the end of a task [s]."""

MAX_OPEN, OPEN_PER_WORKER = 8, 2
"""Films that are under way at once, and how many more for each worker."""

BUSY_PAUSE = 1.0
"""Time after which outputs at which another run works are tried again [s]."""

ReportError = Callable[[PronkError, str, Path | None], None]


class Driver:
    """Makes films side by side.

    Args:
        scenes: files or names.
        order_of: returns the order of a scene.
        store: of the farm.
        engine: that simulates and renders.
        assembler: that makes films of frames, on the machine that has the outputs.
        reporter: of the progress.
        report_error: called with each error as it happens.
        strict: whether notes are an error, before any frame is rendered.
    """

    def __init__(
        self,
        scenes: Sequence[str],
        order_of: Callable[[str], Order],
        store: Store,
        engine: Engine,
        assembler: Engine,
        reporter: Reporter,
        report_error: ReportError,
        strict: bool = False,
    ) -> None:
        self._strict = strict
        self._order_of, self._store = order_of, store
        self._engine, self._assembler = engine, assembler
        self._reporter, self._report_error = reporter, report_error
        self.rows = [SceneRow(scene) for scene in scenes]
        self._unopened = list(range(len(scenes)))
        self._runs: list[FilmRun] = []
        self._given: dict[str, Given] = {}
        self._assembled: dict[str, Given] = {}
        self._last: dict[str, str] = {}
        self._later = 0.0

    def run(self) -> int:
        """Make all films and return the worst exit code, which is the highest.

        Of several scenes a table is reported at the end, also when the user interrupts.
        """
        try:
            self._store.remove_stale()
            while self._unopened or self._runs:
                self._assign()
                self._assign_assembly()
                for ended in self._engine.wait(POLL if self._given else 0.0):
                    self._guarded(ended, self._given)
                for ended in self._assembler.wait(0.0 if self._given else POLL):
                    self._guarded(ended, self._assembled)
                self._runs = [run for run in self._runs if run.state != "ended"]
        finally:
            self._close()
            worst = max((row.exit_code or 0 for row in self.rows), default=0)
            if len(self.rows) > 1:
                self._reporter.table(self.rows, worst)
        return worst

    def _close(self) -> None:
        """End workers, stages and rows, whatever happened."""
        for run in self._runs:
            run.end_stage("")
            run.row.seconds = time.monotonic() - run.began
        self._engine.close()
        self._assembler.close()

    # --- what is due ------------------------------------------------------------------

    def _assign(self) -> None:
        """Give every idle worker a task, as long as there are any."""
        for worker in list(self._engine.idle):
            given = self._next_task(worker)
            while given is None and self._unopened and len(self._runs) < self._most_open:
                self._open(self._unopened.pop(0))
                given = self._next_task(worker)
            if given is None:
                given = late_copy(worker, self._given.values())
                if given is None:
                    continue
                self._reporter.note(
                    f"{given.run.row.scene}: frames {FrameSet(frames_of(given.task))} are late; "
                    f"{worker} renders them as well",
                    detail=True,
                )
            self._given[worker] = given
            match given.task:
                case Encoding():
                    given.run.encoding[worker] = given.task.frames
                case Rendering() if not given.is_copy:
                    given.run.running[worker] = given.task.frames
            if not isinstance(given.task, Encoding):
                self._last[worker] = given.run.film.key
            self._engine.start(worker, given.task)

    def _next_task(self, worker: str) -> Given | None:
        return next_task(worker, self._runs, len(self._engine.workers), self._last.get(worker))

    @property
    def _most_open(self) -> int:
        """Films that are under way at once: more would only take memory."""
        return MAX_OPEN + OPEN_PER_WORKER * len(self._engine.workers)

    def _assign_assembly(self) -> None:
        """Have the next finished film assembled."""
        if time.monotonic() < self._later:
            return
        for worker in self._assembler.idle:
            for run in self._runs:
                if run.state == "assembling" and run.waiting:
                    run.waiting = False
                    try:
                        task = Assembling(self._order_of(run.row.scene), run.film)
                    except Exception as error:
                        self._fail(run, error)
                        continue
                    self._assembled[worker] = Given(run, task)
                    self._assembler.start(worker, task)
                    break

    # --- films ------------------------------------------------------------------------

    def _open(self, number: int) -> None:
        """Begin with a scene."""
        row = self.rows[number]
        row.state, row.exit_code = "stopped", INTERRUPTED
        began = time.monotonic()
        try:
            order = self._order_of(row.scene)
            frames = parse_frames(order.frames, order.scene.n_frames)
            require_encoders(order.scene)
            film, files = film_of(order.scene, order.name)
            run = FilmRun(number, row, film, frames, began=began)
            self._runs.append(run)
            store_film(self._store, film, files)
            scale = float(1 / film.rate)
            stage = run.begin_stage(self._reporter, "simulate", film.frames, "s", scale)
            row.stage = stage
            if is_prepared(self._store, film):
                stage.keep(film.frames)
                self._begin_frames(run, "take is in the store")
        except Exception as error:
            if is_interrupt(error):
                raise
            begun = next((run for run in self._runs if run.number == number), None)
            if begun is not None:
                self._fail(begun, error)
            else:
                self._tell(row, error)
                row.seconds = time.monotonic() - began

    def _begin_frames(self, run: FilmRun, result: str) -> None:
        """Go on with the frames of a film whose take is in the store."""
        if self._strict:
            refuse_notes(stored_notes(self._store, run.film))
        run.end_stage(result)
        index = FrameIndex(self._store, run.film)
        run.done = set(index.done()) & set(run.frames)
        # They are tried again.
        index.forget_failures(index.failures())
        run.state, run.waiting = "rendering", False
        run.pending = [frame for frame in run.frames if frame not in run.done]
        run.segments = due_segments(self._store, run.film, run.frames)
        run.row.stage = run.begin_stage(self._reporter, "render", len(run.frames), "frames")
        run.row.stage.keep(len(run.done))
        self._end_frames(run)

    def _end_frames(self, run: FilmRun) -> None:
        """Go on with a film if all its frames are done, and its segments encoded."""
        if run.state != "rendering" or not run.is_rendered:
            return
        there = FrameIndex(self._store, run.film).done()
        missing = [f for f in run.frames if f not in there and f not in run.given_up]
        if missing:
            run.done &= there.keys()
            run.pending = missing
            return
        if run.given_up:
            numbers = sorted(run.given_up)
            verb = "frame was" if len(numbers) == 1 else "frames were"
            reason = run.given_up[numbers[0]]
            text = f"{len(numbers)} {verb} given up: {FrameSet(numbers)}; {reason}"
            self._fail(run, FilmingError(text))
            return
        if not run.is_encoded:
            return
        stage = run.row.stage
        rendered = len(run.frames) - (stage.kept if stage else 0)
        run.end_stage(f"{counted(rendered)} rendered" if rendered else "frames are in the store")
        run.state, run.waiting = "assembling", True

    def _finish(self, run: FilmRun, result: TaskResult) -> None:
        """End a film that is assembled."""
        for report in result.stages:
            if report.name != "render":
                stage = run.begin_stage(self._reporter, report.name, report.total, report.unit)
                stage.started -= report.seconds
                stage.done = report.total
                run.end_stage(report.result)
        for text, detail in result.lines:
            self._reporter.note(f"{run.row.scene}: {text}", detail)
        if result.notes:
            run.row.notes = len(result.notes)
            manifest = Path(result.place, "manifest.json") if result.place else None
            self._reporter.notes(run.row.scene, result.notes, manifest)
        if result.error is not None:
            self._fail(run, result.error.told)
            return
        run.state = "ended"
        run.row.state, run.row.exit_code = "done", 0
        run.row.seconds = time.monotonic() - run.began
        self._reporter.result(
            result.place, **({"scene": run.row.scene} if self._are_several else {})
        )

    @property
    def _are_several(self) -> bool:
        return len(self.rows) > 1

    def _fail(self, run: FilmRun, error: Exception) -> None:
        """End a film that cannot be made; the others go on."""
        if is_interrupt(error):
            raise error
        run.end_stage("")
        run.state = "ended"
        run.row.seconds = time.monotonic() - run.began
        self._tell(run.row, error)

    def _tell(self, row: SceneRow, error: Exception) -> None:
        told = told_error(error)
        row.state, row.exit_code = "failed", told.exit_code
        row.error = shortened(str(told).splitlines()[0])
        try:
            file: Path | None = find_scene(row.scene)
        except PronkError:
            file = None
        self._report_error(told, row.scene, file)

    # --- ends of tasks ----------------------------------------------------------------

    def _guarded(self, ended: Ended, tasks: dict[str, Given]) -> None:
        """Go on after the end of one of some tasks; an error concerns its film alone."""
        given = tasks.pop(ended.worker, None)
        if given is None:
            return
        try:
            self._on_end(ended, given)
        except Exception as error:
            self._fail(given.run, error)

    def _on_end(self, ended: Ended, given: Given) -> None:
        run = given.run
        run.encoding.pop(ended.worker, None)
        if not given.is_copy:
            run.running.pop(ended.worker, None)
        if run.state == "ended":
            return
        if ended.result is None:
            self._on_death(ended, given)
        elif ended.result.error is not None:
            self._on_error(ended.worker, given, ended.result, ended.result.error)
        else:
            self._on_success(given, ended.result)
        if isinstance(given.task, Rendering | Encoding):
            self._end_frames(run)

    def _on_success(self, given: Given, result: TaskResult) -> None:
        run = given.run
        run.store_errors = 0
        match given.task:
            case Simulation():
                self._begin_frames(run, "take is stored")
            case Rendering():
                run.costs.add(result.cost)
                run.done.update(given.task.frames)
                self._end_others(given)
                run.progress()
            case Assembling():
                self._finish(run, result)

    def _end_others(self, given: Given) -> None:
        """End the other copy of a task that is done."""
        for worker, other in list(self._given.items()):
            if other.run is given.run and other.task == given.task:
                del self._given[worker]
                given.run.running.pop(worker, None)
                self._engine.discard(worker)

    def _on_error(self, worker: str, given: Given, result: TaskResult, error: TaskError) -> None:
        run, frames = given.run, frames_of(given.task)
        if isinstance(given.task, Encoding):
            self._on_encoding_error(run, given.task, error)
        elif error.fault == "busy":
            run.waiting, self._later = True, time.monotonic() + BUSY_PAUSE
        elif error.fault == "missing" and run.repairs < MAX_REPAIRS:
            run.repairs += 1
            self._begin_frames(run, "")
        elif error.fault == "take" and run.repairs < MAX_REPAIRS:
            run.repairs += 1
            self._reporter.note(f"{run.row.scene}: {error.message}")
            run.state, run.waiting = "simulating", True
        elif error.fault == "class" and len(run.unsuited) + 1 < len(self._engine.workers):
            run.unsuited.add(worker)
            run.give_back(frames)
        elif error.fault == "store" and run.store_errors < MAX_STORE_ERRORS:
            run.store_errors += 1
            self._reporter.note(f"{run.row.scene}: {error.message}; tried again")
            self._again(given)
        elif error.fault == "frame" and not given.is_copy:
            self._on_frame_error(run, frames, error.message)
        elif isinstance(given.task, Assembling):
            self._finish(run, result)
        elif not given.is_copy:
            self._fail(run, error.told)

    def _on_encoding_error(self, run: FilmRun, task: Encoding, error: TaskError) -> None:
        """Have lost frames of a segment rendered again; otherwise its assembly encodes it."""
        if error.fault == "missing" and run.repairs < MAX_REPAIRS:
            run.repairs += 1
            run.done.difference_update(task.frames)
            self._take_back(run, task.frames)
            run.segments.append(task.frames)
        else:
            self._reporter.note(f"{run.row.scene}: {error.message}; encoded at the end")

    def _on_death(self, ended: Ended, given: Given) -> None:
        """Go on after a worker died."""
        run, task = given.run, given.task
        self._reporter.note(f"{run.row.scene}: {ended.worker} {ended.death}: {ended.reason}")
        if given.is_copy:
            return
        if isinstance(task, Encoding):
            # Its assembly encodes a segment that crashed a worker.
            if ended.death == "lost":
                run.segments.append(task.frames)
        elif isinstance(task, Rendering) and ended.death == "crashed":
            self._on_frame_error(run, task.frames, f"the renderer crashed: {ended.reason}")
        elif ended.death == "crashed" and run.store_errors >= MAX_STORE_ERRORS:
            self._fail(run, FilmingError(f"{ended.worker} crashed: {ended.reason}"))
        else:
            run.store_errors += ended.death == "crashed"
            self._again(given)

    def _again(self, given: Given) -> None:
        """Have a task done again."""
        if isinstance(given.task, Rendering):
            if not given.is_copy:
                self._take_back(given.run, given.task.frames)
        else:
            given.run.waiting = True

    def _take_back(self, run: FilmRun, frames: Sequence[int]) -> list[int]:
        """Count the frames of a task that are in the store, and return the others."""
        there = FrameIndex(self._store, run.film).done()
        run.done.update(frame for frame in frames if frame in there)
        run.progress()
        left = [frame for frame in frames if frame not in there]
        run.give_back(left)
        return left

    def _on_frame_error(self, run: FilmRun, frames: Sequence[int], reason: str) -> None:
        """Go on after a frame failed: one of those that are not in the store."""
        left = self._take_back(run, frames)
        run.pending = [frame for frame in run.pending if frame not in left]
        frame = run.suspect(left, reason)
        if frame is not None:
            FrameIndex(self._store, run.film).fail(frame, reason, run.tries[frame])
            self._reporter.note(f"{run.row.scene}: frame {frame} is given up: {reason}")
