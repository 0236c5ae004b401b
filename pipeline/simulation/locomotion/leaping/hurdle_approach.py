"""Coming: how a walker gets to where it jumps over something, and how its way goes on behind.

Source: Sims 1987, 3.2.4.
"""

from __future__ import annotations

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
from pipeline.simulation.locomotion.pronking.initial_stance import (
    crouched_state,
    standing_state,
)
from pipeline.simulation.locomotion.routes.route import (
    Route,
    connecting_route,
    heading_vector,
)
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress
from pipeline.simulation.locomotion.routes.walk_orders import apply_order
from pipeline.simulation.spatial import Array, heading
from pipeline.simulation.terrain import Ground
from pipeline.spec.script import GoTo

LOOK_AHEAD = 200.0
"""How far along an endless way something is looked for [m]."""

ROUTE_STEP = 0.2
"""Distance between the places of a way that are looked at, in leg lengths."""

REJOIN_STRIDES = 2.5
"""Strides in which who has landed beside its way comes back to it."""

REJOIN_RATIO = 3.0
"""That it takes at least, in its distance from the way."""


def plan_approach(
    going: RouteProgress, c: int, hopper: Hopper, ground: Ground, solids: Sequence[Array]
) -> Route | str:
    """Return the way that ends where solids are jumped over, or why there is none.

    Args:
        going: of the herd.
        c: who walks.
        hopper: how it jumps.
        ground: that it walks on.
        solids: corners (n, 3) of what is to be jumped over [m].
    """
    before_it = going.path.routes[c]
    found = _plan_approach(going, c, hopper, ground, solids)
    if isinstance(found, str):
        going.lead(c, before_it)
    return found


def _plan_approach(
    going: RouteProgress, c: int, hopper: Hopper, ground: Ground, solids: Sequence[Array]
) -> Route | str:
    route = going.path.routes[c]
    at = _meeting_point(route, float(going.way[c]), hopper, solids)
    if at is None:
        corners = np.concatenate(list(solids))[:, [0, 2]]
        x, z = (0.5 * (corners.min(axis=0) + corners.max(axis=0))).tolist()
        apply_order(going, c, GoTo(go_to=(x, z)))
        route, at = going.path.routes[c], going.path.routes[c].length
    xz, turned = (a[0] for a in route.at(np.array([at])))
    hurdle = hurdle_profile(solids, xz, float(turned), clearance_half_width(hopper))
    if hurdle is None:
        return "it is not there"
    there = _standing_at(hopper, ground, xz, float(turned))
    # No nearer than it can come to rest.
    first = float(going.way[c]) + float(going.braking[c]) * float(going.drive[c]) ** 2
    found = plan_take_off(hopper, there, ground, hurdle, float(turned))
    if isinstance(found, str):
        return found
    stop = at + hurdle.near - found[0]
    if stop >= first:
        return route.upto(stop)
    return _stopping_problem(
        hopper, ground, there, hurdle, float(turned), first - at
    ) or route.upto(first)


def _stopping_problem(
    hopper: Hopper,
    ground: Ground,
    there: HopState,
    hurdle: HurdleProfile,
    turned: float,
    way: float,
) -> str:
    """Return why a hurdle cannot be jumped over from so far along the way; empty if it can."""
    if hurdle.near - way < front_reach(hopper) + CLEARANCE * hopper.leg_length:
        return "it is too near to stop before it"
    state = shifted_state(hopper, there, ground, way * heading_vector(turned))
    one = plan_vault(hopper, state, ground, hurdle.seen_from(way), turned)
    return one if isinstance(one, str) else ""


def route_onward(
    rest: Route, left: float, landed: tuple[Array, float], stride: float
) -> Route | None:
    """Return the way on from where a jump has landed, None if it has come to its end.

    Args:
        rest: the way before the jump.
        left: where on it the jump began [m].
        landed: (2,) where, and heading [m, rad].
        stride: of the creature [m].
    """
    place, turned = landed
    far = float(np.linalg.norm(rest.at(np.array([left]))[0][0] - place))
    ways = left + np.linspace(0.0, 2.0 * far + stride, 400)
    ways = ways[ways <= rest.length]
    if not len(ways):
        return None
    gaps = np.linalg.norm(rest.at(ways)[0] - place, axis=-1)
    nearest = int(gaps.argmin())
    way = float(ways[nearest]) + max(REJOIN_STRIDES * stride, REJOIN_RATIO * float(gaps[nearest]))
    way = min(way, rest.length)
    xz, heading_there = (a[0] for a in rest.at(np.array([way])))
    if np.linalg.norm(xz - place) < 0.1 * stride or rest.length - ways[nearest] < 0.1 * stride:
        return None
    return connecting_route((place, turned), (xz, float(heading_there))).then(rest.beyond(way))


def _meeting_point(
    route: Route, way: float, hopper: Hopper, solids: Sequence[Array]
) -> float | None:
    """Return after which way a route comes over solids [m], None if it never does."""
    corners = np.concatenate(list(solids))[:, [0, 2]]
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    around = 0.5 * float(np.linalg.norm(np.ptp(corners, axis=0))) + clearance_half_width(hopper)
    ways = np.arange(way, min(route.length, way + LOOK_AHEAD), ROUTE_STEP * hopper.leg_length)
    if not len(ways):
        return None
    places, headings = route.at(ways)
    for k in np.flatnonzero(np.linalg.norm(places - middle, axis=-1) <= around).tolist():
        one = hurdle_profile(solids, places[k], float(headings[k]), clearance_half_width(hopper))
        if one is not None and one.near <= 0.0 <= one.far:
            return float(ways[k])
    return None


def _standing_at(hopper: Hopper, ground: Ground, xz: Array, turned: float) -> HopState:
    """Return the state of one that has crouched on level ground at a place (2,) [m]."""
    R = heading(turned)
    base = float(ground.height(xz[0], xz[1]))
    origin = np.array([xz[0], base + hopper.standing_height, xz[1]])
    feet = hopper.rest_feet @ R.T + [xz[0], 0.0, xz[1]]
    feet[:, 1] = base + hopper.sole_radii
    return crouched_state(hopper, standing_state(hopper, R, origin, feet, 0.0))
