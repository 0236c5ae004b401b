"""Scene table: what became of each scene, at the end of a run on several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.production.run.notes import counted_notes
from pipeline.production.run.progress import Stage
from pipeline.terminal_text import escaped_line


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
