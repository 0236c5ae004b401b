"""Story plot: the wanted and the played tension of a story, its beats, and how anxious people are.

Source: Mateas and Stern 2005, "Structuring content in the Façade interactive drama architecture".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import drawsvg
import numpy as np

from pipeline.errors import UsageError
from pipeline.production.reports.canvas import MARGIN, Canvas, Panel
from pipeline.production.reports.plot_colors import FAINT, GRID, INK, LEG_COLORS, PAPER, WARNING
from pipeline.production.reports.plot_files import write_plot
from pipeline.production.reports.time_axis import Axis, draw_frames, draw_seconds
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from pipeline.production.run.scene_run import working
from pipeline.production.run.take_stage import take_of
from pipeline.simulation.spatial import Array
from pipeline.simulation.story.tension import played_tension, wanted_tension
from pipeline.simulation.take import Take
from pipeline.spec import Scene

TOP, HEAD, FOOT, LABELS = 92, 40, 44, 92
"""Above the panel, within it above and below the drawing, and beside it [pixels]."""

CURVES, STRIP = 240, 30
"""Height of the curves and of the strip of beats [pixels]."""

MAX_LENGTH = 1800.0
"""Greatest length of the axis [pixels]."""

WANTED_COLOR = "#2d6fb4"
PLAYED_WIDTH, OTHER_WIDTH = 3, 1.5
LETTER_WIDTH = 7.2
"""Mean width of a letter in the strip [pixels]."""


@dataclass(frozen=True, eq=False)
class BeatSpan:
    """A beat that was played: its name with its choice, first and last time [s], and tension."""

    name: str
    start: float
    end: float
    tension: float


@dataclass(frozen=True, eq=False)
class StoryTrace:
    """A story over K rows.

    Attributes:
        times: (K,) of the rows [s].
        wanted: (K,) tension, None without a curve.
        played: (K,) tension that the beats give.
        beats: that were played.
        anxieties: (K,) of people with minds, by name.
    """

    times: Array
    wanted: Array | None
    played: Array
    beats: tuple[BeatSpan, ...]
    anxieties: dict[str, Array]


def plot_story(order: Order, reporter: Reporter) -> tuple[Path, Path]:
    """Write the story plot of a scene into its folder as SVG and PNG.

    Raises:
        PronkError: the scene has no beats, or something cannot be made.
    """
    if order.scene.story is None or not order.scene.story.beats:
        raise UsageError("the scene has no story; give it `story` with beats")
    with working(order, reporter) as run:
        take = take_of(run)
        svg = story_svg(take.header.title or order.name, story_trace(order.scene, take), take)
        return write_plot(run, "story", svg)


def story_trace(scene: Scene, take: Take) -> StoryTrace:
    """Return the story of a take."""
    header = take.header
    rate = float(header.rate)
    times = np.arange(len(take.positions)) / (rate * header.samples)
    seconds = 1.0 / (rate * header.steps)
    beats = tuple(
        BeatSpan(
            f"{beat.name}: {beat.choice}" if beat.choice else beat.name,
            beat.step * seconds,
            beat.end * seconds,
            beat.tension,
        )
        for beat in take.beats
        if beat.is_played
    )
    curve = scene.story.tension if scene.story is not None else ()
    wanted = np.array([wanted_tension(curve, t) for t in times.tolist()]) if curve else None
    start = float(wanted[0]) if wanted is not None else 0.0
    played = played_tension([(beat.start, beat.tension) for beat in beats], start, times)
    columns = {channel.name: k for k, channel in enumerate(take.channels)}
    anxieties = {
        member.name: take.values[:, columns[f"{member.name}.anxiety"]]
        for member in scene.characters
        if f"{member.name}.anxiety" in columns
    }
    return StoryTrace(times, wanted, played, beats, anxieties)


def story_svg(title: str, story: StoryTrace, take: Take) -> str:
    """Return the plot as SVG."""
    rate = float(take.header.rate)
    duration = take.header.frames / rate
    axis = Axis.fitted(MARGIN + LABELS, duration, rate)
    axis = Axis(axis.x, min(axis.length, MAX_LENGTH) / duration, duration, rate)
    width = axis.length + LABELS + 2 * MARGIN + 24
    height = HEAD + CURVES + STRIP + FOOT
    canvas = Canvas.page(width, TOP + height + MARGIN, title)
    colors = dict(zip(story.anxieties, LEG_COLORS * len(story.anxieties), strict=False))
    _draw_legend(canvas, story, colors)
    canvas.panel(Panel(MARGIN, TOP, width - 2 * MARGIN, height))
    top = TOP + HEAD
    floor = top + CURVES
    draw_seconds(canvas, axis, top, floor + STRIP)
    draw_frames(canvas, axis, top)
    canvas.draw(drawsvg.Line(axis.x, floor, axis.x + axis.length, floor, stroke=GRID))
    canvas.text("1", (axis.x - 8, top + 10), 12, INK, "end")
    canvas.text("0", (axis.x - 8, floor), 12, INK, "end")
    for name, anxiety in story.anxieties.items():
        _draw_curve(canvas, axis, (story.times, anxiety), floor, colors[name], OTHER_WIDTH)
    if story.wanted is not None:
        curve = story.times, story.wanted
        _draw_curve(canvas, axis, curve, floor, WANTED_COLOR, OTHER_WIDTH, "6 4")
    _draw_curve(canvas, axis, (story.times, story.played), floor, WARNING, PLAYED_WIDTH)
    _draw_beats(canvas, axis, story.beats, floor)
    return canvas.svg


def _draw_legend(canvas: Canvas, story: StoryTrace, colors: dict[str, str]) -> None:
    entries = [("tension played", WARNING)]
    if story.wanted is not None:
        entries.append(("tension wanted", WANTED_COLOR))
    entries += [(f"anxiety of {name}", colors[name]) for name in story.anxieties]
    x = float(MARGIN)
    for text, color in entries:
        canvas.text(text, (x, 74), 15, color)
        x += 9.0 * len(text) + 18


def _draw_beats(canvas: Canvas, axis: Axis, beats: Sequence[BeatSpan], floor: float) -> None:
    canvas.text("beats", (MARGIN + 16, floor + 20), 13, INK)
    for beat in beats:
        x, width = axis.at(beat.start), axis.scale * (beat.end - beat.start)
        box = (x, floor + 4, max(width - 1.0, 0.5), STRIP - 8)
        canvas.draw(drawsvg.Rectangle(*box, fill=FAINT if beat.tension < 0.5 else WARNING))
        if len(beat.name) * LETTER_WIDTH < width:
            canvas.text(beat.name, (x + 4, floor + 20), 12, PAPER)


def _draw_curve(
    canvas: Canvas,
    axis: Axis,
    curve: tuple[Array, Array],
    floor: float,
    color: str,
    width: float,
    dashes: str = "none",
) -> None:
    """Draw values (K,) from 0 to 1 over times (K,) [s]."""
    path = drawsvg.Path(fill="none", stroke=color, stroke_width=width, stroke_dasharray=dashes)
    times, values = curve
    # A point every two pixels shows all that can be seen.
    every = max(int(len(values) / max(axis.length / 2.0, 1.0)), 1)
    points = zip(times[::every].tolist(), values[::every].tolist(), strict=True)
    for k, (time, value) in enumerate(points):
        place = round(axis.at(time), 1), round(floor - CURVES * value, 1)
        path.M(*place) if k == 0 else path.L(*place)
    canvas.draw(path)
