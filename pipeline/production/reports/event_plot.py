"""Event plot: the score as a piano roll over pictures of the film, with the waveform below.

Source: Sims 1987, ch. 13.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path

import drawsvg

from audio.dsp import Signal
from audio.notes import Note, notes_of
from audio.score import Marker, Score
from audio.tempo_plan import tempo_plan
from audio.wav_file import read_waveform
from pipeline.production.reports.canvas import LETTER_WIDTH, MARGIN, Canvas, Panel
from pipeline.production.reports.piano_roll import KEYS, Roll, drawn_notes
from pipeline.production.reports.plot_colors import FAINT, GRID, INK, PANEL, WARNING, cause_color
from pipeline.production.reports.plot_files import write_plot
from pipeline.production.reports.stills import thumbnails
from pipeline.production.reports.time_axis import Axis, draw_frames, draw_seconds
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from pipeline.production.run.scene_run import working
from pipeline.production.run.score_stage import write_score
from pipeline.production.run.take_stage import take_of
from pipeline.production.shots.shot_builder import ShotBuilder


def draw_marker(canvas: Canvas, panel: Panel, axis: Axis, marker: Marker) -> None:
    """Draw a cut or an instruction of the script."""
    x = axis.at((marker.frame - 1) / axis.rate)
    color = WARNING if marker.kind == "cut" else INK
    dashes = {"stroke": color, "stroke_width": 1, "stroke_dasharray": "5,4"}
    canvas.draw(drawsvg.Line(x, panel.y, x, panel.y + panel.height, **dashes))
    text = f"{marker.kind}: {marker.text}"
    # Near the end there is room only to the left of the line.
    fits = x + LETTER_WIDTH * 11 * len(text) < panel.x + panel.width
    at, anchor = (x + 4, "start") if fits else (x - 4, "end")
    canvas.text(text, (at, panel.y + 11), 11, color, anchor, halo=True)


def draw_legend(
    canvas: Canvas, notes: Sequence[Note], at: tuple[float, float], right: float
) -> float:
    """List the causes and how often each is heard; return the base line of the last row."""
    counts = Counter(note.event.cause for note in notes if note.is_first)
    x, y = at
    for cause, count in sorted(counts.items(), key=lambda pair: -pair[1]):
        text = f"{cause} {count}"
        width = LETTER_WIDTH * 14 * len(text) + 40
        if x + width > right and x > at[0]:
            x, y = at[0], y + 22
        canvas.draw(drawsvg.Rectangle(x, y - 11, 12, 12, rx=3, fill=cause_color(cause)))
        canvas.text(text, (x + 18, y), 14, INK)
        x += width
    return y


LEFT = 62
"""Beside the axis, for the names of pitches [pixels]."""

HEADER, GAP, FOOT = 116, 14, 40
"""Above the roll with one row of causes, between panels, and below the last [pixels]."""

STRIP, WAVE = 90, 64
"""Height of the pictures, and of each side's wave [pixels]."""

WAVE_COLOR = "#41515f"


@dataclass(frozen=True, eq=False)
class EventPlot:
    """Contents of a plot.

    Attributes:
        title: of the scene.
        score: that is heard.
        notes: of the score.
        pictures: frame numbers and pictures as PNG, in order; may be empty.
        shape: width and height of a picture, in any unit.
        wave: (columns, 2, 2) least and greatest of left and right.
    """

    title: str
    score: Score
    notes: tuple[Note, ...]
    pictures: tuple[tuple[int, bytes], ...]
    shape: tuple[int, int]
    wave: Signal


def plot_events(order: Order, reporter: Reporter, pictures: bool = True) -> tuple[Path, Path]:
    """Write the event plot of a scene into its folder as SVG and PNG.

    Args:
        order: the scene.
        reporter: of progress.
        pictures: whether frames are shown.

    Raises:
        PronkError: something cannot be made.
    """
    with working(order, reporter) as run:
        take = take_of(run)
        score, _ = write_score(run, take, ShotBuilder(order.scene, take))
        shape = order.scene.film.resolved().size
        axis = axis_of(score)
        frames = shown_frames(axis, shape, score.frames) if pictures else []
        images = thumbnails(run, take, frames, STRIP) if frames else []
        plot = EventPlot(
            title=take.header.title or order.name,
            score=score,
            notes=notes_of(score),
            pictures=tuple(zip(frames, images, strict=True)),
            shape=shape,
            wave=read_waveform(run.outputs.wav, round(axis.length)),
        )
        return write_plot(run, "events", event_svg(plot))


def axis_of(score: Score) -> Axis:
    """Return the time axis of a plot."""
    rate = float(score.rate)
    return Axis.fitted(MARGIN + LEFT, score.frames / rate, rate)


def shown_frames(axis: Axis, shape: tuple[int, int], frames: int) -> list[int]:
    """Return the frames at the left edges of pictures that stand side by side below the roll."""
    width = STRIP * shape[0] / shape[1]
    count = max(ceil(axis.length / width), 1)
    starts = (int(i * width / axis.scale * axis.rate) for i in range(count))
    return sorted({1 + min(start, frames - 1) for start in starts})


def event_svg(plot: EventPlot) -> str:
    """Return the plot as SVG."""
    axis, grid = axis_of(plot.score), tempo_plan(plot.score).grid
    roll = Roll(drawn_notes(plot.notes, grid, axis.duration))
    width = axis.x + axis.length + MARGIN
    strip = STRIP + GAP if plot.pictures else 0
    # Names of causes can need several rows; they are measured on a canvas of their own.
    measured = Canvas(drawsvg.Drawing(1, 1))
    top = HEADER + draw_legend(measured, plot.notes, (MARGIN, 0), width - MARGIN)
    height = top + roll.height + GAP + strip + 2 * WAVE + FOOT
    canvas = Canvas.page(width, height, plot.title)
    if plot.notes:
        draw_legend(canvas, plot.notes, (MARGIN, 76), width - MARGIN)
    else:
        text = f"nothing is heard of {len(plot.score.events)} events"
        canvas.text(text, (MARGIN, 76), 14, FAINT)
    panel = Panel(axis.x, top, axis.length, roll.height)
    canvas.draw(drawsvg.Rectangle(panel.x, panel.y, panel.width, panel.height, fill=PANEL))
    bottom = height - FOOT
    draw_seconds(canvas, axis, top, bottom)
    draw_frames(canvas, axis, top)
    roll.draw(canvas, panel, axis, grid)
    _draw_pictures(canvas, plot, axis, top + roll.height + GAP)
    _draw_wave(canvas, plot.wave, axis, bottom - 2 * WAVE)
    for marker in plot.score.markers:
        draw_marker(canvas, panel, axis, marker)
    return canvas.svg


def _draw_pictures(canvas: Canvas, plot: EventPlot, axis: Axis, top: float) -> None:
    width = STRIP * plot.shape[0] / plot.shape[1]
    for i, (frame, picture) in enumerate(plot.pictures):
        x = axis.x + i * width
        source = {"data": picture, "mime_type": "image/png", "embed": True}
        # The last one is cut off where the film ends.
        left = axis.x + axis.length - x
        clip = drawsvg.ClipPath()
        clip.append(drawsvg.Rectangle(x, top, min(width - 2, left), STRIP))
        canvas.draw(drawsvg.Image(x, top, width - 2, STRIP, clip_path=clip, **source))
        canvas.text(f"{frame}", (x + 5, top + STRIP - 6), 11, INK, halo=True)


def _draw_wave(canvas: Canvas, wave: Signal, axis: Axis, top: float) -> None:
    """Draw the left channel above the right, on one scale."""
    peak = max(float(abs(wave).max(initial=0.0)), 1e-9)
    step = axis.length / len(wave)
    for side, name in enumerate("LR"):
        middle = top + WAVE * (side + 0.5)
        canvas.text(name, (axis.x - KEYS - 5, middle + 4), 11, FAINT, "end")
        edge = {"stroke": GRID, "stroke_width": 1}
        canvas.draw(drawsvg.Line(axis.x, middle, axis.x + axis.length, middle, **edge))
        path = drawsvg.Path(fill=WAVE_COLOR, stroke=WAVE_COLOR, stroke_width=0.6)
        scale = 0.47 * WAVE / peak
        low, high = wave[:, side, 0].tolist(), wave[:, side, 1].tolist()
        path.M(axis.x, middle)
        for k, value in enumerate(high):
            path.L(round(axis.x + (k + 0.5) * step, 1), round(middle - scale * value, 2))
        for k in range(len(low) - 1, -1, -1):
            path.L(round(axis.x + (k + 0.5) * step, 1), round(middle - scale * low[k], 2))
        canvas.draw(path.Z())
