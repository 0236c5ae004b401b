"""Routes of a walker that jumps: to the take-off place, to the landing place, and back to its way.

Source: Sims 1987, 3.2.4.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipeline.simulation.locomotion.pronking.hop_state import HopState
from pipeline.simulation.locomotion.pronking.hopper import Hopper
from pipeline.simulation.locomotion.pronking.hurdle_jump import (
    CLEARANCE,
    HurdleProfile,
    clearance_half_width,
    front_reach,
    hurdle_profile,
    plan_take_off,
    plan_vault,
    shifted_state,
)
from pipeline.simulation.locomotion.pronking.start_states import crouched_state, standing_state
from pipeline.simulation.locomotion.routes.route import (
    Route,
    connecting_route,
    heading_vector,
    turn_in_place,
)
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress, redirect
from pipeline.simulation.locomotion.routes.walk_orders import apply_order
from pipeline.simulation.spatial import Array, heading
from pipeline.simulation.terrain import Ground
from pipeline.spec.script import GoTo

LOOK_AHEAD = 200.0
"""Distance along an endless route that is searched [m]."""

ROUTE_STEP = 0.2
"""Distance of the samples along a route, in leg lengths."""

REJOIN_STRIDES = 2.5
"""Length of the way back to the route after landing beside it, in strides."""

REJOIN_RATIO = 3.0
"""Least length of that way, in distances from the route."""


TURN_TOLERANCE = math.radians(8.0)
"""Bearing of a target beyond which a creature turns to it before the jump [rad]."""


def plan_approach(
    progress: RouteProgress, c: int, hopper: Hopper, ground: Ground, solids: Sequence[Array]
) -> Route | str:
    """Return the route that ends where the solids are jumped over, or the reason why there is none.

    Args:
        progress: of the herd.
        c: number of the creature.
        hopper: how it jumps.
        ground: that it walks on.
        solids: corners (n, 3) of the hurdle [m].
    """
    previous = progress.trajectory.routes[c]
    approach = _plan_approach(progress, c, hopper, ground, solids)
    if isinstance(approach, str):
        redirect(progress, c, previous)
    return approach


def _plan_approach(
    progress: RouteProgress, c: int, hopper: Hopper, ground: Ground, solids: Sequence[Array]
) -> Route | str:
    route = progress.trajectory.routes[c]
    at = _meeting_point(route, float(progress.distance[c]), hopper, solids)
    if at is None:
        corners = np.concatenate(list(solids))[:, [0, 2]]
        x, z = (0.5 * (corners.min(axis=0) + corners.max(axis=0))).tolist()
        apply_order(progress, c, GoTo(go_to=(x, z)))
        route, at = progress.trajectory.routes[c], progress.trajectory.routes[c].length
    xz, route_heading = (a[0] for a in route.at(np.array([at])))
    hurdle = hurdle_profile(solids, xz, float(route_heading), clearance_half_width(hopper))
    if hurdle is None:
        return "it is not there"
    # A state crouching on level ground at a place (2,) [m].
    R = heading(float(route_heading))
    base = float(ground.height(xz[0], xz[1]))
    origin = np.array([xz[0], base + hopper.standing_height, xz[1]])
    feet = hopper.rest_feet @ R.T + [xz[0], 0.0, xz[1]]
    feet[:, 1] = base + hopper.foot_radii
    state = crouched_state(hopper, standing_state(hopper, R, origin, feet, 0.0))
    # It cannot stop before its braking distance.
    braking = float(progress.braking_distance[c]) * float(progress.speed_fraction[c]) ** 2
    earliest = float(progress.distance[c]) + braking
    take_off = plan_take_off(hopper, state, ground, hurdle, float(route_heading))
    if isinstance(take_off, str):
        return take_off
    stop = at + hurdle.near - take_off[0]
    if stop >= earliest:
        return route.upto(stop)
    return _stopping_problem(
        hopper, ground, state, hurdle, float(route_heading), earliest - at
    ) or route.upto(earliest)


def _stopping_problem(
    hopper: Hopper,
    ground: Ground,
    crouched: HopState,
    hurdle: HurdleProfile,
    heading: float,
    way: float,
) -> str:
    """Return why a hurdle cannot be jumped over from `way` further; empty if it can."""
    if hurdle.near - way < front_reach(hopper) + CLEARANCE * hopper.leg_length:
        return "it is too near to stop before it"
    state = shifted_state(hopper, crouched, ground, way * heading_vector(heading))
    jump = plan_vault(hopper, state, ground, hurdle.seen_from(way), heading)
    return jump if isinstance(jump, str) else ""


def route_onward(
    previous: Route, distance: float, landed: tuple[Array, float], stride: float
) -> Route | None:
    """Return the route from a landing place back to the previous one; None at its end.

    Args:
        previous: route before the jump.
        distance: along it at the start of the jump [m].
        landed: (2,) place and heading [m, rad].
        stride: of the creature [m].
    """
    place, landed_heading = landed
    offset = float(np.linalg.norm(previous.at(np.array([distance]))[0][0] - place))
    ways = distance + np.linspace(0.0, 2.0 * offset + stride, 400)
    ways = ways[ways <= previous.length]
    if not len(ways):
        return None
    gaps = np.linalg.norm(previous.at(ways)[0] - place, axis=-1)
    nearest = int(gaps.argmin())
    way = float(ways[nearest]) + max(REJOIN_STRIDES * stride, REJOIN_RATIO * float(gaps[nearest]))
    way = min(way, previous.length)
    xz, heading_there = (a[0] for a in previous.at(np.array([way])))
    if np.linalg.norm(xz - place) < 0.1 * stride or previous.length - ways[nearest] < 0.1 * stride:
        return None
    return connecting_route((place, landed_heading), (xz, float(heading_there))).then(
        previous.beyond(way)
    )


def _meeting_point(
    route: Route, start: float, hopper: Hopper, solids: Sequence[Array]
) -> float | None:
    """Return the distance along a route at which it meets solids; None if it never does [m]."""
    corners = np.concatenate(list(solids))[:, [0, 2]]
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    around = 0.5 * float(np.linalg.norm(np.ptp(corners, axis=0))) + clearance_half_width(hopper)
    ways = np.arange(start, min(route.length, start + LOOK_AHEAD), ROUTE_STEP * hopper.leg_length)
    if not len(ways):
        return None
    places, headings = route.at(ways)
    for k in np.flatnonzero(np.linalg.norm(places - middle, axis=-1) <= around).tolist():
        profile = hurdle_profile(
            solids, places[k], float(headings[k]), clearance_half_width(hopper)
        )
        if profile is not None and profile.near <= 0.0 <= profile.far:
            return float(ways[k])
    return None


def turn_towards(route: Route, target: Array, near: float, radius: float) -> Route | None:
    """Return a route with a turn towards a place appended; None if it needs none.

    Args:
        route: ends where the creature rests.
        target: (2,) the place [m].
        near: distance below which the creature does not turn [m].
        radius: of the feet around the middle of the body [m].
    """
    offset = target - route.xz[-1]
    bearing = math.atan2(-offset[1], offset[0]) - float(route.heading[-1])
    angle = math.remainder(bearing, 2.0 * math.pi)
    if abs(angle) <= TURN_TOLERANCE or np.linalg.norm(offset) <= near:
        return None
    return route.then(turn_in_place(route.xz[-1], float(route.heading[-1]), angle, radius))


def route_to_landing(route: Route, place: Array, heading: float) -> Route:
    """Return the straight route from the end of a route to a landing place."""
    start, start_heading = route.xz[-1], float(route.heading[-1])
    length = float(np.linalg.norm(place - start))
    if length < 1e-6:
        angle = math.remainder(heading - start_heading, 2.0 * math.pi)
        return turn_in_place(start, start_heading, angle, 1.0)
    return Route(
        np.array([0.0, length]),
        np.array([start, place]),
        np.array([start_heading, heading]),
        stops=True,
    )
