"""Stance: limits and preferred values of the joints of each kind of appendage.

An insect is created flat, fully extended. The preferred value of a joint so near its
full extension is altered, so that a limb at rest is bent and away from the
singularity (Sims 1987, 5.2 and 6.3.1). A mammal's limbs keep the bends that they were
drawn with, and those drawn straight are bent a little. Positive pitch raises a limb or
swings it forward; an inner joint of a leg bends one way only, as a knee does.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.network import ARM, FEELER, HEAD, LEG, TAIL
from pipeline.simulation.spatial import Array


@dataclass(frozen=True, slots=True)
class Stance:
    """Limits and values of one joint; zero is how it was created [rad].

    Attributes:
        lower, upper: limits.
        preferred: value at rest.
        extended: value at which the links that it joins are as straight as can be.
    """

    lower: float
    upper: float
    preferred: float
    extended: float = 0.0


def degrees(lower: float, upper: float, preferred: float, extended: float = 0.0) -> Stance:
    """Return a stance given in degrees."""
    return Stance(*(math.radians(angle) for angle in (lower, upper, preferred, extended)))


LEG_RISE_DEG = 24.0
"""Elevation of the first link of an insect's leg at rest."""

LEG_FALL_DEG = (-54.0, -72.0)
"""Elevations of the second and of the last link of a leg at rest: over the knee and
steeply down, to stand on its point."""

ROOTS = {
    HEAD: (degrees(-60, 60, 0), degrees(-50, 50, -8), degrees(-40, 40, 0)),
    TAIL: (degrees(-60, 60, 0), degrees(-40, 70, 6), degrees(-40, 40, 0)),
    FEELER: (degrees(-40, 40, 0), degrees(-30, 80, 34), degrees(-40, 40, 0)),
    ARM: (degrees(-80, 80, 0), degrees(-80, 80, 20), degrees(-60, 60, 0)),
}
"""Yaw, pitch and roll at the root of what is no leg."""

BENDS = {
    HEAD: degrees(-50, 50, 0),
    TAIL: degrees(-60, 60, 4),
    FEELER: degrees(-70, 40, -24),
    ARM: degrees(-150, 0, -35),
}
"""Inner joints of what is no leg."""

STRAIGHT_DEG = 8.0
"""A joint drawn with less of a bend than this is taken to be drawn straight."""

SLACK_DEG = {LEG: -22.0, ARM: 26.0}
"""How a limb that is drawn straight is bent at rest: a knee backward, an elbow forward."""

BEND_DEG = {LEG: 160.0, ARM: 150.0}
"""How far a knee or an elbow bends from straight: calf on thigh, forearm on upper arm."""

SHOULDER = {"pitch": degrees(-60, 170, 4), "yaw": degrees(-80, 80, 0)}
"""A mammal's shoulder: back and forward, and about the arm itself. A person's, whose arms
reach farther than most (American Academy of Orthopaedic Surgeons 1965)."""

SPREAD_DEG = (-35.0, 150.0, 6.0)
"""How far a mammal's arm goes inward and outward at the shoulder, and hangs clear at rest."""

WRIST_DEG = (-60.0, 70.0, 8.0)
"""A wrist back and forward, and at rest; unlike an elbow it bends both ways."""


def insect_stance(kind: str, links: int) -> list[dict[str, Stance]]:
    """Return, for each node of an insect's appendage but its tip, its joints in their order.

    Args:
        kind: leg, arm, head, tail or feeler.
        links: number of links of the appendage.
    """
    if kind != LEG:
        return _spread(kind, links)
    elevations = leg_elevations(links)
    base = {
        "yaw": degrees(-75, 75, 0),
        "pitch": degrees(-85, 88, elevations[0]),
        "roll": degrees(-55, 55, 0),
    }
    bends = (after - before for before, after in itertools.pairwise(elevations))
    return [base] + [{"bend": degrees(-165, 0, bend)} for bend in bends]


def _spread(kind: str, links: int) -> list[dict[str, Stance]]:
    yaw, pitch, roll = ROOTS[kind]
    bends = [{"bend": BENDS[kind]} for _ in range(links - 1)]
    return [{"yaw": yaw, "pitch": pitch, "roll": roll}, *bends]


def leg_elevations(links: int) -> list[float]:
    """Return the elevations of an insect's leg at rest [degrees], from hip to foot.

    A leg of one link leans outward.
    """
    if links == 1:
        return [-50.0]
    if links == 2:
        return [LEG_RISE_DEG, LEG_FALL_DEG[1]]
    second, last = LEG_FALL_DEG
    step = (last - second) / (links - 2)
    return [LEG_RISE_DEG] + [second + step * i for i in range(links - 1)]


def mammal_stance(kind: str, side: str, steps: Array) -> list[dict[str, Stance]]:
    """Return, for each node of a mammal's appendage but its tip, its joints in their order.

    Args:
        kind: leg, arm, head, tail or feeler.
        side: l, m or r.
        steps: (n, 3) its links in the creation frame, from base to tip [m].
    """
    if kind not in SLACK_DEG:
        return _spread(kind, len(steps))
    # In the plane in which the limb swings: forward, and down.
    angles = np.unwrap(np.arctan2(steps[:, 0], -steps[:, 1]))
    inner = [_drawn_bend(kind, math.degrees(bend)) for bend in np.diff(angles)]
    if kind == ARM:
        base = {"pitch": SHOULDER["pitch"], "roll": _spread_of(side), "yaw": SHOULDER["yaw"]}
        if len(inner) > 1:
            inner[-1] = _wrist(math.degrees(inner[-1].extended))
    else:
        # A leg that runs back over its own hip cannot come under it.
        under = math.degrees(_under_the_hip(steps, angles, inner))
        base = {"pitch": degrees(-85, 85, min(max(under, -85.0), 85.0))}
        base |= {"roll": degrees(-40, 40, 0), "yaw": degrees(-45, 45, 0)}
    return [base, *({"bend": stance} for stance in inner)]


def _spread_of(side: str) -> Stance:
    """Return the roll of a shoulder, which is positive towards the left."""
    inward, outward, rest = SPREAD_DEG
    if side == "l":
        return degrees(inward, outward, rest)
    if side == "r":
        return degrees(-outward, -inward, -rest)
    return degrees(inward, -inward, 0.0)


def _wrist(straight: float) -> Stance:
    """Return the stance of a wrist whose hand follows the forearm at `straight` [degrees]."""
    back, forward, rest = WRIST_DEG
    if abs(straight) >= STRAIGHT_DEG:
        rest = -straight
    # However sharply it was drawn, what it was drawn at is within its limits.
    lower, upper = min(straight + back, 0.0), max(straight + forward, 0.0)
    return degrees(lower, upper, straight + rest, straight)


def _under_the_hip(steps: Array, angles: Array, inner: Sequence[Stance]) -> float:
    """Return the pitch of a hip that brings the foot under it, its leg being at rest [rad]."""
    turned = angles + np.cumsum([0.0, *(stance.preferred for stance in inner)])
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    return -math.atan2(float(lengths @ np.sin(turned)), float(lengths @ np.cos(turned)))


def _drawn_bend(kind: str, bend: float) -> Stance:
    """Return the stance of an inner joint drawn with `bend` [degrees]."""
    rest = 0.0
    if abs(bend) < STRAIGHT_DEG:
        rest = SLACK_DEG[kind]
    way = math.copysign(1.0, rest or bend)
    # However sharply it was drawn, what it was drawn at is within its limits.
    far = -bend + way * max(BEND_DEG[kind], abs(bend))
    return degrees(min(-bend, far), max(-bend, far), rest, -bend)
