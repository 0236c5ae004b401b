"""Scuffs: feet that drag over the terrain.

Whether a foot is low and quick enough to be heard, its walking says; see `scuffing`.

Source: Sims 1987, 13.1.2, sounds from motion.
"""

from __future__ import annotations

from collections.abc import Iterable

from pipeline.simulation.clock import Clock
from pipeline.simulation.detect.hearing import event_of
from pipeline.simulation.take import Contact, SoundEvent


def scuffs(contacts: Iterable[Contact], clock: Clock) -> list[SoundEvent]:
    """Return the sound events of feet that scuff over the terrain."""
    return [
        event_of(c, "scuff", clock) for c in contacts if c.kind == "scuff" and c.other == "terrain"
    ]
