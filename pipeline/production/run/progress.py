"""Progress of a run, reported to a terminal, a log or another program.

Work is reported in stages with a name and a number of things to do. Everything goes to standard
error except the result of the command, which goes to standard output so that it can be piped.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TextIO

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

LOG_INTERVAL = 5.0
"""Time between two progress lines of a log [s]."""


@dataclass(slots=True)
class Stage:
    """One stage under way.

    Attributes:
        reporter: of its progress.
        name: of the work, such as "render".
        total: number of things to do.
        done: number of things done.
        started: on the monotonic clock [s].
        result: summary, reported at the end; empty for a stage that was stopped.
    """

    reporter: Reporter
    name: str
    total: int
    done: int = 0
    started: float = field(default_factory=time.monotonic)
    result: str = ""

    def advance(self, done: int) -> None:
        """Report that `done` things are done."""
        self.done = done
        self.reporter.advance(self)

    @property
    def seconds(self) -> float:
        """Time since the start [s]."""
        return time.monotonic() - self.started

    @property
    def eta(self) -> float | None:
        """Time left at this pace [s], None before anything is done."""
        return self.seconds / self.done * (self.total - self.done) if self.done else None


class Reporter:
    """Reports nothing; others override what they report."""

    def begin(self, stage: Stage) -> None:
        """Report the start of a stage."""

    def advance(self, stage: Stage) -> None:
        """Report that a stage has come to `stage.done`."""

    def end(self, stage: Stage) -> None:
        """Report the end of a stage."""

    def note(self, text: str, detail: bool = False) -> None:
        """Report a note; a detail only in verbose mode."""

    def result(self, text: str, **facts: object) -> None:
        """Report the result of the command.

        Args:
            text: for people.
            facts: the same and more, for other programs.
        """


@contextmanager
def stage(reporter: Reporter, name: str, total: int) -> Iterator[Stage]:
    """Report a stage from its start to its end."""
    current = Stage(reporter, name, total)
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
        self._last = 0.0

    def begin(self, stage: Stage) -> None:
        """Write a line if there is more than one thing to do."""
        self._last = time.monotonic()
        if stage.total > 1:
            self._print(f"{stage.name}: {stage.total} to do")

    def advance(self, stage: Stage) -> None:
        """Write a line every few seconds."""
        now = time.monotonic()
        if now - self._last >= LOG_INTERVAL and stage.done < stage.total:
            self._last = now
            eta = f", {clock(stage.eta)} left" if stage.eta is not None else ""
            self._print(f"{stage.name}: {stage.done}/{stage.total}{eta}")

    def end(self, stage: Stage) -> None:
        """Write the result of the stage."""
        self._print(f"{stage.name}: {stage.result or 'stopped'} ({stage.seconds:.1f} s)")

    def note(self, text: str, detail: bool = False) -> None:
        """Write a line."""
        if self._verbose or not detail:
            self._print(text)

    def result(self, text: str, **facts: object) -> None:
        """Write a line to standard output."""
        sys.stdout.write(f"{text}\n")
        sys.stdout.flush()

    def _print(self, text: str) -> None:
        print(text, file=self._stream, flush=True)


class TerminalReporter(LogReporter):
    """Reports as progress bars."""

    def __init__(self, stream: TextIO, verbose: bool = False) -> None:
        super().__init__(stream, verbose)
        self._console = Console(file=stream, highlight=False)
        self._progress: Progress | None = None

    def begin(self, stage: Stage) -> None:
        """Show a bar."""
        self._progress = Progress(
            SpinnerColumn(),
            TextColumn("{task.description:<9}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=self._console,
            transient=True,
        )
        self._progress.start()
        self._progress.add_task(stage.name, total=stage.total)

    def advance(self, stage: Stage) -> None:
        """Move the bar."""
        if self._progress is not None:
            self._progress.update(self._progress.task_ids[0], completed=stage.done)

    def end(self, stage: Stage) -> None:
        """Replace the bar by the result of the stage."""
        if self._progress is not None:
            self._progress.stop()
            self._progress = None
        mark = "[green]✓[/]" if stage.result else "[yellow]■[/]"
        text = f"{stage.name:<9} {stage.result or 'stopped'}"
        self._console.print(f"{mark} {text} [dim]{stage.seconds:.1f} s[/]")

    def _print(self, text: str) -> None:
        self._console.print(text, markup=False)


class JsonReporter(Reporter):
    """Reports as one JSON object per line of standard output."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

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

    def result(self, text: str, **facts: object) -> None:
        """Write a `result` object that holds the facts."""
        self._print(event="result", text=text, **facts)

    def _print(self, **members: object) -> None:
        print(json.dumps(members, ensure_ascii=False), file=self._stream, flush=True)


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
