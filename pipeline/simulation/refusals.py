"""Refusals: errors of performers, so that an author is told all of them at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from pipeline.errors import Problem, SceneError, SimulationError, shown


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
            raise SceneError([*_first_of_places(located), *(Problem("", text) for text in texts)])
        if texts:
            raise SimulationError("\n".join(shown(texts)))


def _first_of_places(errors: Sequence[SceneError]) -> Iterator[Problem]:
    """Yields the problems of errors, but of a place with problems in several the first alone.

    What is wrong with a place is often the cause of what is wrong there later.
    """
    told = set[str]()
    for error in errors:
        new = [problem for problem in error.problems if problem.path not in told]
        told.update(problem.path for problem in new)
        yield from dict.fromkeys(new)
