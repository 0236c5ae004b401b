"""Reporting: what a run says while it works, to a terminal, a log or a machine.

Work is told in stages. A stage has a name and a number of things to do; its end says
how long it took and what came of it. All of it goes to standard error, and the result
of the command, such as the file it made, to standard output, so that it can be piped.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Protocol, TextIO

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

PLAIN_EVERY = 5.0
"""Seconds between two progress lines where there is no terminal."""


@dataclass(slots=True)
class Stage:
    """One stage under way.

    Attributes:
        name: what is being done, such as "render".
        total: how many things there are to do.
        done: how many are.
        started: on the monotonic clock [s].
        result: what came of it, said at its end.
    """

    name: str
    total: int
    done: int = 0
    started: float = field(default_factory=time.monotonic)
    result: str = ""

    @property
    def seconds(self) -> float:
        """How long it has taken so far."""
        return time.monotonic() - self.started

    @property
    def eta(self) -> float | None:
        """Seconds that the rest will take at this pace, None as long as nothing is done."""
        return self.seconds / self.done * (self.total - self.done) if self.done else None


class Reporter(Protocol):
    """Where a run says what it does."""

    def begin(self, stage: Stage) -> None:
        """Say that `stage` begins."""

    def advance(self, stage: Stage) -> None:
        """Say that `stage` has come to `stage.done`."""

    def end(self, stage: Stage) -> None:
        """Say that `stage` is over."""

    def note(self, text: str, detail: bool = False) -> None:
        """Say something by the way; details only where they were asked for."""

    def result(self, text: str, **facts: object) -> None:
        """Say what the command was called for, such as the file that it made.

        Args:
            text: for people.
            facts: the same and more, for other programs.
        """


@contextmanager
def stage(reporter: Reporter, name: str, total: int) -> Iterator[Stage]:
    """Report a stage from its begin to its end; the end is said only if it is reached."""
    current = Stage(name, total)
    reporter.begin(current)
    try:
        yield current
    finally:
        # A terminal's progress bar has to be closed whatever happens.
        reporter.end(current)


def step(reporter: Reporter, current: Stage, done: int) -> None:
    """Report that `current` has come to `done`."""
    current.done = done
    reporter.advance(current)


class Quiet:
    """Says nothing; errors are said by the command itself."""

    def begin(self, stage: Stage) -> None:
        """Say nothing."""

    def advance(self, stage: Stage) -> None:
        """Say nothing."""

    def end(self, stage: Stage) -> None:
        """Say nothing."""

    def note(self, text: str, detail: bool = False) -> None:
        """Say nothing."""

    def result(self, text: str, **facts: object) -> None:
        """Say nothing."""


class Plain:
    """Lines of text, for logs."""

    def __init__(self, stream: TextIO, verbose: bool = False) -> None:
        self._stream = stream
        self._verbose = verbose
        self._last = 0.0

    def begin(self, stage: Stage) -> None:
        """Write a line, if there is much to do."""
        self._last = time.monotonic()
        if stage.total > 1:
            self._say(f"{stage.name}: {stage.total} to do")

    def advance(self, stage: Stage) -> None:
        """Write a line now and then."""
        now = time.monotonic()
        if now - self._last >= PLAIN_EVERY and stage.done < stage.total:
            self._last = now
            eta = f", {_clock(stage.eta)} left" if stage.eta is not None else ""
            self._say(f"{stage.name}: {stage.done}/{stage.total}{eta}")

    def end(self, stage: Stage) -> None:
        """Write what came of it."""
        self._say(f"{stage.name}: {stage.result or 'stopped'} ({stage.seconds:.1f} s)")

    def note(self, text: str, detail: bool = False) -> None:
        """Write a line."""
        if self._verbose or not detail:
            self._say(text)

    def result(self, text: str, **facts: object) -> None:
        """Write a line to standard output."""
        sys.stdout.write(f"{text}\n")
        sys.stdout.flush()

    def _say(self, text: str) -> None:
        print(text, file=self._stream, flush=True)


class Terminal(Plain):
    """Bars with the time that is left, for people."""

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
        """Take the bar away and say what came of it."""
        if self._progress is not None:
            self._progress.stop()
            self._progress = None
        mark = "[green]✓[/]" if stage.result else "[yellow]■[/]"
        text = f"{stage.name:<9} {stage.result or 'stopped'}"
        self._console.print(f"{mark} {text} [dim]{stage.seconds:.1f} s[/]")

    def _say(self, text: str) -> None:
        self._console.print(text, markup=False)


class Machine:
    """One JSON object a line on standard output, for other programs."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def begin(self, stage: Stage) -> None:
        """Write a `begin` object."""
        self.say({"event": "begin", "stage": stage.name, "total": stage.total})

    def advance(self, stage: Stage) -> None:
        """Write a `progress` object."""
        eta = None if stage.eta is None else round(stage.eta, 3)
        self.say(
            {
                "event": "progress",
                "stage": stage.name,
                "done": stage.done,
                "total": stage.total,
                "eta": eta,
            }
        )

    def end(self, stage: Stage) -> None:
        """Write an `end` object."""
        self.say(
            {
                "event": "end" if stage.result else "stopped",
                "stage": stage.name,
                "seconds": round(stage.seconds, 3),
                "result": stage.result,
            }
        )

    def note(self, text: str, detail: bool = False) -> None:
        """Write a `note` object."""
        self.say({"event": "note", "text": text, "detail": detail})

    def result(self, text: str, **facts: object) -> None:
        """Write a `result` object that holds the facts."""
        self.say({"event": "result", "text": text, **facts})

    def say(self, words: dict[str, object]) -> None:
        """Write one object."""
        print(json.dumps(words, ensure_ascii=False), file=self._stream, flush=True)


def reporter_for(json_lines: bool, quiet: bool, verbose: bool) -> Reporter:
    """Return the reporter that suits the flags and the place where it writes."""
    if json_lines:
        return Machine(sys.stdout)
    if quiet:
        return Quiet()
    if sys.stderr.isatty():
        return Terminal(sys.stderr, verbose)
    return Plain(sys.stderr, verbose)


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"
