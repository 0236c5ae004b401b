"""Which of the author's voices is for an event: the first whose rule fits."""

from __future__ import annotations

import re

from audio.names import folded
from audio.score import ScoreEvent
from audio.words import Sound, Voice, When


def first_fitting(sound: Sound, event: ScoreEvent) -> Voice:
    """Return the first voice whose rule fits; one that says nothing if none does."""
    return next((voice for voice in sound.voices if _fits(voice.when, event)), Voice())


def _fits(when: When, event: ScoreEvent) -> bool:
    names = (
        (when.cause, event.cause),
        (when.who, event.who),
        (when.part, event.part),
        (when.other, event.other),
        (when.material, event.material),
        (when.surface, event.surface),
    )
    ranges = ((when.size, event.size), (when.strength, abs(event.strength)))
    return all(pattern is None or matches(name, pattern) for pattern, name in names) and all(
        within is None or within.holds(value) for within, value in ranges
    )


def matches(name: str, pattern: str) -> bool:
    """Tell whether a name is meant by an author's pattern, where `*` stands for any letters."""
    pieces = (re.escape(piece) for piece in folded(pattern).split("*"))
    return re.fullmatch(".*".join(pieces), folded(name)) is not None
