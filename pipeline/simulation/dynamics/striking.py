"""Striking: what happens to a body when it meets the ground at some speed.

All contacts that touch at the moment act together. One that comes in at u leaves at -b u or
faster; one that comes in slower than `REST` does not bounce. Friction holds what slides, as
far as Coulomb's law lets it. Bounciness in this sense (Newton's) and friction can add energy
between them; then only as much of the friction acts as does not.

Source: Sims 1987, 12.1 to 12.3, where (12.2), (12.4) and (12.5) stand upside down:
b = |v_after| / |v_before|, and the thesis's 0.8 and 0.2 are ratios of energies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.impulses import Problem, solved
from pipeline.simulation.dynamics.meeting import Contacts
from pipeline.simulation.dynamics.path import in_world
from pipeline.simulation.dynamics.rigid import Bodies, State, dot, kinetic, unturned
from pipeline.simulation.spatial import Array, matrix

REST = 0.05
"""Rest speed: what approaches slower does not bounce [m/s]."""

TOUCHING = 1e-5
"""Gap below which contacts act together, in sizes of the body."""

APPROACHES = 1e-9
"""Speeds below are no approach [m/s]."""

ROUNDING = 1e-12
"""Part of the energy that is rounding."""


@dataclass(frozen=True, eq=False)
class Strike:
    """What an impact does to B bodies.

    Attributes:
        v: (B, 3) velocities after [m/s].
        w: (B, 3) angular velocities after, in the frames of the bodies [rad/s].
        speed: (B,) greatest approach of a contact, 0 where none struck [m/s].
        energy: (B,) of what came at this speed [J].
        place: (B, 3) middle of the impulses, from the centre of mass [m].
        normal: (B, 3) of the ground there.
    """

    v: Array
    w: Array
    speed: Array
    energy: Array
    place: Array
    normal: Array


def strike(bodies: Bodies, state: State, contacts: Contacts) -> Strike:
    """Return what the contacts that approach do; nothing where none does."""
    w = in_world(state)
    acts = contacts.gap <= TOUCHING * bodies.size[:, None]
    problem = Problem.of(bodies, state.q, contacts.normal, contacts.lever, acts)
    u = np.where(acts, problem.speeds(state.v, w)[..., 0], 0.0)
    comes = acts & (u < -APPROACHES)
    rows = np.flatnonzero(comes.any(axis=1))
    after_v, after_w = state.v.copy(), w.copy()
    impulses = np.zeros((*acts.shape, 3))
    if len(rows):
        target = np.zeros((len(rows), acts.shape[1], 3))
        b = bodies.bounciness[rows, None]
        target[..., 0] = np.where(u[rows] < -REST, -b * u[rows], 0.0)
        after_v[rows], after_w[rows], impulses[rows] = _lossy(
            bodies.some(rows), state.some(rows), w[rows], problem.some(rows), target, comes[rows]
        )
    normal = impulses[..., 0]
    total = np.maximum(_total(normal), 1e-300)[:, None]
    place = np.stack([_total(normal * contacts.lever[..., i]) for i in range(3)], axis=-1)
    mean = np.stack([_total(normal * contacts.normal[..., i]) for i in range(3)], axis=-1)
    length = np.maximum(np.sqrt(dot(mean, mean)), 1e-300)[:, None]
    gone = np.where(u < -REST, 1.0 + bodies.bounciness[:, None], 1.0)
    return Strike(
        after_v,
        unturned(matrix(state.q), after_w),
        np.maximum(-u.min(axis=1), 0.0),
        _total(0.5 * normal * np.maximum(-u, 0.0) / gone),
        place / total,
        mean / length,
    )


def _lossy(
    bodies: Bodies,
    state: State,
    w: Array,
    problem: Problem,
    target: Array,
    comes: NDArray[np.bool_],
) -> tuple[Array, Array, Array]:
    """Return velocities, turning and impulses after, with no more energy than before."""
    R = matrix(state.q)
    before = kinetic(bodies, state.v, state.w) * (1.0 + ROUNDING)

    def spent(v: Array, turn: Array, rows: NDArray[np.int64]) -> Array:
        return kinetic(bodies.some(rows), v, unturned(R[rows], turn))

    everyone = np.arange(len(w))
    v, turn, impulses = solved(problem, state.v, w, target)
    rows = everyone[spent(v, turn, everyone) > before]
    if not len(rows):
        return v, turn, impulses
    smooth = _smooth(bodies, state, w, problem, target, comes, rows, before)
    # T(s) = T0 + s B + s² C along the way from no friction (s = 0) to all of it (s = 1).
    low = spent(smooth[0], smooth[1], rows)
    high = spent(v[rows], turn[rows], rows)
    half = spent(0.5 * (smooth[0] + v[rows]), 0.5 * (smooth[1] + turn[rows]), rows)
    C = 2.0 * (high + low) - 4.0 * half
    B = high - low - C
    room = np.maximum(before[rows] - low, 0.0)
    root = np.sqrt(np.maximum(B * B + 4.0 * C * room, 0.0))
    s = np.clip(2.0 * room / np.maximum(B + root, 1e-300), 0.0, 1.0)[:, None]
    v[rows] = smooth[0] + s * (v[rows] - smooth[0])
    turn[rows] = smooth[1] + s * (turn[rows] - smooth[1])
    impulses[rows] = smooth[2] + s[..., None] * (impulses[rows] - smooth[2])
    return v, turn, impulses


def _smooth(
    bodies: Bodies,
    state: State,
    w: Array,
    problem: Problem,
    target: Array,
    comes: NDArray[np.bool_],
    rows: NDArray[np.int64],
    before: Array,
) -> tuple[Array, Array, Array]:
    """Return the same without friction; of contacts that leave anyway only if that loses."""
    part, own = problem.some(rows).without_friction(), state.some(rows)
    v, turn, impulses = solved(part, own.v, w[rows], target[rows])
    after = kinetic(bodies.some(rows), v, unturned(matrix(own.q), turn))
    gains = np.flatnonzero(after > before[rows])
    if len(gains):
        some = part.some(gains).only(comes[rows[gains]])
        v[gains], turn[gains], impulses[gains] = solved(
            some, own.v[gains], w[rows[gains]], target[rows[gains]]
        )
    return v, turn, impulses


def _total(values: Array) -> Array:
    """Return the sums (B,) of rows (B, K), in one order whatever K is."""
    result = np.zeros(len(values))
    for column in values.T:
        result = result + column
    return result
