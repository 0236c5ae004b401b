"""Event roll: the notes of a score on their pitches, colored by what caused them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor

import drawsvg

from audio.controller_curves import BEND_RANGE, ControllerPoint, controller_curve
from audio.notes import Note
from audio.score import Marker
from audio.time_grid import TickGrid
from pipeline.production.reports.canvas import LETTER, Canvas, Panel
from pipeline.production.reports.cause_colors import color_of
from pipeline.production.reports.colors import FAINT, INK, WARNING
from pipeline.production.reports.time_axis import GRID, Axis

HEIGHT, LEAST_ROW, MOST_ROW = 260.0, 7.0, 14.0
"""Height of a roll, about, and of one of its pitches at least and at most [pixels]."""

KEYS = 34
"""Width of the keyboard beside the roll [pixels]."""

LEAST_PITCHES = 12
BLACK = {1, 3, 6, 8, 10}

QUIET, LOUD = -40.0, 0.0
"""Levels at which a note is drawn palest and full [dBFS]."""

LEAST_WIDTH = 3.0
"""Of a note, so that the shortest is seen [pixels]."""

_WHEEL = 8192


@dataclass(frozen=True, slots=True)
class Sung:
    """A note as it is drawn.

    Attributes:
        note: of the score.
        end: when it ends [s].
        moments: what happens to it while it lasts; empty for nothing.
    """

    note: Note
    end: float
    moments: tuple[ControllerPoint, ...]

    @property
    def pitches(self) -> list[float]:
        """The pitches that it takes, bends and all."""
        return [self.note.pitch + bent(moment) for moment in self.moments] or [self.note.pitch]


def bent(moment: ControllerPoint) -> float:
    """Return by how many semitones a moment is bent."""
    return BEND_RANGE * moment.bend / _WHEEL


def sung(notes: Sequence[Note], grid: TickGrid, duration: float) -> tuple[Sung, ...]:
    """Return notes as they are drawn, the loudest last so that they lie on top.

    Args:
        notes: of a score.
        grid: of it.
        duration: of the film [s].
    """
    found = []
    for note in sorted(notes, key=lambda note: note.level):
        end = min(float(note.onset) + note.seconds, duration)
        start = grid.tick_at(note.onset)
        last = max(start + 1, round(end / float(grid.seconds(1))))
        moments = () if note.drum else controller_curve(note.event, grid, start, last)
        found.append(Sung(note, end, moments))
    return tuple(found)


def pitches_of(notes: Sequence[Sung]) -> tuple[int, int]:
    """Return the lowest and the highest pitch that a roll shows."""
    heard = [pitch for one in notes for pitch in one.pitches] or [60.0]
    low, high = floor(min(heard)) - 1, ceil(max(heard)) + 1
    more = max(LEAST_PITCHES - (high - low + 1), 0)
    low = max(low - more // 2, 0)
    return low, min(max(high, low + LEAST_PITCHES - 1), 127)


def row_of(notes: Sequence[Sung]) -> float:
    """Return the height of a pitch [pixels]."""
    low, high = pitches_of(notes)
    return min(max(HEIGHT / (high - low + 1), LEAST_ROW), MOST_ROW)


def height_of(notes: Sequence[Sung]) -> float:
    """Return the height of a roll [pixels]."""
    low, high = pitches_of(notes)
    return row_of(notes) * (high - low + 1)


class Roll:
    """A piano roll within a panel.

    Args:
        canvas: to draw on.
        panel: as wide as the axis, as high as the roll.
        axis: of time.
        notes: of the score.
    """

    def __init__(self, canvas: Canvas, panel: Panel, axis: Axis, notes: Sequence[Sung]) -> None:
        self.canvas, self.panel, self.axis, self.notes = canvas, panel, axis, notes
        self.low, self.high = pitches_of(notes)
        self._row = row_of(notes)

    def draw(self, grid: TickGrid) -> None:
        """Draw keys and notes."""
        self._keyboard()
        for one in self.notes:
            if one.moments:
                self._bent(one, grid)
            else:
                self._straight(one)

    def mark(self, marker: Marker, rate: float) -> None:
        """Draw a cut or an instruction of the script."""
        x = self.axis.at((marker.frame - 1) / rate)
        color = WARNING if marker.kind == "cut" else INK
        dashes = {"stroke": color, "stroke_width": 1, "stroke_dasharray": "5,4"}
        self.canvas.draw(drawsvg.Line(x, self.panel.y, x, self._bottom, **dashes))
        text = f"{marker.kind}: {marker.text}"
        # Near the end there is room to the left of the line alone.
        fits = x + LETTER * 11 * len(text) < self.panel.x + self.panel.width
        at, anchor = (x + 4, "start") if fits else (x - 4, "end")
        self.canvas.say(text, (at, self.panel.y + 11), 11, color, anchor, halo=True)

    @property
    def _bottom(self) -> float:
        return self.panel.y + self.panel.height

    def _y(self, pitch: float) -> float:
        """Return the upper edge of a pitch's row."""
        return self.panel.y + self._row * (self.high - pitch)

    def _keyboard(self) -> None:
        x = self.panel.x
        for pitch in range(self.low, self.high + 1):
            black, y = pitch % 12 in BLACK, self._y(pitch)
            key = "#3a424c" if black else "#ffffff"
            box = {"stroke": GRID, "stroke_width": 0.5}
            self.canvas.draw(drawsvg.Rectangle(x - KEYS, y, KEYS - 4, self._row, fill=key, **box))
            if black:
                shade = {"fill": INK, "fill_opacity": 0.035}
                self.canvas.draw(drawsvg.Rectangle(x, y, self.panel.width, self._row, **shade))
            if pitch % 12 == 0:
                self.canvas.say(
                    f"C{pitch // 12 - 1}", (x - KEYS - 5, y + 0.5 * self._row + 4), 11, FAINT, "end"
                )
                edge = {"stroke": GRID, "stroke_width": 1}
                right = x + self.panel.width
                self.canvas.draw(drawsvg.Line(x, y + self._row, right, y + self._row, **edge))

    def _straight(self, one: Sung) -> None:
        note, onset = one.note, float(one.note.onset)
        x, y = self.axis.at(onset), self._y(note.pitch)
        width = max(self.axis.scale * (one.end - onset), LEAST_WIDTH)
        width = min(width, self.panel.x + self.panel.width - x)
        words = {"fill": color_of(note.event.cause), "fill_opacity": 0.55 * _strength(note)}
        self.canvas.draw(drawsvg.Rectangle(x, y + 1, width, self._row - 2, rx=2, **words))
        # The onset stands out: it is what is exact.
        full = {"fill": color_of(note.event.cause), "fill_opacity": _strength(note)}
        tall = self._row - 2
        self.canvas.draw(drawsvg.Rectangle(x, y + 1, min(LEAST_WIDTH, width), tall, **full))

    def _bent(self, one: Sung, grid: TickGrid) -> None:
        """Draw what lasts as a line that follows its bend."""
        note = one.note
        words = {"stroke": color_of(note.event.cause), "stroke_opacity": _strength(note)}
        line = drawsvg.Path(fill="none", stroke_width=2.5, stroke_linejoin="round", **words)
        for k, moment in enumerate(one.moments):
            x = self.axis.at(float(grid.seconds(moment.tick)))
            y = self._y(note.pitch + bent(moment)) + 0.5 * self._row
            if k == 0:
                line.M(x, y)
            else:
                line.L(x, y)
        line.H(max(self.axis.at(one.end), self.axis.at(float(note.onset)) + LEAST_WIDTH))
        self.canvas.draw(line)


def legend(canvas: Canvas, notes: Sequence[Note], at: tuple[float, float], right: float) -> float:
    """List causes and how often each is heard; return the base line of the last row."""
    counts = Counter(note.event.cause for note in notes if note.is_first)
    x, y = at
    for cause, count in sorted(counts.items(), key=lambda pair: -pair[1]):
        text = f"{cause} {count}"
        width = LETTER * 14 * len(text) + 40
        if x + width > right and x > at[0]:
            x, y = at[0], y + 22
        canvas.draw(drawsvg.Rectangle(x, y - 11, 12, 12, rx=3, fill=color_of(cause)))
        canvas.say(text, (x + 18, y), 14, INK)
        x += width
    return y


def _strength(note: Note) -> float:
    return min(max((note.level - QUIET) / (LOUD - QUIET), 0.0), 1.0) * 0.75 + 0.25
