"""Refusals: errors of performers, so that an author is told all of them at once."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pipeline.errors import Problem, SceneError, SimulationError


class Refusals:
    """Errors of several performers, raised as one at the end."""

    def __init__(self) -> None:
        self._errors: list[SceneError | SimulationError] = []

    @contextmanager
    def gathered(self) -> Iterator[None]:
        """Keeps an error of the block and goes on after it."""
        try:
            yield
        except (SceneError, SimulationError) as error:
            self._errors.append(error)

    def refuse(self) -> None:
        """Refuses the scene if there was an error.

        Raises:
            SceneError: with the problems of all errors, or another single error as it was.
            SimulationError: if no error has a place in the scene.
        """
        if len(self._errors) == 1:
            raise self._errors[0]
        located = [error for error in self._errors if isinstance(error, SceneError)]
        texts = [str(error) for error in self._errors if not isinstance(error, SceneError)]
        if located:
            problems = [problem for error in located for problem in error.problems]
            raise SceneError([*dict.fromkeys(problems), *(Problem("", text) for text in texts)])
        if texts:
            raise SimulationError("\n".join(texts))
