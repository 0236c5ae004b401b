"""Fault: what is wrong with one file of a scene's outputs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from pipeline.errors import PronkError

MAX_LINES = 40
"""Faults that an error lists one by one."""

NOT_AS_WRITTEN = "is not as it was written"
MISSING = "is missing"


@dataclass(frozen=True, slots=True)
class Fault:
    """A file that is missing or is not what was written.

    Attributes:
        file: its path from the folder of the outputs.
        text: what is wrong.
        remedy: the command that makes it again, "" where `pronk render` of the scene does.
    """

    file: str
    text: str
    remedy: str = ""

    def __str__(self) -> str:
        return f"{self.file}: {self.text}" + (f" ({self.remedy})" if self.remedy else "")


class OutputsDamaged(PronkError):
    """Files of a scene's outputs are missing or damaged.

    Attributes:
        faults: one or more.
    """

    exit_code = 1

    def __init__(self, folder: Path, scene: str, count: int, faults: Sequence[Fault]) -> None:
        self.faults = tuple(faults)
        by_render = any(not fault.remedy for fault in faults)
        again = f"; pronk render {scene} makes them again" if by_render else ""
        left = len(faults) - MAX_LINES
        lines = [
            f"{folder}: {len(faults)} of {count} files are damaged or missing{again}",
            *map(str, faults[:MAX_LINES]),
            *([f"and {left} more; --json lists them all"] if left > 0 else []),
        ]
        super().__init__("\n  ".join(lines))

    @property
    def facts(self) -> dict[str, object]:
        """Its faults."""
        return {"faults": [asdict(fault) for fault in self.faults]}
