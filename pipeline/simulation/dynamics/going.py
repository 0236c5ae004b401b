"""Going: a body on its way through a step, strike by strike and sub-step by sub-step."""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.dynamics.compiled import Record, Records, compiled, entry
from pipeline.simulation.dynamics.contacts import least
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.grid import Grid, highest
from pipeline.simulation.dynamics.leaning import HELD, holding, leant, paid
from pipeline.simulation.dynamics.meeting import meet, under
from pipeline.simulation.dynamics.path import Path, along
from pipeline.simulation.dynamics.records import Motion, Room, Shapes, now, place
from pipeline.simulation.dynamics.striking import REST, Strike, strike
from pipeline.simulation.dynamics.tumbling import MOST_TURN, tumbled, tumbling
from pipeline.simulation.dynamics.vectors import (
    Rows,
    length,
    minus,
    rotation,
    rows_of,
    times,
    triple,
    turned,
)
from pipeline.simulation.spatial import Array

LONGEST = 1.0 / 240.0
"""Longest sub-step near the ground [s]."""

FREE_LONGEST = 1.0 / 24.0
"""Longest sub-step of a flight that meets nothing [s]."""

TRAVEL = 0.5
"""Way of any point in a sub-step near the ground, in the depth of the body: none passes
through what is higher than that."""

DEEP = 1e-7
"""Depth at which a body in flight has struck, in sizes; an impact is located to half of it."""

DEEP_HELD = 2e-5
"""The same of new contacts of a body that the ground holds already."""

SLACK = 0.02
"""Gap up to which contacts are told, in sizes of the body."""

LOCATING = 60
"""Most times that a path is cut to find an impact."""

AT_ONCE = 1e-12
"""Time in which what happens happens at once [s]."""

MOST_ROUNDS = 400
"""Sub-steps of one step; what needs more is stuck, and loses the rest of its step."""

QUIET = 0.01
"""Speed of any point below which a body is quiet [m/s]."""

QUIET_TIME = 0.4
"""How long a body is quiet until it sleeps [s]."""

PROPPED, PROPPED_TIME = 3, 1.5
"""Contacts that let a body lie safely; one with fewer sleeps after this time [s]."""

DONE = 1e-12
"""What is left of a step when it is over [s]."""

STRIKES = 10
"""Columns of a list of strikes: body, time, place, normal, speed, energy."""


@entry
def go(
    grid: Grid,
    shapes: Shapes,
    bodies: Records,
    room: Room,
    dt: float,
) -> Array:
    """Take bodies that are awake through a step; return their strikes (n, STRIKES).

    Args:
        grid: the ground.
        shapes: of all bodies.
        bodies: N `BODY`.
        room: for one of them at a time.
        dt: the step [s].
    """
    strikes, count = np.empty((16, STRIKES)), 0
    for b in range(len(bodies)):
        body = bodies[b]
        if not body.awake:
            continue
        body.quiet += dt
        left = dt
        for _ in range(MOST_ROUNDS):
            if left <= DONE:
                break
            if body.pushed == 0.0 and least(body) <= HELD * body.size:
                one = _struck(body, room.parts)
                if one.speed >= REST:
                    if count == len(strikes):
                        strikes = np.concatenate((strikes, np.empty_like(strikes)))
                    _write(strikes[count], b, dt - left, triple(body.p), one)
                    count += 1
            left -= _sub_step(grid, shapes, body, room, left)
        _fall_asleep(body)
    return strikes[:count]


@entry
def look(grid: Grid, shapes: Shapes, bodies: Records, room: Room, slack: float) -> None:
    """Find the contacts of bodies that were put somewhere, up to gaps of `slack` [m]."""
    for b in range(len(bodies)):
        body = bodies[b]
        motion = now(body)
        meet(grid, shapes, body, motion.p, motion.q, slack, room)


@compiled
def _write(strikes: Array, b: int, time: float, p: tuple[float, float, float], one: Strike) -> None:
    strikes[0], strikes[1] = b, time
    for i in range(3):
        strikes[2 + i], strikes[5 + i] = p[i] + one.place[i], one.normal[i]
    strikes[8], strikes[9] = one.speed, one.energy


@compiled
def _struck(body: Record, parts: Records) -> Strike:
    """Let a body that touches the ground, and approaches it, bounce."""
    motion = now(body)
    one = strike(body, motion, parts)
    # Only what bounces is pushed for a while; what rests is held.
    if body.soft > 0.0 and one.speed >= REST:
        # The force makes up for gravity as well: Sims 1987, (12.11) and (12.19).
        body.pushed = body.soft
        push_v = times(1.0 / body.soft, minus(one.v, motion.v))
        push_w = times(1.0 / body.soft, turned(rotation(motion.q), minus(one.w, motion.w)))
        for i in range(3):
            body.push_v[i], body.push_w[i] = push_v[i], push_w[i]
    else:
        place(body, Motion(motion.p, motion.q, one.v, one.w))
    return one


@compiled
def _sub_step(
    grid: Grid,
    shapes: Shapes,
    body: Record,
    room: Room,
    left: float,
) -> float:
    """Take a body on by a sub-step, or to where it strikes; return how long [s]."""
    motion, before, pushed = now(body), least(body), body.pushed > 0.0
    speed = length(motion.v) + length(motion.w) * body.reach
    h = _length(grid.frame, grid.tops, body, motion, speed, left)
    R = rotation(motion.q)
    n = 0
    if not pushed and before <= HELD * body.size:
        n = holding(body, motion, R, h, room.parts)
    path = _path(body, motion, R, n, h, room)
    # What lies deeper from the begin may stay so, but not go deeper.
    deep = (DEEP_HELD if n > 0 else DEEP) * body.size
    limit = -np.inf if pushed else min(before, 0.0) - deep
    slack = SLACK * body.size + (speed + GRAVITY * h) * h
    h, end = _located(grid, shapes, body, path, h, limit, before, deep, slack, room)
    place(body, paid(body, motion, end) if n > 0 else end)
    _after(body, h, pushed)
    return h


@compiled
def _length(
    frame: Record, tops: Array, body: Record, motion: Motion, speed: float, left: float
) -> float:
    """Return how long a sub-step may be [s]."""
    h, rate = min(left, FREE_LONGEST), length(motion.w)
    if rate * h > MOST_TURN:
        h = MOST_TURN / rate
    way = h * (speed + h * GRAVITY)
    x, y, z = motion.p
    if y - body.reach - way <= highest(frame, tops, x, z, body.reach + way):
        h = min(h, LONGEST)
        if speed * h > TRAVEL * body.thin:
            h = TRAVEL * body.thin / speed
        # In equal parts: a short one at the end is no cheaper.
        h = left / math.ceil(left / h)
    return min(h, body.pushed) if body.pushed > 0.0 else h


@compiled
def _path(body: Record, motion: Motion, R: Rows, n: int, h: float, room: Room) -> Path:
    """Return the motion over a sub-step, of a body that n contacts hold."""
    turn, nothing = turned(R, motion.w), (0.0, 0.0, 0.0)
    if body.pushed > 0.0:
        body.held = 0
        return Path(motion, triple(body.push_v), True, turn, triple(body.push_w), 0, room.series)
    inertia, inverse = rows_of(body.inertia), rows_of(body.inverse)
    order = tumbling(motion.q, motion.w, inertia, inverse, h, room.series)
    if n == 0:
        body.held = 0
        return Path(motion, (0.0, -GRAVITY, 0.0), False, turn, nothing, order, room.series)
    q, w = tumbled(room.series, order, h)
    v, after = leant(body, motion, R, room.parts, n, turned(rotation(q), w), h)
    a, turn_rate = times(1.0 / h, minus(v, motion.v)), times(1.0 / h, minus(after, turn))
    return Path(motion, a, True, turn, turn_rate, order, room.series)


@compiled
def _located(
    grid: Grid,
    shapes: Shapes,
    body: Record,
    path: Path,
    h: float,
    limit: float,
    before: float,
    deep: float,
    slack: float,
    room: Room,
) -> tuple[float, Motion]:
    """Cut a path where a body gets below its limit; return its length and end.

    By false position, the end that stays having its weight halved (Illinois).
    """
    cut, low, high, f_low, f_high = h, 0.0, h, 0.0, 0.0
    aim = limit + 0.5 * deep
    end = _moved(grid, shapes, body, path, cut, slack, room)
    f = least(body) - aim
    if f + 0.5 * deep >= 0.0:
        return cut, end
    # A contact that is just leaving is as near as nothing: it must not draw the search.
    f_high, f_low = f, min(max(before - aim, -f), -1e3 * f)
    for i in range(LOCATING):
        cut = 0.5 * (low + high)
        if i % 4 != 3:
            cut = high - f_high * (high - low) / (f_high - f_low)
        end = _moved(grid, shapes, body, path, cut, slack, room)
        f = least(body) - aim
        if abs(f) <= 0.45 * deep:
            return cut, end
        if f < 0.0:
            high, f_high, f_low = cut, f, 0.5 * f_low
        else:
            low, f_low, f_high = cut, f, 0.5 * f_high
        if high - low <= AT_ONCE:
            break
    # A contact that is deep at once, as in a corner of the ground that an edge slides into:
    # it is there at the end of the search alone.
    return high, _moved(grid, shapes, body, path, high, slack, room)


@compiled
def _moved(
    grid: Grid, shapes: Shapes, body: Record, path: Path, t: float, slack: float, room: Room
) -> Motion:
    """Return how a body is after a time t, its contacts there having been found."""
    end = along(path, t)
    if under(grid, body, end.p):
        body.count = 0
        return end
    meet(grid, shapes, body, end.p, end.q, slack, room)
    for k in range(body.count):
        body.gap[k] += body.sunk
    return end


@compiled
def _after(body: Record, h: float, pushed: bool) -> None:
    """Keep account of a push, of a dent, and of how long a body has been quiet."""
    left = max(body.pushed - h, 0.0) if pushed else 0.0
    body.pushed = left if left >= 1e-9 else 0.0
    if body.sunk > 0.0 or pushed:
        depth = max(body.sunk - least(body), 0.0)
        grown = depth - body.sunk
        if pushed or grown < 0.0:
            body.sunk = depth
            for k in range(body.count):
                body.gap[k] += grown
    speed = length(triple(body.v)) + length(triple(body.w)) * body.reach
    if speed > QUIET or body.held == 0:
        body.quiet = 0.0


@compiled
def _fall_asleep(body: Record) -> None:
    """Let a body sleep that has long been quiet."""
    propped = body.held >= PROPPED or body.radius > 0.0
    if body.quiet >= (QUIET_TIME if propped else PROPPED_TIME):
        body.awake = False
        for i in range(3):
            body.v[i] = body.w[i] = 0.0
