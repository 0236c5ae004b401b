"""What can go wrong, as one tree, with the exit code each branch ends in.

    PronkError              1    and its branches elsewhere: notes that --strict refuses
    ├── UsageError          2    the command was called in a way that cannot work
    ├── SceneError          3    the scene is wrong; holds every problem found
    ├── ProductionError     4    simulating, rendering or writing failed
    │   ├── SimulationError      diverged or impossible; says step, time and part
    │   │   └── MassError        a solid or a set of points has no mass properties
    │   ├── FilmingError         Mitsuba, the denoiser or the encoder failed
    │   ├── ScoringError         the score could not be written as MIDI or sound
    │   └── StoreError           an output could not be written or read
    ├── GoldenMissing       5    there is nothing to compare with
    └── CannotJudge         6    this machine cannot decide the comparison

`render` and `audio` import nothing of the project and raise their own
`RenderError` and `AudioError`; production turns these into the tree above.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import ClassVar

from pipeline.terminal_text import escaped_line


class PronkError(Exception):
    """Root of all errors that pronk reports as one clear message."""

    exit_code: ClassVar[int] = 1

    @property
    def facts(self) -> dict[str, object]:
        """What other programs are told besides the message."""
        return {}


class UsageError(PronkError):
    """The command cannot work as it was called."""

    exit_code = 2


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong in a scene file.

    Attributes:
        path: where in the scene, such as `cast[0].walk.strde`; empty for the whole file.
        message: what is wrong and what would be right.
        file: name of the file as the author gave it.
        line: 1-based line, 0 where there is none (a value given on the command line).
        column: 1-based column, 0 likewise.
        source: the text of that line, shown under the message.
    """

    path: str
    message: str
    file: str = ""
    line: int = 0
    column: int = 0
    source: str = ""

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        pieces = (place, self.path, self.message)
        # Names within them may hold line feeds, which would pass for lines of their own.
        head = ": ".join(escaped_line(piece) for piece in pieces if piece)
        if not self.source.strip():
            return head
        before = len(escaped_line(self.source[: self.column - 1].ljust(self.column - 1)))
        return f"{head}\n    {escaped_line(self.source.rstrip())}\n    {' ' * before}^"


MAX_SHOWN = 20
"""Most problems that a message shows."""


def in_file_order(problems: Iterable[Problem]) -> list[Problem]:
    """Return problems by line and column, those of each file together."""
    files: dict[str, list[Problem]] = {}
    for problem in problems:
        files.setdefault(problem.file, []).append(problem)
    return [
        problem
        for own in files.values()
        for problem in sorted(own, key=lambda problem: (problem.line, problem.column))
    ]


def shown(problems: Iterable[object]) -> list[str]:
    """Return the texts of the first `MAX_SHOWN` problems, then the number of the others."""
    told = list(problems)
    left = len(told) - MAX_SHOWN
    more = [f"and {left:,} more problem{'s' if left > 1 else ''}"] if left > 0 else []
    return [*map(str, told[:MAX_SHOWN]), *more]


class SceneError(PronkError):
    """The scene is wrong; holds every problem found in it, of which its message shows the first."""

    exit_code = 3

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(shown(in_file_order(self.problems))))

    @property
    def facts(self) -> dict[str, object]:
        """Its problems."""
        return {"problems": [asdict(problem) for problem in self.problems]}


def located(error: PronkError, file: object) -> str:
    """Return the message of an error, with the file of its scene before all that has no line."""
    if isinstance(error, SimulationError):
        return "\n".join(f"{file}: {line}" for line in str(error).splitlines())
    if not isinstance(error, SceneError):
        return f"{file}: {error}"
    problems = (
        str(problem) if problem.line or problem.file == str(file) else f"{file}: {problem}"
        for problem in in_file_order(error.problems)
    )
    return "\n".join(shown(problems))


class ProductionError(PronkError):
    """Simulating, rendering or writing failed."""

    exit_code = 4


class SimulationError(ProductionError):
    """The simulation diverged or met something impossible."""


class MassError(SimulationError):
    """Mass properties were asked of what has none, such as an open surface."""


class FilmingError(ProductionError):
    """Mitsuba, the denoiser or the encoder failed."""


class ScoringError(ProductionError):
    """The score could not be written as MIDI or sound."""


class StoreError(ProductionError):
    """An output could not be written, or an earlier one not read."""


class GoldenMissing(PronkError):
    """There is no golden to compare with."""

    exit_code = 5


class CannotJudge(PronkError):
    """This machine cannot decide the comparison."""

    exit_code = 6
