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
"""Most times that all contacts are gone through."""

CONVERGED = 1e-12
"""Change of a speed that is none, in parts of the speeds there are."""


SOLVER_CONTACT = np.dtype(
    [
        # Number of the contact, and whether it takes part.
        ("which", "i8"),
        ("acts", "?"),
        # Normal and two tangents; levers × these [m]; turning by impulses along these,
        # I⁻¹ (L × d) [1/(kg m)].
        ("axes", "f8", (3, 3)),
        ("arms", "f8", (3, 3)),
        ("yields", "f8", (3, 3)),
        # Speed by impulse along the normal, inverse; across it likewise, entries 00, 01, 11 of
        # the inverse matrix, and the inverse of the matrix's greater eigenvalue [kg].
        ("normal", "f8"),
        ("across", "f8", 3),
        ("gentle", "f8"),
        # Tangential speeds by a normal impulse [1/kg].
        ("beside", "f8", 2),
        # Speeds along the axes, below which no normal one may be, and which friction would have
        # the tangential ones be [m/s]; impulses along them [N s].
        ("target", "f8", 3),
        ("impulse", "f8", 3),
    ],
    align=True,
)
"""A contact that acts, one of several on a body."""


@compiled
def add_contact(part: Record, body: Record, which: int, inverse: Rows) -> None:
    """Make a part of a body's contact `which`; `inverse` is that of its inertia in the world."""
    per_mass, lever = 1.0 / body.mass, row(body.lever, which)
    axes = _contact_axes(row(body.normal, which))
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
    """Return the speed of a contact along its axis i, 0 for the normal [m/s].

    Args:
        part: the contact.
        i: which axis.
        v: velocity of the body.
        w: angular velocity in the world.

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
    """Return velocity and turning in the world after; the impulses stay in the parts.

    Args:
        parts: n contacts; impulses in them are begun with, and have to be possible.
        n: how many.
        v: velocity before [m/s].
        w: angular velocity before, in the world [rad/s].
        per_mass: 1 / mass [1/kg].
        friction: Coulomb's coefficient.
        still: change of a speed that is none, in parts of the speeds there are.
        rounds: most times that the contacts are gone through.
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
    """Return the greatest speed by which a contact misses what is asked of it [m/s]."""
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
    """Let a contact have its way; return v, w and how much a speed changed [m/s]."""
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
            # What friction cannot hold slides, and its most is against the sliding: only a
            # step of the same length along every axis ends in that direction.
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
    """Return velocity and turning after an impulse along the axes of a contact."""
    for i in range(3):
        if impulse[i] != 0.0:
            v = plus(v, times(per_mass * impulse[i], row(part.axes, i)))
            w = plus(w, times(impulse[i], row(part.yields, i)))
    return v, w


@compiled
def _contact_axes(normal: Vector) -> Rows:
    """Return a normal and two tangents across it."""
    x, y, z = normal
    # Across the normal and whichever of X and Z it is farther from.
    first = (0.0, z, -y) if abs(x) < abs(z) else (y, -x, 0.0)
    first = times(1.0 / length(first), first)
    return (normal, first, cross(normal, first))
