"""Directing: what orders do to the ways and paces of walking creatures.

Source: Sims 1987, 3.2.3 and 3.2.4.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from pipeline.simulation.locomotion.carriage.looking import look_of
from pipeline.simulation.locomotion.ways.going import Going
from pipeline.simulation.locomotion.ways.route import Route, direction, straight, through, turning
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

WIDE = 1.2
"""Radius of the arc on which who walks is turned, as a part of the stride."""

ARC = math.radians(30.0)
"""Between waypoints on that arc."""


def obey(going: Going, c: int, order: Do) -> str | None:
    """Let creature `c` do as it is told from now on; return what of it it cannot do."""
    return ORDERS[type(order) if not isinstance(order, str) else order](going, c, order)


def _stop(going: Going, c: int, order: Do) -> None:
    """End the way where braking ends."""
    del order
    if not going.arrived[c]:
        braking = 0.5 * float(going.full[c]) * float(going.drive[c]) ** 2
        route = going.path.routes[c]
        going.lead(c, route.upto(min(float(going.way[c]) + braking, route.length)))


def _walk(going: Going, c: int, order: Do) -> None:
    """Go straight on from here."""
    del order
    here = _here(going, c)
    going.lead(c, here.then(straight(here.xz[-1], float(here.heading[-1]))))


def _go_to(going: Going, c: int, order: GoTo) -> None:
    """Go to a place: a turn on the spot first, if it stands, then a curve."""
    here, target = _here(going, c), np.array(order.go_to)
    way = target - here.xz[-1]
    if np.linalg.norm(way) < NEAR * going.full[c]:
        going.lead(c, here)
        return
    if going.drive[c] == 0.0:
        towards = math.atan2(-way[1], way[0])
        angle = math.remainder(towards - float(here.heading[-1]), 2.0 * math.pi)
        here = here.then(_spot(going, c, here, angle))
    heading = float(here.heading[-1])
    points = [here.xz[-1], target]
    ahead = float(way @ direction(heading))
    if ahead < 0.0:
        # What lies behind is gone to by a wide curve, not by a hairpin.
        side = math.copysign(1.0, float(way @ direction(heading + math.pi / 2.0)))
        across = direction(heading + side * math.pi / 2.0)
        radius = WIDE * float(going.full[c])
        points.insert(1, here.xz[-1] + radius * (direction(heading) + across))
    going.lead(c, here.then(through(points, heading)))


def _turn(going: Going, c: int, order: TurnBy) -> None:
    """Turn on the spot who stands, and along an arc who walks."""
    here, angle = _here(going, c), math.radians(order.turn_deg)
    if going.drive[c] == 0.0:
        going.lead(c, here.then(_spot(going, c, here, angle)))
        return
    heading, radius = float(here.heading[-1]), WIDE * float(going.full[c])
    count = max(math.ceil(abs(angle) / ARC), 1)
    side = math.copysign(1.0, angle)
    centre = here.xz[-1] + radius * direction(heading + side * math.pi / 2.0)
    arc = [
        centre + radius * direction(heading + side * (abs(angle) * k / count - math.pi / 2.0))
        for k in range(count + 1)
    ]
    arc.append(arc[-1] + radius * direction(heading + angle))
    curve = here.then(through(arc, heading))
    going.lead(c, curve.then(straight(curve.xz[-1], float(curve.heading[-1]))))


def _set_speed(going: Going, c: int, order: SetSpeed) -> str | None:
    """Change the speed, as far as the legs can: the stride grows with its root."""
    pace = going.paces.last(c)
    full = pace.stride / pace.cycle
    most = full * max(pace.longest / pace.stride, 1.0) ** 2
    going.let(c, min(order.speed, most) / full)
    if order.speed <= most:
        return None
    return f"goes at {most:.3g} m/s, the most that its legs can do, instead of {order.speed:g}"


def _look_at(going: Going, c: int, order: LookAt) -> str | None:
    """Look at something from now on."""
    try:
        going.looks = {**going.looks, c: look_of(going.herd, c, order.look_at)}
    except ValueError as error:
        return str(error)
    return None


def _look(going: Going, c: int, order: LookAhead) -> None:
    """Look ahead again."""
    del order
    going.looks = {who: look for who, look in going.looks.items() if who != c}


def _here(going: Going, c: int) -> Route:
    """Return what is gone of its route."""
    return going.path.routes[c].upto(float(going.way[c]))


def _spot(going: Going, c: int, here: Route, angle: float) -> Route:
    radius = float(np.hypot(*going.herd.footprint[c]))
    return turning(here.xz[-1], float(here.heading[-1]), angle, radius)


def _change_gait(going: Going, c: int, order: ChangeGait) -> None:
    """Go over into another gait, and go at its own speed."""
    going.take_on(c, going.manners.told(c, order))


def _change_mood(going: Going, c: int, order: ChangeMood) -> None:
    """Walk and carry itself otherwise from now on."""
    going.take_on(c, going.manners.felt(c, order.mood, going.time))


ORDERS: dict[Any, Callable[[Going, int, Any], str | None]] = {
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
