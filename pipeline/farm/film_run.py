"""Film run: what a driver knows of one film while it is made."""

from __future__ import annotations

import time
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Literal

from pipeline.farm.chunk_plan import FilmCosts, chunk_size
from pipeline.farm.film import Film
from pipeline.production.run.progress import Reporter, SceneRow, Stage

MAX_TRIES = 3
"""Tries of a frame before it is given up."""

MAX_STORE_ERRORS = 8
"""Successive tasks of a film that may fail because of the store."""

MAX_REPAIRS = 3
"""Times that frames which got lost are rendered again."""

State = Literal["simulating", "rendering", "assembling", "ended"]


@dataclass(slots=True)
class FilmRun:
    """One film under way.

    Attributes:
        number: of its scene in the command.
        row: of the table.
        film: that is made.
        frames: all that are wanted, ascending.
        state: of the film.
        stage: that is reported.
        began: on the monotonic clock [s].
        waiting: whether a task of its state (simulating, assembling) waits for a worker.
        pending: frames that no task has, in runs that are given out from the front.
        running: frames of the tasks of each worker.
        done: frames that are in the store.
        tries: how often each frame failed.
        given_up: why frames were given up.
        unsuited: workers whose class does not fit the film.
        store_errors: successive tasks that failed because of the store.
        repairs: times that frames which got lost were rendered again.
        segments: frames of each segment that no task encodes and the store does not have.
        encoding: segments of the tasks of each worker.
        costs: of its frames.
    """

    number: int
    row: SceneRow
    film: Film
    frames: tuple[int, ...]
    state: State = "simulating"
    stage: Stage | None = None
    began: float = field(default_factory=lambda: time.monotonic())
    waiting: bool = True
    pending: list[int] = field(default_factory=list)
    singles: list[int] = field(default_factory=list)
    running: dict[str, tuple[int, ...]] = field(default_factory=dict)
    done: set[int] = field(default_factory=set)
    tries: dict[int, int] = field(default_factory=dict)
    given_up: dict[int, str] = field(default_factory=dict)
    unsuited: set[str] = field(default_factory=set)
    store_errors: int = 0
    repairs: int = 0
    segments: list[tuple[int, ...]] = field(default_factory=list)
    encoding: dict[str, tuple[int, ...]] = field(default_factory=dict)
    costs: FilmCosts = field(default_factory=FilmCosts)

    @property
    def has_frames(self) -> bool:
        """Whether there are frames that no task has."""
        return self.state == "rendering" and bool(self.pending or self.singles)

    @property
    def is_rendered(self) -> bool:
        """Whether no frame is left to do."""
        return not (self.pending or self.singles or self.running)

    @property
    def is_encoded(self) -> bool:
        """Whether no segment is left to encode."""
        return not (self.segments or self.encoding)

    def next_segment(self) -> tuple[int, ...] | None:
        """Take a segment whose frames are all done for a task, None if there is none."""
        if self.state != "rendering":
            return None
        for segment in self.segments:
            if self.done.issuperset(segment):
                self.segments.remove(segment)
                return segment
        return None

    def begin_stage(
        self, reporter: Reporter, name: str, total: int, unit: str, scale: float = 1.0
    ) -> Stage:
        """Report the start of a stage, after the end of the one before; see `Stage`."""
        self.end_stage("")
        self.stage = Stage(reporter, name, total, unit, scale, scene=self.row.scene)
        reporter.begin(self.stage)
        return self.stage

    def end_stage(self, result: str) -> None:
        """Report the end of the stage under way, if there is one."""
        if self.stage is not None:
            self.stage.result = result
            self.stage.reporter.end(self.stage)
            self.stage = None

    def next_chunk(self, workers: int) -> tuple[int, ...]:
        """Take frames for a task: one that may be at fault alone, otherwise a chunk.

        Args:
            workers: number of workers that the film can have.
        """
        if self.singles:
            return (self.singles.pop(0),)
        size = chunk_size(len(self.pending), workers, self.costs)
        chunk, self.pending = tuple(self.pending[:size]), self.pending[size:]
        return chunk

    def give_back(self, frames: Collection[int]) -> None:
        """Take frames of a task that did not end well back among those to do."""
        known = {*self.pending, *self.singles, *self.done, *self.given_up}
        self.pending = sorted({*self.pending, *(f for f in frames if f not in known)})

    def suspect(self, frames: Collection[int], reason: str) -> int | None:
        """Count a failure of the first of some frames, which is tried alone from now on.

        Args:
            frames: of a task that ended at one of them, without those that are done.
            reason: of the failure.

        Returns:
            The frame if it is given up.
        """
        if not frames:
            return None
        frame, *others = sorted(frames)
        self.give_back(others)
        self.tries[frame] = self.tries.get(frame, 0) + 1
        if self.tries[frame] >= MAX_TRIES:
            self.given_up[frame] = reason
            return frame
        self.pending = [f for f in self.pending if f != frame]
        if frame not in self.singles:
            self.singles.append(frame)
        # A frame is written while the next one is rendered, so that one may be at fault as well.
        if others and others[0] in self.pending:
            self.pending.remove(others[0])
            self.singles.append(others[0])
        return None

    def progress(self) -> None:
        """Report how many frames are done."""
        if self.stage is not None:
            pace = self.costs.per_frame
            shared = None if pace is None else pace / max(len(self.running), 1)
            self.stage.advance_together(len(self.done), shared)
