"""Hearing: a contact -> the sound event that it makes."""

from __future__ import annotations

from pipeline.simulation.clock import Clock
from pipeline.simulation.take import Contact, SoundEvent


def event_of(contact: Contact, cause: str, clock: Clock) -> SoundEvent:
    """Return the onset of a sound at a contact."""
    # The last row that is not after it.
    row = contact.step * clock.samples // clock.steps
    return SoundEvent(
        step=contact.step,
        fraction=contact.fraction,
        frame=clock.frame_of(contact.step, contact.fraction),
        cause=cause,
        who=contact.performer,
        part=contact.part,
        other=contact.other,
        place=contact.place,
        strength=contact.speed,
        energy=contact.energy,
        size=contact.size,
        material=contact.material,
        surface=contact.surface,
        track=(row, row),
    )
