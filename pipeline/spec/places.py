"""Places: where the words of a scene stand, kept for errors that are found after its loading."""

from __future__ import annotations

import re
from dataclasses import dataclass

from pipeline.errors import Problem, SceneError
from pipeline.spec.checking import locate
from pipeline.spec.faults import Step
from pipeline.spec.tree import LONGEST_LINE, Leaf, Place, Tree

_STEP = re.compile(r"(?:^|\.)([^.\[\]]+)|\[([0-9]+)\]")

NAMING = ("figures", "nodes", "parts", "joints")
"""Mappings whose keys are names: what is wrong with an entry is wrong with its name."""


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """The file of a scene as a tree; None for a scene that was not read from text."""

    tree: Tree | None = None

    # Where words stand is no part of what they say: equal scenes may stand in different files.
    def __eq__(self, other: object) -> bool:
        return isinstance(other, Places)

    def __hash__(self) -> int:
        return 0

    def of(self, path: str) -> Place | None:
        """Return where a path of a scene stands, or the nearest word above that does.

        Args:
            path: such as `figures.bug.then[1]`.
        """
        if self.tree is None:
            return None
        steps: list[Step] = [
            int(found[2]) if found[2] else found[1].strip("'") for found in _STEP.finditer(path)
        ]
        spot = locate(self.tree, steps)
        while spot.skipped:
            steps = steps[:-1]
            spot = locate(self.tree, steps)
        if not steps:
            return Place(spot.tree.place.file)
        is_name = len(steps) > 1 and steps[-2] in NAMING and isinstance(steps[-1], str)
        return spot.key if is_name or not isinstance(spot.tree, Leaf) else spot.tree.place

    def placed(self, problem: Problem) -> Problem:
        """Return a problem with its file, line and column, if it has none and they are known."""
        place = self.of(problem.path)
        if problem.file or place is None:
            return problem
        source = place.source if len(place.source) <= LONGEST_LINE else ""
        words = problem.path, problem.message
        return Problem(*words, place.file, place.line, place.column, source)

    def located(self, error: SceneError) -> SceneError:
        """Return an error whose problems all have their places."""
        return SceneError([self.placed(problem) for problem in error.problems])
