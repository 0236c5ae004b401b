"""Timecode: hours, minutes, seconds and frames, as editing programs count them.

Rates of n · 1000/1001 count as n, without dropping numbers: what is counted is frames.
"""

from __future__ import annotations

from fractions import Fraction

SLOWEST, FASTEST = 2, 100
"""Frames a second that have two digits, counted from 00."""


def counted_as(rate: Fraction) -> int | None:
    """Return the whole frames a second that a rate is counted as; None if it has no timecode."""
    count = round(rate)
    fits = rate in (count, Fraction(count * 1000, 1001)) and SLOWEST <= count <= FASTEST
    return count if fits else None


def timecode(frames: int, count: int) -> str:
    """Return the timecode of a place in the film, `frames` after its begin.

    Args:
        frames: less than a day of them.
        count: frames a second.
    """
    seconds, frame = divmod(frames, count)
    minutes, second = divmod(seconds, 60)
    hour, minute = divmod(minutes, 60)
    return f"{hour:02d}:{minute:02d}:{second:02d}:{frame:02d}"
