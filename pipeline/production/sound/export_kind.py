"""Export kinds: what is written of a score for other programs."""

from __future__ import annotations

from enum import StrEnum


class ExportKind(StrEnum):
    """What is written of a score for other programs."""

    performers = "performers"
    stems = "stems"
    musicxml = "musicxml"
    reaper = "reaper"
