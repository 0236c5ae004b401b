"""Rubs: bodies that roll or slide over the ground, heard for as long as they do.

Source: Sims 1987, 13.1.2, sounds from motion.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from pipeline.simulation.clock import Clock
from pipeline.simulation.detect.hearing import event_of
from pipeline.simulation.take import Contact, SoundEvent


def rubs(contacts: Iterable[Contact], clock: Clock) -> list[SoundEvent]:
    """Return the sound events of what rolls or slides."""
    return [_rub(c, clock) for c in contacts if c.kind in ("roll", "slide")]


def _rub(contact: Contact, clock: Clock) -> SoundEvent:
    event = event_of(contact, contact.kind, clock)
    last = contact.until * clock.samples // clock.steps
    return replace(event, track=(event.track[0], last))
