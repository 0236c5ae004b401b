"""Contact solver: impulses of all contacts of one body together.

Vertex by vertex, (12.19) is wrong where several touch at once: each impulse changes the speeds of
the others. Together they are a linear complementarity problem,

    λ_n >= 0,   u_n >= c,   λ_n (u_n - c) = 0,      |λ_t| <= μ λ_n against the sliding,

in the contact velocities u = J V after the impulses, with V⁺ = V + M⁻¹ Jᵀ λ. The diagonal of
J M⁻¹ Jᵀ is what (12.18) divides by: 1/m + N · ((I⁻¹ (L × N)) × L). Block Gauss-Seidel solves it;
a body has few contacts, so this is fast, and redundant contacts do no harm.

Gauss-Seidel favours the contact that comes first: with friction the solution depends on the order,
and a box that lands on an edge would leave its plane of symmetry. So contacts that are alike but
for a reflection or rotation are solved together, each for its share of the mass (Jacobi with mass
splitting), which is stable for any number of them.

Source: Sims 1987, 12.3; Jean 1999 (block Gauss-Seidel for contact with friction); Tonge et al. 2012
(mass splitting).
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
    minus,
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

NEARLY_CONVERGED = 1e-8
"""The same at which sweeps end as well if the change grows: with friction there may be several
solutions, and one that keeps the symmetry of the contacts may repel the sweeps."""

ALIKE_TOLERANCE = 1e-6
"""Difference of speeds of contacts that are alike, in the largest speed error, and relative
difference of their effective masses."""


SOLVER_CONTACT = np.dtype(
    [
        # Number of the contact, and whether it is active.
        ("which", "i8"),
        ("acts", "?"),
        # First of the contacts that are alike; there their number, zero at the others.
        ("leader", "i8"),
        ("alike", "i8"),
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
        # Normal speed before the impulses, above the lower bound [m/s].
        ("error", "f8"),
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
    if scale == 0.0:
        return v, w
    _group_alike(parts, n, ALIKE_TOLERANCE * scale)
    for k in range(n):
        if parts[k].acts:
            v, w = _apply_impulse(parts[k], v, w, per_mass, triple(parts[k].impulse))
    least = np.inf
    for _ in range(rounds):
        v, w, changed = _sweep(parts, n, v, w, per_mass, friction)
        least = min(least, changed)
        if changed <= still * scale or 2.0 * least < changed < NEARLY_CONVERGED * scale:
            break
    return v, w


@compiled
def _sweep(
    parts: Records, n: int, v: Vector, w: Vector, per_mass: float, friction: float
) -> tuple[Vector, Vector, float]:
    """Solves each contact, or group of them, once; returns v, w and the largest change [m/s]."""
    changed = 0.0
    for k in range(n):
        if parts[k].alike > 1:
            v, w, change = _project_alike(parts, n, k, v, w, per_mass, friction)
            changed = max(changed, change)
        elif parts[k].alike == 1 and parts[k].acts:
            v, w, change = _project_contact(parts[k], v, w, per_mass, friction, 1.0)
            changed = max(changed, change)
    return v, w, changed


@compiled
def _largest_error(parts: Records, n: int, v: Vector, w: Vector) -> float:
    """Returns the largest difference between a contact speed and its target [m/s]."""
    scale = 0.0
    for k in range(n):
        part = parts[k]
        part.error = contact_speed(part, 0, v, w) - part.target[0]
        if part.acts:
            scale = max(scale, abs(part.error))
            for i in range(1, 3):
                scale = max(scale, abs(contact_speed(part, i, v, w) - part.target[i]))
    return scale


@compiled
def _group_alike(parts: Records, n: int, near: float) -> None:
    """Groups the contacts with equal effective masses and equal speeds, up to `near` [m/s].

    Contacts that are mirror images of one another agree in both. Others that do so by chance are
    solved together as well, and converge to the same solution.
    """
    for k in range(n):
        part = parts[k]
        part.leader, part.alike = k, 1
        for j in range(k):
            first = parts[j]
            if (
                first.leader == j
                and abs(first.error - part.error) <= near
                and abs(first.normal - part.normal) <= ALIKE_TOLERANCE * part.normal
            ):
                part.leader, part.alike = j, 0
                first.alike += 1
                break


@compiled
def _project_alike(
    parts: Records, n: int, leader: int, v: Vector, w: Vector, per_mass: float, friction: float
) -> tuple[Vector, Vector, float]:
    """Solves a group of contacts from the same velocities, each for its share of the mass.

    Returns:
        v, w, and the largest change of a speed if it were for the whole mass [m/s].
    """
    count, after_v, after_w, changed = parts[leader].alike, v, w, 0.0
    for k in range(leader, n):
        part = parts[k]
        if part.leader == leader and part.acts:
            own_v, own_w, change = _project_contact(part, v, w, per_mass, friction, 1.0 / count)
            after_v, after_w = plus(after_v, minus(own_v, v)), plus(after_w, minus(own_w, w))
            changed = max(changed, change)
    return after_v, after_w, count * changed


@compiled
def _project_contact(
    part: Record, v: Vector, w: Vector, per_mass: float, friction: float, share: float
) -> tuple[Vector, Vector, float]:
    """Solves one contact alone, for a share of the mass; returns v, w and its change [m/s]."""
    before, target = triple(part.impulse), triple(part.target)
    error = contact_speed(part, 0, v, w) - target[0]
    first = max(before[0] - error * (share * part.normal), 0.0)
    second = third = 0.0
    limit = friction * first
    if limit > 0.0:
        push = (first - before[0]) / share
        x = contact_speed(part, 1, v, w) - target[1] + part.beside[0] * push
        y = contact_speed(part, 2, v, w) - target[2] + part.beside[1] * push
        a, b, c = times(share, triple(part.across))
        second, third = before[1] - (a * x + b * y), before[2] - (b * x + c * y)
        if second * second + third * third > limit * limit:
            # Sliding friction opposes the sliding: only a step of equal length along every axis
            # converges to that direction.
            gentle = share * part.gentle
            second, third = before[1] - gentle * x, before[2] - gentle * y
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
