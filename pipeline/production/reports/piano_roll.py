"""Piano roll: the notes of a score on their pitches, colored by their causes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor

import drawsvg

from audio.controller_curves import ControllerPoint, note_curve
from audio.notes import Note
from audio.time_grid import TickGrid
from pipeline.production.reports.canvas import Canvas, Panel
from pipeline.production.reports.plot_colors import FAINT, GRID, INK, cause_color
from pipeline.production.reports.time_axis import Axis

HEIGHT, MIN_ROW, MAX_ROW = 260.0, 7.0, 14.0
"""Height of a roll, about, and bounds of the height of one pitch [pixels]."""

KEYS = 34
"""Width of the keyboard beside the roll [pixels]."""

MIN_PITCHES = 12
BLACK_KEYS = {1, 3, 6, 8, 10}

PALEST_LEVEL, FULL_LEVEL = -40.0, 0.0
"""Levels of the palest and of fully opaque notes [dBFS]."""

MIN_NOTE_WIDTH = 3.0
"""Width of the shortest note [pixels]."""


@dataclass(frozen=True, slots=True)
class DrawnNote:
    """A note with its course over time.

    Attributes:
        note: of the score.
        end: of the note [s].
        moments: gestures while it lasts; may be empty.
    """

    note: Note
    end: float
    moments: tuple[ControllerPoint, ...]

    @property
    def pitches(self) -> list[float]:
        """Its pitches, bends included."""
        return [self.note.pitch + moment.semitones for moment in self.moments] or [self.note.pitch]


def drawn_notes(notes: Sequence[Note], grid: TickGrid, duration: float) -> tuple[DrawnNote, ...]:
    """Return notes as they are drawn, the loudest last, on top.

    Args:
        notes: of a score.
        grid: of it.
        duration: of the film [s].
    """
    found = []
    for note in sorted(notes, key=lambda note: note.level):
        end = min(float(note.onset) + note.seconds, duration)
        start = grid.tick_at(note.onset)
        last = max(start + 1, grid.tick_at(Fraction(end)))
        found.append(DrawnNote(note, end, note_curve(note, grid, start, last)))
    return tuple(found)


class Roll:
    """A piano roll; its height follows from the pitches of its notes."""

    def __init__(self, notes: Sequence[DrawnNote]) -> None:
        self.notes = notes
        heard = [pitch for drawn in notes for pitch in drawn.pitches] or [60.0]
        low, high = floor(min(heard)) - 1, ceil(max(heard)) + 1
        self.low = max(low - max(MIN_PITCHES - (high - low + 1), 0) // 2, 0)
        self.high = min(max(high, self.low + MIN_PITCHES - 1), 127)
        self._row = min(max(HEIGHT / (self.high - self.low + 1), MIN_ROW), MAX_ROW)

    @property
    def height(self) -> float:
        """Height of the roll [pixels]."""
        return self._row * (self.high - self.low + 1)

    def draw(self, canvas: Canvas, panel: Panel, axis: Axis, grid: TickGrid) -> None:
        """Draw keys and notes into a panel as long as the axis and as high as the roll."""
        self._draw_keyboard(canvas, panel)
        for drawn in self.notes:
            if drawn.moments:
                self._draw_bent(canvas, panel, axis, drawn, grid)
            else:
                self._draw_straight(canvas, panel, axis, drawn)

    def _y(self, panel: Panel, pitch: float) -> float:
        """Return the upper edge of a pitch's row."""
        return panel.y + self._row * (self.high - pitch)

    def _draw_keyboard(self, canvas: Canvas, panel: Panel) -> None:
        x, row = panel.x, self._row
        for pitch in range(self.low, self.high + 1):
            black, y = pitch % 12 in BLACK_KEYS, self._y(panel, pitch)
            key = "#3a424c" if black else "#ffffff"
            box = {"stroke": GRID, "stroke_width": 0.5}
            canvas.draw(drawsvg.Rectangle(x - KEYS, y, KEYS - 4, row, fill=key, **box))
            if black:
                shade = {"fill": INK, "fill_opacity": 0.035}
                canvas.draw(drawsvg.Rectangle(x, y, panel.width, row, **shade))
            if pitch % 12 == 0:
                label = f"C{pitch // 12 - 1}"
                canvas.text(label, (x - KEYS - 5, y + 0.5 * row + 4), 11, FAINT, "end")
                edge = {"stroke": GRID, "stroke_width": 1}
                canvas.draw(drawsvg.Line(x, y + row, x + panel.width, y + row, **edge))

    def _draw_straight(self, canvas: Canvas, panel: Panel, axis: Axis, drawn: DrawnNote) -> None:
        note, onset = drawn.note, float(drawn.note.onset)
        color, height = cause_color(note.event.cause), self._row - 2
        x, y = axis.at(onset), self._y(panel, note.pitch) + 1
        width = max(axis.scale * (drawn.end - onset), MIN_NOTE_WIDTH)
        width = min(width, panel.x + panel.width - x)
        body = {"fill": color, "fill_opacity": 0.55 * _opacity(note)}
        canvas.draw(drawsvg.Rectangle(x, y, width, height, rx=2, **body))
        # The onset stands out because it is exact.
        onset_style = {"fill": color, "fill_opacity": _opacity(note)}
        canvas.draw(drawsvg.Rectangle(x, y, min(MIN_NOTE_WIDTH, width), height, **onset_style))

    def _draw_bent(
        self, canvas: Canvas, panel: Panel, axis: Axis, drawn: DrawnNote, grid: TickGrid
    ) -> None:
        """Draw a lasting note as a line that follows its bend."""
        note = drawn.note
        style = {"stroke": cause_color(note.event.cause), "stroke_opacity": _opacity(note)}
        line = drawsvg.Path(fill="none", stroke_width=2.5, stroke_linejoin="round", **style)
        for k, moment in enumerate(drawn.moments):
            x = axis.at(float(grid.seconds(moment.tick)))
            y = self._y(panel, note.pitch + moment.semitones) + 0.5 * self._row
            line.M(x, y) if k == 0 else line.L(x, y)
        line.H(max(axis.at(drawn.end), axis.at(float(note.onset)) + MIN_NOTE_WIDTH))
        canvas.draw(line)


def _opacity(note: Note) -> float:
    level = (note.level - PALEST_LEVEL) / (FULL_LEVEL - PALEST_LEVEL)
    return min(max(level, 0.0), 1.0) * 0.75 + 0.25
