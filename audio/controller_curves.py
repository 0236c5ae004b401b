"""Controller curves: pitch bend and expression of a sustained note as its speed changes."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log2

from audio.controller_range import BEND_RANGE
from audio.loudness_at_listener import SPEED_EXPONENT
from audio.music.piece import Bend
from audio.notes import Note
from audio.score import ScoreEvent
from audio.time_grid import TickGrid

CENTERED, FULL_EXPRESSION = 0, 127
"""Pitch bend and expression of a note without a curve."""

FULL_BEND = 8192
"""Pitch bend of the full range."""

# Half an octave for half the speed: a ball that rolls out audibly sinks but stays audible.
_SEMITONES_PER_HALVING = 6.0
# Smallest change of pitch bend that is sent, 5 cents: finer ones are inaudible.
_MIN_BEND_CHANGE = 32
# Steps of a slide [semitones].
_SLIDE_STEP = 0.1


@dataclass(frozen=True, slots=True)
class ControllerPoint:
    """Controller values from a tick on.

    Attributes:
        tick: of the change.
        bend: pitch bend, -8192 to 8191; 0 is the note's own pitch.
        expression: 0 to 127.
    """

    tick: int
    bend: int
    expression: int

    @property
    def semitones(self) -> float:
        """Pitch bend in semitones."""
        return BEND_RANGE * self.bend / FULL_BEND


def note_curve(note: Note, grid: TickGrid, start: int, end: int) -> tuple[ControllerPoint, ...]:
    """Return the controller points of a note: of its slide, or of its sustained sound.

    Args:
        note: of a score.
        grid: of the score.
        start: tick of its onset.
        end: tick of its end.
    """
    if note.drum:
        return ()
    if note.bend:
        return bend_curve(note.bend, start, end)
    return controller_curve(note.event, grid, start, end)


def controller_curve(
    event: ScoreEvent, grid: TickGrid, start: int, end: int
) -> tuple[ControllerPoint, ...]:
    """Return the controller points of a note, at most one a frame; empty for a steady sound.

    The note's own pitch and velocity are those of the greatest speed.

    Args:
        event: the sustained sound.
        grid: of the score.
        start: tick of the note's onset.
        end: tick of its end.
    """
    top = max(event.speeds, default=0.0)
    if len(event.speeds) < 2 or top <= 0.0 or event.duration <= 0.0:
        return ()
    points: list[ControllerPoint] = []
    onset, frame = grid.seconds(start), 0
    while (tick := grid.tick_at(onset + frame / grid.rate)) < end:
        elapsed = float(frame / grid.rate)
        frame += 1
        relative_speed = _interpolate(event.speeds, elapsed / event.duration) / top
        point = _controller_point(tick, relative_speed)
        if (
            not points
            or point.expression != points[-1].expression
            or abs(point.bend - points[-1].bend) >= _MIN_BEND_CHANGE
        ):
            points.append(point)
    return tuple(points)


def bend_curve(bend: Bend, start: int, end: int) -> tuple[ControllerPoint, ...]:
    """Return the controller points of a note of the music that is bent; empty for none.

    Args:
        bend: semitones at shares of its length.
        start: tick of its onset.
        end: tick of its end.
    """
    points: list[ControllerPoint] = []
    earlier = (0.0, bend[0][1] if bend else 0.0)
    for share, semitones in bend:
        change = semitones - earlier[1]
        steps = max(ceil(abs(change) / _SLIDE_STEP), 1)
        for k in range(1, steps + 1):
            at = earlier[0] + (share - earlier[0]) * k / steps
            tick = min(start + round(at * (end - start)), end - 1)
            value = _bend_value(earlier[1] + change * k / steps)
            if points and points[-1].tick == tick:
                points.pop()
            if not points or points[-1].bend != value:
                points.append(ControllerPoint(tick, value, FULL_EXPRESSION))
        earlier = share, semitones
    if points and points[0].tick > start:
        points.insert(0, ControllerPoint(start, _bend_value(bend[0][1]), FULL_EXPRESSION))
    return tuple(points)


def _bend_value(semitones: float) -> int:
    value = round(semitones / BEND_RANGE * FULL_BEND)
    return min(max(value, -FULL_BEND), FULL_BEND - 1)


def _interpolate(speeds: tuple[float, ...], fraction: float) -> float:
    """Return the speed at a fraction of the duration by linear interpolation."""
    position = min(fraction, 1.0) * (len(speeds) - 1)
    left = min(int(position), len(speeds) - 2)
    return speeds[left] + (position - left) * (speeds[left + 1] - speeds[left])


def _controller_point(tick: int, relative_speed: float) -> ControllerPoint:
    relative_speed = max(relative_speed, 1e-3)
    semitones = max(_SEMITONES_PER_HALVING * log2(relative_speed), -BEND_RANGE)
    # A synthesiser's loudness follows 40 log10(expression / 127). Source: MMA DLS 1999.
    expression = max(round(FULL_EXPRESSION * relative_speed ** (SPEED_EXPONENT / 2)), 1)
    return ControllerPoint(tick, round(semitones / BEND_RANGE * FULL_BEND), expression)
