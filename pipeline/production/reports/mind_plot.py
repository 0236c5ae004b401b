"""Mind plot: anxiety, distance, focus and behaviour of all who have a mind, over time.

One SVG; the PNG is made of the same.

Source: Horswill 2008, "Example application".
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import drawsvg
import numpy as np

from audio.atomic_file import write_if_changed
from pipeline.errors import UsageError
from pipeline.production.reports.canvas import FONT, Canvas, Panel
from pipeline.production.reports.colors import INK, LEG_COLORS, PANEL, PAPER, WARNING
from pipeline.production.reports.figure_picture import png_of
from pipeline.production.reports.time_axis import GRID, Axis, draw_frames, draw_seconds
from pipeline.production.run.order import Order
from pipeline.production.run.production import take_of, working
from pipeline.production.run.progress import Reporter
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from pipeline.spec.behaviour import NAMES
from pipeline.spec.cast import Character

MARGIN, TOP, GAP = 36, 92, 24
"""Around all, above the first panel, and between panels [pixels]."""

LABELS, HEAD, FOOT = 92, 62, 44
"""Beside the curves, above and below them within a panel [pixels]."""

CURVES, STRIP = 120, 26
"""Height of the curves, and of a strip of names [pixels]."""

LETTER = 7.2
"""Width of a letter, about [pixels]."""

FAR = "#2d6fb4"
"""Color of the distance."""


@dataclass(frozen=True, eq=False)
class Traced:
    """What went on in one mind.

    Attributes:
        name: whose.
        anxiety: (K,) from 0 to 1, a sample each.
        distance: (K,) from who cares for it [m].
        strips: title, and the name of what it was in each sample, "" for nothing.
    """

    name: str
    anxiety: Array
    distance: Array
    strips: tuple[tuple[str, tuple[str, ...]], ...]


def plot_mind(order: Order, reporter: Reporter) -> tuple[Path, Path]:
    """Write the plot of a scene's minds into its folder, simulating if need be.

    Returns:
        SVG and PNG.

    Raises:
        PronkError: nobody has a mind, or something cannot be made.
    """
    if not any(isinstance(one, Character) and one.has_mind for one in order.scene.cast):
        message = "nobody in the scene has a mind; give a child or an adult traits: {}"
        raise UsageError(message)
    with working(order, reporter) as run:
        take = take_of(run)
        rate = float(take.header.rate)
        svg = mind_svg(
            take.header.title or order.name,
            traced(order.scene, take),
            take.header.frames / rate,
            rate,
        )
        files = tuple(run.outputs.folder / f"{order.name}_mind.{end}" for end in ("svg", "png"))
        write_if_changed(files[0], svg.encode("utf-8"))
        write_if_changed(files[1], png_of(svg))
    return files[0], files[1]


def traced(scene: Scene, take: Take) -> tuple[Traced, ...]:
    """Return what went on in all minds of a scene, from its take."""
    cast = [member.name for member in scene.cast if isinstance(member, Character)]
    columns = {channel.name: k for k, channel in enumerate(take.channels)}
    found = []
    for name in cast:
        if f"{name}.anxiety" not in columns:
            continue
        values = {
            what: take.values[:, columns[f"{name}.{what}"]]
            for what in ("anxiety", "distance", "focus", "gaze", "behaviour")
        }
        found.append(
            Traced(
                name,
                values["anxiety"],
                values["distance"],
                (
                    ("behaviour", _named(values["behaviour"], NAMES)),
                    ("focus", _named(values["focus"], cast)),
                    ("looks at", _named(values["gaze"], cast)),
                ),
            )
        )
    return tuple(found)


def _named(numbers: Array, names: Sequence[str]) -> tuple[str, ...]:
    return tuple(names[n] if n >= 0 else "" for n in np.rint(numbers).astype(int).tolist())


def mind_svg(title: str, minds: Sequence[Traced], duration: float, rate: float) -> str:
    """Return the plot as SVG.

    Args:
        title: of the scene.
        minds: what went on in each.
        duration: of the film [s].
        rate: frames a second.
    """
    axis = Axis.from_(MARGIN + LABELS, min(duration, 60.0), rate)
    axis = Axis(axis.x, min(axis.length, 2400.0) / duration, duration, rate)
    width = axis.length + LABELS + 2 * MARGIN + 24
    tall = HEAD + CURVES + 3 * STRIP + FOOT
    height = TOP + (tall + GAP) * len(minds)
    canvas = Canvas(drawsvg.Drawing(width, height, font_family=FONT))
    canvas.draw(drawsvg.Rectangle(0, 0, width, height, fill=PAPER))
    canvas.say(title, (MARGIN, 46), 30, INK, bold=True)
    canvas.say("anxiety", (MARGIN, 74), 15, WARNING)
    canvas.say("distance from the caregiver", (MARGIN + 66, 74), 15, FAR)
    colors = _colors(minds)
    for i, mind in enumerate(minds):
        panel = Panel(MARGIN, TOP + i * (tall + GAP), width - 2 * MARGIN, tall)
        _draw(canvas, panel, mind, axis, colors)
    return str(canvas.picture.as_svg())


def _colors(minds: Sequence[Traced]) -> dict[str, str]:
    """Return a color for each name, in the order in which they turn up."""
    names = dict.fromkeys(name for mind in minds for _, row in mind.strips for name in row if name)
    return {name: LEG_COLORS[k % len(LEG_COLORS)] for k, name in enumerate(names)}


def _draw(canvas: Canvas, panel: Panel, mind: Traced, axis: Axis, colors: dict[str, str]) -> None:
    """Draw one mind."""
    box = panel.x, panel.y, panel.width, panel.height
    canvas.draw(drawsvg.Rectangle(*box, rx=10, fill=PANEL))
    canvas.say(mind.name, (panel.x + 16, panel.y + 26), 17, INK, bold=True)
    top = panel.y + HEAD
    bottom = top + CURVES + 3 * STRIP
    draw_seconds(canvas, axis, top, bottom)
    draw_frames(canvas, axis, top)
    floor = top + CURVES
    canvas.draw(drawsvg.Line(axis.x, floor, axis.x + axis.length, floor, stroke=GRID))
    most = max(float(mind.distance.max(initial=0.0)), 1.0)
    canvas.say("1", (axis.x - 8, top + 10), 12, WARNING, "end")
    if mind.distance.any():
        canvas.say(f"{most:.1f} m", (axis.x - 22, top + 10), 12, FAR, "end")
        _curve(canvas, axis, mind.distance / most, floor, FAR)
    _curve(canvas, axis, mind.anxiety, floor, WARNING)
    for k, (title, names) in enumerate(mind.strips):
        y = floor + k * STRIP
        canvas.say(title, (panel.x + 16, y + 18), 13, INK)
        for name, begin, end in _spans(names, axis):
            _block(canvas, name, begin, end, y, colors[name])


def _curve(canvas: Canvas, axis: Axis, values: Array, floor: float, color: str) -> None:
    path = drawsvg.Path(fill="none", stroke=color, stroke_width=2)
    times = np.linspace(0.0, axis.duration, len(values))
    # A point every two pixels shows all that can be seen.
    every = max(int(len(values) / max(axis.length / 2.0, 1.0)), 1)
    for k, (time, value) in enumerate(
        zip(times[::every].tolist(), values[::every].tolist(), strict=True)
    ):
        place = round(axis.at(time), 1), round(floor - (CURVES - 6) * value, 1)
        path.M(*place) if k == 0 else path.L(*place)
    canvas.draw(path)


def _block(canvas: Canvas, name: str, begin: float, end: float, y: float, color: str) -> None:
    canvas.draw(drawsvg.Rectangle(begin, y + 4, max(end - begin - 1.0, 0.5), STRIP - 8, fill=color))
    if len(name) * LETTER < end - begin:
        canvas.say(name, (begin + 4, y + 18), 12, PAPER)


def _spans(names: Sequence[str], axis: Axis) -> Iterator[tuple[str, float, float]]:
    """Give each name, and from where to where it lasts [pixels]."""
    each = axis.length / max(len(names), 1)
    begin = 0
    for k in range(1, len(names) + 1):
        if k == len(names) or names[k] != names[begin]:
            if names[begin]:
                yield names[begin], axis.x + begin * each, axis.x + k * each
            begin = k
