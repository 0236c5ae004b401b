"""Throw flight: the velocity with which a thing leaves the hand or the foot to hit a target."""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.spatial import Array

FLATNESS = 0.75  # time of a natural flight, in that of the flight of least speed
SHORTEST_FLIGHT = 0.22  # [s]
LONGEST_FLIGHT, FLIGHTS = 3.0, 40  # in natural ones; number of flights tried


def launch_velocity(
    offset: Array, v: Array, limit: float, gravity: float, damping: float = 0.0
) -> tuple[Array, float]:
    """Return the velocity (3,) that carries a thing to a target, and the distance it falls short.

    Of all flights the thrower takes the flattest that it is strong enough for, but no flatter than
    a natural throw.

    Args:
        offset: (3,) to the target now [m].
        v: (3,) of the target [m/s].
        limit: greatest speed [m/s].
        gravity: [m/s²].
        damping: of the thing by air [1/s].
    """
    level = math.hypot(offset[0], offset[2])
    natural = max(FLATNESS * math.sqrt(2.0 * level / gravity), SHORTEST_FLIGHT)
    times = natural * np.geomspace(1.0, LONGEST_FLIGHT, FLIGHTS)
    launches = [_launch(offset + time * v, time, gravity, damping) for time in times.tolist()]
    speeds = np.array([float(np.linalg.norm(launch)) for launch in launches])
    strong = np.flatnonzero(speeds <= limit)
    if len(strong):
        return launches[int(strong[0])], 0.0
    k = int(np.argmin(speeds))
    share = limit / float(speeds[k])
    # The range of a throw goes with the square of its speed.
    return share * launches[k], (1.0 - share * share) * level


def _launch(offset: Array, time: float, gravity: float, damping: float) -> Array:
    """Return the velocity (3,) that covers an offset in a time [s]."""
    share = time if damping == 0.0 else -math.expm1(-damping * time) / damping
    fall = 0.5 * gravity * time * time
    if damping > 0.0:
        fall = gravity * (time - share) / damping
    return (offset + np.array([0.0, fall, 0.0])) / share
