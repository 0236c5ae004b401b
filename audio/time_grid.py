"""Time grids: MIDI ticks and audio samples that agree exactly with the frames of a film.

A beat holds B frames and a frame k ticks, so a beat has B·k ticks and lasts B / rate seconds.
The tempo is a whole number of microseconds a beat, hence the grid is exact if B·10⁶ / rate is an
integer: every frame is then a whole tick whose time, computed from the file alone, is
(frame - 1) / rate as a fraction. For a rate n / d, B is a multiple of n / gcd(n, 10⁶·d).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import gcd

from audio.errors import GridError

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


@dataclass(frozen=True, slots=True)
class TickGrid:
    """MIDI ticks for one frame rate.

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
        """Division in the file's header."""
        return self.frames_per_beat * self.ticks_per_frame

    @property
    def tempo(self) -> int:
        """Microseconds a beat."""
        return int(self.frames_per_beat * 1_000_000 / self.rate)

    def tick(self, frame: int) -> int:
        """Return the tick at the start of a 1-based frame."""
        return (frame - 1) * self.ticks_per_frame

    def frame_at(self, tick: int) -> int:
        """Return the first frame that does not start before a tick."""
        return 1 - (-tick // self.ticks_per_frame)

    def tick_at(self, seconds: Fraction) -> int:
        """Return the tick nearest to a time [s]: exact on frames, half a tick off at most."""
        return _round_half_up(seconds * self.rate * self.ticks_per_frame)

    def seconds(self, tick: int) -> Fraction:
        """Return the exact time of a tick [s]."""
        return Fraction(tick * self.tempo, self.ticks_per_beat * 1_000_000)

    def ticks(self, seconds: float) -> int:
        """Return a duration [s] in ticks, at least one."""
        return max(1, round(seconds * float(self.rate) * self.ticks_per_frame))


def tick_grid(rate: Fraction) -> TickGrid:
    """Return the exact grid of a frame rate.

    Raises:
        GridError: the rate is not positive, or no grid is exact within the limits of MIDI files.
    """
    if rate <= 0:
        raise GridError(f"a frame rate is positive; got {rate}")
    n, d = rate.numerator, rate.denominator
    multiple = n // gcd(n, 1_000_000 * d)
    for frames_per_beat in (_FRAMES_PER_BEAT, multiple):
        is_exact = frames_per_beat % multiple == 0
        tempo = frames_per_beat * 1_000_000 / rate
        if is_exact and 1 <= tempo <= _MAX_TEMPO and frames_per_beat <= _MAX_DIVISION:
            least = min(_MIN_TICKS_PER_FRAME, _MAX_DIVISION // frames_per_beat)
            return TickGrid(rate, frames_per_beat, max(_TICKS_PER_BEAT // frames_per_beat, least))
    raise GridError(
        f"no MIDI tempo is exact for {rate} frames a second: a beat would need {multiple} frames "
        f"and {float(multiple * 1_000_000 / rate):.6g} µs (at most {_MAX_DIVISION} frames, "
        f"1 to {_MAX_TEMPO} µs)"
    )


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
