"""Figure sheet: figures told and pictured, before any scene needs them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from audio.atomic_file import write_if_changed
from pipeline.errors import SceneError, StoreError
from pipeline.production.reports.denavit_report import denavit_text
from pipeline.production.reports.figure_facts import denavit_facts, facts
from pipeline.production.reports.figure_picture import figure_svg, png_of
from pipeline.production.reports.figure_report import report
from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.spec import load_figures


@dataclass(frozen=True, slots=True)
class Sheet:
    """What is made of one figure.

    Attributes:
        text: what the analysis found.
        facts: the same and more, for other programs.
        files: the pictures.
    """

    text: str
    facts: dict[str, Any]
    files: tuple[Path, ...]


def figures_of(name: str) -> list[Figure]:
    """Return the figures that a name stands for, at the size they are drawn in.

    Args:
        name: of a figure file, a shipped figure, a scene, or `scene:figure`.

    Raises:
        UsageError: nothing is called so.
        SceneError: a figure is wrong.
    """
    scene, names = load_figures(name)
    try:
        return [build_figure(one, scene.figures[one], 1.0) for one in names]
    except SceneError as error:
        raise scene.places.located(error) from None


def figure_sheet(figure: Figure, out: Path, denavit: bool = False) -> Sheet:
    """Write the pictures of a figure into a folder and return what there is to say of it.

    Args:
        figure: any.
        out: the folder.
        denavit: whether its Denavit-Hartenberg parameters are told as well.

    Raises:
        StoreError: they cannot be written.
    """
    svg = figure_svg(figure)
    stem = figure.name.replace(" ", "_")
    files = out / f"{stem}.svg", out / f"{stem}.png"
    try:
        out.mkdir(parents=True, exist_ok=True)
        write_if_changed(files[0], svg.encode("utf-8"))
        write_if_changed(files[1], png_of(svg))
    except OSError as error:
        raise StoreError(f"{out}: cannot be written ({error.strerror})") from error
    inertia = FigureMass(figure)
    text, told = report(figure, inertia), facts(figure, inertia)
    if denavit:
        text, told = f"{text}\n{denavit_text(figure)}", {**told, "denavit": denavit_facts(figure)}
    return Sheet(text, told, files)
