"""Looking: where creatures look: ahead on their way, or where their author has them look.

Who goes looks at a place a little beyond where it will be in a moment, from before a
curve or a turn on the spot begins.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import hinge
from pipeline.simulation.locomotion.bearing import Bearing
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.route import Route, direction
from pipeline.simulation.spatial import Array, heading, turn

LEAD = 0.8
"""How long before it is somewhere a creature looks there [s]."""

LEAST = 0.35
"""Part of its speed at which it looks ahead at least, so that it does where it brakes."""

BEYOND = 2.0
"""How far beyond its eyes' place there it looks, in half lengths of its stance."""

MOST_UP = math.radians(50.0)
"""How far heads look up or down."""

ROUNDS = 3
"""In which the eyes' own turning is taken into account."""

Look = Array | int
"""A place (3,) [m], or the number of a creature."""


@dataclass(frozen=True, eq=False)
class Rows:
    """What the carriage of a herd of C depends on, at n rows.

    Attributes:
        time: (n,) since the start [s].
        way: (n, C) way gone [m].
        phase, drive: (n, C) of the gaits.
        bearing: (n, C).
        routes: (n) lists of C, the same object as long as nobody is led elsewhere.
        looks: (n) what somebody is told to look at, by creature.
        R_WB, p_WB: (n, C, 3, 3) and (n, C, 3) of the bodies [m].
    """

    time: Array
    way: Array
    phase: Array
    drive: Array
    bearing: Bearing
    routes: Sequence[Sequence[Route]]
    looks: Sequence[Mapping[int, Look]]
    R_WB: Array
    p_WB: Array

    @property
    def turned(self) -> Array:
        """(n, C) headings of the bodies [rad]."""
        result: Array = np.arctan2(-self.R_WB[..., 2, 0], self.R_WB[..., 0, 0])
        return result


def looks_of(
    herd: Herd, rows: Rows, c: int, base: Array, eye: Array, most: float
) -> tuple[Array, Array]:
    """Return where a head is to look (n,): left of its body's heading, and up [rad].

    Args:
        herd: the creatures.
        rows: what is known of them.
        c: whose head.
        base: (3,) of its neck, relative to the body [m].
        eye: (3,) its end at rest, likewise [m].
        most: how far it turns [rad].
    """
    azimuth, elevation = np.zeros((2, len(rows.time)))
    told = np.array([c in looks for looks in rows.looks], dtype=bool)
    for span in _spans(rows):
        route = rows.routes[span.start][c]
        own = np.arange(span.start, span.stop)[~told[span]]
        if not route.goes_straight and len(own):
            targets = _ahead(herd, rows, c, route, own, float(np.hypot(*eye[[0, 2]])))
            aside = _seen(rows, c, own, targets, base, eye)[0]
            azimuth[own] = rows.bearing.head_turn[own, c] * aside
    if told.any():
        own = np.flatnonzero(told)
        targets = np.array([_place(rows, k, rows.looks[k][c]) for k in own.tolist()])
        azimuth[own], up = _seen(rows, c, own, targets, base, eye)
        elevation[own] = within(up, MOST_UP)
    return within(azimuth, most), elevation


def within(angle: Array, most: float) -> Array:
    """Return angles as they are up to half of `most`, and then ever less, up to `most` [rad]."""
    width = max(0.25 * most, 1e-6)
    result: Array = angle - np.sign(angle) * hinge(np.abs(angle) - (most - width), width)
    return np.clip(result, -most, most)


def _spans(rows: Rows) -> Iterator[slice]:
    """Yield the rows during which nobody is led elsewhere."""
    start = 0
    for k in range(1, len(rows.routes) + 1):
        if k == len(rows.routes) or rows.routes[k] is not rows.routes[start]:
            yield slice(start, k)
            start = k


def _ahead(
    herd: Herd, rows: Rows, c: int, route: Route, own: NDArray[np.int64], out: float
) -> Array:
    """Return places (n, 3) to which who follows its way looks, its eyes `out` before it [m]."""
    speed = herd.stride[c] / herd.cycle[c] * np.maximum(rows.drive[own, c], LEAST)
    xz, turned = route.at(rows.way[own, c] + LEAD * speed)
    xz = xz + (out + BEYOND * herd.footprint[c, 0]) * direction(turned)
    return np.stack([xz[:, 0], rows.p_WB[own, c, 1], xz[:, 1]], axis=-1)


def _place(rows: Rows, k: int, look: Look) -> Array:
    """Return the place (3,) of what is looked at in row `k` [m]."""
    return rows.p_WB[k, look] if isinstance(look, int) else look


def _seen(
    rows: Rows, c: int, own: NDArray[np.int64], targets: Array, base: Array, eye: Array
) -> tuple[Array, Array]:
    """Return azimuths and elevations (n,) of places (n, 3) from the eyes that look at them."""
    R, p, turned = rows.R_WB[own, c], rows.p_WB[own, c], rows.turned[own, c]
    azimuth = np.zeros(len(own))
    for _ in range(ROUNDS):
        eyes = p + turn(R, base + turn(heading(azimuth), np.broadcast_to(eye - base, p.shape)))
        x, y, z = (targets - eyes).T
        azimuth = np.remainder(np.arctan2(-z, x) - turned + np.pi, 2.0 * np.pi) - np.pi
    return azimuth, np.arctan2(y, np.hypot(x, z))
