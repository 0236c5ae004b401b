"""Figure panels: the drawing with its parts told apart, and the views of what it becomes."""

from __future__ import annotations

import io
import itertools
from collections.abc import Sequence

import drawsvg
import numpy as np
from PIL import Image

from pipeline.production.reports.canvas import Canvas, Panel
from pipeline.production.reports.colors import BODY_COLOR, FAINT, INK, PANEL, rgb
from pipeline.production.reports.figure_views import Standing
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.network import LEG
from pipeline.simulation.spatial import Array

FLOOR = 62.0
"""From the ground to the lower edge of its panel [pixels]."""


def draw_drawing(canvas: Canvas, panel: Panel, figure: Figure, colors: Sequence[str]) -> None:
    """Draw nodes and connections, each part in its color, on the axes of the editor."""
    drawing, anatomy = figure.drawing, figure.anatomy
    low, high = drawing.places.min(axis=0), drawing.places.max(axis=0)
    span = np.maximum(high - low, 2 * float(drawing.radii.max()))
    scale = float((np.array([panel.width - 130.0, panel.height - 120.0]) / span).min())
    centre = np.array([panel.x + panel.width / 2, panel.y + panel.height / 2 + 8])
    at = centre + (drawing.places - (low + high) / 2) * scale
    canvas.panel(panel, "drawing")
    _axes(canvas, panel, centre - (low + high) / 2 * scale)
    paint = [BODY_COLOR if n in anatomy.body else FAINT for n in range(len(drawing.names))]
    of_pair = dict.fromkeys(anatomy.bones, BODY_COLOR)
    for appendage, color in zip(anatomy.appendages, colors, strict=True):
        for a, b in itertools.pairwise(appendage.nodes):
            of_pair[min(a, b), max(a, b)] = paint[b] = color
    for (x, y), color, radius in zip(at, paint, drawing.radii * scale, strict=True):
        canvas.draw(drawsvg.Circle(x, y, max(float(radius), 1.0), fill=color, fill_opacity=0.13))
    for pair in drawing.connections:
        line = {"stroke": of_pair.get(pair, FAINT), "stroke_width": 5, "stroke_linecap": "round"}
        if pair not in of_pair:
            line["stroke_dasharray"] = "1 9"
        canvas.draw(drawsvg.Line(*at[pair[0]], *at[pair[1]], **line))
    for (x, y), color in zip(at, paint, strict=True):
        canvas.draw(drawsvg.Circle(x, y, 5.5, fill=PANEL, stroke=color, stroke_width=3))
        canvas.keep_free(float(x), float(y), 6.0)
    _names(canvas, panel, figure, at, colors)
    _scale_bar(canvas, panel, scale)


def _names(canvas: Canvas, panel: Panel, figure: Figure, at: Array, colors: Sequence[str]) -> None:
    """Name all limbs at their tips, and the nodes that there is room to name."""
    anatomy, names = figure.anatomy, figure.drawing.names
    limbs = zip(anatomy.appendages, figure.skeleton.limbs, colors, strict=True)
    for appendage, limb, color in limbs:
        base, tip = at[appendage.nodes[0]], at[appendage.nodes[-1]]
        away = float(tip[0] - base[0]), float(tip[1] - base[1])
        canvas.name(limb.name, (tip[0], tip[1]), 16, color, panel, away, bold=True)
    middle = panel.x + panel.width / 2
    for n in range(len(names)):
        x, y = float(at[n][0]), float(at[n][1])
        side = 1.0 if x >= middle else -1.0
        canvas.name(names[n], (x, y), 10.5, INK, panel, (side, -0.5))


def _axes(canvas: Canvas, panel: Panel, origin: Array) -> None:
    """Draw the axes of the drawing, dotted, where they cross the panel."""
    x, y = (float(value) for value in origin)
    dots = {"stroke": FAINT, "stroke_width": 1.2, "stroke_dasharray": "2 5"}
    if panel.x < x < panel.x + panel.width:
        canvas.draw(drawsvg.Line(x, panel.y + 12, x, panel.y + panel.height - 12, **dots))
    if panel.y < y < panel.y + panel.height:
        canvas.draw(drawsvg.Line(panel.x + 12, y, panel.x + panel.width - 12, y, **dots))


def _scale_bar(canvas: Canvas, panel: Panel, scale: float) -> None:
    """Draw a bar of a round length, at most a fifth of the panel long."""
    most = panel.width / 5 / scale
    power = 10.0 ** np.floor(np.log10(most))
    length = float(power * max(n for n in (1, 2, 5) if n * power <= most))
    x, y = panel.x + 18, panel.y + panel.height - 18
    canvas.draw(drawsvg.Line(x, y, x + length * scale, y, stroke=INK, stroke_width=2))
    canvas.say(f"{length:g} m", (x, y - 7), 12, INK)


def scale_of(standing: Standing, view: Array, panel: Panel) -> float:
    """Return pixels a metre at which a view fits its panel."""
    low, high = standing.bounds(view)
    room = np.array([panel.width - 110.0, panel.height - FLOOR - 50.0])
    return float((room / np.maximum(high - low, 1e-9)).min())


def draw_view(
    canvas: Canvas,
    panel: Panel,
    title: str,
    standing: Standing,
    view: Array,
    scale: float,
    colors: Sequence[str],
) -> None:
    """Draw the figure as it stands, on a line that is the ground, its limbs named.

    Args:
        canvas: the picture.
        panel: where in it.
        title: of the panel.
        standing: the figure.
        view: (3, 3) rows right, up, to the eye.
        scale: pixels a metre.
        colors: of the limbs.
    """
    canvas.panel(panel, title)
    low, high = standing.bounds(view)
    floor = panel.height - FLOOR
    middle = panel.width / 2 - (low[0] + high[0]) / 2 * scale
    origin = np.array([middle, floor + standing.ground * scale])
    inner = Panel(panel.x + 8, panel.y + 36, panel.width - 16, panel.height - 46)
    offset = np.array([8.0, 36.0])
    skeleton = standing.figure.skeleton
    paint = {link: (0, np.array(rgb(BODY_COLOR))) for link in range(len(skeleton.links))}
    for number, (limb, color) in enumerate(zip(skeleton.limbs, colors, strict=True), start=1):
        paint |= dict.fromkeys(limb.links, (number, np.array(rgb(color))))
    frame = int(inner.width), int(inner.height)
    seen = standing.picture(view, frame, origin - offset, scale, paint, np.array(rgb(PANEL)))
    stream = io.BytesIO()
    Image.fromarray(seen).save(stream, "PNG", optimize=True)
    box = inner.x, inner.y, *frame
    canvas.draw(drawsvg.Image(*box, data=stream.getvalue(), mime_type="image/png"))
    left, right, y = panel.x + 14, panel.x + panel.width - 14, panel.y + floor
    canvas.draw(drawsvg.Line(left, y, right, y, stroke=INK, stroke_width=1.4))
    _name_limbs(canvas, panel, standing, view, (origin, scale), colors)


def _name_limbs(
    canvas: Canvas,
    panel: Panel,
    standing: Standing,
    view: Array,
    placing: tuple[Array, float],
    colors: Sequence[str],
) -> None:
    """Name legs under the ground and other limbs at their tips, the nearest first."""
    origin, scale = placing
    corner = np.array([panel.x, panel.y])
    seen = standing.tips @ view.T
    tips = corner + origin + seen[:, :2] * scale * [1.0, -1.0]
    floor = panel.y + panel.height - FLOOR
    under = Panel(panel.x, floor + 6, panel.width, FLOOR - 8)
    above = Panel(panel.x, panel.y + 32, panel.width, panel.height - FLOOR - 34)
    middle = tips.mean(axis=0) if len(tips) else corner
    for i in np.argsort(-seen[:, 2], kind="stable"):
        limb, (x, y) = standing.figure.skeleton.limbs[i], (float(v) for v in tips[i])
        if limb.kind == LEG:
            canvas.name(limb.name, (x, floor + 4), 14, colors[i], under, (0.0, 1.0), bold=True)
        else:
            away = x - float(middle[0]), min(y - float(middle[1]), 0.0) - 1.0
            canvas.name(limb.name, (x, y), 14, colors[i], above, away, bold=True)
