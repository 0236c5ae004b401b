"""Footfalls: feet that come down on the terrain.

Source: Sims 1987, 13.1.1.
"""

from __future__ import annotations

from collections.abc import Iterable

from pipeline.simulation.clock import Clock
from pipeline.simulation.detect.hearing import event_of
from pipeline.simulation.take import Contact, SoundEvent

LEAST_SPEED = 0.005
"""Approaches slower than this are not heard [m/s]."""


def footfalls(contacts: Iterable[Contact], clock: Clock) -> list[SoundEvent]:
    """Return the sound events of feet that touch the terrain."""
    return [
        event_of(c, "footfall", clock)
        for c in contacts
        if c.kind == "touch" and c.other == "terrain" and c.speed >= LEAST_SPEED
    ]
