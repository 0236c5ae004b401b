"""Quantities of the command line: sizes of memory and durations, read and written."""

from __future__ import annotations

import re

from pipeline.errors import UsageError

_UNITS = {
    "b": 1,
    "kb": 10**3,
    "mb": 10**6,
    "gb": 10**9,
    "tb": 10**12,
    "kib": 2**10,
    "mib": 2**20,
    "gib": 2**30,
    "tib": 2**40,
}
_SIZE = re.compile(r"(\d{1,15}(?:\.\d{1,6})?)\s*([A-Za-z]{1,3})", re.ASCII)
_PERIOD = re.compile(r"(?:(\d{1,6})h)?(?:(\d{1,6})m)?(?:(\d{1,9}(?:\.\d{1,3})?)s)?", re.ASCII)

MIN_SIZE, MIN_DURATION = 2**20, 1.0
"""Smallest limits: less than any run takes, and most likely a slip [bytes, s]."""


def parse_size(text: str, option: str) -> int:
    """Return a size of memory [bytes].

    Args:
        text: a number with its unit, such as 2GiB or 500MB.
        option: of the command line, for messages.

    Raises:
        UsageError: it is no size, or below 1 MiB.
    """
    match = _SIZE.fullmatch(text.strip())
    unit = _UNITS.get(match[2].lower()) if match is not None else None
    if match is None or unit is None:
        message = f"{option} {text!r} is no size; write a number with its unit, as in 2GiB or 500MB"
        raise UsageError(message)
    size = int(float(match[1]) * unit)
    if size < MIN_SIZE:
        raise UsageError(
            f"{option} {text!r} is less than {size_text(MIN_SIZE)}; write a larger one"
        )
    return size


def parse_duration(text: str, option: str) -> float:
    """Return a duration [s].

    Args:
        text: numbers with their units, such as 90s, 10m or 1h30m.
        option: of the command line, for messages.

    Raises:
        UsageError: it is no duration, or below a second.
    """
    match = _PERIOD.fullmatch(text.strip().lower())
    if match is None or not any(match.groups()):
        message = (
            f"{option} {text!r} is no duration; write numbers with their units, as in 90s, 10m or "
            "1h30m"
        )
        raise UsageError(message)
    hours, minutes, seconds = (float(part or 0) for part in match.groups())
    duration = 3600 * hours + 60 * minutes + seconds
    if duration < MIN_DURATION:
        raise UsageError(f"{option} {text!r} is less than a second; write a longer one")
    return duration


def size_text(size: float) -> str:
    """Return a size of memory in words, such as 1.5 GiB."""
    if size < 2**30:
        return f"{max(round(size / 2**20), 1):d} MiB"
    if size < 2**40:
        return f"{size / 2**30:.3g} GiB"
    return f"{size / 2**40:.3g} TiB"


def duration_text(seconds: float) -> str:
    """Return a duration in words, such as 1 h 30 min."""
    if seconds < 99.5:
        return f"{max(round(seconds), 1):d} s"
    minutes = round(seconds / 60)
    if minutes < 60:
        return f"{minutes} min"
    hours, minutes = divmod(minutes, 60)
    if hours >= 48:
        return f"{hours:,} h"
    return f"{hours} h {minutes} min" if minutes else f"{hours} h"
