"""Footfalls: feet that come down on the terrain.

Source: Sims 1987, 13.1.1.
"""

from __future__ import annotations

from collections.abc import Iterable

from pipeline.simulation.clock import Clock
from pipeline.simulation.take import Contact, SoundEvent

LEAST_SPEED = 0.005
"""Approaches slower than this are not heard [m/s]."""


def footfalls(contacts: Iterable[Contact], clock: Clock) -> list[SoundEvent]:
    """Return the sound events of contacts with the terrain."""
    return [
        SoundEvent(
            step=c.step,
            fraction=c.fraction,
            frame=clock.frame_of(c.step, c.fraction),
            cause="footfall",
            who=c.performer,
            part=c.part,
            other=c.other,
            place=c.place,
            strength=c.speed,
            energy=c.energy,
            size=c.size,
            material=c.material,
            surface=c.surface,
            track=(_row(c, clock), _row(c, clock)),
        )
        for c in contacts
        if c.other == "terrain" and c.speed >= LEAST_SPEED
    ]


def _row(contact: Contact, clock: Clock) -> int:
    """Return the last row that is not after the contact."""
    return contact.step * clock.samples // clock.steps
