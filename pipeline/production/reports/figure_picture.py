"""Figure picture: the drawing with its parts named, beside the figure as it stands.

One SVG; the PNG is made of the same.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import drawsvg
import numpy as np
import resvg_py
from PIL import ImageFont

from pipeline.production.reports.canvas import FONT, Canvas, Panel
from pipeline.production.reports.colors import (
    BODY_COLOR,
    FAINT,
    INK,
    PAPER,
    WARNING,
    limb_colors,
)
from pipeline.production.reports.figure_panels import draw_drawing, draw_view, scale_of
from pipeline.production.reports.figure_report import counted, headline
from pipeline.production.reports.figure_views import FRONT, SIDE, Standing
from pipeline.simulation.figures.figure import Figure

WIDTH, MARGIN, TOP, GAP = 1600, 36, 92, 20
HEIGHT, DRAWING = 660, 620
"""Height of the panels, width of the drawing's [pixels]."""

COLUMNS = 4
MOST_REMARKS = 6


def figure_svg(figure: Figure) -> str:
    """Return the picture of a figure as SVG."""
    standing = Standing(figure)
    colors = limb_colors(figure.skeleton.limbs)
    remarks = figure.anatomy.warnings[:MOST_REMARKS]
    rows = -(-(len(figure.skeleton.limbs) + 1) // COLUMNS)
    height = TOP + HEIGHT + 32 + 24 * rows + 22 * len(remarks) + MARGIN // 2
    canvas = Canvas(drawsvg.Drawing(WIDTH, height, font_family=FONT))
    canvas.draw(drawsvg.Rectangle(0, 0, WIDTH, height, fill=PAPER))
    canvas.say(figure.name, (MARGIN, 46), 30, INK, bold=True)
    canvas.say(headline(figure), (MARGIN, 74), 15, FAINT)
    draw_drawing(canvas, Panel(MARGIN, TOP, DRAWING, HEIGHT), figure, colors)
    side, front = _panels(standing)
    scale = min(scale_of(standing, SIDE, side), scale_of(standing, FRONT, front))
    draw_view(canvas, side, "from the side", standing, SIDE, scale, colors)
    draw_view(canvas, front, "from the front", standing, FRONT, scale, colors)
    y = TOP + HEIGHT + 34
    _legend(canvas, figure, colors, y)
    for i, remark in enumerate(remarks):
        text = str(remark)
        short = text if len(text) < 190 else f"{text[:187]}..."
        canvas.say(short, (MARGIN, y + 24 * rows + 22 * i), 13, WARNING)
    return str(canvas.picture.as_svg())


def png_of(svg: str) -> bytes:
    """Return an SVG as PNG, its text set in a font that is there on every machine."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "font.ttf"
        # Pillow carries a font; a system need not.
        file.write_bytes(getattr(ImageFont.load_default(16), "font_bytes", b""))
        return bytes(resvg_py.svg_to_bytes(svg_string=svg, font_files=[str(file)], zoom=1.5))


def _panels(standing: Standing) -> tuple[Panel, Panel]:
    """Return the panels of both views: side by side, or one above the other, whichever is larger.

    Both views have one scale, so that what is beside a panel is as long in the other.
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
    above = Panel(x, TOP, room, half), Panel(x, TOP + half + GAP, room, half)
    return max(
        (beside, above),
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
        canvas.say(name, (x + 20, y), 14, INK, bold=True)
        canvas.say(text, (x + 112, y), 13, FAINT)
