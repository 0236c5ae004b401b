"""Figure sheet: text, facts and picture of a figure, before any scene needs it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import drawsvg
import numpy as np

from pipeline.atomic_file import make_folder
from pipeline.errors import Problem, SceneError, StoreError
from pipeline.production.reports.canvas import MARGIN, Canvas, Panel
from pipeline.production.reports.figure_drawing import (
    FRONT,
    SIDE,
    StandingFigure,
    draw_drawing,
    draw_view,
    scale_of,
)
from pipeline.production.reports.figure_report import (
    counted,
    denavit_facts,
    denavit_text,
    facts,
    headline,
    report,
)
from pipeline.production.reports.plot_colors import BODY_COLOR, FAINT, INK, WARNING, limb_colors
from pipeline.production.reports.plot_files import write_pictures
from pipeline.production.run.scene_check import remarks_on
from pipeline.simulation.figure_analysis import Figure, FigureMass, build_figure
from pipeline.spec import Scene, load_figures

WIDTH, TOP, GAP = 1600, 92, 20
"""Of the page, above its panels and between them [pixels]."""

HEIGHT, DRAWING = 660, 620
"""Height of the panels, and width of the drawing's [pixels]."""

COLUMNS = 4
MAX_REMARKS, MAX_REMARK_LENGTH = 6, 190


@dataclass(frozen=True, slots=True)
class Sheet:
    """Report on one figure.

    Attributes:
        text: for people.
        facts: the same and more, as plain values.
        files: the pictures.
    """

    text: str
    facts: dict[str, Any]
    files: tuple[Path, ...]


@dataclass(frozen=True, eq=False)
class DrawnFigure:
    """A figure as its author drew it.

    Attributes:
        figure: at the size it is drawn in.
        scene: that holds it, under its name.
        remarks: on its drawing and on how it stands, at their lines.
    """

    figure: Figure
    scene: Scene
    remarks: tuple[Problem, ...]


def drawn_figures(name: str) -> list[DrawnFigure]:
    """Return the figures of a name.

    Args:
        name: of a figure file, a shipped figure, a scene, or `scene:figure`.

    Raises:
        UsageError: no such figure.
        SceneError: a figure is wrong.
    """
    scene, names = load_figures(name)
    found = []
    try:
        for figure_name in names:
            figure = build_figure(figure_name, scene.figures[figure_name], 1.0)
            remarks = tuple(remark.problem for remark in remarks_on(scene, figure))
            found.append(DrawnFigure(figure, scene, remarks))
    except SceneError as error:
        raise scene.source_map.with_locations(error) from None
    return found


def figures_of(name: str) -> list[Figure]:
    """Return the figures of a name, see `drawn_figures`."""
    return [drawn.figure for drawn in drawn_figures(name)]


def figure_sheet(drawn: DrawnFigure, out: Path, denavit: bool = False) -> Sheet:
    """Write the pictures of a figure into a folder and return the report on it.

    Args:
        drawn: any figure.
        out: the folder.
        denavit: whether to report its Denavit-Hartenberg parameters.

    Raises:
        StoreError: the pictures cannot be written.
    """
    figure = drawn.figure
    try:
        make_folder(out)
        pictures = figure_svg(figure, drawn.remarks)
        files = write_pictures(out / figure.name.replace(" ", "_"), pictures)
    except OSError as error:
        raise StoreError(f"{out}: cannot be written ({error.strerror})") from error
    inertia = FigureMass(figure)
    text, plain = report(figure, inertia, drawn.remarks), facts(figure, inertia, drawn.remarks)
    if denavit:
        text, plain = f"{text}\n{denavit_text(figure)}", {**plain, "denavit": denavit_facts(figure)}
    return Sheet(text, plain, files)


def figure_svg(figure: Figure, remarks: Sequence[Problem] = ()) -> str:
    """Return the picture of a figure as SVG, with the first few remarks on it."""
    standing = StandingFigure(figure)
    colors = limb_colors([(limb.kind, limb.side) for limb in figure.skeleton.limbs])
    remarks = remarks[:MAX_REMARKS]
    rows = -(-(len(figure.skeleton.limbs) + 1) // COLUMNS)
    height = TOP + HEIGHT + 32 + 24 * rows + 22 * len(remarks) + MARGIN // 2
    canvas = Canvas.page(WIDTH, height, figure.name)
    canvas.text(headline(figure), (MARGIN, 74), 15, FAINT)
    draw_drawing(canvas, Panel(MARGIN, TOP, DRAWING, HEIGHT), figure, colors)
    side, front = _panels(standing)
    scale = min(scale_of(standing, SIDE, side), scale_of(standing, FRONT, front))
    draw_view(canvas, side, "from the side", standing, SIDE, scale, colors)
    draw_view(canvas, front, "from the front", standing, FRONT, scale, colors)
    y = TOP + HEIGHT + 34
    _legend(canvas, figure, colors, y)
    for i, remark in enumerate(remarks):
        text = remark.message
        short = text if len(text) < MAX_REMARK_LENGTH else f"{text[: MAX_REMARK_LENGTH - 3]}..."
        canvas.text(short, (MARGIN, y + 24 * rows + 22 * i), 13, WARNING)
    return canvas.svg


def _panels(standing: StandingFigure) -> tuple[Panel, Panel]:
    """Return the panels of both views, side by side or stacked, whichever is larger.

    Both views have one scale, so that lengths can be compared.
    """
    x = MARGIN + DRAWING + GAP
    room = WIDTH - MARGIN - x
    (low_s, high_s), (low_f, high_f) = standing.bounds(SIDE), standing.bounds(FRONT)
    shares = np.maximum([high_s[0] - low_s[0], high_f[0] - low_f[0]], 1e-9)
    width = round(float(np.clip(shares[0] / shares.sum(), 0.3, 0.7)) * (room - GAP))
    half = (HEIGHT - GAP) / 2
    beside = (
        Panel(x, TOP, width, HEIGHT),
        Panel(x + width + GAP, TOP, room - GAP - width, HEIGHT),
    )
    stacked = Panel(x, TOP, room, half), Panel(x, TOP + half + GAP, room, half)
    return max(
        (beside, stacked),
        key=lambda two: min(
            scale_of(standing, view, one) for one, view in zip(two, (SIDE, FRONT), strict=True)
        ),
    )


def _legend(canvas: Canvas, figure: Figure, colors: Sequence[str], top: float) -> None:
    """List the parts, several in a row."""
    texts = [("body", f"one solid, {counted(len(figure.anatomy.body), 'node')}", BODY_COLOR)]
    for limb, color in zip(figure.skeleton.limbs, colors, strict=True):
        links, joints = counted(len(limb.links), "link"), counted(len(limb.joints), "joint")
        texts.append((limb.name, f"{limb.kind}, {links}, {joints}, {limb.length:.3g} m", color))
    column = (WIDTH - 2 * MARGIN) / COLUMNS
    for i, (name, text, color) in enumerate(texts):
        x, y = MARGIN + column * (i % COLUMNS), top + 24 * (i // COLUMNS)
        canvas.draw(drawsvg.Circle(x + 6, y - 5, 6, fill=color))
        canvas.text(name, (x + 20, y), 14, INK, bold=True)
        canvas.text(text, (x + 112, y), 13, FAINT)
