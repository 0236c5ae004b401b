"""Progress of a run, reported to a terminal, a log or another program.

Work is reported in stages with a name and a number of things to do. Everything goes to standard
error except the result of the command, which goes to standard output so that it can be piped.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn, Task, TaskID
from rich.text import Text

from pipeline.production.run.notes import Note, counted_notes, summary
from pipeline.production.run.time_estimate import TimeEstimate
from pipeline.terminal_text import escaped, escaped_line
from pipeline.text_stream import print_json, print_text

MIN_LOG_INTERVAL, MAX_LOG_INTERVAL = 10.0, 300.0
"""Shortest and longest time between two progress lines of a log [s]."""

LOG_LINES = 6
"""Progress lines of a stage in a log, about."""


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
    done: int = 0
    kept: int = 0
    started: float = field(default_factory=lambda: time.monotonic())
    result: str = ""
    estimate: TimeEstimate = field(init=False)
    _paused: float = 0.0
    _paused_at: float | None = None

    def __post_init__(self) -> None:
        self.estimate = TimeEstimate(self.total)
        self.label = self.label or self.name

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
        return f"{self.done * self.scale:.1f} of {self.total * self.scale:g} {self.unit}"

    @property
    def time_text(self) -> str:
        """The time left, or the time since the start before it is known."""
        eta = self.eta
        return f"{self.seconds:.0f} s" if eta is None else f"{clock(eta)} left"


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


def table_lines(rows: Sequence[SceneRow]) -> list[str]:
    """Return the table of several scenes, line by line."""
    cells = [("scene", "frames", "cached", "seconds", "state"), *map(_cells, rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [
        "  ".join([row[0].ljust(widths[0]), *(row[i].rjust(widths[i]) for i in (1, 2, 3)), row[4]])
        for row in cells
    ]


def _cells(row: SceneRow) -> tuple[str, ...]:
    return tuple(map(escaped_line, row.cells))


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


class LogReporter(Reporter):
    """Reports as lines of text."""

    def __init__(self, stream: TextIO, verbose: bool = False) -> None:
        self._stream = stream
        self._verbose = verbose
        self._next = dict[int, float]()
        self._estimated = set[int]()

    def scene(self, name: str, number: int, total: int) -> None:
        """Write a line."""
        self._print(f"[{number}/{total}] {name}")

    def table(self, rows: Sequence[SceneRow], exit_code: int) -> None:
        """Write a line for each scene."""
        for line in table_lines(rows):
            self._print(line)

    def begin(self, stage: Stage) -> None:
        """Write a line if there is more than one thing to do."""
        self._next[id(stage)] = time.monotonic() + MIN_LOG_INTERVAL
        if stage.total > 1:
            whole = f"{stage.total * stage.scale:g} {stage.unit}".rstrip()
            self._print(f"{stage.label}: {whole} to do")

    def advance(self, stage: Stage) -> None:
        """Write a line for the first estimate, and some until the end."""
        now, eta = time.monotonic(), stage.eta
        first = eta is not None and eta > MIN_LOG_INTERVAL and id(stage) not in self._estimated
        if stage.done >= stage.total or not (first or now >= self._next[id(stage)]):
            return
        if first:
            self._estimated.add(id(stage))
        # Without an estimate a stage may take as long again as it has.
        whole = stage.seconds + (stage.seconds * LOG_LINES if eta is None else eta)
        interval = min(max(whole / LOG_LINES, MIN_LOG_INTERVAL), MAX_LOG_INTERVAL)
        self._next[id(stage)] = now + interval
        self._print(f"{stage.label}: {stage.amount}, {stage.time_text}")

    def end(self, stage: Stage) -> None:
        """Write the result of the stage."""
        self._next.pop(id(stage), None)
        self._estimated.discard(id(stage))
        self._print(f"{stage.name}: {stage.result or 'stopped'} ({stage.seconds:.1f} s)")

    def note(self, text: str, detail: bool = False) -> None:
        """Write a line."""
        if self._verbose or not detail:
            self._print(text)

    def notes(self, scene: str, notes: Sequence[Note], manifest: Path | None) -> None:
        """Write a summary of a few lines."""
        self._print(f"{scene}: {counted_notes(len(notes))}")
        for line in summary(notes, str(manifest or "")):
            self._print(f"  {line}")

    def result(self, text: str, **facts: object) -> None:
        """Write a line to standard output."""
        print_text(sys.stdout, text)

    def _print(self, text: str) -> None:
        print_text(self._stream, text)


class _StageColumn(ProgressColumn):
    """A column of a bar with a text of its stage."""

    def __init__(self, text: Callable[[Stage], str]) -> None:
        super().__init__()
        self._text = text

    def render(self, task: Task) -> Text:
        """Return the text as it is now."""
        return Text(escaped_line(self._text(task.fields["stage"])))


class TerminalReporter(LogReporter):
    """Reports as progress bars, which move between two reports as well."""

    def __init__(self, stream: TextIO, verbose: bool = False) -> None:
        super().__init__(stream, verbose)
        self._console = Console(file=stream, highlight=False)
        self._progress: Progress | None = None
        self._bars = dict[int, TaskID]()

    def begin(self, stage: Stage) -> None:
        """Show a bar, below those of stages under way."""
        if self._progress is None:
            self._progress = Progress(
                SpinnerColumn(),
                _StageColumn(lambda stage: f"{stage.label:<9}"),
                BarColumn(),
                _StageColumn(lambda stage: stage.amount),
                _StageColumn(lambda stage: stage.time_text),
                console=self._console,
                transient=True,
            )
            self._progress.start()
        self._bars[id(stage)] = self._progress.add_task(stage.name, total=stage.total, stage=stage)

    def advance(self, stage: Stage) -> None:
        """Move the bar."""
        if self._progress is not None:
            self._progress.update(self._bars[id(stage)], completed=stage.done, total=stage.total)

    def end(self, stage: Stage) -> None:
        """Replace the bar by the result of the stage."""
        if self._progress is not None:
            self._progress.remove_task(self._bars.pop(id(stage)))
            if not self._bars:
                self._progress.stop()
                self._progress = None
        mark = ("✓", "green") if stage.result else ("■", "yellow")
        text = escaped(f" {stage.name:<9} {stage.result or 'stopped'} ")
        self._console.print(Text.assemble(mark, text, (f"{stage.seconds:.1f} s", "dim")))

    def _print(self, text: str) -> None:
        self._console.print(escaped(text), markup=False, soft_wrap=True)


class JsonReporter(Reporter):
    """Reports as one JSON object per line of standard output."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._scene: dict[str, object] = {}

    def scene(self, name: str, number: int, total: int) -> None:
        """Write a `scene` object; all that follow name the scene."""
        self._scene = {"scene": name}
        self._print(event="scene", number=number, total=total)

    def table(self, rows: Sequence[SceneRow], exit_code: int) -> None:
        """Write a `table` object."""
        self._scene = {}
        self._print(event="table", scenes=[row.facts for row in rows], exit_code=exit_code)

    def begin(self, stage: Stage) -> None:
        """Write a `begin` object."""
        self._print(event="begin", stage=stage.name, total=stage.total)

    def advance(self, stage: Stage) -> None:
        """Write a `progress` object."""
        eta = None if stage.eta is None else round(stage.eta, 3)
        counts = {"done": stage.done, "total": stage.total, "eta": eta}
        self._print(event="progress", stage=stage.name, **counts)

    def end(self, stage: Stage) -> None:
        """Write an `end` or a `stopped` object."""
        event, seconds = "end" if stage.result else "stopped", round(stage.seconds, 3)
        self._print(event=event, stage=stage.name, seconds=seconds, result=stage.result)

    def note(self, text: str, detail: bool = False) -> None:
        """Write a `note` object."""
        self._print(event="note", text=text, detail=detail)

    def notes(self, scene: str, notes: Sequence[Note], manifest: Path | None) -> None:
        """Write a `note` object with a `kind` for each."""
        for note in notes:
            self._print(event="note", **{**note.facts, "scene": scene}, detail=False)

    def result(self, text: str, **facts: object) -> None:
        """Write a `result` object that holds the facts."""
        self._print(event="result", text=text, **facts)

    def _print(self, event: str, **members: object) -> None:
        line = {"event": event, **self._scene, **members}
        print_json(self._stream, line)


def reporter_for(json_lines: bool, quiet: bool, verbose: bool) -> Reporter:
    """Return the reporter for the flags of a command and its standard error."""
    if json_lines:
        return JsonReporter(sys.stdout)
    if quiet:
        return Reporter()
    if sys.stderr.isatty():
        return TerminalReporter(sys.stderr, verbose)
    return LogReporter(sys.stderr, verbose)


def clock(seconds: float) -> str:
    """Return a duration as hours, minutes and seconds."""
    whole = round(seconds)
    hours, minutes = divmod(whole // 60, 60)
    return f"{hours}:{minutes:02d}:{whole % 60:02d}" if hours else f"{minutes}:{whole % 60:02d}"
