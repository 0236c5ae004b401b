"""Striking: what happens to a body when it meets the ground at some speed.

All contacts that touch at the moment act together. One that comes in at u leaves at -b u or
faster; one that comes in slower than `REST` does not bounce. Friction holds what slides, as
far as Coulomb's law lets it. Bounciness in this sense (Newton's) and friction can add energy
between them; then only as much of the friction acts as does not.

Source: Sims 1987, 12.1 to 12.3, where (12.2), (12.4) and (12.5) stand upside down:
b = |v_after| / |v_before|, and the thesis's 0.8 and 0.2 are ratios of energies.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.impulses import ROUNDS, STILL, add_part, solved, speed
from pipeline.simulation.dynamics.records import Motion
from pipeline.simulation.dynamics.vectors import (
    Rows,
    Vector,
    carried,
    cross,
    dot,
    length,
    minus,
    plus,
    rotation,
    row,
    rows_of,
    times,
    turned,
    unturned,
)

REST = 0.05
"""Rest speed: what approaches slower does not bounce [m/s]."""

TOUCHING = 1e-5
"""Gap below which contacts act together, in sizes of the body."""

APPROACHES = 1e-9
"""Speeds below are no approach [m/s]."""

ROUNDING = 1e-12
"""Part of the energy that is rounding."""


class Strike(NamedTuple):
    """What an impact does to a body.

    Attributes:
        v: velocity after [m/s].
        w: angular velocity after, in the frame of the body [rad/s].
        speed: greatest approach of a contact, 0 where none struck [m/s].
        energy: of what came at this speed [J].
        place: middle of the impulses, from the centre of mass [m].
        normal: of the ground there.
    """

    v: Vector
    w: Vector
    speed: float
    energy: float
    place: Vector
    normal: Vector


class Matter(NamedTuple):
    """A body as an impact sees it: mass, inertia in the world and its inverse, friction."""

    mass: float
    inertia: Rows
    inverse: Rows
    friction: float


@compiled
def matter_of(body: Record, R: Rows) -> Matter:
    """Return a body's matter in an attitude."""
    return Matter(
        body.mass,
        carried(R, rows_of(body.inertia)),
        carried(R, rows_of(body.inverse)),
        body.friction,
    )


@compiled
def strike(body: Record, now: Motion, parts: Records) -> Strike:
    """Return what the contacts that approach do; nothing where none does.

    Args:
        body: with its contacts.
        now: how it is.
        parts: room for contacts that act.
    """
    R = rotation(now.q)
    w = turned(R, now.w)
    n, fastest = 0, 0.0
    for k in range(body.count):
        if body.gap[k] > TOUCHING * body.size:
            break
        u = dot(row(body.normal, k), plus(now.v, cross(w, row(body.lever, k))))
        fastest = min(fastest, u)
        n = k + 1
    nothing = (0.0, 0.0, 0.0)
    # What lies comes here sub-step by sub-step, and needs no more.
    if not fastest < -APPROACHES:
        return Strike(now.v, now.w, 0.0, 0.0, nothing, nothing)
    matter = matter_of(body, R)
    for k in range(n):
        add_part(parts[k], body, k, matter.inverse)
        u = speed(parts[k], 0, now.v, w)
        parts[k].target[0] = -body.bounciness * u if u < -REST else 0.0
    v, turn = _lossy(matter, parts, n, now.v, w)
    total, place, normal, energy = 1e-300, nothing, nothing, 0.0
    for k in range(n):
        impulse, u = parts[k].impulse[0], speed(parts[k], 0, now.v, w)
        place = plus(place, times(impulse, row(body.lever, k)))
        normal = plus(normal, times(impulse, row(body.normal, k)))
        total += impulse
        energy += 0.5 * impulse * max(-u, 0.0) / (1.0 + body.bounciness if u < -REST else 1.0)
    normal = times(1.0 / max(length(normal), 1e-300), normal)
    return Strike(v, unturned(R, turn), -fastest, energy, times(1.0 / total, place), normal)


@compiled
def _kinetic(matter: Matter, v: Vector, w: Vector) -> float:
    return 0.5 * (matter.mass * dot(v, v) + dot(w, turned(matter.inertia, w)))


@compiled
def _lossy(matter: Matter, parts: Records, n: int, v0: Vector, w0: Vector) -> tuple[Vector, Vector]:
    """Return velocity and turning after, with no more energy than before."""
    before = _kinetic(matter, v0, w0) * (1.0 + ROUNDING)
    per_mass = 1.0 / matter.mass
    v, w = solved(parts, n, v0, w0, per_mass, matter.friction, STILL, ROUNDS)
    high = _kinetic(matter, v, w)
    if high <= before:
        return v, w
    rough = parts[:n].copy()
    smooth_v, smooth_w = _smooth(matter, parts, n, v0, w0, before)
    # T(s) = T0 + s B + s² C along the way from no friction (s = 0) to all of it (s = 1).
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
def _smooth(
    matter: Matter, parts: Records, n: int, v0: Vector, w0: Vector, before: float
) -> tuple[Vector, Vector]:
    """Return the same without friction; of contacts that leave anyway only if that loses."""
    _begin(parts, n)
    v, w = solved(parts, n, v0, w0, 1.0 / matter.mass, 0.0, STILL, ROUNDS)
    if _kinetic(matter, v, w) <= before:
        return v, w
    for k in range(n):
        parts[k].acts = speed(parts[k], 0, v0, w0) < -APPROACHES
    _begin(parts, n)
    return solved(parts, n, v0, w0, 1.0 / matter.mass, 0.0, STILL, ROUNDS)


@compiled
def _begin(parts: Records, n: int) -> None:
    """Begin without impulses."""
    for k in range(n):
        parts[k].impulse[0] = parts[k].impulse[1] = parts[k].impulse[2] = 0.0
