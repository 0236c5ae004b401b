"""Take-offs: creatures that leave the ground, with all the feet that do so at once.

Source: Sims 1987, ch. 11 and 13.1.1.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import groupby

from pipeline.simulation.clock import Clock
from pipeline.simulation.detect.hearing import event_of
from pipeline.simulation.take import Contact, SoundEvent


def takeoffs(contacts: Iterable[Contact], clock: Clock) -> list[SoundEvent]:
    """Return the sound events of who leaves the ground, one for each, in the middle of its feet."""
    lifts = sorted((c for c in contacts if c.kind == "lift"), key=_moment)
    return [_takeoff(list(feet), clock) for _, feet in groupby(lifts, key=_moment)]


def _moment(contact: Contact) -> tuple[str, int, float]:
    return contact.performer, contact.step, contact.fraction


def _takeoff(feet: list[Contact], clock: Clock) -> SoundEvent:
    x, y, z = (sum(axis) / len(feet) for axis in zip(*(c.place for c in feet), strict=True))
    energy = sum(c.energy for c in feet)
    return replace(event_of(feet[0], "take-off", clock), place=(x, y, z), energy=energy)
