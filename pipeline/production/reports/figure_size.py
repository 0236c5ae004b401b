"""Figure size: how large figures stand, for authors who choose a `scale`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.errors import PronkError
from pipeline.production.reports.figure_drawing import StandingFigure
from pipeline.simulation.figure_analysis import Figure, FigureMass, build_figure
from pipeline.spec import load_figures
from pipeline.spec.name_catalogue import LIBRARY_GROUP, NameEntry, names_of
from pipeline.spec.scene_library import FIGURES, SUFFIX, library


@dataclass(frozen=True, slots=True)
class FigureSize:
    """Extent of a figure that stands in its preferred pose.

    Attributes:
        length, width, height: along its heading, across and up [m].
        legs: how many it has.
        mass: [kg].
    """

    length: float
    width: float
    height: float
    legs: int
    mass: float

    @staticmethod
    def of(figure: Figure) -> FigureSize:
        """Return the size of a figure at its scale.

        Raises:
            SceneError: its body has no surface.
        """
        vertices = np.concatenate([points for _, _, points, _ in StandingFigure(figure).solids])
        x, y, z = np.ptp(vertices, axis=0).tolist()
        mass = float(FigureMass(figure).at_rest.mass)
        return FigureSize(x, z, y, len(figure.skeleton.legs), mass)

    @property
    def text(self) -> str:
        """Its measures in words."""
        legs = "no legs" if not self.legs else "1 leg" if self.legs == 1 else f"{self.legs} legs"
        extent = f"{metres(self.length)} m long, {metres(self.width)} m wide"
        return f"{extent}, {metres(self.height)} m high, {legs}, {kilograms(self.mass)} kg"

    @property
    def facts(self) -> dict[str, Any]:
        """Its measures as JSON has them."""
        return {key: round(value, 4) for key, value in asdict(self).items()}


def metres(length: float) -> str:
    """Return a length with two significant digits, and centimetres from a metre on."""
    return f"{length:.2f}" if length >= 1.0 else f"{length:.2g}"


def kilograms(mass: float) -> str:
    """Return a mass with two significant digits or more."""
    return f"{mass:.0f}" if mass >= 10.0 else f"{mass:.2g}"


@dataclass(frozen=True, slots=True)
class ListedName:
    """A name as `pronk list` shows it.

    Attributes:
        entry: the name and its description.
        size: of a figure, None of anything else.
    """

    entry: NameEntry
    size: FigureSize | None = None

    @property
    def text(self) -> str:
        """Its description in one line."""
        return f"{self.size.text}. {self.entry.text}" if self.size else self.entry.text

    @property
    def facts(self) -> dict[str, Any]:
        """Its members as JSON has them."""
        return {**asdict(self.entry), **(self.size.facts if self.size else {})}


def listed_names(kind: str, folder: Path) -> Iterator[ListedName]:
    """Yield the names of a kind, figures with their sizes.

    Args:
        kind: as `pronk list` calls it.
        folder: of the author.

    Raises:
        UsageError: there is no such kind.
    """
    for entry in names_of(kind, folder):
        if kind != FIGURES:
            yield ListedName(entry)
            continue
        try:
            yield ListedName(entry, _size_of(entry, folder))
        except PronkError:
            wrong = f"{entry.text} (wrong: `pronk figure {entry.name}` says why)".lstrip()
            yield ListedName(NameEntry(entry.name, wrong, entry.group))


def _size_of(entry: NameEntry, folder: Path) -> FigureSize:
    """Return the size of a listed figure."""
    shelf = library() / FIGURES if entry.group == LIBRARY_GROUP else folder
    file = shelf / (entry.name + SUFFIX)
    if not file.is_file():
        file = folder / FIGURES / (entry.name + SUFFIX)
    scene, (name, *_) = load_figures(str(file))
    return FigureSize.of(build_figure(name, scene.figures[name], 1.0))


def size_table() -> str:
    """Return the sizes of the library's figures as a table in Markdown."""
    rows = []
    for listed in listed_names(FIGURES, library()):
        assert listed.size is not None
        size = listed.size
        extent = " | ".join(metres(x) for x in (size.length, size.width, size.height))
        rows.append(f"| `{listed.entry.name}` | {extent} | {size.legs} | {kilograms(size.mass)} |")
    head = "| figure | length | width | height | legs | mass |\n|---|---|---|---|---|---|"
    return "\n".join([head, *rows])
