"""Figure drawing: panels of a figure's drawing and of the figure standing, seen from two sides."""

from __future__ import annotations

import io
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import drawsvg
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pipeline.production.reports.canvas import Canvas, Panel
from pipeline.production.reports.plot_colors import BODY_COLOR, FAINT, INK, PANEL, rgb
from pipeline.production.shots.solid_preview import PreviewSolid, render_preview
from pipeline.simulation.figure_analysis import BODY, LEG, Figure, JointTree
from pipeline.simulation.spatial import Array

SIDE = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
"""View from the figure's right, so that it looks to the right. Rows: right, up, to the eye."""

FRONT = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
"""View from the front, with the figure's right on the left."""

SUPERSAMPLING = 2
"""Samples per pixel along each side."""

EYE_COLOR = np.array([0.10, 0.11, 0.13])

EYE_PART = -2
"""Number of the eyes in `PreviewSolid`, so that they have outlines of their own."""

FLOOR = 62.0
"""From the ground to the lower edge of its panel [pixels]."""


@dataclass(frozen=True, eq=False)
class StandingFigure:
    """A figure in its preferred pose.

    Attributes:
        figure: any figure.
    """

    figure: Figure

    @cached_property
    def frames(self) -> Array:
        """Frames (J, 4, 4) of the joints, relative to the body."""
        skeleton = self.figure.skeleton
        return JointTree.of(skeleton).pose(skeleton.preferred)

    @cached_property
    def solids(self) -> list[tuple[int, bool, Array, NDArray[np.uint32]]]:
        """Link, whether it is an eye, vertices (V, 3) in the body's frame [m], faces."""
        found = []
        for piece in self.figure.pieces:
            vertices = self._to_body(piece.link, piece.solid.vertices)
            found.append((piece.link, ".eye_" in piece.name, vertices, piece.solid.faces))
        return found

    @cached_property
    def tips(self) -> Array:
        """(L, 3) tips of all limbs, in the body's frame [m]."""
        limbs = self.figure.skeleton.limbs
        return np.array([self._to_body(limb.links[-1], limb.tip) for limb in limbs]).reshape(-1, 3)

    @property
    def ground(self) -> float:
        """Height of the ground below it, in the body's frame [m]."""
        return float(min(vertices[:, 1].min() for _, _, vertices, _ in self.solids))

    def _to_body(self, link: int, points: Array) -> Array:
        """Return points (..., 3) of a link from the creation frame in the body's frame [m]."""
        skeleton = self.figure.skeleton
        joint = skeleton.links[link].joint
        if joint == BODY:
            return points
        X = self.frames[joint]
        return (points - skeleton.places[joint]) @ X[:3, :3].T + X[:3, 3]

    def bounds(self, view: Array) -> tuple[Array, Array]:
        """Return the least and greatest (2,) right and up that are seen [m]."""
        seen = np.concatenate([vertices for _, _, vertices, _ in self.solids]) @ view[:2].T
        return seen.min(axis=0), seen.max(axis=0)

    def picture(
        self,
        view: Array,
        frame: tuple[int, int],
        origin: Array,
        scale: float,
        paint: dict[int, tuple[int, Array]],
        background: Array,
    ) -> NDArray[np.uint8]:
        """Return a picture (height, width, 3) of values 0 to 255.

        Args:
            view: (3, 3) rows right, up, to the eye.
            frame: width and height [pixels].
            origin: (2,) where the body's origin is seen, from the upper left [pixels].
            scale: pixels a metre.
            paint: part and color by link; outlines run between parts.
            background: (3,) 0 to 1.
        """
        solids = []
        for link, is_eye, vertices, faces in self.solids:
            seen = vertices @ view.T * scale * [1.0, -1.0, 1.0] * SUPERSAMPLING
            seen[:, :2] += origin * SUPERSAMPLING
            part, color = (EYE_PART, EYE_COLOR) if is_eye else paint[link]
            solids.append(PreviewSolid(seen, faces, color, part))
        width, height = frame
        fine = render_preview(solids, (width * SUPERSAMPLING, height * SUPERSAMPLING), background)
        coarse = fine.reshape(height, SUPERSAMPLING, width, SUPERSAMPLING, 3).mean(axis=(1, 3))
        return np.rint(coarse * 255.0).astype(np.uint8)


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
    node_colors = [BODY_COLOR if n in anatomy.body else FAINT for n in range(len(drawing.names))]
    pair_colors = dict.fromkeys(anatomy.bones, BODY_COLOR)
    for appendage, color in zip(anatomy.appendages, colors, strict=True):
        for a, b in itertools.pairwise(appendage.nodes):
            pair_colors[min(a, b), max(a, b)] = node_colors[b] = color
    for (x, y), color, radius in zip(at, node_colors, drawing.radii * scale, strict=True):
        canvas.draw(drawsvg.Circle(x, y, max(float(radius), 1.0), fill=color, fill_opacity=0.13))
    for pair in drawing.connections:
        line = {
            "stroke": pair_colors.get(pair, FAINT),
            "stroke_width": 5,
            "stroke_linecap": "round",
        }
        if pair not in pair_colors:
            line["stroke_dasharray"] = "1 9"
        canvas.draw(drawsvg.Line(*at[pair[0]], *at[pair[1]], **line))
    for (x, y), color in zip(at, node_colors, strict=True):
        canvas.draw(drawsvg.Circle(x, y, 5.5, fill=PANEL, stroke=color, stroke_width=3))
        canvas.keep_free(float(x), float(y), 6.0)
    _label_nodes(canvas, panel, figure, at, colors)
    _scale_bar(canvas, panel, scale)


def _label_nodes(
    canvas: Canvas, panel: Panel, figure: Figure, at: Array, colors: Sequence[str]
) -> None:
    """Label all limbs at their tips, and nodes where there is room."""
    anatomy, names = figure.anatomy, figure.drawing.names
    limbs = zip(anatomy.appendages, figure.skeleton.limbs, colors, strict=True)
    for appendage, limb, color in limbs:
        base, tip = at[appendage.nodes[0]], at[appendage.nodes[-1]]
        away = float(tip[0] - base[0]), float(tip[1] - base[1])
        canvas.label(limb.name, (tip[0], tip[1]), 16, color, panel, away, bold=True)
    middle = panel.x + panel.width / 2
    for n in range(len(names)):
        x, y = float(at[n][0]), float(at[n][1])
        side = 1.0 if x >= middle else -1.0
        canvas.label(names[n], (x, y), 10.5, INK, panel, (side, -0.5))


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
    longest = panel.width / 5 / scale
    power = 10.0 ** np.floor(np.log10(longest))
    length = float(power * max(n for n in (1, 2, 5) if n * power <= longest))
    x, y = panel.x + 18, panel.y + panel.height - 18
    canvas.draw(drawsvg.Line(x, y, x + length * scale, y, stroke=INK, stroke_width=2))
    canvas.text(f"{length:g} m", (x, y - 7), 12, INK)


def scale_of(standing: StandingFigure, view: Array, panel: Panel) -> float:
    """Return pixels a metre at which a view fits its panel."""
    low, high = standing.bounds(view)
    room = np.array([panel.width - 110.0, panel.height - FLOOR - 50.0])
    return float((room / np.maximum(high - low, 1e-9)).min())


def draw_view(
    canvas: Canvas,
    panel: Panel,
    title: str,
    standing: StandingFigure,
    view: Array,
    scale: float,
    colors: Sequence[str],
) -> None:
    """Draw the standing figure on a line for the ground, its limbs labelled.

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
    _label_limbs(canvas, panel, standing, view, (origin, scale), colors)


def _label_limbs(
    canvas: Canvas,
    panel: Panel,
    standing: StandingFigure,
    view: Array,
    placing: tuple[Array, float],
    colors: Sequence[str],
) -> None:
    """Label legs under the ground and other limbs at their tips, the nearest first."""
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
            canvas.label(limb.name, (x, floor + 4), 14, colors[i], under, (0.0, 1.0), bold=True)
        else:
            away = x - float(middle[0]), min(y - float(middle[1]), 0.0) - 1.0
            canvas.label(limb.name, (x, y), 14, colors[i], above, away, bold=True)
