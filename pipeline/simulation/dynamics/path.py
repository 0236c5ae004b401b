"""Path: how a body moves over one sub-step, known at every time of it.

In flight the acceleration is constant and the tumbling a power series. While the ground
holds or pushes a body, its velocity and its turning go over into those after the sub-step
at a constant rate. So places are advanced exactly in both: p + v t + a t² / 2.
"""

from __future__ import annotations

from typing import NamedTuple

from pipeline.simulation.dynamics.compiled import compiled
from pipeline.simulation.dynamics.records import Motion
from pipeline.simulation.dynamics.tumbling import tumbled, turned_by
from pipeline.simulation.dynamics.vectors import (
    Vector,
    plus,
    rotation,
    times,
    unturned,
)
from pipeline.simulation.spatial import Array


class Path(NamedTuple):
    """The motion of a body over a sub-step.

    Attributes:
        start: how it begins.
        a: acceleration [m/s²].
        driven: whether the ground turns it; else it tumbles.
        turn: angular velocity at the begin, in the world [rad/s].
        turn_rate: its change, if driven [rad/s²].
        order: highest power in the series.
        series: of the tumbling.
    """

    start: Motion
    a: Vector
    driven: bool
    turn: Vector
    turn_rate: Vector
    order: int
    series: Array


@compiled
def along(path: Path, t: float) -> Motion:
    """Return how the body is after a time t of the sub-step [s]."""
    start = path.start
    p = plus(start.p, times(t, plus(start.v, times(0.5 * t, path.a))))
    v = plus(start.v, times(t, path.a))
    if path.driven:
        q = turned_by(start.q, times(t, plus(path.turn, times(0.5 * t, path.turn_rate))))
        w = unturned(rotation(q), plus(path.turn, times(t, path.turn_rate)))
    else:
        q, w = tumbled(path.series, path.order, t)
    return Motion(p, q, v, w)
