"""Compile progress: a stage of its own for code that a simulation has to compile first.

Code is compiled where a simulation first calls it, in the middle of another stage, whose clock
stands still in the meantime.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pipeline.production.run.progress import Reporter, Stage
from pipeline.simulation.code_samples import code_folder, compile_all
from pipeline.simulation.compilation import CompilationObserver, observed


class CompileProgress(CompilationObserver):
    """Reports what is compiled.

    Args:
        reporter: of progress.
        waiting: stage that waits for the code, if any.

    Attributes:
        functions: number of functions compiled.
    """

    def __init__(self, reporter: Reporter, waiting: Stage | None = None) -> None:
        self.functions = 0
        self._reporter = reporter
        self._waiting = waiting
        self._stage: Stage | None = None
        self._room = ""
        self._warned = False

    def begin(self, room: str, functions: int) -> None:
        """Begin a stage, or go on with that of the same room."""
        if self._waiting is not None:
            self._waiting.pause()
        if self._room != room:
            self.close()
        if self._stage is None:
            self._room = room
            label = f"compiling the {room} simulation (once)"
            self._stage = Stage(
                self._reporter, "compile", functions, "functions", label=label, estimated=False
            )
            self._reporter.begin(self._stage)
        else:
            self._stage.total += functions
            self._stage.resume()

    def advance(self) -> None:
        """Report one more function."""
        self.functions += 1
        if self._stage is not None:
            self._stage.advance(self._stage.done + 1)

    def end(self) -> None:
        """Let the other stage go on."""
        if self._stage is not None:
            self._stage.result = f"{self._room} simulation, {self._stage.total} functions"
            self._stage.pause()
        if self._waiting is not None:
            self._waiting.resume()

    def warn(self, text: str) -> None:
        """Report once that code cannot be stored."""
        if not self._warned:
            self._reporter.note(f"warning: {text}")
        self._warned = True

    def close(self) -> None:
        """End the stage if there is one."""
        if self._stage is not None:
            self._reporter.end(self._stage)
            self._stage, self._room = None, ""


@contextmanager
def compile_progress(reporter: Reporter, waiting: Stage | None = None) -> Iterator[CompileProgress]:
    """Report what is compiled inside the block."""
    progress = CompileProgress(reporter, waiting)
    try:
        with observed(progress):
            yield progress
    finally:
        progress.close()


def compile_ahead(reporter: Reporter) -> str:
    """Compile what is not stored yet, and return a summary."""
    with compile_progress(reporter) as progress:
        compile_all()
    folder = code_folder()
    if progress.functions == 0:
        return f"{folder}: up to date"
    return f"{folder}: {progress.functions} functions compiled"
