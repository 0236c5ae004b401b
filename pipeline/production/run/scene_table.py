"""Scene table: what became of each scene, at the end of a run on several."""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.production.run.progress import SceneRow
from pipeline.terminal_text import escaped_line


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
