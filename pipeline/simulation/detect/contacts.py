"""Contacts that are heard: each by its cause, none again too soon.

Source: Sims 1987, 13.1.1.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from math import inf

from pipeline.simulation.clock import Clock
from pipeline.simulation.detect.hearing import event_of, fits
from pipeline.simulation.take import Contact, SoundEvent
from pipeline.spec.sound_thresholds import Blow, Cause, Detect

IsOne = Callable[[Contact], bool]

Pair = tuple[str, str, str, str]
"""Cause, performer, part, and what it met."""


class Contacts:
    """All causes that are contacts.

    Args:
        causes: cause -> function that tells whether a contact is one.
        detect: the author's thresholds.
        clock: the grid of steps, rows and frames.
    """

    def __init__(self, causes: Mapping[str, IsOne], detect: Detect, clock: Clock) -> None:
        words: dict[str, Cause] = {cause: getattr(detect, cause) for cause in causes}
        self._causes = {c: (is_one, words[c]) for c, is_one in causes.items() if words[c].heard}
        self.clock = clock
        self._last: dict[Pair, float] = {}

    def hear(self, contacts: Iterable[Contact]) -> list[SoundEvent]:
        """Return the sound events of contacts, in the order of time."""
        contacts = list(contacts)
        return [
            event_of(contact, cause, self.clock)
            for cause, (is_one, words) in self._causes.items()
            for contact in contacts
            if is_one(contact) and self._is_heard(contact, cause, words)
        ]

    def _is_heard(self, contact: Contact, cause: str, words: Cause) -> bool:
        if not fits(contact.performer, words.who):
            return False
        if not isinstance(words, Blow):
            return True
        return contact.speed >= words.above and self._is_new(contact, cause, words.pause)

    def _is_new(self, contact: Contact, cause: str, pause: float) -> bool:
        """Tell whether the same two have not been heard just before."""
        pair = (cause, contact.performer, contact.part, contact.other)
        now = float(contact.step + Fraction(contact.fraction)) * self.clock.dt
        if now - self._last.get(pair, -inf) < pause:
            return False
        self._last[pair] = now
        return True
