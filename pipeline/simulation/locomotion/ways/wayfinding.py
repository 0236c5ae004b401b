"""Wayfinding: from the words of a path to the route that a creature goes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from pipeline.simulation.locomotion.ways.route import Route, standing, straight, through, turning
from pipeline.simulation.spatial import Array
from pipeline.spec.cast import Creature

SHARP = math.radians(120.0)
"""Corner at a waypoint from which on a creature halts there and turns on the spot: a spline
would come to a point."""

ROUNDS = 200
"""How often a path that is repeated is laid out; no film is longer."""


def route_of(member: Creature, footprint: Array, far: float) -> Route:
    """Return the way that a creature goes.

    Args:
        member: its words.
        footprint: (2,) half extent of its feet at rest along x and z [m].
        far: at least as long as it can get in the film [m].
    """
    start = np.array([member.at[0], member.at[-1]])
    heading = math.radians(member.heading_deg)
    walk = member.walk
    if walk is None:
        return standing(start, heading)
    points = [np.array(point) for point in walk.path if tuple(point) != tuple(start)]
    if not points:
        return straight(start, heading)
    # Who was not told where to look looks where it goes.
    first = heading if "heading_deg" in member.model_fields_set else None
    radius = float(np.hypot(*footprint))
    if walk.repeat == "once":
        return _along([start, *points], first, radius)
    if walk.repeat == "loop" and not corners_of([points[-1], start, *points, start]):
        once = through([start, *points], None, closed=True)
        return _repeated(once, once, far)
    if walk.repeat == "loop":
        once = _along([start, *points, start], first, radius)
        return _repeated(once, _joined(once, once, radius), far)
    there = _along([start, *points], first, radius)
    back = _joined(there, _along([*points[::-1], start], None, radius), radius)
    return _repeated(there.then(back), _joined(back, there, radius).then(back), far)


def _along(points: Sequence[Array], heading: float | None, radius: float) -> Route:
    """Return the way through waypoints, with a turn on the spot at sharp corners.

    Args:
        points: two or more (2,) [m].
        heading: at the first [rad]; that of the way if None.
        radius: of the feet, for turns on the spot [m].
    """
    cuts = [0, *corners_of(points), len(points) - 1]
    route = through(points[: cuts[1] + 1], heading)
    for a, b in itertools.pairwise(cuts[1:]):
        route = route.then(_joined(route, through(points[a : b + 1], None), radius))
    return route


def corners_of(points: Sequence[Array]) -> list[int]:
    """Return which of the inner waypoints are sharp corners."""
    found = []
    for i in range(1, len(points) - 1):
        a, b = points[i] - points[i - 1], points[i + 1] - points[i]
        angle = math.atan2(a[0] * b[1] - a[1] * b[0], float(a @ b))
        if abs(angle) > SHARP:
            found.append(i)
    return found


def _joined(before: Route, after: Route, radius: float) -> Route:
    """Return the turn on the spot from the end of one route to another, and that one."""
    heading = float(before.heading[-1])
    angle = math.remainder(float(after.heading[0]) - heading, 2.0 * math.pi)
    return turning(before.xz[-1], heading, angle, radius).then(after)


def _repeated(first: Route, again: Route, far: float) -> Route:
    """Return `first`, and `again` after it until that is longer than `far` [m]."""
    result = first
    for _ in range(ROUNDS):
        if result.s[-1] > far:
            break
        result = result.then(again)
    return result
