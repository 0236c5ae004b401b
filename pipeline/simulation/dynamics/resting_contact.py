"""Resting contact: bodies that the ground holds while they roll, slide, tip over or lie.

The contact forces over a sub-step are solved together, like impulses, so that no contact sinks in
and friction holds what it can. The constraint is the gap at the end of the sub-step,
gap + h (u + u⁺) / 2 + c, with the mean velocity and the centripetal displacement
c = h² ω × (ω × L) / 2: then the work of the forces equals the energy lost, to third order in h.
Energy gained nevertheless is taken from the velocities at once; a body that cannot pay for it
stays where it is.
"""

from __future__ import annotations

import math

from pipeline.simulation.dynamics.body_record import Motion
from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.contact_solver import add_contact, contact_speed, solve_contacts
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.impact import REST_SPEED, TOUCH_GAP
from pipeline.simulation.dynamics.vectors import (
    Rows,
    Vector,
    carried,
    cross,
    dot,
    inverse_turned,
    length,
    minus,
    plus,
    put,
    row,
    rows_of,
    times,
    triple,
    turned,
)

HOLD_GAP = 2e-4
"""Gap below which a contact holds, in sizes of the body."""

ALLOWED_DEPTH = 5e-4
"""Depth that is not corrected, in sizes of the body: correcting it would jitter."""

FORCE_TOLERANCE = 1e-5
"""Convergence of the forces, see `solve_contacts`; the energy is limited anyway."""

MAX_FORCE_SWEEPS = 60
"""Largest number of sweeps over the contacts."""

WARM_START_DISTANCE = 0.03
"""Distance of contacts that count as the same one sub-step later, in sizes of the body."""

SAME_PLACE = 1e-6
"""Difference of distances that count as equal, in sizes of the body."""

DEPTH_CORRECTION = 0.1
"""Fraction of a larger depth that is corrected in a sub-step."""


@compiled
def holding_contacts(body: Record, now: Motion, R: Rows, h: float, parts: Records) -> int:
    """Fills parts with the contacts that would close within a sub-step; returns their number."""
    n, w = 0, turned(R, now.w)
    back = (GRAVITY + dot(w, w) * body.reach) * h
    inverse = carried(R, rows_of(body.inverse))
    for which in range(body.count):
        gap = body.gap[which]
        if gap > HOLD_GAP * body.size:
            break
        u = dot(row(body.normal, which), plus(now.v, cross(w, row(body.lever, which))))
        # A contact that will close fast enough bounces instead.
        comes = u * u + 2.0 * GRAVITY * max(gap, 0.0)
        if u < back and (comes < REST_SPEED * REST_SPEED or gap <= TOUCH_GAP * body.size):
            add_contact(parts[n], body, which, inverse)
            n += 1
    return n


@compiled
def held_velocity(
    body: Record, now: Motion, R: Rows, parts: Records, n: int, free_w: Vector, h: float
) -> tuple[Vector, Vector]:
    """Returns velocity and angular velocity in the world after a sub-step; stores the forces.

    Args:
        body: record of the held body.
        now: its motion at the start.
        R: its attitude.
        parts: its holding contacts.
        n: their number.
        free_w: angular velocity after the sub-step without contacts, in the world [rad/s].
        h: length of the sub-step [s].
    """
    w = turned(R, now.w)
    for k in range(n):
        _set_target(parts[k], body, now.v, w, h)
        _warm_start(parts[k], body, h)
    free_v = (now.v[0], now.v[1] - h * GRAVITY, now.v[2])
    v, turn = solve_contacts(
        parts, n, free_v, free_w, 1.0 / body.mass, body.friction, FORCE_TOLERANCE, MAX_FORCE_SWEEPS
    )
    total = 0.0
    body.held = n
    for k in range(n):
        total += parts[k].impulse[0]
        force = times(1.0 / h, inverse_turned(rows_of(parts[k].axes), triple(parts[k].impulse)))
        put(body.force, k, force)
        put(body.force_lever, k, row(body.lever, parts[k].which))
    # The moment of rolling resistance is lever times force.
    momentum = length(turned(rows_of(body.inertia), inverse_turned(R, turn)))
    lost = body.rolling * total / max(momentum, 1e-300)
    if lost < 1.0:
        return v, times(1.0 - lost, turn)
    return (_blocked_ball_velocity(body, now.v, parts, n, h) if body.radius > 0.0 else v), (
        0.0,
        0.0,
        0.0,
    )


@compiled
def _blocked_ball_velocity(body: Record, v: Vector, parts: Records, n: int, h: float) -> Vector:
    """Returns the velocity of a ball after a sub-step in which it cannot turn."""
    nothing = (0.0, 0.0, 0.0)
    for k in range(n):
        add_contact(parts[k], body, parts[k].which, (nothing, nothing, nothing))
        _set_target(parts[k], body, v, nothing, h)
    free = (v[0], v[1] - h * GRAVITY, v[2])
    return solve_contacts(
        parts, n, free, nothing, 1.0 / body.mass, body.friction, FORCE_TOLERANCE, MAX_FORCE_SWEEPS
    )[0]


@compiled
def _set_target(part: Record, body: Record, v: Vector, w: Vector, h: float) -> None:
    """Sets the speeds that a contact must have after a sub-step."""
    if body.radius == 0.0:
        # The gap of a ball does not depend on its rotation.
        inward = times(-h, cross(w, cross(w, row(body.lever, part.which))))
        for i in range(3):
            part.target[i] = dot(row(part.axes, i), inward)
    gap = body.gap[part.which]
    gap = min(gap + ALLOWED_DEPTH * body.size, 0.0) * DEPTH_CORRECTION if gap < 0.0 else gap
    part.target[0] -= contact_speed(part, 0, v, w) + 2.0 * gap / h


@compiled
def _warm_start(part: Record, body: Record, h: float) -> None:
    """Sets the impulse of the contact at the same place one sub-step before.

    Contacts at one place, such as that of an edge with two planes, share their forces.
    """
    lever, least = row(body.lever, part.which), WARM_START_DISTANCE * body.size
    for old in range(body.held):
        least = min(least, length(minus(row(body.force_lever, old), lever)))
    force, count = (0.0, 0.0, 0.0), 0
    for old in range(body.held):
        if length(minus(row(body.force_lever, old), lever)) <= least + SAME_PLACE * body.size:
            force, count = plus(force, row(body.force, old)), count + 1
    if count == 0:
        return
    first, second, third = turned(rows_of(part.axes), times(h / count, force))
    first = max(first, 0.0)
    limit, hold = body.friction * first, math.sqrt(second * second + third * third)
    within = limit / hold if hold > limit else 1.0
    part.impulse[0], part.impulse[1], part.impulse[2] = first, within * second, within * third


@compiled
def limit_energy(body: Record, before: Motion, after: Motion) -> Motion:
    """Returns the motion after a sub-step with no more energy than before it."""
    moves = _kinetic(body, after)
    climbed = body.mass * GRAVITY * (after.p[1] - before.p[1])
    gained = moves + climbed - _kinetic(body, before)
    if gained <= 0.0:
        return after
    share = (moves - gained) / max(moves, 1e-300)
    slow = math.sqrt(min(max(share, 0.0), 1.0))
    v, w = times(slow, after.v), times(slow, after.w)
    if share < 0.0:
        return Motion(before.p, before.q, v, w)
    return Motion(after.p, after.q, v, w)


@compiled
def _kinetic(body: Record, now: Motion) -> float:
    turning = dot(now.w, turned(rows_of(body.inertia), now.w))
    return 0.5 * (body.mass * dot(now.v, now.v) + turning)
