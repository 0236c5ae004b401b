"""Tables: columns of text, and reports that hold them beside the same as plain values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Report:
    """A report for people and for other programs.

    Attributes:
        text: tables.
        facts: the same, one mapping per creature or trial.
    """

    text: str
    facts: list[dict[str, Any]]


def table_lines(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return rows as lines: the first column aligned to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = [cell.rjust(w) for cell, w in zip(row[1:], widths[1:], strict=True)]
        lines.append("  ".join([row[0].ljust(widths[0]), *cells]))
    return lines
