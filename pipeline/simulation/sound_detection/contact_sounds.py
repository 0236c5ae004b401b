"""Contact sounds: footfalls, scuffs, collisions, rolling and sliding.

Whether a foot scuffs or a body rolls is decided by the performer that reports the contact. What
lies still is silent: a collision needs more than the rest speed.

Source: Sims 1987, 13.1.1 and 13.1.2.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from math import inf

from audio.names import matches_pattern
from pipeline.simulation.clock import Clock
from pipeline.simulation.sound_detection.sound_events import contact_event
from pipeline.simulation.take import Contact, SoundEvent
from pipeline.spec.sound_thresholds import Cause, Detect, ImpactCause


@dataclass(frozen=True, slots=True)
class ContactFilter:
    """The contacts of a cause.

    Attributes:
        kind: of the contact.
        terrain_only: whether it must be with the terrain.
    """

    kind: str
    terrain_only: bool = False

    def selects(self, contact: Contact) -> bool:
        """Return whether a contact belongs to the cause."""
        return contact.kind == self.kind and (not self.terrain_only or contact.other == "terrain")


CONTACT_CAUSES = {
    "footfall": ContactFilter("touch", terrain_only=True),
    "scuff": ContactFilter("scuff", terrain_only=True),
    "collision": ContactFilter("hit"),
    "roll": ContactFilter("roll"),
    "slide": ContactFilter("slide"),
}


class ContactSounds:
    """Detects the causes that are contacts.

    Args:
        detect: thresholds.
        clock: grid of steps, rows and frames.
    """

    def __init__(self, detect: Detect, clock: Clock) -> None:
        configs: dict[str, Cause] = {cause: getattr(detect, cause) for cause in CONTACT_CAUSES}
        self._configs = {cause: config for cause, config in configs.items() if config.heard}
        self._clock = clock
        self._last_times: dict[tuple[str, str, str, str], float] = {}

    def events(self, contacts: Iterable[Contact]) -> list[SoundEvent]:
        """Return the sound events of contacts, by cause and then in the order of time."""
        contacts = list(contacts)
        return [
            contact_event(contact, cause, self._clock)
            for cause, config in self._configs.items()
            for contact in contacts
            if CONTACT_CAUSES[cause].selects(contact) and self._is_audible(contact, cause, config)
        ]

    def _is_audible(self, contact: Contact, cause: str, config: Cause) -> bool:
        if not matches_pattern(contact.performer, config.who):
            return False
        if not isinstance(config, ImpactCause):
            return True
        return contact.speed >= config.above and not self._is_repeated(contact, cause, config.pause)

    def _is_repeated(self, contact: Contact, cause: str, pause: float) -> bool:
        """Return whether the same two made the same sound within a pause [s]."""
        key = (cause, contact.performer, contact.part, contact.other)
        now = float(contact.step + Fraction(contact.fraction)) * self._clock.dt
        if now - self._last_times.get(key, -inf) < pause:
            return True
        self._last_times[key] = now
        return False
