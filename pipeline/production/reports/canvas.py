"""Canvas: pages, panels and texts of the plots."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

import drawsvg

from pipeline.production.reports.plot_colors import FAINT, INK, PANEL, PAPER

FONT = "Aileron, Helvetica, Arial, sans-serif"

LETTER_WIDTH = 0.56
"""Mean width of a letter per font size."""

MARGIN = 36
"""Around a page [pixels]."""

LABEL_DIRECTIONS = ((1, 0), (-1, 0), (0, -1), (0, 1), (1, -1), (-1, -1), (1, 1), (-1, 1))
"""Where a label can stand beside a point; x to the right, y down."""

LABEL_GAPS = (9.0, 18.0)
"""Distances of a label from its point, tried in this order [pixels]."""


@dataclass(frozen=True, slots=True)
class Panel:
    """A rectangle of the picture, from its upper left corner [pixels]."""

    x: float
    y: float
    width: float
    height: float

    def overlaps(self, other: Panel) -> bool:
        """Return whether two rectangles intersect."""
        return (
            self.x < other.x + other.width
            and other.x < self.x + self.width
            and self.y < other.y + other.height
            and other.y < self.y + self.height
        )

    def contains(self, other: Panel) -> bool:
        """Return whether another rectangle lies within this one."""
        return (
            self.x <= other.x
            and other.x + other.width <= self.x + self.width
            and self.y <= other.y
            and other.y + other.height <= self.y + self.height
        )


@dataclass(slots=True)
class Canvas:
    """A picture and the places in it that labels must leave free.

    Attributes:
        picture: drawn so far.
        taken: rectangles of labels and nodes.
    """

    picture: drawsvg.Drawing
    taken: list[Panel] = field(default_factory=list)

    @staticmethod
    def page(width: float, height: float, title: str) -> Canvas:
        """Return a sheet of paper with a title."""
        canvas = Canvas(drawsvg.Drawing(width, height, font_family=FONT))
        canvas.draw(drawsvg.Rectangle(0, 0, width, height, fill=PAPER))
        canvas.text(title, (MARGIN, 46), 30, INK, bold=True)
        return canvas

    @property
    def svg(self) -> str:
        """The picture as SVG."""
        return str(self.picture.as_svg())

    def draw(self, shape: object) -> None:
        """Add a shape."""
        self.picture.append(shape)

    def panel(self, panel: Panel, title: str = "") -> None:
        """Draw the background of a panel and its title."""
        box = panel.x, panel.y, panel.width, panel.height
        self.draw(drawsvg.Rectangle(*box, rx=10, fill=PANEL))
        if title:
            self.text(title, (panel.x + 16, panel.y + 26), 14, FAINT)

    def text(
        self,
        text: str,
        at: tuple[float, float],
        size: float,
        color: str,
        anchor: str = "start",
        bold: bool = False,
        halo: bool = False,
    ) -> None:
        """Write a text on its base line; a halo keeps it readable on any background."""
        style = {"text_anchor": anchor, "font_family": FONT, "stroke_linejoin": "round"}
        if halo:
            ring = {"stroke": PANEL, "stroke_width": 4, "stroke_opacity": 0.9}
            self.draw(drawsvg.Text(text, size, *at, fill=PANEL, **style, **ring))
        # Pillow's font, which every machine has, has no bold face.
        weight = {"stroke": color, "stroke_width": 0.045 * size} if bold else {}
        self.draw(drawsvg.Text(text, size, *at, fill=color, **style, **weight))

    def keep_free(self, x: float, y: float, radius: float) -> None:
        """Keep labels off a point."""
        self.taken.append(Panel(x - radius, y - radius, 2 * radius, 2 * radius))

    def label(
        self,
        text: str,
        at: tuple[float, float],
        size: float,
        color: str,
        bounds: Panel,
        towards: tuple[float, float] = (1.0, -0.5),
        bold: bool = False,
    ) -> None:
        """Write a label beside a point, unless there is no room for it.

        Args:
            text: of the label.
            at: the point.
            size: of the font.
            color: of the text.
            bounds: that contain the label.
            towards: preferred side of the point.
            bold: whether it is written in bold.
        """
        width, height = LETTER_WIDTH * size * len(text) + 4.0, size
        directions = sorted(LABEL_DIRECTIONS, key=lambda way: -_agreement(way, towards))
        for gap, (dx, dy) in itertools.product(LABEL_GAPS, directions):
            x = at[0] + dx * gap - {1: 0.0, 0: width / 2, -1: width}[dx]
            y = at[1] + dy * gap - {1: 0.0, 0: height / 2, -1: height}[dy]
            box = Panel(x, y, width, height)
            if bounds.contains(box) and not any(box.overlaps(other) for other in self.taken):
                self.taken.append(box)
                anchor = {1: "start", 0: "middle", -1: "end"}[dx]
                start = x + {1: 0.0, 0: width / 2, -1: width}[dx]
                place = (start, y + 0.86 * height)
                self.text(text, place, size, color, anchor, bold=bold, halo=True)
                return


def _agreement(direction: tuple[int, int], towards: tuple[float, float]) -> float:
    dot = direction[0] * towards[0] + direction[1] * towards[1]
    return dot / math.hypot(*direction)
