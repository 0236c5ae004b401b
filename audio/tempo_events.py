"""Tempo events: whole microseconds a beat that follow an exact tempo closely.

The format holds a tempo as a whole number of microseconds a beat. A tempo that is none is written
as the whole numbers below and above it in turn, changed on beats just before the time that follows
from the file would be more than MAX_ERROR off.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import floor

MAX_ERROR = 8
"""Greatest error of the time that follows from the tempo events [µs]."""


@dataclass(frozen=True, slots=True)
class TempoEvent:
    """A tempo from a tick on.

    Attributes:
        tick: absolute.
        microseconds: a beat.
    """

    tick: int
    microseconds: int


@dataclass(frozen=True, slots=True)
class BeatTempo:
    """A tempo from a beat on.

    Attributes:
        beat: from the start of its span.
        microseconds: a beat.
    """

    beat: Fraction
    microseconds: int


@dataclass(frozen=True)
class TempoTrack:
    """The tempo events of a file.

    Attributes:
        division: ticks a beat.
        events: in the order of ticks, the first at 0.
    """

    division: int
    events: tuple[TempoEvent, ...]

    @cached_property
    def _times(self) -> tuple[list[int], list[int]]:
        """Ticks of the events, and their times [µs / division]."""
        ticks, times = [0], [0]
        for earlier, later in zip(self.events, self.events[1:], strict=False):
            ticks.append(later.tick)
            times.append(times[-1] + (later.tick - earlier.tick) * earlier.microseconds)
        return ticks, times

    def seconds(self, tick: int) -> Fraction:
        """Return the time of a tick as it follows from the file alone [s]."""
        ticks, times = self._times
        last = bisect_right(ticks, tick) - 1
        since = (tick - ticks[last]) * self.events[last].microseconds
        return Fraction(times[last] + since, self.division * 1_000_000)


def tempo_events(
    beats: Fraction, length: Fraction, error: Fraction
) -> tuple[list[BeatTempo], Fraction]:
    """Return the tempos of a span of beats, and the error at its end.

    Args:
        beats: of the span.
        length: exact, of a beat [µs].
        error: at its start, of the time that follows from the file [µs].
    """
    nearest = floor(length + Fraction(1, 2))
    events: list[BeatTempo] = []
    beat = Fraction(0)
    value = max(nearest, 1)
    while True:
        events.append(BeatTempo(beat, value))
        gain = value - length
        left = beats - beat
        if gain == 0:
            return events, error
        room = (MAX_ERROR - error) / gain if gain > 0 else (MAX_ERROR + error) / -gain
        whole = max(floor(room), 1)
        if whole >= left:
            return events, error + left * gain
        beat += whole
        error += whole * gain
        # The other whole number takes the error back.
        value = floor(length) if gain > 0 else floor(length) + 1
