"""Canvas: pages, panels, texts and colors of the plots, and the files that they become."""

from __future__ import annotations

import itertools
import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from hashlib import blake2b
from pathlib import Path

import drawsvg
import resvg_py
from PIL import ImageFont

from pipeline.atomic_file import write_if_changed
from pipeline.production.run.outputs import Outputs

FONT = "Aileron, Helvetica, Arial, sans-serif"

LETTER_WIDTH = 0.56
"""Mean width of a letter per font size."""

MARGIN = 36
"""Around a page [pixels]."""

BODY_COLOR = "#64748b"
INK = "#1f2933"
FAINT = "#8a94a0"
PAPER = "#fbfaf7"
PANEL = "#f1efe9"
GRID = "#d7d3c8"
WARNING = "#b4442f"

LEG_COLORS = ("#e07a3f", "#2f8f9d", "#d9a514", "#7a6cc4", "#5f9e4c", "#c2577f")
LIMB_COLORS = {
    "head": "#c8403c",
    "tail": "#8b5a9f",
    "arm": "#2d6fb4",
    "feeler": "#8f8440",
    "horn": "#7a5c3e",
    "wing": "#3f9c86",
}

CAUSE_COLORS = {
    "footfall": "#2d6fb4",
    "scuff": "#7fb0dc",
    "collision": "#c8403c",
    "roll": "#d9a514",
    "slide": "#a8842c",
    "squeak": "#5f9e4c",
    "squawk": "#3b6b34",
    "swoosh": "#2f8f9d",
    "whistle": "#74c4c9",
    "boing": "#e07a3f",
    "breath": "#c2577f",
    "cry": "#d64ba0",
    "hug": "#8e6bd1",
}
OTHER_CAUSES = ("#7a6cc4", "#8b5a9f", "#64748b", "#b5651d", "#4b8f8c")

LABEL_DIRECTIONS = ((1, 0), (-1, 0), (0, -1), (0, 1), (1, -1), (-1, -1), (1, 1), (-1, 1))
"""Where a label can stand beside a point; x to the right, y down."""

LABEL_GAPS = (9.0, 18.0)
"""Distances of a label from its point, tried in this order [pixels]."""


def limb_colors(limbs: Sequence[tuple[str, str]]) -> list[str]:
    """Return a color for each limb, given as kind and side; left and right twins share one."""
    counts: dict[tuple[str, str], int] = {}
    colors = []
    for limb in limbs:
        number = counts.get(limb, 0)
        counts[limb] = number + 1
        colors.append(LIMB_COLORS.get(limb[0]) or LEG_COLORS[number % len(LEG_COLORS)])
    return colors


def cause_color(cause: str) -> str:
    """Return the color of a cause; an unknown one always gets the same of a few."""
    if cause in CAUSE_COLORS:
        return CAUSE_COLORS[cause]
    number = blake2b(cause.encode("utf-8", "replace"), digest_size=2).digest()
    return OTHER_CAUSES[int.from_bytes(number) % len(OTHER_CAUSES)]


def rgb(color: str) -> tuple[float, float, float]:
    """Return red, green and blue, 0 to 1, of `#rrggbb`."""
    red, green, blue = (int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue


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


def png_of(svg: str) -> bytes:
    """Return an SVG as PNG, its text set in a font that every machine has."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "font.ttf"
        file.write_bytes(getattr(ImageFont.load_default(16), "font_bytes", b""))
        return bytes(resvg_py.svg_to_bytes(svg_string=svg, font_files=[str(file)], zoom=1.5))


def write_plot(outputs: Outputs, kind: str, svg: str) -> tuple[Path, Path]:
    """Write a plot into a scene's folder as SVG and PNG, and return both files."""
    return write_pictures(outputs.folder / f"{outputs.name}_{kind}", svg)


def write_pictures(stem: Path, svg: str) -> tuple[Path, Path]:
    """Write a picture as SVG and PNG, named by a path without suffix."""
    files = stem.with_name(f"{stem.name}.svg"), stem.with_name(f"{stem.name}.png")
    write_if_changed(files[0], svg.encode("utf-8"))
    write_if_changed(files[1], png_of(svg))
    return files


# --- Time axis shared by the plots: seconds below, frames above -------------------

PIXELS_PER_SECOND, MIN_LENGTH, MAX_LENGTH = 260, 1000, 6000
"""Scale of an axis, and the bounds of its length [pixels]."""

TICK_SECONDS = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)
TICK_FRAMES = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 5000, 10000)
MIN_TICK_DISTANCE = 56
"""[pixels]"""


@dataclass(frozen=True, slots=True)
class Axis:
    """Time axis of a film: left end [pixels], pixels per second, duration [s], frame rate [1/s]."""

    x: float
    scale: float
    duration: float
    rate: float

    @classmethod
    def fitted(cls, x: float, duration: float, rate: float) -> Axis:
        """Return the axis of a film, as long as reads well."""
        length = min(max(PIXELS_PER_SECOND * duration, MIN_LENGTH), MAX_LENGTH)
        return cls(x, length / duration, duration, rate)

    @property
    def length(self) -> float:
        """Width of the whole axis [pixels]."""
        return self.scale * self.duration

    def at(self, time: float) -> float:
        """Return the x of a time [pixels]."""
        return self.x + self.scale * time


def draw_seconds(canvas: Canvas, axis: Axis, top: float, bottom: float) -> None:
    """Draw lines at round times from `top` to `bottom`, labelled below."""
    step = next((s for s in TICK_SECONDS if s * axis.scale >= MIN_TICK_DISTANCE), TICK_SECONDS[-1])
    for i in range(int(axis.duration / step + 1e-9) + 1):
        x = axis.at(i * step)
        canvas.draw(drawsvg.Line(x, top, x, bottom + 5, stroke=GRID, stroke_width=1))
        canvas.text(f"{i * step:g} s", (x, bottom + 22), 12, FAINT, "middle")


def draw_frames(canvas: Canvas, axis: Axis, top: float) -> None:
    """Draw ticks at round frames, labelled above `top`."""
    every = next(
        (n for n in TICK_FRAMES if n * axis.scale / axis.rate >= MIN_TICK_DISTANCE),
        TICK_FRAMES[-1],
    )
    last = round(axis.duration * axis.rate)
    for frame in (1, *range(every, last + 1, every)):
        x = axis.at((frame - 1) / axis.rate)
        canvas.draw(drawsvg.Line(x, top - 6, x, top, stroke=FAINT, stroke_width=1))
        if frame == 1 or frame > every / 2:
            text, anchor = ("frame 1", "start") if frame == 1 else (f"{frame}", "middle")
            canvas.text(text, (x, top - 11), 12, FAINT, anchor)
