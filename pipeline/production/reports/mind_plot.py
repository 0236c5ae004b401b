"""Mind plot: anxiety, distance, focus and behaviour of all characters with a mind, over time.

Source: Horswill 2008, "Example application".
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import drawsvg
import numpy as np

from pipeline.errors import UsageError
from pipeline.production.reports.canvas import MARGIN, Canvas, Panel
from pipeline.production.reports.plot_colors import GRID, INK, LEG_COLORS, PAPER, WARNING
from pipeline.production.reports.plot_files import write_plot
from pipeline.production.reports.time_axis import Axis, draw_frames, draw_seconds
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from pipeline.production.run.scene_run import working
from pipeline.production.run.take_stage import take_of
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from pipeline.spec.behaviour import TAKE_NAMES
from pipeline.spec.character import Character

TOP, GAP = 92, 24
"""Above the first panel, and between panels [pixels]."""

LABELS, HEAD, FOOT = 92, 62, 44
"""Beside the curves, above and below them within a panel [pixels]."""

CURVES, STRIP = 120, 26
"""Height of the curves, and of a strip of names [pixels]."""

LETTER_WIDTH = 7.2
"""Mean width of a letter in a strip [pixels]."""

MAX_SECONDS, MAX_LENGTH = 60.0, 2400.0
"""Duration up to which the axis grows, and its greatest length [pixels]."""

DISTANCE_COLOR = "#2d6fb4"


@dataclass(frozen=True, eq=False)
class MindTrace:
    """The mind of one character over K rows.

    Attributes:
        name: of the character.
        anxiety: (K,) from 0 to 1.
        distance: (K,) from the caregiver [m].
        strips: title and K names each, "" for none.
    """

    name: str
    anxiety: Array
    distance: Array
    strips: tuple[tuple[str, tuple[str, ...]], ...]


def plot_mind(order: Order, reporter: Reporter) -> tuple[Path, Path]:
    """Write the mind plot of a scene into its folder as SVG and PNG.

    Raises:
        PronkError: no character has a mind, or something cannot be made.
    """
    if not any(member.has_mind for member in order.scene.characters):
        message = "nobody in the scene has a mind; give a child or an adult traits: {}"
        raise UsageError(message)
    with working(order, reporter) as run:
        take = take_of(run)
        rate = float(take.header.rate)
        traces = mind_traces(order.scene, take)
        title = take.header.title or order.name
        svg = mind_svg(title, traces, take.header.frames / rate, rate)
        return write_plot(run, "mind", svg)


def mind_traces(scene: Scene, take: Take) -> tuple[MindTrace, ...]:
    """Return the traces of all minds of a scene."""
    members = [member.name for member in scene.cast if isinstance(member, Character)]
    # Channels tell characters by their number in the order of names.
    cast = sorted(members)
    columns = {channel.name: k for k, channel in enumerate(take.channels)}

    def trace(name: str) -> MindTrace:
        def values(quantity: str) -> Array:
            return take.values[:, columns[f"{name}.{quantity}"]]

        strips = (
            ("behaviour", _named(values("behaviour"), TAKE_NAMES)),
            ("focus", _named(values("focus"), cast)),
            ("looks at", _named(values("gaze"), cast)),
        )
        return MindTrace(name, values("anxiety"), values("distance"), strips)

    return tuple(trace(name) for name in members if f"{name}.anxiety" in columns)


def _named(numbers: Array, names: Sequence[str]) -> tuple[str, ...]:
    return tuple(names[n] if n >= 0 else "" for n in np.rint(numbers).astype(int).tolist())


def mind_svg(title: str, minds: Sequence[MindTrace], duration: float, rate: float) -> str:
    """Return the plot as SVG.

    Args:
        title: of the scene.
        minds: one panel each.
        duration: of the film [s].
        rate: frames per second.
    """
    axis = Axis.fitted(MARGIN + LABELS, min(duration, MAX_SECONDS), rate)
    axis = Axis(axis.x, min(axis.length, MAX_LENGTH) / duration, duration, rate)
    width = axis.length + LABELS + 2 * MARGIN + 24
    height = HEAD + CURVES + 3 * STRIP + FOOT
    canvas = Canvas.page(width, TOP + (height + GAP) * len(minds), title)
    canvas.text("anxiety", (MARGIN, 74), 15, WARNING)
    canvas.text("distance from the caregiver", (MARGIN + 66, 74), 15, DISTANCE_COLOR)
    names = dict.fromkeys(name for mind in minds for _, row in mind.strips for name in row if name)
    colors = {name: LEG_COLORS[k % len(LEG_COLORS)] for k, name in enumerate(names)}
    for i, mind in enumerate(minds):
        panel = Panel(MARGIN, TOP + i * (height + GAP), width - 2 * MARGIN, height)
        _draw_mind(canvas, panel, mind, axis, colors)
    return canvas.svg


def _draw_mind(
    canvas: Canvas, panel: Panel, mind: MindTrace, axis: Axis, colors: dict[str, str]
) -> None:
    canvas.panel(panel)
    canvas.text(mind.name, (panel.x + 16, panel.y + 26), 17, INK, bold=True)
    top = panel.y + HEAD
    draw_seconds(canvas, axis, top, top + CURVES + 3 * STRIP)
    draw_frames(canvas, axis, top)
    floor = top + CURVES
    canvas.draw(drawsvg.Line(axis.x, floor, axis.x + axis.length, floor, stroke=GRID))
    farthest = max(float(mind.distance.max(initial=0.0)), 1.0)
    canvas.text("1", (axis.x - 8, top + 10), 12, WARNING, "end")
    if mind.distance.any():
        canvas.text(f"{farthest:.1f} m", (axis.x - 22, top + 10), 12, DISTANCE_COLOR, "end")
        _draw_curve(canvas, axis, mind.distance / farthest, floor, DISTANCE_COLOR)
    _draw_curve(canvas, axis, mind.anxiety, floor, WARNING)
    for k, (title, names) in enumerate(mind.strips):
        y = floor + k * STRIP
        canvas.text(title, (panel.x + 16, y + 18), 13, INK)
        for name, start, end in _spans(names, axis):
            width = max(end - start - 1.0, 0.5)
            canvas.draw(drawsvg.Rectangle(start, y + 4, width, STRIP - 8, fill=colors[name]))
            if len(name) * LETTER_WIDTH < end - start:
                canvas.text(name, (start + 4, y + 18), 12, PAPER)


def _draw_curve(canvas: Canvas, axis: Axis, values: Array, floor: float, color: str) -> None:
    path = drawsvg.Path(fill="none", stroke=color, stroke_width=2)
    times = np.linspace(0.0, axis.duration, len(values))
    # A point every two pixels shows all that can be seen.
    every = max(int(len(values) / max(axis.length / 2.0, 1.0)), 1)
    points = zip(times[::every].tolist(), values[::every].tolist(), strict=True)
    for k, (time, value) in enumerate(points):
        place = round(axis.at(time), 1), round(floor - (CURVES - 6) * value, 1)
        path.M(*place) if k == 0 else path.L(*place)
    canvas.draw(path)


def _spans(names: Sequence[str], axis: Axis) -> Iterator[tuple[str, float, float]]:
    """Yield each name with the x of its start and end [pixels]."""
    width = axis.length / max(len(names), 1)
    start = 0
    for k in range(1, len(names) + 1):
        if k == len(names) or names[k] != names[start]:
            if names[start]:
                yield names[start], axis.x + start * width, axis.x + k * width
            start = k
