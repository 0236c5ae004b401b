"""Gait plot: planned and actual contacts of all feet over time, one panel a creature.

One SVG; the PNG is made of the same.

Source: Sims 1987, figure 9.2.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import drawsvg

from audio.files import put
from pipeline.production.figure_canvas import FONT, Canvas, Panel
from pipeline.production.figure_colors import FAINT, INK, PANEL, PAPER, limb_colors
from pipeline.production.figure_picture import png_of
from pipeline.production.gait_bars import CreatureBars, LegBars, bars_of, walkers_of
from pipeline.production.order import Order
from pipeline.production.produce import take_of, working
from pipeline.production.reporting import Reporter
from pipeline.simulation.spatial import Array

MARGIN, TOP, GAP = 36, 92, 24
"""Around all, above the first panel, and between panels [pixels]."""

NAMES, HEAD, FOOT = 92, 62, 44
"""Beside the bars, above and below them within a panel [pixels]."""

ROW, BAR = 30, 10
"""Height of a leg's row and of one of its two bars [pixels]."""

SECOND, LEAST_WIDTH, MOST_WIDTH = 260, 1000, 6000
"""Width of a second, and of all bars at least and at most [pixels]."""

TICKS = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)
ROOM = 56
"""Least distance of ticks [pixels]."""


@dataclass(frozen=True, slots=True)
class Axis:
    """The axis of time: pixels of its begin, pixels a second, duration, frames a second."""

    x: float
    scale: float
    duration: float
    rate: float

    def at(self, time: float) -> float:
        """Return where a time stands."""
        return self.x + self.scale * time


def plot_gait(order: Order, reporter: Reporter) -> tuple[Path, Path]:
    """Write the plot of a scene's gaits into its folder, simulating if need be.

    Returns:
        SVG and PNG.

    Raises:
        PronkError: nobody walks on legs, or something cannot be made.
    """
    walkers = walkers_of(order.scene)
    with working(order, reporter) as run:
        take = take_of(run)
        rate = float(take.header.rate)
        creatures = tuple(bars_of(order.scene, walkers, take))
        svg = gait_svg(take.header.title or order.name, creatures, take.header.frames / rate, rate)
        files = tuple(run.outputs.folder / f"{order.name}_gait.{end}" for end in ("svg", "png"))
        put(files[0], svg.encode("utf-8"))
        put(files[1], png_of(svg))
    return files[0], files[1]


def gait_svg(title: str, creatures: Sequence[CreatureBars], duration: float, rate: float) -> str:
    """Return the plot as SVG.

    Args:
        title: of the scene.
        creatures: that walk.
        duration: of the film [s].
        rate: frames a second.
    """
    length = min(max(SECOND * duration, LEAST_WIDTH), MOST_WIDTH)
    width = length + NAMES + 2 * MARGIN + 24
    heights = [HEAD + ROW * len(creature.legs) + FOOT for creature in creatures]
    height = TOP + sum(heights) + GAP * len(heights)
    canvas = Canvas(drawsvg.Drawing(width, height, font_family=FONT))
    canvas.draw(drawsvg.Rectangle(0, 0, width, height, fill=PAPER))
    canvas.say(title, (MARGIN, 46), 30, INK, bold=True)
    told = "feet on the ground: as planned by the gait (pale, above), as they were (full, below)"
    canvas.say(told, (MARGIN, 74), 15, FAINT)
    axis = Axis(MARGIN + NAMES, length / duration, duration, rate)
    y = float(TOP)
    for creature, tall in zip(creatures, heights, strict=True):
        _draw(canvas, Panel(MARGIN, y, width - 2 * MARGIN, tall), creature, axis)
        y += tall + GAP
    return str(canvas.picture.as_svg())


def _draw(canvas: Canvas, panel: Panel, creature: CreatureBars, axis: Axis) -> None:
    """Draw one creature."""
    box = panel.x, panel.y, panel.width, panel.height
    canvas.draw(drawsvg.Rectangle(*box, rx=10, fill=PANEL))
    canvas.say(creature.name, (panel.x + 16, panel.y + 26), 17, INK, bold=True)
    canvas.say(creature.gait, (axis.x, panel.y + 26), 15, FAINT)
    top = panel.y + HEAD
    bottom = top + ROW * len(creature.legs)
    for x, span in _boxes(creature.flights, axis):
        canvas.draw(drawsvg.Rectangle(x, top, span, bottom - top, fill="#ffffff"))
    _scale(canvas, axis, top, bottom)
    colors = limb_colors(creature.figure.skeleton.legs)
    for i, (leg, color) in enumerate(zip(creature.legs, colors, strict=True)):
        _row(canvas, leg, color, axis, top + ROW * i, panel.x + 16)


def _row(canvas: Canvas, leg: LegBars, color: str, axis: Axis, y: float, x: float) -> None:
    canvas.say(leg.name, (x, y + 20), 14, INK, bold=True)
    rows = (leg.planned, 4.0, 0.45), (leg.actual, 4.0 + BAR + 1.0, 1.0)
    for spans, down, opacity in rows:
        for left, wide in _boxes(spans, axis):
            words = {"fill": color, "fill_opacity": opacity}
            canvas.draw(drawsvg.Rectangle(left, y + down, wide, BAR, **words))


def _boxes(spans: Array, axis: Axis) -> Iterable[tuple[float, float]]:
    """Give left edge and width of intervals, as far as the film goes [pixels]."""
    for begin, end in spans.tolist():
        last = min(end, axis.duration)
        if last > begin:
            yield axis.at(begin), axis.scale * (last - begin)


def _scale(canvas: Canvas, axis: Axis, top: float, bottom: float) -> None:
    """Draw seconds below the bars, frames above."""
    step = next((s for s in TICKS if s * axis.scale >= ROOM), TICKS[-1])
    for i in range(int(axis.duration / step + 1e-9) + 1):
        x = axis.at(i * step)
        canvas.draw(drawsvg.Line(x, top, x, bottom + 5, stroke="#d7d3c8", stroke_width=1))
        canvas.say(f"{i * step:g} s", (x, bottom + 22), 12, FAINT, "middle")
    every = next((n for n in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 5000) if
                  n * axis.scale / axis.rate >= ROOM), 10000)  # fmt: skip
    last = round(axis.duration * axis.rate)
    for frame in (1, *range(every, last + 1, every)):
        x = axis.at((frame - 1) / axis.rate)
        canvas.draw(drawsvg.Line(x, top - 6, x, top, stroke=FAINT, stroke_width=1))
        if frame == 1 or frame > every / 2:
            canvas.say(f"frame {frame}" if frame == 1 else f"{frame}", (x, top - 11), 12, FAINT,
                       "start" if frame == 1 else "middle")  # fmt: skip
