"""Feeling: blows go through muscles, which are slack for a moment after them."""

from __future__ import annotations

from pipeline.simulation.characters.layout import Crowd
from pipeline.simulation.dynamics.compiled import Record, compiled

STUNS = 0.5
"""Energy of a blow after which muscles are quite slack, for each kilogram of the body [J/kg]."""

RECOVERS = 2.2
"""How quickly they are not any more [1/s]."""


@compiled
def feel(person: Record, crowd: Crowd, dt: float) -> None:
    """Take in what others strike, and recover from it."""
    person.dazed *= max(1.0 - RECOVERS * dt, 0.0)
    owner = crowd.owners[person.owner]
    first, count = owner.links[0], owner.links[1]
    for link in range(first, first + count):
        other = crowd.links[link].touched_owner
        if other >= 0 and other != person.owner:
            blow = crowd.links[link].energy / (STUNS * owner.mass)
            if blow > 0.1:
                person.dazed = max(person.dazed, min(blow, 1.0))
