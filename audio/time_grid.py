"""Time grids: MIDI ticks and audio samples that agree with the frames of a film.

With p / q frames a beat, a beat of k·p ticks and a frame of k·q are both whole, so every frame and
every beat is a tick. The division of the file is at most 32,767. Where a tempo needs more, the
nearest one that does not is written: frames stay whole ticks, and the beats drift by a stated
amount. Where a piece has several tempos, frames are at the nearest tick.

Without beats the grid has B frames a beat such that B·10⁶ / rate, a whole number of microseconds
a beat, makes the times that follow from the file alone equal (frame - 1) / rate.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import gcd, lcm

from audio.beat_clock import BeatClock
from audio.errors import GridError
from audio.tempo_events import TempoEvent, TempoTrack, tempo_events

SAMPLE_RATE = 48_000
"""[Hz]"""

# 24 frames and 960 ticks a beat suit all the usual rates and leave 40 ticks a frame.
_FRAMES_PER_BEAT = 24
_TICKS_PER_BEAT = 960
# Fewer ticks a frame than this make short notes coarse; the limits of the file take precedence.
_MIN_TICKS_PER_FRAME = 8
# The tempo has 24 bits, the division 15.
_MAX_TEMPO = 2**24 - 1
_MAX_DIVISION = 2**15 - 1
# Sixteenths and eighths' triplets are whole ticks too.
_SUBDIVISIONS = (12, 4, 1)
# The division of tempos that no division suits; it has many divisors.
_FINEST_DIVISION = 32_760


@dataclass(frozen=True, slots=True)
class GridSpan:
    """Frames of equal length in ticks.

    Attributes:
        frame: its start, from 0 at the start of the film; may lie between frames.
        tick: at its start.
        ticks_per_frame: may be a fraction.
    """

    frame: Fraction
    tick: int
    ticks_per_frame: Fraction


@dataclass(frozen=True, slots=True)
class Signature:
    """A meter from a tick on.

    Attributes:
        tick: of its first bar line.
        meter: beats of a bar and the note value of each.
    """

    tick: int
    meter: tuple[int, int]


@dataclass(frozen=True)
class TickGrid:
    """MIDI ticks of one film.

    Attributes:
        rate: frames a second.
        ticks_per_beat: division in the file's header.
        spans: in the order of time, the first from tick 0.
        signatures: in the order of time, the first from tick 0.
        bar_line: tick of bar 1.
        drift: by which the written tempo lengthens a beat [s].
    """

    rate: Fraction
    ticks_per_beat: int
    spans: tuple[GridSpan, ...]
    signatures: tuple[Signature, ...]
    bar_line: int = 0
    drift: Fraction = Fraction(0)

    @property
    def ticks_per_frame(self) -> Fraction:
        """Ticks a frame of the last tempo."""
        return self.spans[-1].ticks_per_frame

    @property
    def frames_per_beat(self) -> Fraction:
        """Frames a beat of the last tempo."""
        return self.ticks_per_beat / self.ticks_per_frame

    @property
    def tempo(self) -> Fraction:
        """Exact microseconds a beat of the last tempo."""
        return self._beat_length(self.spans[-1])

    def _beat_length(self, span: GridSpan) -> Fraction:
        return self.ticks_per_beat * 1_000_000 / (span.ticks_per_frame * self.rate)

    @cached_property
    def _starts(self) -> tuple[list[Fraction], list[int]]:
        return [span.frame for span in self.spans], [span.tick for span in self.spans]

    def tick(self, frame: int) -> int:
        """Return the tick at the start of a 1-based frame, the nearest where none is exact."""
        return self._tick_at(Fraction(frame - 1))

    def tick_at(self, seconds: Fraction) -> int:
        """Return the tick nearest to a time [s]."""
        return self._tick_at(seconds * self.rate)

    def _tick_at(self, frames: Fraction) -> int:
        span = self.spans[max(bisect_right(self._starts[0], frames) - 1, 0)]
        return span.tick + _round_half_up((frames - span.frame) * span.ticks_per_frame)

    def _frames_at(self, tick: int) -> Fraction:
        span = self.spans[max(bisect_right(self._starts[1], tick) - 1, 0)]
        return span.frame + (tick - span.tick) / span.ticks_per_frame

    def frame_at(self, tick: int) -> int:
        """Return the first frame that does not start before a tick."""
        position = self._frames_at(tick)
        frame = position.numerator // position.denominator + 1
        while self.tick(frame) < tick:
            frame += 1
        return frame

    def tick_of_beat(self, beat: Fraction) -> int:
        """Return the tick nearest to a beat; beat 0 is the first of bar 1."""
        return self.bar_line + _round_half_up(beat * self.ticks_per_beat)

    def seconds(self, tick: int) -> Fraction:
        """Return the time in the film of a tick [s]."""
        return self._frames_at(tick) / self.rate

    def span_tempos(self) -> Iterator[tuple[GridSpan, Fraction]]:
        """Yield the spans, and the exact microseconds a beat of each."""
        for span in self.spans:
            yield span, self._beat_length(span)

    def tempo_track(self, end: int) -> TempoTrack:
        """Return the tempo events of a file that ends at a tick."""
        bounds = [*(span.tick for span in self.spans[1:]), max(end, self.spans[-1].tick + 1)]
        events: list[TempoEvent] = []
        error = Fraction(0)
        for span, bound in zip(self.spans, bounds, strict=True):
            beats = Fraction(bound - span.tick, self.ticks_per_beat)
            added, error = tempo_events(beats, self._beat_length(span), error)
            for each in added:
                tick = span.tick + int(each.beat * self.ticks_per_beat)
                if not events or each.microseconds != events[-1].microseconds:
                    events.append(TempoEvent(tick, each.microseconds))
        return TempoTrack(self.ticks_per_beat, tuple(events))


def tick_grid(
    rate: Fraction, clock: BeatClock | None = None, bar_line: Fraction | None = None
) -> TickGrid:
    """Return the grid of a frame rate, and of the beats of a piece.

    Args:
        rate: frames a second.
        clock: beats of the piece; None for a grid without beats.
        bar_line: place of bar 1 [frames from the start of the film]; that of the clock by default.

    Raises:
        GridError: the rate is not positive, or a beat is longer than the format allows.
    """
    if rate <= 0:
        raise GridError(f"a frame rate is positive; got {rate}")
    if clock is None:
        return _even_grid(rate)
    return _beat_grid(rate, clock, clock.spans[0].time * rate if bar_line is None else bar_line)


def _even_grid(rate: Fraction) -> TickGrid:
    n, d = rate.numerator, rate.denominator
    multiple = n // gcd(n, 1_000_000 * d)
    for frames_per_beat in (_FRAMES_PER_BEAT, multiple):
        is_exact = frames_per_beat % multiple == 0
        tempo = frames_per_beat * 1_000_000 / rate
        if is_exact and 1 <= tempo <= _MAX_TEMPO and frames_per_beat <= _MAX_DIVISION:
            least = min(_MIN_TICKS_PER_FRAME, _MAX_DIVISION // frames_per_beat)
            ticks = max(_TICKS_PER_BEAT // frames_per_beat, least)
            spans = (GridSpan(Fraction(0), 0, Fraction(ticks)),)
            return TickGrid(rate, frames_per_beat * ticks, spans, (Signature(0, (4, 4)),))
    raise GridError(
        f"no MIDI tempo is exact for {rate} frames a second: a beat would need {multiple} frames "
        f"and {float(multiple * 1_000_000 / rate):.6g} µs (at most {_MAX_DIVISION} frames, "
        f"1 to {_MAX_TEMPO} µs)"
    )


def _beat_grid(rate: Fraction, clock: BeatClock, bar_line: Fraction) -> TickGrid:
    """Return the grid of beats: a pickup of whole sixteenths, then a span for each tempo."""
    lengths = [span.length * rate for span in clock.spans]
    drift = Fraction(0)
    if len(lengths) == 1:
        if lengths[0] > _MAX_DIVISION:
            raise GridError(
                f"a beat of {float(lengths[0]):.6g} frames has more frames than MIDI files have "
                f"ticks, {_MAX_DIVISION}; write a faster tempo_bpm"
            )
        written = 1 / (1 / lengths[0]).limit_denominator(_MAX_DIVISION)
        drift, lengths = (written - lengths[0]) / rate, [written]
    pickup = max(round(4 * bar_line / lengths[0]), 1) if bar_line else 0
    starts = [bar_line]
    for (earlier, later), length in zip(pairwise(clock.spans), lengths, strict=False):
        starts.append(starts[-1] + (later.beat - earlier.beat) * length)
    # What has to be whole, multiplied by the division.
    parts = [1 / length for length in lengths]
    parts += [start / length for start, length in zip(starts, lengths, strict=True)]
    bars = [Fraction(pickup, 4), *(span.beat for span in clock.spans)]
    own = [pickup / (4 * bar_line)] if pickup else []
    # Where not all can be whole, what lies before bar 1 is at the nearest tick, then bar lines are.
    wishes = ([*parts, *bars, *own], [*parts, *bars], parts)
    found = (_division(wish, lengths) for wish in wishes)
    division = next((ticks for ticks in found if ticks is not None), _FINEST_DIVISION)
    first = _round_half_up(Fraction(pickup * division, 4))
    spans = [GridSpan(Fraction(0), 0, first / bar_line)] if pickup else []
    for start, span, length in zip(starts, clock.spans, lengths, strict=True):
        tick = first + _round_half_up(span.beat * division)
        spans.append(GridSpan(start, tick, division / length))
    signatures = [*_pickup_signatures(pickup, division, clock.meters[0].meter)]
    for change in clock.meters:
        signatures.append(Signature(first + round(change.beat * division), change.meter))
    return TickGrid(rate, division, tuple(spans), tuple(signatures), first, drift)


def _division(parts: Sequence[Fraction], lengths: Sequence[Fraction]) -> int | None:
    """Return the least division that makes parts of a beat whole; None if the limit forbids it.

    Args:
        parts: of a beat.
        lengths: of beats [frames].
    """
    multiple = lcm(*(part.denominator for part in parts))
    least = max(Fraction(_TICKS_PER_BEAT), _MIN_TICKS_PER_FRAME * max(lengths))
    for subdivision in _SUBDIVISIONS:
        step = lcm(multiple, subdivision)
        division = -(-least // step) * step
        if division <= _MAX_DIVISION:
            return int(division)
    largest = _MAX_DIVISION // multiple * multiple
    return largest or None


def _pickup_signatures(
    sixteenths: int, division: int, meter: tuple[int, int]
) -> Iterator[Signature]:
    """Yield the meters before bar 1: a first bar of what whole bars leave over."""
    bar = Fraction(16 * meter[0], meter[1])
    rest = sixteenths % bar
    if rest:
        yield Signature(0, _shortest_meter(rest))
    if sixteenths > rest:
        yield Signature(int(rest * division / 4), meter)


def _shortest_meter(sixteenths: Fraction) -> tuple[int, int]:
    """Return the meter of a bar of so many sixteenths, in the longest note value."""
    for unit in (4, 8, 16, 32):
        beats = sixteenths * unit / 16
        if beats.denominator == 1:
            return int(beats), unit
    return max(round(sixteenths * 2), 1), 32


def nearest_frame_time(time: Fraction, rate: Fraction) -> Fraction:
    """Return the time of the nearest frame [s], the later of two equally near."""
    return _round_half_up(time * rate) / rate


def sample_of_frame(frame: int, rate: Fraction) -> int:
    """Return the sample nearest to the start of a 1-based frame, half a sample upward.

    The length of a sound is `sample_of_frame(frames + 1, rate)`.
    """
    return sample_at(Fraction(frame - 1) / rate)


def sample_at(seconds: Fraction) -> int:
    """Return the sample nearest to a time [s]."""
    return _round_half_up(seconds * SAMPLE_RATE)


def _round_half_up(value: Fraction) -> int:
    return (2 * value.numerator + value.denominator) // (2 * value.denominator)
