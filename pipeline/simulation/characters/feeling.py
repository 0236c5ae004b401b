"""Feeling: blows go through muscles, which are slack for a moment after them."""

from __future__ import annotations

import math

from pipeline.simulation.characters.layout import SOLID
from pipeline.simulation.characters.record import PELVIS
from pipeline.simulation.dynamics.compiled import Record, Records, compiled

STUNS = 0.5
"""Energy of a blow after which muscles are quite slack, for each kilogram of the body [J/kg]."""

LEAST = 0.25
"""Of that, what a body takes without a change."""

RECOVERS = 2.2
"""How quickly they are not any more [1/s]."""


KNOCK, KNOCKED = 0.5, 1.5
"""Speed of the pelvis against where it is led: what nobody minds, and what leaves nobody upright
[m/s]."""


@compiled
def feel(person: Record, nodes: Records, links: Records, owners: Records, dt: float) -> None:
    """Take in what others strike, and what throws somebody off, and recover from it."""
    person.dazed *= max(1.0 - RECOVERS * dt, 0.0)
    pelvis = nodes[person.node + PELVIS]
    x = (pelvis.p[0] - pelvis.before[0]) / dt - person.going[0]
    z = (pelvis.p[2] - pelvis.before[2]) / dt - person.going[1]
    if person.seated == 0.0 and not person.frozen:
        off = (math.hypot(x, z) - KNOCK) / (KNOCKED - KNOCK)
        person.dazed = max(person.dazed, min(off, 1.0))
    owner = owners[person.owner]
    first, count = owner.links[0], owner.links[1]
    for link in range(first, first + count):
        other = links[link].touched_owner
        if (other >= 0 and other != person.owner) or links[link].touched <= SOLID:
            blow = links[link].energy / (STUNS * owner.mass)
            if blow > LEAST:
                person.dazed = max(person.dazed, min(blow, 1.0))
