"""What a score must hold so that it can be written."""

from __future__ import annotations

from math import isfinite

from audio.errors import ScoreError
from audio.score import Score, ScoreEvent


def check(score: Score) -> None:
    """Refuse a score without time, and events that cannot be.

    Raises:
        ScoreError: an event lies outside the score or holds a number that is not finite.
    """
    if score.frames < 1:
        raise ScoreError(f"a score has at least one frame; got {score.frames}")
    if score.rate <= 0:
        raise ScoreError(f"a frame rate is positive; got {score.rate}")
    for event in score.events:
        _check(event, score)


def _check(event: ScoreEvent, score: Score) -> None:
    name = f"{event.cause} of {event.who}.{event.part} at frame {event.frame}"
    if not 1 <= event.frame <= score.frames:
        raise ScoreError(f"{name} lies outside frames 1 to {score.frames}")
    if not 0 <= score.onset(event) < score.frames / score.rate:
        raise ScoreError(f"{name}: its time, {float(event.time):.6g} s, lies outside the film")
    if not all(isfinite(speed) and speed >= 0 for speed in event.speeds):
        raise ScoreError(f"{name}: its speeds are to be finite and not negative")
    numbers = {
        field: getattr(event, field)
        for field in ("strength", "energy", "size", "distance", "azimuth", "duration")
    }
    for field, value in numbers.items():
        if not isfinite(value):
            raise ScoreError(f"{name}: {field} is {value}")
    if event.size <= 0 or min(event.distance, event.duration, event.energy) < 0:
        raise ScoreError(f"{name}: size is positive; distance, duration and energy not negative")
