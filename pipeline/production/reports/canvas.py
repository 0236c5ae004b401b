"""Figure canvas: panels, and texts that keep out of each other's way."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

import drawsvg

from pipeline.production.reports.colors import PANEL

FONT = "Aileron, Helvetica, Arial, sans-serif"
LETTER = 0.56
"""Width of a letter as a part of its height, about."""

AROUND = ((1, 0), (-1, 0), (0, -1), (0, 1), (1, -1), (-1, -1), (1, 1), (-1, 1))
"""Where a name may stand beside a point; x to the right, y down."""


@dataclass(frozen=True, slots=True)
class Panel:
    """A rectangle of the picture, from its upper left corner [pixels]."""

    x: float
    y: float
    width: float
    height: float

    def overlaps(self, other: Panel) -> bool:
        """Tell whether two rectangles have a place in common."""
        return (
            self.x < other.x + other.width
            and other.x < self.x + self.width
            and self.y < other.y + other.height
            and other.y < self.y + self.height
        )

    def holds(self, other: Panel) -> bool:
        """Tell whether another rectangle lies within this one."""
        return (
            self.x <= other.x
            and other.x + other.width <= self.x + self.width
            and self.y <= other.y
            and other.y + other.height <= self.y + self.height
        )


@dataclass(slots=True)
class Canvas:
    """A picture under way.

    Attributes:
        picture: what is drawn so far.
        taken: where there is a name or a node already.
    """

    picture: drawsvg.Drawing
    taken: list[Panel] = field(default_factory=list)

    def draw(self, shape: object) -> None:
        """Add a shape."""
        self.picture.append(shape)

    def panel(self, panel: Panel, title: str) -> None:
        """Begin a panel."""
        box = panel.x, panel.y, panel.width, panel.height
        self.draw(drawsvg.Rectangle(*box, rx=10, fill=PANEL))
        self.say(title, (panel.x + 16, panel.y + 26), 14, "#8a94a0")

    def say(
        self,
        text: str,
        at: tuple[float, float],
        size: float,
        color: str,
        anchor: str = "start",
        bold: bool = False,
        halo: bool = False,
    ) -> None:
        """Write a text on its base line; a halo keeps it readable on anything."""
        words = {"text_anchor": anchor, "font_family": FONT, "stroke_linejoin": "round"}
        if halo:
            ring = {"stroke": PANEL, "stroke_width": 4, "stroke_opacity": 0.9}
            self.draw(drawsvg.Text(text, size, *at, fill=PANEL, **words, **ring))
        # The font that is there on every machine has no bold face.
        weight = {"stroke": color, "stroke_width": 0.045 * size} if bold else {}
        self.draw(drawsvg.Text(text, size, *at, fill=color, **words, **weight))

    def keep_free(self, x: float, y: float, radius: float) -> None:
        """Let no name stand on a point."""
        self.taken.append(Panel(x - radius, y - radius, 2 * radius, 2 * radius))

    def name(
        self,
        text: str,
        at: tuple[float, float],
        size: float,
        color: str,
        within: Panel,
        towards: tuple[float, float] = (1.0, -0.5),
        bold: bool = False,
    ) -> bool:
        """Write a name beside a point, where there is room; return whether there was.

        Args:
            text: the name.
            at: the point.
            size: height of the letters.
            color: of the letters.
            within: where it must stay.
            towards: on which side of the point it stands if there is a choice.
            bold: whether it is written in bold.
        """
        width, height = LETTER * size * len(text) + 4.0, size
        ways = sorted(AROUND, key=lambda way: -_agreement(way, towards))
        for gap, (dx, dy) in itertools.product((9.0, 18.0), ways):
            x = at[0] + dx * gap - {1: 0.0, 0: width / 2, -1: width}[dx]
            y = at[1] + dy * gap - {1: 0.0, 0: height / 2, -1: height}[dy]
            box = Panel(x, y, width, height)
            if within.holds(box) and not any(box.overlaps(other) for other in self.taken):
                self.taken.append(box)
                anchor, start = (
                    ("start", x) if dx > 0 else ("end", x + width) if dx < 0 else
                    ("middle", x + width / 2)
                )  # fmt: skip
                place = (start, y + 0.86 * height)
                self.say(text, place, size, color, anchor, bold=bold, halo=True)
                return True
        return False


def _agreement(way: tuple[int, int], towards: tuple[float, float]) -> float:
    return (way[0] * towards[0] + way[1] * towards[1]) / math.hypot(*way)
