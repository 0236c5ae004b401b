"""Batch: scenes one after the other; where one fails, the others are made all the same."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from pipeline.errors import PronkError
from pipeline.production.run.interrupts import INTERRUPTED, is_interrupt
from pipeline.production.run.notes import Note
from pipeline.production.run.progress import Reporter, SceneRow, Stage
from pipeline.spec import find_scene
from pipeline.unexpected_error import told_error

FRAME_STAGES = ("simulate", "render")
"""Stages whose things are frames; the last of them counts in the table."""

MAX_ERROR_LENGTH = 90
"""Of an error in the table, which was told in full before [characters]."""

Work = Callable[[str, Reporter], None]
"""Work on a scene, by its name; reports to the reporter."""

ReportError = Callable[[PronkError, str, Path | None], None]
"""Tells an error with the name of the scene and its file, None if there is none."""


class SceneReporter(Reporter):
    """Passes on what the work on a scene reports and enters it into the scene's row."""

    def __init__(self, reporter: Reporter, row: SceneRow) -> None:
        self._reporter = reporter
        self._row = row

    def begin(self, stage: Stage) -> None:
        """Pass on, and note a stage that counts frames."""
        if stage.name in FRAME_STAGES:
            self._row.stage = stage
        self._reporter.begin(stage)

    def advance(self, stage: Stage) -> None:
        """Pass on."""
        self._reporter.advance(stage)

    def end(self, stage: Stage) -> None:
        """Pass on."""
        self._reporter.end(stage)

    def note(self, text: str, detail: bool = False) -> None:
        """Pass on."""
        self._reporter.note(text, detail)

    def notes(self, scene: str, notes: Sequence[Note], manifest: Path | None) -> None:
        """Pass on and count."""
        self._row.notes += len(notes)
        self._reporter.notes(scene, notes, manifest)

    def result(self, text: str, **facts: object) -> None:
        """Pass on."""
        self._reporter.result(text, **facts)


def run_batch(
    scenes: Sequence[str],
    work: Work,
    reporter: Reporter,
    report_error: ReportError,
    success: str = "done",
    find: Callable[[str], Path | None] = find_scene,
) -> int:
    """Work on scenes one after the other and return the worst exit code, which is the highest.

    Of several scenes a table is reported at the end, also when the user interrupts.

    Args:
        scenes: files or names.
        work: on each of them.
        reporter: of the work.
        report_error: called with each error as it happens.
        success: word of the table for a scene that the work is done on.
        find: returns the file of a scene, None for what is none.
    """
    rows = [SceneRow(scene, success=success) for scene in scenes]
    several = len(rows) > 1
    try:
        for number, row in enumerate(rows, start=1):
            if several:
                reporter.scene(row.scene, number, len(rows))
            _run_scene(row, work, reporter, report_error, find)
    finally:
        worst = max(row.exit_code or 0 for row in rows)
        if several:
            reporter.table(rows, worst)
    return worst


def _run_scene(
    row: SceneRow,
    work: Work,
    reporter: Reporter,
    report_error: ReportError,
    find: Callable[[str], Path | None],
) -> None:
    """Work on one scene and fill its row."""
    began = time.monotonic()
    file: Path | None = None
    # Until it has come to an end of its own.
    row.state, row.exit_code = "stopped", INTERRUPTED
    try:
        file = find(row.scene)
        work(row.scene, SceneReporter(reporter, row))
        row.state, row.exit_code = "done", 0
    except BrokenPipeError:
        # Nobody reads the results any more.
        raise
    except Exception as error:
        if is_interrupt(error):
            raise
        told = told_error(error)
        row.state, row.exit_code = "failed", told.exit_code
        row.error = shortened(str(told).splitlines()[0])
        report_error(told, row.scene, file)
    finally:
        row.seconds = time.monotonic() - began


def shortened(text: str) -> str:
    """Return the first line of an error, as long as the table has room for it."""
    return text if len(text) <= MAX_ERROR_LENGTH else text[: MAX_ERROR_LENGTH - 3] + "..."
