"""Voice selection: the voice that an event is played with."""

from __future__ import annotations

from audio.config.sound import EventFilter, Sound, Voice
from audio.names import matches_pattern
from audio.score import ScoreEvent

_DEFAULT = Voice()


def voice_of(sound: Sound, event: ScoreEvent) -> Voice:
    """Return the first voice whose conditions hold for an event, or the default voice."""
    return next((voice for voice in sound.voices if _selects(voice.when, event)), _DEFAULT)


def _selects(when: EventFilter, event: ScoreEvent) -> bool:
    names = (
        (when.cause, event.cause),
        (when.who, event.who),
        (when.part, event.part),
        (when.other, event.other),
        (when.material, event.material),
        (when.surface, event.surface),
    )
    ranges = ((when.size, event.size), (when.strength, abs(event.strength)))
    return all(
        pattern is None or matches_pattern(name, pattern) for pattern, name in names
    ) and all(bounds is None or bounds.contains(value) for bounds, value in ranges)
