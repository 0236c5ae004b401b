"""Stance: limits and preferred values of the joints of each kind of appendage.

A figure is created flat, fully extended. The preferred value of a joint so near its
full extension is altered, so that a limb at rest is bent and away from the
singularity (Sims 1987, 5.2 and 6.3.1). Positive pitch raises a limb, negative bends
turn it down; an inner joint of a leg bends one way only, as a knee does.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

from pipeline.simulation.figures.network import FEELER, HEAD, LEG, TAIL


@dataclass(frozen=True, slots=True)
class Stance:
    """Limits and value at rest of one joint [rad]."""

    lower: float
    upper: float
    preferred: float


def _degrees(lower: float, upper: float, preferred: float) -> Stance:
    return Stance(math.radians(lower), math.radians(upper), math.radians(preferred))


LEG_RISE_DEG = 24.0
"""Elevation of the first link of a leg at rest."""

LEG_FALL_DEG = (-54.0, -72.0)
"""Elevations of the second and of the last link of a leg at rest: over the knee and
steeply down, to stand on its point."""

NECK = {
    HEAD: (_degrees(-60, 60, 0), _degrees(-50, 50, -8), _degrees(-40, 40, 0)),
    TAIL: (_degrees(-60, 60, 0), _degrees(-40, 70, 6), _degrees(-40, 40, 0)),
    FEELER: (_degrees(-40, 40, 0), _degrees(-30, 80, 34), _degrees(-40, 40, 0)),
}
"""Yaw, pitch and roll at the root of what is no leg."""

BEND = {
    HEAD: _degrees(-50, 50, 0),
    TAIL: _degrees(-60, 60, 4),
    FEELER: _degrees(-70, 40, -24),
}
"""Inner joints of what is no leg."""


def stance_of(kind: str, links: int) -> list[dict[str, Stance]]:
    """Return, for each node of an appendage but its tip, its joints in their order.

    Args:
        kind: leg, head, tail or feeler.
        links: number of links of the appendage.
    """
    if kind != LEG:
        yaw, pitch, roll = NECK[kind]
        return [{"yaw": yaw, "pitch": pitch, "roll": roll}] + [
            {"bend": BEND[kind]} for _ in range(links - 1)
        ]
    elevations = leg_elevations(links)
    base = {
        "yaw": _degrees(-75, 75, 0),
        "pitch": _degrees(-85, 88, elevations[0]),
        "roll": _degrees(-55, 55, 0),
    }
    bends = (after - before for before, after in itertools.pairwise(elevations))
    return [base] + [{"bend": _degrees(-165, 0, bend)} for bend in bends]


def leg_elevations(links: int) -> list[float]:
    """Return the elevations of a leg's links at rest [degrees], from hip to foot.

    A leg of one link leans outward.
    """
    if links == 1:
        return [-50.0]
    if links == 2:
        return [LEG_RISE_DEG, LEG_FALL_DEG[1]]
    second, last = LEG_FALL_DEG
    step = (last - second) / (links - 2)
    return [LEG_RISE_DEG] + [second + step * i for i in range(links - 1)]
