"""Gait plot: planned and actual contacts of all feet over time, one panel a creature.

One SVG; the PNG is made of the same.

Source: Sims 1987, figure 9.2.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import drawsvg

from audio.atomic_file import write_if_changed
from pipeline.production.reports.canvas import FONT, Canvas, Panel
from pipeline.production.reports.colors import FAINT, INK, PANEL, PAPER, limb_colors
from pipeline.production.reports.figure_picture import png_of
from pipeline.production.reports.gait_contacts import (
    CreatureBars,
    LegBars,
    bars_of,
    walkers_of,
)
from pipeline.production.reports.time_axis import Axis, draw_frames, draw_seconds
from pipeline.production.run.order import Order
from pipeline.production.run.production import take_of, working
from pipeline.production.run.progress import Reporter
from pipeline.simulation.spatial import Array

MARGIN, TOP, GAP = 36, 92, 24
"""Around all, above the first panel, and between panels [pixels]."""

NAMES, HEAD, FOOT = 92, 62, 44
"""Beside the bars, above and below them within a panel [pixels]."""

ROW, BAR = 30, 10
"""Height of a leg's row and of one of its two bars [pixels]."""


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
        write_if_changed(files[0], svg.encode("utf-8"))
        write_if_changed(files[1], png_of(svg))
    return files[0], files[1]


def gait_svg(title: str, creatures: Sequence[CreatureBars], duration: float, rate: float) -> str:
    """Return the plot as SVG.

    Args:
        title: of the scene.
        creatures: that walk.
        duration: of the film [s].
        rate: frames a second.
    """
    axis = Axis.from_(MARGIN + NAMES, duration, rate)
    width = axis.length + NAMES + 2 * MARGIN + 24
    heights = [HEAD + ROW * len(creature.legs) + FOOT for creature in creatures]
    height = TOP + sum(heights) + GAP * len(heights)
    canvas = Canvas(drawsvg.Drawing(width, height, font_family=FONT))
    canvas.draw(drawsvg.Rectangle(0, 0, width, height, fill=PAPER))
    canvas.say(title, (MARGIN, 46), 30, INK, bold=True)
    told = "feet on the ground: as planned by the gait (pale, above), as they were (full, below)"
    canvas.say(told, (MARGIN, 74), 15, FAINT)
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
    draw_seconds(canvas, axis, top, bottom)
    draw_frames(canvas, axis, top)
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
