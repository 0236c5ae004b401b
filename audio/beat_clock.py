"""Beat clock: times of beats in a piece whose tempo may change at bars."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from audio.config.meter import TempoChange, bar_length, parse_meter


@dataclass(frozen=True, slots=True)
class TempoSpan:
    """Beats of one length.

    Attributes:
        beat: its first beat; beat 0 is the first of bar 1.
        time: of that beat [s].
        length: of a beat [s].
    """

    beat: Fraction
    time: Fraction
    length: Fraction


@dataclass(frozen=True, slots=True)
class MeterChange:
    """A meter from a beat on.

    Attributes:
        beat: its first beat; beat 0 is the first of bar 1.
        meter: beats of a bar and the note value of each.
    """

    beat: Fraction
    meter: tuple[int, int]


@dataclass(frozen=True, slots=True)
class BeatClock:
    """Times of beats; a beat is a quarter note.

    Attributes:
        spans: in the order of time, the first from beat 0; it holds before that, too.
        meters: in the order of time, the first from beat 0.
    """

    spans: tuple[TempoSpan, ...]
    meters: tuple[MeterChange, ...]

    def time(self, beat: Fraction) -> Fraction:
        """Return the time of a beat [s]."""
        span = self._span([each.beat for each in self.spans], beat)
        return span.time + (beat - span.beat) * span.length

    def beat(self, time: Fraction) -> Fraction:
        """Return the beat at a time [s]."""
        span = self._span([each.time for each in self.spans], time)
        return span.beat + (time - span.time) / span.length

    def _span(self, starts: Sequence[Fraction], at: Fraction) -> TempoSpan:
        return self.spans[max(bisect_right(starts, at) - 1, 0)]


def beat_clock(
    tempo: Fraction,
    origin: Fraction,
    meter: tuple[int, int] = (4, 4),
    changes: Sequence[TempoChange] = (),
) -> BeatClock:
    """Return the clock of a tempo and its changes.

    Args:
        tempo: quarter notes a minute.
        origin: time of bar 1 [s].
        meter: of bar 1.
        changes: in the order of bars.
    """
    spans = [TempoSpan(Fraction(0), origin, 60 / tempo)]
    meters = [MeterChange(Fraction(0), meter)]
    bar, beat = 1, Fraction(0)
    for change in changes:
        step = (change.bar - bar) * bar_length(meters[-1].meter)
        bar, beat = change.bar, beat + step
        if change.tempo_bpm is not None:
            last = spans[-1]
            time = last.time + (beat - last.beat) * last.length
            spans.append(TempoSpan(beat, time, 60 / Fraction(str(change.tempo_bpm))))
        if change.meter is not None:
            meters.append(MeterChange(beat, parse_meter(change.meter)))
    return BeatClock(tuple(spans), tuple(meters))
