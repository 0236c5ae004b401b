"""Progress of a run: its stages, and the interface of the reporters that show them.

`reporters` implements the interface.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from pipeline.production.run.notes import Note, counted_notes
from pipeline.production.run.quantities import duration_text
from pipeline.production.run.time_estimate import TimeEstimate


@dataclass(slots=True)
class Stage:
    """One stage under way.

    Attributes:
        reporter: of its progress.
        name: of the work, such as "render".
        total: number of things to do.
        unit: of the things, such as "frames".
        scale: units in a thing.
        label: name for people; the name by default.
        estimated: whether the time left is estimated.
        scene: that it belongs to, where stages of several scenes are under way at once.
        done: number of things done.
        kept: those of them that an earlier run had done.
        started: on the monotonic clock [s].
        result: summary, reported at the end; empty for a stage that was stopped.
        estimate: of the time left.
    """

    reporter: Reporter
    name: str
    total: int
    unit: str = ""
    scale: float = 1.0
    label: str = ""
    estimated: bool = True
    scene: str = ""
    done: int = 0
    kept: int = 0
    started: float = field(default_factory=lambda: time.monotonic())
    result: str = ""
    estimate: TimeEstimate = field(init=False)
    _paused: float = 0.0
    _paused_at: float | None = None

    def __post_init__(self) -> None:
        self.estimate = TimeEstimate(self.total)
        self.label = self.label or self.title

    @property
    def title(self) -> str:
        """Its name for people, after that of its scene."""
        return f"{self.scene}: {self.name}" if self.scene else self.name

    def advance(self, done: int) -> None:
        """Report that `done` things are done."""
        self.done = done
        self.estimate.measure(done, self.seconds)
        self.reporter.advance(self)

    def advance_together(self, done: int, pace: float | None) -> None:
        """Report that `done` things are done, several at once.

        Args:
            done: number of things.
            pace: time per thing [s], None before it is measured.
        """
        self.done = done
        self.estimate.set_pace(done, self.seconds, pace)
        self.reporter.advance(self)

    def pause(self) -> None:
        """Stop the clock of the stage, for work that belongs to another one."""
        if self._paused_at is None:
            self._paused_at = time.monotonic()

    def resume(self) -> None:
        """Let the clock go on."""
        if self._paused_at is not None:
            self._paused += time.monotonic() - self._paused_at
            self._paused_at = None

    def keep(self, kept: int) -> None:
        """Report that an earlier run has done `kept` things."""
        self.kept = self.done = kept
        # No measure of the pace.
        self.reporter.advance(self)

    @property
    def seconds(self) -> float:
        """Time since the start without pauses [s]."""
        now = time.monotonic() if self._paused_at is None else self._paused_at
        return now - self.started - self._paused

    @property
    def eta(self) -> float | None:
        """Time left [s], None before it is known."""
        return self.estimate.left(self.seconds) if self.estimated else None

    @property
    def amount(self) -> str:
        """What is done of all there is to do, such as "12 of 144 frames"."""
        if self.scale == 1.0:
            return f"{self.done} of {self.total} {self.unit}".rstrip()
        return f"{self.done * self.scale:.1f} of {self.whole}"

    @property
    def whole(self) -> str:
        """All there is to do, such as "144 frames"."""
        return f"{round(self.total * self.scale, 1):g} {self.unit}".rstrip()

    @property
    def time_text(self) -> str:
        """The time left, or the time since the start before it is known."""
        eta = self.eta
        if eta is None:
            return f"{duration_text(self.seconds)} so far"
        return f"{duration_text(eta)} left"


@dataclass(slots=True)
class SceneRow:
    """What became of one scene: a row of the table at the end of a run on several.

    Attributes:
        scene: as the command names it.
        state: "not started", "stopped", "failed" or "done".
        stage: the stage whose things are frames, None before it.
        seconds: time that the scene took [s].
        notes: number of its notes.
        error: first line of its error, "" without one.
        exit_code: that the scene alone ends with, None for one that is not started.
        success: word for the state "done".
    """

    scene: str
    state: str = "not started"
    stage: Stage | None = None
    seconds: float = 0.0
    notes: int = 0
    error: str = ""
    exit_code: int | None = None
    success: str = "done"

    @property
    def facts(self) -> dict[str, object]:
        """Its members for other programs."""
        return {
            "scene": self.scene,
            "state": self.state,
            "frames": self.stage.done if self.stage else None,
            "of": self.stage.total if self.stage else None,
            "cached": self.stage.kept if self.stage else None,
            "seconds": round(self.seconds, 3),
            "notes": self.notes,
            "exit_code": self.exit_code,
            "error": self.error,
        }

    @property
    def cells(self) -> tuple[str, ...]:
        """Its cells: scene, frames, cached, seconds, state."""
        frames, kept = "-", "-"
        if self.stage is not None:
            whole = self.stage.done >= self.stage.total
            frames = str(self.stage.done) + ("" if whole else f" of {self.stage.total}")
            kept = str(self.stage.kept)
        notes = f", {counted_notes(self.notes)}" if self.notes else ""
        error = f": {self.error}" if self.error else ""
        seconds = "-" if self.state == "not started" else f"{self.seconds:.1f}"
        state = self.success if self.state == "done" else self.state
        return self.scene, frames, kept, seconds, f"{state}{notes}{error}"


class Reporter:
    """Reports nothing; others override what they report."""

    def scene(self, name: str, number: int, total: int) -> None:
        """Report that the work on one of several scenes begins."""

    def table(self, rows: Sequence[SceneRow], exit_code: int) -> None:
        """Report what became of several scenes.

        Args:
            rows: one for each scene.
            exit_code: of the command.
        """

    def begin(self, stage: Stage) -> None:
        """Report the start of a stage."""

    def advance(self, stage: Stage) -> None:
        """Report that a stage has come to `stage.done`."""

    def end(self, stage: Stage) -> None:
        """Report the end of a stage."""

    def note(self, text: str, detail: bool = False) -> None:
        """Report a note; a detail only in verbose mode."""

    def notes(self, scene: str, notes: Sequence[Note], manifest: Path | None) -> None:
        """Report the notes of a scene at the end of its run.

        Args:
            scene: its name.
            notes: one or more.
            manifest: file that lists them all, None without one.
        """

    def result(self, text: str, **facts: object) -> None:
        """Report the result of the command.

        Args:
            text: for people.
            facts: the same and more, for other programs.
        """


@contextmanager
def stage(
    reporter: Reporter, name: str, total: int, unit: str = "", scale: float = 1.0, label: str = ""
) -> Iterator[Stage]:
    """Report a stage from its start to its end; see `Stage`."""
    current = Stage(reporter, name, total, unit, scale, label)
    reporter.begin(current)
    try:
        yield current
    finally:
        # A terminal's progress bar has to be closed whatever happens.
        reporter.end(current)
