"""Figures that stand in files of their own, and where these are found."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from pydantic import Field

from pipeline.errors import Problem
from pipeline.spec.checking import check
from pipeline.spec.figure import Figure
from pipeline.spec.files import read_file
from pipeline.spec.nearest import hint
from pipeline.spec.shipped import FIGURES, SUFFIX, library, names_in
from pipeline.spec.tree import Leaf, Place, Row, Table, Tree
from pipeline.spec.values import NAME_PATTERN, Words


class FigureFile(Words):
    """A file that holds one figure."""

    pronk: Literal[1] = Field(description="Version of the scene language.")
    figure: Figure = Field(description="The drawing.")


@dataclass(slots=True)
class Search:
    """Looks for the figures that a scene names and does not draw.

    Attributes:
        beside: folder of the scene, None where it has none.
        scene_file: name of the file of the scene.
        problems: what is wrong with the figures and their names.
        files: names of the files that were read, in this order.
    """

    beside: Path | None
    scene_file: str
    problems: list[Problem] = field(default_factory=list)
    files: list[str] = field(default_factory=list)

    def complete(self, scene: Table) -> Table:
        """Return the scene with the drawings that it names and does not hold."""
        figures, cast = scene.get("figures"), scene.get("cast")
        if not isinstance(cast, Row) or not (figures is None or isinstance(figures, Table)):
            return scene
        drawn = figures or Table(scene.place, {})
        for i, member in enumerate(cast.items):
            figure = member.get("figure") if isinstance(member, Table) else None
            if not (isinstance(figure, Leaf) and isinstance(figure.value, str)):
                continue
            name = figure.value
            if name not in drawn.entries and re.fullmatch(NAME_PATTERN, name):
                found = self._find(name) or self._not_found(i, name, figure.place, drawn)
                drawn = drawn.having(name, found.place, found)
        return scene.having("figures", drawn.place, drawn) if drawn.entries else scene

    def _find(self, name: str) -> Tree | None:
        for path in self._places(name):
            if not path.is_file() or str(path) == self.scene_file:
                continue
            tree, problems = read_file(path)
            if tree is not None and "figure" not in tree.entries:
                # A scene may be called like the figure that plays in it.
                continue
            self.files.append(str(path))
            if tree is not None:
                problems = [*problems, *check(FigureFile, tree)[1]]
            self.problems += problems
            figure = tree.get("figure") if tree is not None else None
            return _STAND_IN if problems or figure is None else figure
        return None

    def _places(self, name: str) -> list[Path]:
        folders = [library() / FIGURES]
        if self.beside is not None:
            folders = [self.beside, self.beside / FIGURES, *folders]
        return [folder / (name + SUFFIX) for folder in folders]

    def _not_found(self, i: int, name: str, place: Place, drawn: Table) -> Tree:
        known = {*drawn.entries, *names_in(library() / FIGURES)}
        if self.beside is not None:
            known |= {*names_in(self.beside / FIGURES)}
        searched = f"{name}{SUFFIX} and {FIGURES}/{name}{SUFFIX} beside it, "
        message = (
            f"no figure is called '{name}', {hint(name, known)} (searched: this file, "
            f"{searched if self.beside is not None else ''}the library)"
        )
        self.problems.append(place.problem(("cast", i, "figure"), message))
        return _STAND_IN


_NOWHERE = Place("")
# Takes the place of a figure that is wrong or missing, which is reported once already.
_STAND_IN: Tree = Table(_NOWHERE, {}).having(
    "nodes",
    _NOWHERE,
    Table(_NOWHERE, {}).having(
        "node", _NOWHERE, Row(_NOWHERE, (Leaf(_NOWHERE, 0), Leaf(_NOWHERE, 0)))
    ),
)
