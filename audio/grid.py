"""The exact grid on which frames, ticks and samples meet.

A beat holds B frames and a frame k ticks, so a beat has B·k ticks and lasts B / rate seconds.
Tempo is a whole number of microseconds a beat, hence a grid is exact where B·10⁶ / rate is an
integer: every frame is then a whole tick whose time, computed from the file alone, is
(frame - 1) / rate as a fraction. B must be a multiple of n / gcd(n, 10⁶·d) for a rate n / d.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import gcd

from audio.errors import GridError

SAMPLE_RATE = 48_000

# 24 frames and 960 ticks a beat suit all the usual rates and leave 40 ticks a frame.
_FRAMES_PER_BEAT = 24
_TICKS_PER_BEAT = 960
# Fewer ticks a frame than this make short notes coarse; the file's limits come first.
_FINE = 8
# The tempo has 24 bits, the division 15.
_MAX_TEMPO = 2**24 - 1
_MAX_DIVISION = 2**15 - 1


@dataclass(frozen=True, slots=True)
class Grid:
    """The notes' grid for one frame rate.

    Attributes:
        rate: frames a second.
        frames_per_beat: B.
        ticks_per_frame: k.
    """

    rate: Fraction
    frames_per_beat: int
    ticks_per_frame: int

    @property
    def ticks_per_beat(self) -> int:
        """The division that stands in the file's header."""
        return self.frames_per_beat * self.ticks_per_frame

    @property
    def tempo(self) -> int:
        """Microseconds a beat."""
        return int(self.frames_per_beat * 1_000_000 / self.rate)

    def tick(self, frame: int) -> int:
        """Return the tick at which a 1-based frame begins."""
        return (frame - 1) * self.ticks_per_frame

    def frame_at(self, tick: int) -> int:
        """Return the first frame that does not begin before a tick."""
        return 1 - (-tick // self.ticks_per_frame)

    def tick_at(self, seconds: Fraction) -> int:
        """Return the tick nearest to a time [s]: exact on frames, half a tick off at most."""
        return _nearest(seconds * self.rate * self.ticks_per_frame)

    def seconds(self, tick: int) -> Fraction:
        """Return the exact time of a tick [s]."""
        return Fraction(tick * self.tempo, self.ticks_per_beat * 1_000_000)

    def ticks(self, seconds: float) -> int:
        """Return the whole ticks of a length of time [s], at least one."""
        return max(1, round(seconds * float(self.rate) * self.ticks_per_frame))


def grid_of(rate: Fraction) -> Grid:
    """Return the exact grid of a frame rate.

    Raises:
        GridError: the rate is not positive, or no grid is exact within the limits of MIDI files.
    """
    if rate <= 0:
        raise GridError(f"a frame rate is positive; got {rate}")
    n, d = rate.numerator, rate.denominator
    least = n // gcd(n, 1_000_000 * d)
    for frames_per_beat in (_FRAMES_PER_BEAT, least):
        exact = frames_per_beat % least == 0
        tempo = frames_per_beat * 1_000_000 / rate
        if exact and 1 <= tempo <= _MAX_TEMPO and frames_per_beat <= _MAX_DIVISION:
            coarse = min(_FINE, _MAX_DIVISION // frames_per_beat)
            return Grid(rate, frames_per_beat, max(_TICKS_PER_BEAT // frames_per_beat, coarse))
    raise GridError(
        f"no MIDI tempo is exact for {rate} frames a second: a beat would need {least} frames and "
        f"{float(least * 1_000_000 / rate):.6g} µs (at most {_MAX_DIVISION} frames, "
        f"1 to {_MAX_TEMPO} µs)"
    )


def sample_of(frame: int, rate: Fraction) -> int:
    """Return the sample at which a 1-based frame begins: the nearest one, half a sample upward.

    The length of a sound is `sample_of(frames + 1, rate)`.
    """
    return sample_at(Fraction(frame - 1) / rate)


def sample_at(seconds: Fraction) -> int:
    """Return the sample nearest to a time [s]."""
    return _nearest(seconds * SAMPLE_RATE)


def _nearest(at: Fraction) -> int:
    """Return the nearest whole number, half upward."""
    return (2 * at.numerator + at.denominator) // (2 * at.denominator)
