"""Rigid step: one body goes through a step, impact by impact and sub-step by sub-step.

In flight the acceleration is constant and the rotation a power series. While the ground holds or
pushes a body, its velocities change linearly to those after the sub-step. So positions are
exact in both: p + v t + a t² / 2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipeline.simulation.dynamics.body_record import (
    Motion,
    Shapes,
    Workspace,
    motion_of,
    set_motion,
    smallest_gap,
)
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, entry
from pipeline.simulation.dynamics.free_motion import (
    MAX_STEP_ANGLE,
    evaluate_rotation,
    rotate_by_vector,
    rotation_series,
)
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.impact import REST_SPEED, Impact, resolve_impact
from pipeline.simulation.dynamics.resting_contact import (
    HOLD_GAP,
    held_velocity,
    holding_contacts,
    limit_energy,
)
from pipeline.simulation.dynamics.terrain_contacts import find_body_contacts, is_under_ground
from pipeline.simulation.dynamics.terrain_grid import Grid, highest_around
from pipeline.simulation.dynamics.vectors import (
    Rows,
    Vector,
    inverse_turned,
    length,
    minus,
    plus,
    rotation,
    rows_of,
    times,
    triple,
    turned,
)
from pipeline.simulation.spatial import Array

MAX_CONTACT_STEP = 1.0 / 240.0
"""Longest sub-step near the ground [s]."""

MAX_FLIGHT_STEP = 1.0 / 24.0
"""Longest sub-step of a flight that meets nothing [s]."""

MAX_TRAVEL = 0.5
"""Way of any point in a sub-step near the ground, in thicknesses of the body: none passes
through anything higher."""

IMPACT_DEPTH = 1e-7
"""Depth at which a body in flight has struck, in sizes; impacts are located to half of it."""

HELD_IMPACT_DEPTH = 2e-5
"""The same for new contacts of a body that the ground holds already."""

CONTACT_MARGIN = 0.02
"""Gap up to which contacts are kept, in sizes of the body."""

MAX_ROOT_ITERATIONS = 60
"""Largest number of bisections of a path in search of an impact."""

MIN_BRACKET = 1e-12
"""Length of a time bracket that ends the search [s]."""

MAX_SUBSTEPS = 400
"""Sub-steps of one step; a body that needs more is stuck and loses the rest of its step."""

SLEEP_SPEED = 0.01
"""Speed of any point below which a body is quiet [m/s]."""

SLEEP_TIME = 0.4
"""Quiet time after which a body with stable support sleeps [s]."""

STABLE_CONTACTS = 3
"""Contacts that support a body stably."""

UNSTABLE_SLEEP_TIME = 1.5
"""Quiet time after which a body with fewer contacts sleeps [s]."""

MIN_TIME_LEFT = 1e-12
"""Remaining time at which a step is over [s]."""

IMPACT_COLUMNS = 10
"""Columns of an impact: body, time, place, normal, speed, energy."""


@entry
def advance_bodies(
    grid: Grid,
    shapes: Shapes,
    bodies: Records,
    room: Workspace,
    dt: float,
) -> Array:
    """Advances all bodies that are awake; returns their impacts (n, IMPACT_COLUMNS).

    Args:
        grid: the ground.
        shapes: of all bodies.
        bodies: N `BODY` records.
        room: workspace for one body.
        dt: the step [s].
    """
    strikes, count = np.empty((16, IMPACT_COLUMNS)), 0
    for b in range(len(bodies)):
        body = bodies[b]
        if not body.awake:
            continue
        body.quiet += dt
        left = dt
        for _ in range(MAX_SUBSTEPS):
            if left <= MIN_TIME_LEFT:
                break
            if body.pushed == 0.0 and smallest_gap(body) <= HOLD_GAP * body.size:
                impact = _resolve_impact(body, room.parts)
                if impact.speed >= REST_SPEED:
                    if count == len(strikes):
                        strikes = np.concatenate((strikes, np.empty_like(strikes)))
                    _write_impact(strikes[count], b, dt - left, triple(body.p), impact)
                    count += 1
            left -= _sub_step(grid, shapes, body, room, left)
        _fall_asleep(body)
    return strikes[:count]


@entry
def find_contacts(
    grid: Grid, shapes: Shapes, bodies: Records, room: Workspace, slack: float
) -> None:
    """Finds the contacts of bodies at their present poses, up to gaps of `slack` [m]."""
    for b in range(len(bodies)):
        body = bodies[b]
        motion = motion_of(body)
        find_body_contacts(grid, shapes, body, motion.p, motion.q, slack, room)


@compiled
def _write_impact(
    strikes: Array, b: int, time: float, p: tuple[float, float, float], impact: Impact
) -> None:
    strikes[0], strikes[1] = b, time
    for i in range(3):
        strikes[2 + i], strikes[5 + i] = p[i] + impact.place[i], impact.normal[i]
    strikes[8], strikes[9] = impact.speed, impact.energy


@compiled
def _resolve_impact(body: Record, parts: Records) -> Impact:
    """Resolves the impact of a body that touches and approaches the ground."""
    motion = motion_of(body)
    impact = resolve_impact(body, motion, parts)
    # Soft ground acts over a while on a bounce only; a resting body is held.
    if body.soft > 0.0 and impact.speed >= REST_SPEED:
        # The force compensates gravity as well: Sims 1987, (12.11) and (12.19).
        body.pushed = body.soft
        push_v = times(1.0 / body.soft, minus(impact.v, motion.v))
        push_w = times(1.0 / body.soft, turned(rotation(motion.q), minus(impact.w, motion.w)))
        for i in range(3):
            body.push_v[i], body.push_w[i] = push_v[i], push_w[i]
    else:
        set_motion(body, Motion(motion.p, motion.q, impact.v, impact.w))
    return impact


@compiled
def _sub_step(
    grid: Grid,
    shapes: Shapes,
    body: Record,
    room: Workspace,
    left: float,
) -> float:
    """Advances a body by a sub-step, or up to its next impact; returns the time taken [s]."""
    motion, before, pushed = motion_of(body), smallest_gap(body), body.pushed > 0.0
    speed = length(motion.v) + length(motion.w) * body.reach
    h = _substep_length(grid.frame, grid.tops, body, motion, speed, left)
    R = rotation(motion.q)
    n = 0
    if not pushed and before <= HOLD_GAP * body.size:
        n = holding_contacts(body, motion, R, h, room.parts)
    path = _substep_path(body, motion, R, n, h, room)
    # A contact that is deeper at the start may stay so, but not go deeper.
    deep = (HELD_IMPACT_DEPTH if n > 0 else IMPACT_DEPTH) * body.size
    limit = -np.inf if pushed else min(before, 0.0) - deep
    slack = CONTACT_MARGIN * body.size + (speed + GRAVITY * h) * h
    h, end = _locate_impact(grid, shapes, body, path, h, limit, before, deep, slack, room)
    set_motion(body, limit_energy(body, motion, end) if n > 0 else end)
    _update_timers(body, h, pushed)
    return h


@compiled
def _substep_length(
    frame: Record, tops: Array, body: Record, motion: Motion, speed: float, left: float
) -> float:
    """Returns the length of the next sub-step [s]."""
    h, rate = min(left, MAX_FLIGHT_STEP), length(motion.w)
    if rate * h > MAX_STEP_ANGLE:
        h = MAX_STEP_ANGLE / rate
    way = h * (speed + h * GRAVITY)
    x, y, z = motion.p
    if y - body.reach - way <= highest_around(frame, tops, x, z, body.reach + way):
        h = min(h, MAX_CONTACT_STEP)
        if speed * h > MAX_TRAVEL * body.thin:
            h = MAX_TRAVEL * body.thin / speed
        # In equal parts: a short last one is no cheaper.
        h = left / math.ceil(left / h)
    return min(h, body.pushed) if body.pushed > 0.0 else h


@compiled
def _substep_path(
    body: Record, motion: Motion, R: Rows, n: int, h: float, room: Workspace
) -> SubstepPath:
    """Returns the motion over a sub-step of a body held by n contacts."""
    turn, nothing = turned(R, motion.w), (0.0, 0.0, 0.0)
    if body.pushed > 0.0:
        body.held = 0
        return SubstepPath(
            motion, triple(body.push_v), True, turn, triple(body.push_w), 0, room.series
        )
    inertia, inverse = rows_of(body.inertia), rows_of(body.inverse)
    order = rotation_series(motion.q, motion.w, inertia, inverse, h, room.series)
    if n == 0:
        body.held = 0
        return SubstepPath(motion, (0.0, -GRAVITY, 0.0), False, turn, nothing, order, room.series)
    q, w = evaluate_rotation(room.series, order, h)
    v, after = held_velocity(body, motion, R, room.parts, n, turned(rotation(q), w), h)
    a, turn_rate = times(1.0 / h, minus(v, motion.v)), times(1.0 / h, minus(after, turn))
    return SubstepPath(motion, a, True, turn, turn_rate, order, room.series)


@compiled
def _locate_impact(
    grid: Grid,
    shapes: Shapes,
    body: Record,
    path: SubstepPath,
    h: float,
    limit: float,
    before: float,
    deep: float,
    slack: float,
    room: Workspace,
) -> tuple[float, Motion]:
    """Shortens a path to where a gap falls below `limit`; returns its length and end.

    False position with halved weights (Illinois).
    """
    cut, low, high, f_low, f_high = h, 0.0, h, 0.0, 0.0
    aim = limit + 0.5 * deep
    end = _contacts_at(grid, shapes, body, path, cut, slack, room)
    f = smallest_gap(body) - aim
    if f + 0.5 * deep >= 0.0:
        return cut, end
    # A separating contact has a gap near zero and must not attract the search.
    f_high, f_low = f, min(max(before - aim, -f), -1e3 * f)
    for i in range(MAX_ROOT_ITERATIONS):
        cut = 0.5 * (low + high)
        if i % 4 != 3:
            cut = high - f_high * (high - low) / (f_high - f_low)
        end = _contacts_at(grid, shapes, body, path, cut, slack, room)
        f = smallest_gap(body) - aim
        if abs(f) <= 0.45 * deep:
            return cut, end
        if f < 0.0:
            high, f_high, f_low = cut, f, 0.5 * f_low
        else:
            low, f_low, f_high = cut, f, 0.5 * f_high
        if high - low <= MIN_BRACKET:
            break
    # A contact that is deep at once, such as an edge that slides into a corner of the ground,
    # exists only at the end of the bracket.
    return high, _contacts_at(grid, shapes, body, path, high, slack, room)


@compiled
def _contacts_at(
    grid: Grid,
    shapes: Shapes,
    body: Record,
    path: SubstepPath,
    t: float,
    slack: float,
    room: Workspace,
) -> Motion:
    """Returns the motion after a time t, and finds the contacts there."""
    end = motion_at(path, t)
    if is_under_ground(grid, body, end.p):
        body.count = 0
        return end
    find_body_contacts(grid, shapes, body, end.p, end.q, slack, room)
    for k in range(body.count):
        body.gap[k] += body.sunk
    return end


@compiled
def _update_timers(body: Record, h: float, pushed: bool) -> None:
    """Updates the times of soft impact and quiet, and the depth in soft ground."""
    left = max(body.pushed - h, 0.0) if pushed else 0.0
    body.pushed = left if left >= 1e-9 else 0.0
    if body.sunk > 0.0 or pushed:
        depth = max(body.sunk - smallest_gap(body), 0.0)
        grown = depth - body.sunk
        if pushed or grown < 0.0:
            body.sunk = depth
            for k in range(body.count):
                body.gap[k] += grown
    speed = length(triple(body.v)) + length(triple(body.w)) * body.reach
    if speed > SLEEP_SPEED or body.held == 0:
        body.quiet = 0.0


@compiled
def _fall_asleep(body: Record) -> None:
    """Puts a body to sleep that has long been quiet."""
    propped = body.held >= STABLE_CONTACTS or body.radius > 0.0
    if body.quiet >= (SLEEP_TIME if propped else UNSTABLE_SLEEP_TIME):
        body.awake = False
        for i in range(3):
            body.v[i] = body.w[i] = 0.0


class SubstepPath(NamedTuple):
    """Motion of a body over a sub-step.

    Attributes:
        start: motion at the start.
        a: acceleration [m/s²].
        driven: whether the ground turns it; otherwise it rotates freely.
        turn: angular velocity at the start, in the world [rad/s].
        turn_rate: angular acceleration if driven [rad/s²].
        order: highest power in the series.
        series: of the free rotation.
    """

    start: Motion
    a: Vector
    driven: bool
    turn: Vector
    turn_rate: Vector
    order: int
    series: Array


@compiled
def motion_at(path: SubstepPath, t: float) -> Motion:
    """Returns the motion after a time t of the sub-step [s]."""
    start = path.start
    p = plus(start.p, times(t, plus(start.v, times(0.5 * t, path.a))))
    v = plus(start.v, times(t, path.a))
    if path.driven:
        q = rotate_by_vector(start.q, times(t, plus(path.turn, times(0.5 * t, path.turn_rate))))
        w = inverse_turned(rotation(q), plus(path.turn, times(t, path.turn_rate)))
    else:
        q, w = evaluate_rotation(path.series, path.order, t)
    return Motion(p, q, v, w)
