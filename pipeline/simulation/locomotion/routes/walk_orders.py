"""Walk orders: how orders change the routes and paces of walking creatures.

Source: Sims 1987, 3.2.3 and 3.2.4.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from pipeline.simulation.locomotion.routes.route import (
    Route,
    heading_vector,
    spline_route,
    straight_route,
    turn_in_place,
)
from pipeline.simulation.locomotion.routes.route_progress import (
    RouteProgress,
    choose_speed,
    redirect,
    update_pace,
)
from pipeline.simulation.spatial import Array
from pipeline.spec.script import (
    ChangeGait,
    ChangeMood,
    Do,
    GoTo,
    LookAhead,
    LookAt,
    SetSpeed,
    TurnBy,
    Wait,
)

# Relative difference between speeds that is rounding.
SPEED_TOLERANCE = 1e-9

# Distance between places that count as the same, in strides.
SAME_PLACE = 0.02

# Radius of the arc on which a walking creature turns, in strides.
TURN_RADIUS = 1.5

# Strides that a walking creature goes on before it turns: the feet that are down were placed for
# it.
TURN_LEAD = 0.5

# Least radius of an arc to a place, as a fraction of the turn radius: for places that are
# nearer and to the side, or behind, a creature comes to rest and turns in place.
MIN_ARC = 0.65

# Angle to the side within which a place counts as straight ahead.
STRAIGHT_AHEAD = math.radians(1.0)

# Angle between waypoints on an arc.
ARC_SPACING = math.radians(30.0)


def apply_order(progress: RouteProgress, c: int, order: Do) -> str | None:
    """Let creature `c` follow an order from now on; return the text of what it cannot do."""
    return ORDERS[type(order) if not isinstance(order, str) else order](progress, c, order)


def _stop(progress: RouteProgress, c: int, _order: Do) -> None:
    """End the route where braking ends."""
    if not progress.arrived[c]:
        redirect(progress, c, _braked_route(progress, c))


def _walk(progress: RouteProgress, c: int, _order: Do) -> None:
    """Go straight on from here."""
    here = _route_so_far(progress, c)
    redirect(progress, c, here.then(straight_route(here.xz[-1], float(here.heading[-1]))))


def _go_to(progress: RouteProgress, c: int, order: GoTo) -> None:
    """Go to a place; members are gone to by `pursuit`."""
    go_to_point(progress, c, np.array(order.go_to))


def go_to_point(progress: RouteProgress, c: int, target: Array) -> None:
    """Let creature `c` go to a place (2,) [m]: along an arc and straight on, or by a turn there."""
    here = _route_so_far(progress, c, TURN_LEAD)
    way = target - here.xz[-1]
    if np.linalg.norm(way) < SAME_PLACE * progress.stride[c]:
        redirect(progress, c, here)
        return
    widest = _turn_radius(progress, c)
    if progress.speed_fraction[c] != 0.0:
        heading = float(here.heading[-1])
        radius = min(_arc_radius(way, heading), widest)
        if radius >= MIN_ARC * widest:
            arc = _arc(here, _angle_towards(way, heading, radius), radius)
            if len(arc) > 1 and np.linalg.norm(arc[-1] - target) < SAME_PLACE * widest:
                arc.pop()
            redirect(progress, c, here.then(spline_route([*arc, target], heading)))
            return
        here = _braked_route(progress, c)
    redirect(progress, c, _with_turn_to(progress, c, here, target))


def go_near(progress: RouteProgress, c: int, target: Array) -> None:
    """Let creature `c` go to a place (2,) [m], or rest beside it where it is too near ahead."""
    route, gone = progress.trajectory.routes[c], float(progress.distance[c])
    braking = _braking_way(progress, c)
    place, heading = route.at(np.array([gone]))
    way = target - place[0]
    ahead = float(way @ heading_vector(heading)[0])
    if ahead >= 0.0 and np.linalg.norm(way) < max(braking, TURN_LEAD * _stride(progress, c)):
        redirect(progress, c, route.upto(min(gone + max(ahead, braking), route.length)))
    else:
        go_to_point(progress, c, target)


def _with_turn_to(progress: RouteProgress, c: int, here: Route, target: Array) -> Route:
    """Return a route continued to a place by a turn in place at its end."""
    way = target - here.xz[-1]
    if np.linalg.norm(way) < SAME_PLACE * progress.stride[c]:
        return here
    towards = math.atan2(-way[1], way[0])
    angle = math.remainder(towards - float(here.heading[-1]), 2.0 * math.pi)
    here = _with_turn(progress, c, here, angle)
    return here.then(spline_route([here.xz[-1], target], float(here.heading[-1])))


def _turn(progress: RouteProgress, c: int, order: TurnBy) -> None:
    """Turn in place at rest, and along an arc while walking."""
    here, angle = _route_so_far(progress, c, TURN_LEAD), math.radians(order.turn_deg)
    if progress.speed_fraction[c] == 0.0:
        redirect(progress, c, _with_turn(progress, c, here, angle))
        return
    heading, radius = float(here.heading[-1]), _turn_radius(progress, c)
    arc = _arc(here, angle, radius)
    arc.append(arc[-1] + radius * heading_vector(heading + angle))
    curve = here.then(spline_route(arc, heading))
    redirect(progress, c, curve.then(straight_route(curve.xz[-1], float(curve.heading[-1]))))


def _set_speed(progress: RouteProgress, c: int, order: SetSpeed) -> str | None:
    speed = choose_speed(progress, c, order.speed)
    if order.speed <= speed * (1.0 + SPEED_TOLERANCE):
        return None
    return f"goes at {speed:.3g} m/s, the most that its legs can do, instead of {order.speed:g}"


def _look_at(progress: RouteProgress, c: int, order: LookAt) -> str | None:
    try:
        progress.look_targets.set(c, order.look_at)
    except ValueError as error:
        return str(error)
    return None


def _look_ahead(progress: RouteProgress, c: int, _order: LookAhead) -> None:
    progress.look_targets.set(c, None)


def _change_gait(progress: RouteProgress, c: int, order: ChangeGait) -> None:
    progress.moods.change_gait(c, order)
    if chooses_speed(order):
        progress.hurrying.discard(c)
    update_pace(progress, c)


def _change_mood(progress: RouteProgress, c: int, order: ChangeMood) -> None:
    progress.moods.change_mood(c, order.mood, progress.time)
    update_pace(progress, c)


def chooses_speed(order: Do) -> bool:
    """Return whether an order says how fast to go."""
    if isinstance(order, ChangeGait):
        return any(key is not None for key in (order.speed, order.stride, order.cycle))
    return isinstance(order, SetSpeed)


ORDERS: dict[Any, Callable[[RouteProgress, int, Any], str | None]] = {
    ChangeGait: _change_gait,
    ChangeMood: _change_mood,
    "stop": _stop,
    Wait: _stop,
    "walk": _walk,
    GoTo: _go_to,
    TurnBy: _turn,
    SetSpeed: _set_speed,
    LookAt: _look_at,
    LookAhead: _look_ahead,
}


# --- geometry -----------------------------------------------------------------------


def _route_so_far(progress: RouteProgress, c: int, lead: float = 0.0) -> Route:
    """Return a creature's route up to where it is, or `lead` strides farther."""
    route, gone = progress.trajectory.routes[c], float(progress.distance[c])
    return route.upto(min(gone + lead * _stride(progress, c), max(route.length, gone)))


def _stride(progress: RouteProgress, c: int) -> float:
    """Return a creature's stride at its present speed [m]."""
    return float(progress.stride[c] * np.sqrt(progress.speed_fraction[c]))


def _braked_route(progress: RouteProgress, c: int) -> Route:
    """Return a creature's route up to where braking ends."""
    route = progress.trajectory.routes[c]
    return route.upto(min(float(progress.distance[c]) + _braking_way(progress, c), route.length))


def _braking_way(progress: RouteProgress, c: int) -> float:
    """Return how far a creature goes on that stops [m]."""
    return float(progress.braking_distance[c]) * float(progress.speed_fraction[c]) ** 2


def _with_turn(progress: RouteProgress, c: int, here: Route, angle: float) -> Route:
    """Return a route continued by a turn in place [rad]."""
    radius = float(np.hypot(*progress.herd.footprint[c]))
    return here.then(turn_in_place(here.xz[-1], float(here.heading[-1]), angle, radius))


def _turn_radius(progress: RouteProgress, c: int) -> float:
    """Return the radius of the arc that feet already down can follow [m]."""
    fraction = max(float(progress.speed_fraction[c]), float(progress.requested_fraction[c]))
    longer = math.sqrt(max(fraction, 1.0))
    stride = max(float(progress.stride[c]), float(progress.paces.last(c).stride))
    return TURN_RADIUS * stride * longer


def _arc(here: Route, angle: float, radius: float) -> list[Array]:
    """Return waypoints (2,) from the end of a route along an arc that turns by `angle` [rad]."""
    heading, side = float(here.heading[-1]), math.copysign(1.0, angle)
    count = math.ceil(abs(angle) / ARC_SPACING) if abs(angle) > STRAIGHT_AHEAD else 0
    centre = here.xz[-1] + radius * heading_vector(heading + side * math.pi / 2.0)
    turns = (
        heading + side * (abs(angle) * k / max(count, 1) - math.pi / 2.0) for k in range(count + 1)
    )
    return [centre + radius * heading_vector(turn) for turn in turns]


def _arc_radius(way: Array, heading: float) -> float:
    """Return the radius of the arc that starts along a heading [rad] and ends at `way` (2,) [m]."""
    across = abs(float(way @ heading_vector(heading + math.pi / 2.0)))
    return float(way @ way) / (2.0 * across) if across > 0.0 else math.inf


def _angle_towards(way: Array, heading: float, radius: float) -> float:
    """Return the turn on an arc after which a place is straight ahead [rad].

    Args:
        way: (2,) to the place, which is not within the arc [m].
        heading: now [rad].
        radius: of the arc [m].
    """
    ahead = float(way @ heading_vector(heading))
    left = float(way @ heading_vector(heading + math.pi / 2.0))
    # The arc turns to +Y about (0, radius).
    x, y, side = ahead, abs(left) - radius, math.copysign(1.0, left)
    beyond = math.sqrt(max(x * x + y * y - radius * radius, 0.0))
    on = math.atan2(y, x) + math.pi / 2.0 - math.atan2(beyond, radius)
    # Rounding must not make a whole turn towards a place straight ahead.
    return side * (max(on, 0.0) if on > -STRAIGHT_AHEAD else on + 2.0 * math.pi)
