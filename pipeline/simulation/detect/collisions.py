"""Collisions: bodies that strike the terrain or one another.

What lies or rolls is silent: only what comes at more than the rest speed strikes.

Source: Sims 1987, 13.1.1.
"""

from __future__ import annotations

from collections.abc import Iterable

from pipeline.simulation.clock import Clock
from pipeline.simulation.detect.hearing import event_of
from pipeline.simulation.take import Contact, SoundEvent


def collisions(contacts: Iterable[Contact], clock: Clock) -> list[SoundEvent]:
    """Return the sound events of what strikes something."""
    return [event_of(c, "collision", clock) for c in contacts if c.kind == "hit"]
