"""Impact: the velocity change of a body that meets the ground.

All contacts that touch act together. A contact that approaches at u leaves at -b u or faster; one
slower than `REST_SPEED` does not bounce. Friction stops sliding as far as Coulomb's law allows.
Newton's restitution with friction can add energy; then only as much friction acts as does not.

Source: Sims 1987, 12.1 to 12.3, where (12.2), (12.4) and (12.5) stand upside down:
b = |v_after| / |v_before|, and the thesis's 0.8 and 0.2 are ratios of energies.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from pipeline.simulation.dynamics.body_record import Motion
from pipeline.simulation.dynamics.compiled import Record, Records, allocating, compiled
from pipeline.simulation.dynamics.contact_solver import (
    CONVERGED,
    MAX_SWEEPS,
    add_contact,
    contact_speed,
    solve_contacts,
)
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
    rotation,
    row,
    rows_of,
    times,
    turned,
)

REST_SPEED = 0.05
"""Approach speed below which a contact does not bounce [m/s]."""

TOUCH_GAP = 1e-5
"""Gap below which contacts act together, in sizes of the body."""

MIN_APPROACH_SPEED = 1e-9
"""Approach speed below which nothing is resolved [m/s]."""

ENERGY_ROUNDING = 1e-12
"""Relative rounding error of the energy."""


class Impact(NamedTuple):
    """Result of an impact.

    Attributes:
        v: velocity after [m/s].
        w: angular velocity after, in the frame of the body [rad/s].
        speed: greatest approach speed of a contact, 0 without an impact [m/s].
        energy: kinetic energy of the approach [J].
        place: centre of the impulses, from the centre of mass [m].
        normal: of the ground there.
    """

    v: Vector
    w: Vector
    speed: float
    energy: float
    place: Vector
    normal: Vector


class BodyMatter(NamedTuple):
    """Mass, inertia in the world, its inverse, and friction of a body."""

    mass: float
    inertia: Rows
    inverse: Rows
    friction: float


@compiled
def matter_in_world(body: Record, R: Rows) -> BodyMatter:
    """Returns mass, inertia and friction of a body in an attitude."""
    return BodyMatter(
        body.mass,
        carried(R, rows_of(body.inertia)),
        carried(R, rows_of(body.inverse)),
        body.friction,
    )


@compiled
def resolve_impact(body: Record, now: Motion, parts: Records) -> Impact:
    """Returns the effect of the approaching contacts; the unchanged motion if none approaches.

    Args:
        body: record with its contacts.
        now: its pose and velocity.
        parts: workspace for the active contacts.
    """
    R = rotation(now.q)
    w = turned(R, now.w)
    n, fastest = 0, 0.0
    for k in range(body.count):
        if body.gap[k] > TOUCH_GAP * body.size:
            break
        u = dot(row(body.normal, k), plus(now.v, cross(w, row(body.lever, k))))
        fastest = min(fastest, u)
        n = k + 1
    nothing = (0.0, 0.0, 0.0)
    # Resting bodies come here in every sub-step, and need no more.
    if not fastest < -MIN_APPROACH_SPEED:
        return Impact(now.v, now.w, 0.0, 0.0, nothing, nothing)
    matter = matter_in_world(body, R)
    for k in range(n):
        add_contact(parts[k], body, k, matter.inverse)
        u = contact_speed(parts[k], 0, now.v, w)
        parts[k].target[0] = -body.bounciness * u if u < -REST_SPEED else 0.0
    v, turn = _dissipative_solution(matter, parts, n, now.v, w)
    total, place, normal, energy = 1e-300, nothing, nothing, 0.0
    for k in range(n):
        impulse, u = parts[k].impulse[0], contact_speed(parts[k], 0, now.v, w)
        place = plus(place, times(impulse, row(body.lever, k)))
        normal = plus(normal, times(impulse, row(body.normal, k)))
        total += impulse
        energy += 0.5 * impulse * max(-u, 0.0) / (1.0 + body.bounciness if u < -REST_SPEED else 1.0)
    normal = times(1.0 / max(length(normal), 1e-300), normal)
    return Impact(v, inverse_turned(R, turn), -fastest, energy, times(1.0 / total, place), normal)


@compiled
def _kinetic(matter: BodyMatter, v: Vector, w: Vector) -> float:
    return 0.5 * (matter.mass * dot(v, v) + dot(w, turned(matter.inertia, w)))


@allocating
def _dissipative_solution(
    matter: BodyMatter, parts: Records, n: int, v0: Vector, w0: Vector
) -> tuple[Vector, Vector]:
    """Returns velocities after the impact, with no more energy than before."""
    before = _kinetic(matter, v0, w0) * (1.0 + ENERGY_ROUNDING)
    per_mass = 1.0 / matter.mass
    v, w = solve_contacts(parts, n, v0, w0, per_mass, matter.friction, CONVERGED, MAX_SWEEPS)
    high = _kinetic(matter, v, w)
    if high <= before:
        return v, w
    rough = parts[:n].copy()
    smooth_v, smooth_w = _frictionless_solution(matter, parts, n, v0, w0, before)
    # T(s) = T0 + s B + s² C between no friction (s = 0) and all of it (s = 1).
    low = _kinetic(matter, smooth_v, smooth_w)
    half = _kinetic(matter, times(0.5, plus(smooth_v, v)), times(0.5, plus(smooth_w, w)))
    C = 2.0 * (high + low) - 4.0 * half
    B = high - low - C
    room = max(before - low, 0.0)
    root = math.sqrt(max(B * B + 4.0 * C * room, 0.0))
    s = min(max(2.0 * room / max(B + root, 1e-300), 0.0), 1.0)
    for k in range(n):
        for i in range(3):
            parts[k].impulse[i] += s * (rough[k].impulse[i] - parts[k].impulse[i])
    return (
        plus(smooth_v, times(s, minus(v, smooth_v))),
        plus(smooth_w, times(s, minus(w, smooth_w))),
    )


@compiled
def _frictionless_solution(
    matter: BodyMatter, parts: Records, n: int, v0: Vector, w0: Vector, before: float
) -> tuple[Vector, Vector]:
    """Returns velocities without friction; separating contacts act only if that loses energy."""
    _clear_impulses(parts, n)
    v, w = solve_contacts(parts, n, v0, w0, 1.0 / matter.mass, 0.0, CONVERGED, MAX_SWEEPS)
    if _kinetic(matter, v, w) <= before:
        return v, w
    for k in range(n):
        parts[k].acts = contact_speed(parts[k], 0, v0, w0) < -MIN_APPROACH_SPEED
    _clear_impulses(parts, n)
    return solve_contacts(parts, n, v0, w0, 1.0 / matter.mass, 0.0, CONVERGED, MAX_SWEEPS)


@compiled
def _clear_impulses(parts: Records, n: int) -> None:
    for k in range(n):
        parts[k].impulse[0] = parts[k].impulse[1] = parts[k].impulse[2] = 0.0
