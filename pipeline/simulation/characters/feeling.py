"""Feeling: blows go through muscles, which are slack for a moment after them."""

from __future__ import annotations

from pipeline.simulation.dynamics.compiled import Record, Records, compiled

STUNS = 0.5
"""Energy of a blow after which muscles are quite slack, for each kilogram of the body [J/kg]."""

LEAST = 0.25
"""Of that, what a body takes without a change."""

RECOVERS = 2.2
"""How quickly they are not any more [1/s]."""


@compiled
def feel(person: Record, links: Records, owners: Records, dt: float) -> None:
    """Take in what others strike, and recover from it."""
    person.dazed *= max(1.0 - RECOVERS * dt, 0.0)
    owner = owners[person.owner]
    first, count = owner.links[0], owner.links[1]
    for link in range(first, first + count):
        other = links[link].touched_owner
        if other >= 0 and other != person.owner:
            blow = links[link].energy / (STUNS * owner.mass)
            if blow > LEAST:
                person.dazed = max(person.dazed, min(blow, 1.0))
