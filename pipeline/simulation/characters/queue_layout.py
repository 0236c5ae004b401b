"""Queue layout: where a queue stands before what people are served at."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.queues import ADULT_HEIGHT, PITCH, Queue
from pipeline.simulation.members import MemberState

MOST_PLACES = 60  # of a queue
STANDOFF = 0.1  # of the first from the surface of what it queues at, beyond its own radius [m]
FAR_AWAY = 1000.0  # from where a side of a thing is looked at [m]


def queue_at(
    state: MemberState, controller: PersonController, from_heading: float | None = None
) -> Queue:
    """Return an empty queue at a member or a place, that leads to where a person is.

    Places on the line that things or the edge of the terrain bar are left out.

    Args:
        state: what is queued at.
        controller: of the person.
        from_heading: side of it on which the queue stands [rad]; that of the person if None.
    """
    waist, centre = controller.waist(), state.centre
    if from_heading is not None:
        side = np.array([math.cos(from_heading), 0.0, -math.sin(from_heading)])
        waist = np.array([centre[0], waist[1], centre[2]]) + FAR_AWAY * side
    surface = state.nearest(waist)
    offset = (waist - surface)[[0, 2]]
    size = math.hypot(offset[0], offset[1])
    away = offset / size if size > 1e-6 else -controller.ahead[[0, 2]]
    if from_heading is not None:
        away = side[[0, 2]]
    # At a place without extent the first one stands on it.
    standoff = controller.body_radius + STANDOFF if state.radius > 0.0 else 0.0
    head = surface[[0, 2]] + standoff * away
    pitch = PITCH * ADULT_HEIGHT
    places = head + pitch * np.arange(MOST_PLACES)[:, None] * away
    low, high = controller.view.edges
    inside = (places > low) & (places < high)
    is_free: NDArray[np.bool_] = inside[:, 0] & inside[:, 1]
    middles, radii = controller.obstacles()
    if len(radii):
        off = np.hypot(*np.moveaxis(places[:, None] - middles, -1, 0))
        is_free &= (off > radii + controller.body_radius).all(axis=1)
    is_free[0] = True
    front = surface[[0, 2]] if standoff > 0.0 else head - away
    return Queue(places[is_free], front, away)
