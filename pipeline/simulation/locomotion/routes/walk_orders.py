"""Directing: what orders do to the ways and paces of walking creatures.

Source: Sims 1987, 3.2.3 and 3.2.4.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from pipeline.simulation.locomotion.body_motion.gaze import set_look_target
from pipeline.simulation.locomotion.routes.route import (
    Route,
    heading_vector,
    spline_route,
    straight_route,
    turn_in_place,
)
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress
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

NEAR = 0.02
"""Places nearer to one another than this part of the stride are the same."""

WIDE = 1.5
"""Radius of the arc on which who walks is turned, as a part of the stride."""

LEAD = 0.5
"""Strides that who walks goes on as before it turns: feet that are down were put there for it."""

NARROW = 0.65
"""Least radius of an arc to a place, as a part of that one: for what is nearer and to the side, or
behind, who walks comes to rest, and turns on the spot."""

AHEAD = math.radians(1.0)
"""How far to the side a place is that is straight ahead."""

ARC = math.radians(30.0)
"""Between waypoints on that arc."""


def apply_order(going: RouteProgress, c: int, order: Do) -> str | None:
    """Let creature `c` do as it is told from now on; return what of it it cannot do."""
    return ORDERS[type(order) if not isinstance(order, str) else order](going, c, order)


def _stop(going: RouteProgress, c: int, order: Do) -> None:
    """End the way where braking ends."""
    del order
    if not going.arrived[c]:
        going.lead(c, _braked(going, c))


def _walk(going: RouteProgress, c: int, order: Do) -> None:
    """Go straight on from here."""
    del order
    here = _here(going, c)
    going.lead(c, here.then(straight_route(here.xz[-1], float(here.heading[-1]))))


def _go_to(going: RouteProgress, c: int, order: GoTo) -> None:
    """Go to a place: along an arc and straight on, or by a turn on the spot."""
    here, target = _here(going, c, LEAD), np.array(order.go_to)
    way = target - here.xz[-1]
    if np.linalg.norm(way) < NEAR * going.full[c]:
        going.lead(c, here)
        return
    widest = _radius(going, c)
    if going.drive[c] != 0.0:
        heading = float(here.heading[-1])
        radius = min(_arc_through(way, heading), widest)
        if radius >= NARROW * widest:
            arc = _arc(here, _towards(way, heading, radius), radius)
            if len(arc) > 1 and np.linalg.norm(arc[-1] - target) < NEAR * widest:
                arc.pop()
            going.lead(c, here.then(spline_route([*arc, target], heading)))
            return
        here = _braked(going, c)
    going.lead(c, _turned_to(going, c, here, target))


def _turned_to(going: RouteProgress, c: int, here: Route, target: Array) -> Route:
    """Return the way to a place by a turn on the spot at the end of the route so far."""
    way = target - here.xz[-1]
    if np.linalg.norm(way) < NEAR * going.full[c]:
        return here
    towards = math.atan2(-way[1], way[0])
    angle = math.remainder(towards - float(here.heading[-1]), 2.0 * math.pi)
    here = here.then(_spot(going, c, here, angle))
    return here.then(spline_route([here.xz[-1], target], float(here.heading[-1])))


def _turn(going: RouteProgress, c: int, order: TurnBy) -> None:
    """Turn on the spot who stands, and along an arc who walks."""
    here, angle = _here(going, c, LEAD), math.radians(order.turn_deg)
    if going.drive[c] == 0.0:
        going.lead(c, here.then(_spot(going, c, here, angle)))
        return
    heading, radius = float(here.heading[-1]), _radius(going, c)
    arc = _arc(here, angle, radius)
    arc.append(arc[-1] + radius * heading_vector(heading + angle))
    curve = here.then(spline_route(arc, heading))
    going.lead(c, curve.then(straight_route(curve.xz[-1], float(curve.heading[-1]))))


def _radius(going: RouteProgress, c: int) -> float:
    """Return the radius of the arc on which feet that are down already can follow [m]."""
    return WIDE * max(float(going.full[c]), float(going.paces.last(c).stride))


def _arc(here: Route, angle: float, radius: float) -> list[Array]:
    """Return waypoints (2,) from the end of a route along an arc that turns by `angle` [rad]."""
    heading, side = float(here.heading[-1]), math.copysign(1.0, angle)
    count = math.ceil(abs(angle) / ARC) if abs(angle) > AHEAD else 0
    centre = here.xz[-1] + radius * heading_vector(heading + side * math.pi / 2.0)
    turns = (
        heading + side * (abs(angle) * k / max(count, 1) - math.pi / 2.0) for k in range(count + 1)
    )
    return [centre + radius * heading_vector(turn) for turn in turns]


def _arc_through(way: Array, heading: float) -> float:
    """Return the radius of the arc that begins along a heading [rad] and ends at `way` (2,) [m]."""
    across = abs(float(way @ heading_vector(heading + math.pi / 2.0)))
    return float(way @ way) / (2.0 * across) if across > 0.0 else math.inf


def _towards(way: Array, heading: float, radius: float) -> float:
    """Return by how much one turns on an arc until a place is straight ahead [rad].

    Args:
        way: (2,) to the place, which is not within the arc [m].
        heading: now [rad].
        radius: of the arc [m].
    """
    ahead, left = (
        float(way @ heading_vector(heading)),
        float(way @ heading_vector(heading + math.pi / 2.0)),
    )
    # The arc turns to +Y about (0, radius).
    x, y, side = ahead, abs(left) - radius, math.copysign(1.0, left)
    beyond = math.sqrt(max(x * x + y * y - radius * radius, 0.0))
    on = math.atan2(y, x) + math.pi / 2.0 - math.atan2(beyond, radius)
    # What is straight ahead is not gone to by a whole turn.
    return side * (max(on, 0.0) if on > -AHEAD else on + 2.0 * math.pi)


def _set_speed(going: RouteProgress, c: int, order: SetSpeed) -> str | None:
    """Change the speed, as far as the legs can: the stride grows with its root."""
    pace = going.paces.last(c)
    full = pace.stride / pace.cycle
    most = full * max(pace.longest / pace.stride, 1.0) ** 2
    going.let(c, min(order.speed, most) / full)
    if order.speed <= most:
        return None
    return f"goes at {most:.3g} m/s, the most that its legs can do, instead of {order.speed:g}"


def _look_at(going: RouteProgress, c: int, order: LookAt) -> str | None:
    """Look at something from now on."""
    try:
        going.looks = set_look_target(going.looks, going.herd, c, order.look_at)
    except ValueError as error:
        return str(error)
    return None


def _look(going: RouteProgress, c: int, order: LookAhead) -> None:
    """Look ahead again."""
    del order
    going.looks = set_look_target(going.looks, going.herd, c, None)


def _here(going: RouteProgress, c: int, lead: float = 0.0) -> Route:
    """Return its route up to where it is, or as many strides farther."""
    route = going.path.routes[c]
    ahead = lead * float(going.stride[c])
    return route.upto(min(float(going.way[c]) + ahead, max(route.length, float(going.way[c]))))


def _braked(going: RouteProgress, c: int) -> Route:
    """Return its route up to where braking ends."""
    braking = 0.5 * float(going.full[c]) * float(going.drive[c]) ** 2
    route = going.path.routes[c]
    return route.upto(min(float(going.way[c]) + braking, route.length))


def _spot(going: RouteProgress, c: int, here: Route, angle: float) -> Route:
    radius = float(np.hypot(*going.herd.footprint[c]))
    return turn_in_place(here.xz[-1], float(here.heading[-1]), angle, radius)


def _change_gait(going: RouteProgress, c: int, order: ChangeGait) -> None:
    """Go over into another gait, and go at its own speed."""
    going.take_on(c, going.manners.told(c, order))


def _change_mood(going: RouteProgress, c: int, order: ChangeMood) -> None:
    """Walk and carry itself otherwise from now on."""
    going.take_on(c, going.manners.felt(c, order.mood, going.time))


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
    LookAhead: _look,
}
