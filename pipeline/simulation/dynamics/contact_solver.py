"""Contact solver: impulses of all contacts of one body together.

Vertex by vertex, (12.19) is wrong where several touch at once: each impulse changes the speeds of
the others. Together they are a linear complementarity problem,

    λ_n >= 0,   u_n >= c,   λ_n (u_n - c) = 0,      |λ_t| <= μ λ_n against the sliding,

in the contact velocities u = J V after the impulses, with V⁺ = V + M⁻¹ Jᵀ λ. The diagonal of
J M⁻¹ Jᵀ is what (12.18) divides by: 1/m + N · ((I⁻¹ (L × N)) × L). Block Gauss-Seidel solves it;
a body has few contacts, so this is fast, and redundant contacts do no harm.

Source: Sims 1987, 12.3; Jean 1999 (block Gauss-Seidel for contact with friction).
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.vectors import (
    Rows,
    Vector,
    cross,
    dot,
    length,
    plus,
    put,
    row,
    times,
    triple,
    turned,
)

MAX_SWEEPS = 400
"""Largest number of sweeps over the contacts of an impact."""

CONVERGED = 1e-12
"""Change of a speed that ends the sweeps, relative to the largest speed error."""


SOLVER_CONTACT = np.dtype(
    [
        # Number of the contact, and whether it is active.
        ("which", "i8"),
        ("acts", "?"),
        # Normal and two tangents d; L × d [m]; angular velocity by unit impulses,
        # I⁻¹ (L × d) [1/(kg m)].
        ("axes", "f8", (3, 3)),
        ("arms", "f8", (3, 3)),
        ("yields", "f8", (3, 3)),
        # Effective mass along the normal; entries 00, 01, 11 of that along the tangents, and the
        # inverse of the larger eigenvalue of its inverse [kg].
        ("normal", "f8"),
        ("across", "f8", 3),
        ("gentle", "f8"),
        # Tangential speeds by a unit normal impulse [1/kg].
        ("beside", "f8", 2),
        # Lower bound of the normal speed, and tangential speeds that friction aims at [m/s];
        # impulses along the axes [N s].
        ("target", "f8", 3),
        ("impulse", "f8", 3),
    ],
    align=True,
)
"""One of the active contacts of a body."""


@compiled
def add_contact(part: Record, body: Record, which: int, inverse: Rows) -> None:
    """Fills `part` from a body's contact `which`; `inverse` is the inverse inertia in the world."""
    per_mass, lever = 1.0 / body.mass, row(body.lever, which)
    normal = row(body.normal, which)
    x, y, z = normal
    # Perpendicular to the normal and to the one of X and Z that is farther from it.
    first = (0.0, z, -y) if abs(x) < abs(z) else (y, -x, 0.0)
    first = times(1.0 / length(first), first)
    axes = (normal, first, cross(normal, first))
    arms = (cross(lever, axes[0]), cross(lever, axes[1]), cross(lever, axes[2]))
    yields = (turned(inverse, arms[0]), turned(inverse, arms[1]), turned(inverse, arms[2]))
    part.which, part.acts = which, True
    for i in range(3):
        put(part.axes, i, axes[i])
        put(part.arms, i, arms[i])
        put(part.yields, i, yields[i])
        part.target[i] = part.impulse[i] = 0.0
    part.normal = 1.0 / (dot(arms[0], yields[0]) + per_mass)
    a, c = dot(arms[1], yields[1]) + per_mass, dot(arms[2], yields[2]) + per_mass
    b = dot(arms[1], yields[2])
    inside = 1.0 / (a * c - b * b)
    part.across[0], part.across[1], part.across[2] = c * inside, -b * inside, a * inside
    part.gentle = 1.0 / (0.5 * (a + c) + math.sqrt(0.25 * (a - c) * (a - c) + b * b))
    part.beside[0], part.beside[1] = dot(arms[1], yields[0]), dot(arms[2], yields[0])


@compiled
def contact_speed(part: Record, i: int, v: Vector, w: Vector) -> float:
    """Returns the speed of a contact along its axis i, 0 for the normal [m/s].

    Args:
        part: the contact.
        i: number of the axis.
        v: velocity of the body [m/s].
        w: its angular velocity in the world [rad/s].

    Source: Sims 1987, (12.12).
    """
    return dot(row(part.axes, i), v) + dot(row(part.arms, i), w)


@compiled
def solve_contacts(
    parts: Records,
    n: int,
    v: Vector,
    w: Vector,
    per_mass: float,
    friction: float,
    still: float,
    rounds: int,
) -> tuple[Vector, Vector]:
    """Returns velocity and angular velocity in the world after all impulses, which stay in `parts`.

    Args:
        parts: contacts; their impulses are the feasible initial guess.
        n: number of contacts.
        v: velocity before [m/s].
        w: angular velocity before, in the world [rad/s].
        per_mass: 1 / mass [1/kg].
        friction: Coulomb's coefficient.
        still: convergence tolerance, see `CONVERGED`.
        rounds: largest number of sweeps.
    """
    scale = _largest_error(parts, n, v, w)
    for k in range(n):
        if scale == 0.0 or not parts[k].acts:
            parts[k].impulse[0] = parts[k].impulse[1] = parts[k].impulse[2] = 0.0
        else:
            v, w = _apply_impulse(parts[k], v, w, per_mass, triple(parts[k].impulse))
    if scale == 0.0:
        return v, w
    for _ in range(rounds):
        changed = 0.0
        for k in range(n):
            if parts[k].acts:
                v, w, change = _project_contact(parts[k], v, w, per_mass, friction)
                changed = max(changed, change)
        if changed <= still * scale:
            break
    return v, w


@compiled
def _largest_error(parts: Records, n: int, v: Vector, w: Vector) -> float:
    """Returns the largest difference between a contact speed and its target [m/s]."""
    scale = 0.0
    for k in range(n):
        if parts[k].acts:
            for i in range(3):
                scale = max(scale, abs(contact_speed(parts[k], i, v, w) - parts[k].target[i]))
    return scale


@compiled
def _project_contact(
    part: Record, v: Vector, w: Vector, per_mass: float, friction: float
) -> tuple[Vector, Vector, float]:
    """Solves one contact alone; returns v, w and the change of its speed [m/s]."""
    before, target = triple(part.impulse), triple(part.target)
    first = max(before[0] - (contact_speed(part, 0, v, w) - target[0]) * part.normal, 0.0)
    second = third = 0.0
    limit = friction * first
    if limit > 0.0:
        push = first - before[0]
        x = contact_speed(part, 1, v, w) - target[1] + part.beside[0] * push
        y = contact_speed(part, 2, v, w) - target[2] + part.beside[1] * push
        a, b, c = triple(part.across)
        second, third = before[1] - (a * x + b * y), before[2] - (b * x + c * y)
        if second * second + third * third > limit * limit:
            # Sliding friction opposes the sliding: only a step of equal length along every axis
            # converges to that direction.
            second, third = before[1] - part.gentle * x, before[2] - part.gentle * y
            hold = math.sqrt(second * second + third * third)
            if hold > limit:
                second, third = second * (limit / hold), third * (limit / hold)
    change = (first - before[0], second - before[1], third - before[2])
    part.impulse[0], part.impulse[1], part.impulse[2] = first, second, third
    v, w = _apply_impulse(part, v, w, per_mass, change)
    return v, w, max(abs(change[0]), max(abs(change[1]), abs(change[2]))) / part.normal


@compiled
def _apply_impulse(
    part: Record, v: Vector, w: Vector, per_mass: float, impulse: Vector
) -> tuple[Vector, Vector]:
    """Returns velocity and angular velocity after an impulse along the axes of a contact."""
    for i in range(3):
        if impulse[i] != 0.0:
            v = plus(v, times(per_mass * impulse[i], row(part.axes, i)))
            w = plus(w, times(impulse[i], row(part.yields, i)))
    return v, w
