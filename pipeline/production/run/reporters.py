"""Reporters: the progress of a run for a terminal, a log or another program.

Everything goes to standard error except the result of the command, which goes to standard output
so that it can be piped.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn, Task, TaskID
from rich.text import Text

from pipeline.production.run.notes import Note, counted_notes, summary
from pipeline.production.run.progress import Reporter, SceneRow, Stage
from pipeline.production.run.scene_table import table_lines
from pipeline.terminal_text import escaped, escaped_line
from pipeline.text_stream import print_json, print_text

MIN_LOG_INTERVAL, MAX_LOG_INTERVAL = 10.0, 300.0
"""Shortest and longest time between two progress lines of a log [s]."""

LOG_LINES = 6
"""Progress lines of a stage in a log, about."""


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
            self._print(f"{stage.label}: {stage.whole} to do")

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
        self._print(f"{stage.title}: {stage.result or 'stopped'} ({stage.seconds:.1f} s)")

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
        text = escaped(f" {stage.title:<9} {stage.result or 'stopped'} ")
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
        self._print("begin", **_named(stage), total=stage.total)

    def advance(self, stage: Stage) -> None:
        """Write a `progress` object."""
        eta = None if stage.eta is None else round(stage.eta, 3)
        counts = {"done": stage.done, "total": stage.total, "eta": eta}
        self._print("progress", **_named(stage), **counts)

    def end(self, stage: Stage) -> None:
        """Write an `end` or a `stopped` object."""
        event, seconds = "end" if stage.result else "stopped", round(stage.seconds, 3)
        self._print(event, **_named(stage), seconds=seconds, result=stage.result)

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


def _named(stage: Stage) -> dict[str, object]:
    """Return the members that name a stage."""
    return {**({"scene": stage.scene} if stage.scene else {}), "stage": stage.name}


def reporter_for(json_lines: bool, quiet: bool, verbose: bool) -> Reporter:
    """Return the reporter for the flags of a command and its standard error."""
    if json_lines:
        return JsonReporter(sys.stdout)
    if quiet:
        return Reporter()
    if sys.stderr.isatty():
        return TerminalReporter(sys.stderr, verbose)
    return LogReporter(sys.stderr, verbose)
