"""Event plot: what is heard as a piano roll, over pictures of the film, the waveform below.

One SVG; the PNG is made of the same.

Source: Sims 1987, ch. 13.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from pathlib import Path

import drawsvg

from audio.atomic_file import write_if_changed
from audio.dsp import Signal
from audio.notes import Note, notes_of
from audio.score import Score
from audio.time_grid import tick_grid
from audio.wav_file import read_waveform
from pipeline.production.reports.canvas import FONT, Canvas, Panel
from pipeline.production.reports.colors import FAINT, INK, PANEL, PAPER
from pipeline.production.reports.figure_picture import png_of
from pipeline.production.reports.piano_roll import KEYS, Roll, height_of, legend, sung
from pipeline.production.reports.thumbnails import thumbnails
from pipeline.production.reports.time_axis import GRID, Axis, draw_frames, draw_seconds
from pipeline.production.run.order import Order
from pipeline.production.run.production import take_of, working, write_score
from pipeline.production.run.progress import Reporter
from pipeline.production.shots.shot_builder import Shooting

MARGIN, LEFT = 36, 62
"""Around all, and beside the axis for the names of pitches [pixels]."""

HEADER, GAP, FOOT = 116, 14, 40
"""Above the roll with one row of causes, between panels, and below the last [pixels]."""

STRIP, WAVE = 90, 64
"""Height of the pictures, and of each side's wave [pixels]."""

WAVE_COLOR = "#41515f"


@dataclass(frozen=True, eq=False)
class Heard:
    """All that a plot shows.

    Attributes:
        title: of the scene.
        score: what is heard.
        notes: of the score.
        pictures: frame and its picture as PNG, in the order of frames; none if not wanted.
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
    """Write the plot of what is heard into a scene's folder, making the score if need be.

    Args:
        order: the scene.
        reporter: told how far it is.
        pictures: whether frames are shown.

    Returns:
        SVG and PNG.

    Raises:
        PronkError: something cannot be made.
    """
    with working(order, reporter) as run:
        take = take_of(run)
        score = write_score(run, take, Shooting(order.scene, take))
        shape = order.scene.film.resolved().size
        axis = axis_of(score)
        frames = shown(axis, shape, score.frames) if pictures else []
        heard = Heard(
            title=take.header.title or order.name,
            score=score,
            notes=notes_of(score),
            pictures=tuple(zip(frames, thumbnails(run, take, frames, STRIP), strict=True))
            if frames
            else (),
            shape=shape,
            wave=read_waveform(run.outputs.wav, round(axis.length)),
        )
        svg = event_svg(heard)
        files = tuple(run.outputs.folder / f"{order.name}_events.{end}" for end in ("svg", "png"))
        write_if_changed(files[0], svg.encode("utf-8"))
        write_if_changed(files[1], png_of(svg))
    return files[0], files[1]


def axis_of(score: Score) -> Axis:
    """Return the axis of a plot."""
    rate = float(score.rate)
    return Axis.from_(MARGIN + LEFT, score.frames / rate, rate)


def shown(axis: Axis, shape: tuple[int, int], frames: int) -> list[int]:
    """Return the frames whose pictures stand beside one another below the roll.

    Each is the one at the left edge of its picture.
    """
    width = STRIP * shape[0] / shape[1]
    count = max(ceil(axis.length / width), 1)
    return sorted({1 + min(int(i * width / axis.scale * axis.rate), frames - 1)
                   for i in range(count)})  # fmt: skip


def event_svg(heard: Heard) -> str:
    """Return the plot as SVG."""
    axis, grid = axis_of(heard.score), tick_grid(heard.score.rate)
    notes = sung(heard.notes, grid, axis.duration)
    width = axis.x + axis.length + MARGIN
    tall = height_of(notes)
    strip = STRIP + GAP if heard.pictures else 0
    # Names of causes may need several rows; they are measured on a canvas of their own.
    extra = legend(Canvas(drawsvg.Drawing(1, 1)), heard.notes, (MARGIN, 0), width - MARGIN)
    top = HEADER + extra
    height = top + tall + GAP + strip + 2 * WAVE + FOOT
    canvas = Canvas(drawsvg.Drawing(width, height, font_family=FONT))
    canvas.draw(drawsvg.Rectangle(0, 0, width, height, fill=PAPER))
    canvas.say(heard.title, (MARGIN, 46), 30, INK, bold=True)
    _told(canvas, heard, (MARGIN, 76), width - MARGIN)
    roll = Panel(axis.x, top, axis.length, tall)
    canvas.draw(drawsvg.Rectangle(roll.x, roll.y, roll.width, roll.height, fill=PANEL))
    bottom = height - FOOT
    draw_seconds(canvas, axis, top, bottom)
    draw_frames(canvas, axis, top)
    piano = Roll(canvas, roll, axis, notes)
    piano.draw(grid)
    _pictures(canvas, heard, axis, top + tall + GAP)
    _wave(canvas, heard.wave, axis, bottom - 2 * WAVE)
    for marker in heard.score.markers:
        piano.mark(marker, axis.rate)
    return str(canvas.picture.as_svg())


def _told(canvas: Canvas, heard: Heard, at: tuple[float, float], right: float) -> None:
    if heard.notes:
        legend(canvas, heard.notes, at, right)
        return
    canvas.say(f"nothing is heard of {len(heard.score.events)} events", at, 14, FAINT)


def _pictures(canvas: Canvas, heard: Heard, axis: Axis, top: float) -> None:
    width = STRIP * heard.shape[0] / heard.shape[1]
    for i, (frame, picture) in enumerate(heard.pictures):
        x = axis.x + i * width
        words = {"data": picture, "mime_type": "image/png", "embed": True}
        # The last one is cut off where the film ends.
        left = axis.x + axis.length - x
        clip = drawsvg.ClipPath()
        clip.append(drawsvg.Rectangle(x, top, min(width - 2, left), STRIP))
        canvas.draw(drawsvg.Image(x, top, width - 2, STRIP, clip_path=clip, **words))
        canvas.say(f"{frame}", (x + 5, top + STRIP - 6), 11, INK, halo=True)


def _wave(canvas: Canvas, wave: Signal, axis: Axis, top: float) -> None:
    """Draw left over right, on one scale."""
    most = max(float(abs(wave).max(initial=0.0)), 1e-9)
    step = axis.length / len(wave)
    for side, name in enumerate("LR"):
        middle = top + WAVE * (side + 0.5)
        canvas.say(name, (axis.x - KEYS - 5, middle + 4), 11, FAINT, "end")
        edge = {"stroke": GRID, "stroke_width": 1}
        canvas.draw(drawsvg.Line(axis.x, middle, axis.x + axis.length, middle, **edge))
        path = drawsvg.Path(fill=WAVE_COLOR, stroke=WAVE_COLOR, stroke_width=0.6)
        scale = 0.47 * WAVE / most
        low, high = wave[:, side, 0].tolist(), wave[:, side, 1].tolist()
        path.M(axis.x, middle)
        for k, value in enumerate(high):
            path.L(round(axis.x + (k + 0.5) * step, 1), round(middle - scale * value, 2))
        for k in range(len(low) - 1, -1, -1):
            path.L(round(axis.x + (k + 0.5) * step, 1), round(middle - scale * low[k], 2))
        canvas.draw(path.Z())
