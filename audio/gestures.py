"""Gestures: what happens to a note while it sounds, as its cause goes faster and slower."""

from __future__ import annotations

from dataclasses import dataclass
from math import log2

from audio.grid import Grid
from audio.heard import SPEED_POWER
from audio.score import ScoreEvent

BEND_RANGE = 12
"""Semitones that the whole way of the pitch wheel stands for, to either side."""

CENTRED, FULL = 0, 127
"""Pitch wheel and expression of a note to which nothing happens."""

_LOWEST = -8192
# Half an octave for half the speed: what rolls out is heard to sink, and stays in hearing.
_SEMITONES_PER_HALVING = 6.0
# Of the pitch wheel, 5 cents: finer changes cost messages and are not heard.
_FINE = 32


@dataclass(frozen=True, slots=True)
class Moment:
    """Where the controllers of a sounding note stand from a tick on.

    Attributes:
        tick: from which on.
        bend: of the pitch wheel, -8192 to 8191; 0 is the note's own pitch.
        expression: of the controller of that name, 0 to 127.
    """

    tick: int
    bend: int
    expression: int


def gesture_of(event: ScoreEvent, grid: Grid, start: int, end: int) -> tuple[Moment, ...]:
    """Return the moments of a note, a frame apart where something changes; empty if nothing does.

    The note's own pitch and velocity are those of the greatest speed.

    Args:
        event: what lasts.
        grid: of the score.
        start: tick of the note's onset.
        end: tick of its end.
    """
    top = max(event.speeds, default=0.0)
    if len(event.speeds) < 2 or top <= 0.0 or event.duration <= 0.0:
        return ()
    moments: list[Moment] = []
    length = grid.ticks(event.duration)
    for tick in range(start, end, grid.ticks_per_frame):
        moment = _moment(tick, _between(event.speeds, (tick - start) / length) / top)
        if not moments or _differ(moment, moments[-1]):
            moments.append(moment)
    return tuple(moments)


def _between(speeds: tuple[float, ...], part: float) -> float:
    """Return the speed at a part of the duration, 0 to 1, on straight lines between rows."""
    at = min(part, 1.0) * (len(speeds) - 1)
    left = min(int(at), len(speeds) - 2)
    return speeds[left] + (at - left) * (speeds[left + 1] - speeds[left])


def _moment(tick: int, share: float) -> Moment:
    share = max(share, 1e-3)
    semitones = max(_SEMITONES_PER_HALVING * log2(share), -BEND_RANGE)
    # Loudness follows 40 log10(expression / 127) in a player. Source: MMA DLS 1999.
    expression = max(round(FULL * share ** (SPEED_POWER / 2)), 1)
    return Moment(tick, round(semitones / BEND_RANGE * -_LOWEST), expression)


def _differ(moment: Moment, last: Moment) -> bool:
    return moment.expression != last.expression or abs(moment.bend - last.bend) >= _FINE
