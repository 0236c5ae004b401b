"""Leaning: bodies that the ground holds, as they roll, slide, tip over or lie.

The forces of the contacts over a sub-step are found together, as impulses are, so that no
contact moves into the ground and friction holds those that it can. What is asked of a
contact is where it is at the end, gap + h (u + u⁺) / 2 + c, with the velocity in the middle
and the way c = h² ω × (ω × L) / 2 that turning takes it towards the centre: then the work of
the forces is what the energy loses, to the third order in h. What is gained nevertheless is
taken from the velocities at once, and what cannot pay for it stays where it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.impulses import Problem, solved
from pipeline.simulation.dynamics.meeting import Contacts
from pipeline.simulation.dynamics.path import in_world
from pipeline.simulation.dynamics.rigid import FREE, Bodies, State, dot, energy, kinetic, turned
from pipeline.simulation.dynamics.striking import REST, TOUCHING
from pipeline.simulation.spatial import Array, cross

HELD = 2e-4
"""Gap below which a contact holds, in sizes of the body."""

SUNK = 5e-4
"""Depth that is not mended, in sizes of the body: that would be jitter."""

ENOUGH = 1e-5
"""How exactly forces are found, see `solved`: what is left is less than the eye sees, and the
energy is watched anyway."""

SWEEPS = 60
"""Most times that contacts are gone through for them."""

SAME_PLACE = 0.03
"""Distance of contacts that are the same as a sub-step before, in sizes of the body."""

MENDED = 0.1
"""Part of a greater depth that is mended in a sub-step."""


@dataclass(frozen=True, eq=False)
class Forces:
    """What the ground gave B bodies.

    Attributes:
        force: (B, K, 3) in the world [N].
        lever: (B, K, 3) where, from the centre of mass [m].
    """

    force: Array
    lever: Array


def holds(bodies: Bodies, state: State, contacts: Contacts, h: Array) -> NDArray[np.bool_]:
    """Say which contacts (B, K) are held over a sub-step: those that would come back in it."""
    near = contacts.gap <= HELD * bodies.size[:, None]
    w = in_world(state)
    speed = dot(contacts.normal, state.v[:, None] + cross(w[:, None], contacts.lever))
    back = np.sqrt(dot(FREE, FREE)) + dot(w, w) * bodies.reach
    # What will come fast enough to bounce shall do so.
    comes = speed**2 + 2.0 * GRAVITY * np.where(near, np.maximum(contacts.gap, 0.0), 0.0)
    slow = (comes < REST**2) | (contacts.gap <= TOUCHING * bodies.size[:, None])
    return near & slow & (speed < (back * h)[:, None])


def leant(
    bodies: Bodies,
    state: State,
    contacts: Contacts,
    acts: NDArray[np.bool_],
    free_w: Array,
    h: Array,
    before: Forces,
) -> tuple[Array, Array, Forces]:
    """Return velocities and turning in the world (B, 3) after a sub-step, and the forces.

    Args:
        bodies: B of them.
        state: how they begin.
        contacts: of theirs.
        acts: (B, K) which hold.
        free_w: (B, 3) turning after the sub-step if nothing held, in the world [rad/s].
        h: (B,) its length [s].
        before: forces of the sub-step before.
    """
    w = in_world(state)
    problem = Problem.of(bodies, state.q, contacts.normal, contacts.lever, acts)
    inward = cross(w[:, None], cross(w[:, None], contacts.lever))
    # A ball is as near to the ground however it turns.
    inward = np.where((bodies.radius > 0.0)[:, None, None], 0.0, inward)
    pull = dot(problem.axes, inward[:, :, None]) * h[:, None, None]
    target = -pull
    size = bodies.size[:, None]
    gap = np.where(acts, contacts.gap, 0.0)
    gap = np.where(gap < 0.0, np.minimum(gap + SUNK * size, 0.0) * MENDED, gap)
    target[..., 0] -= problem.speeds(state.v, w)[..., 0] + 2.0 * gap / h[:, None]
    free_v = state.v + h[:, None] * FREE
    guess = _guess(bodies, problem, contacts, before, h)
    v, turn, impulses = solved(problem, free_v, free_w, target, ENOUGH, SWEEPS, guess)
    given = (impulses[..., None] * problem.axes).sum(axis=-2) / h[:, None, None]
    return v, _rolled(bodies, state, turn, impulses), Forces(given, contacts.lever)


def _guess(bodies: Bodies, problem: Problem, contacts: Contacts, before: Forces, h: Array) -> Array:
    """Return impulses (B, K, 3) such as the contacts at the same places had before."""
    apart = contacts.lever[:, :, None] - before.lever[:, None]
    apart = np.where((before.force != 0.0).any(axis=-1)[:, None], dot(apart, apart), np.inf)
    which = np.argmin(apart, axis=-1)
    rows = np.arange(len(which))[:, None]
    near = apart.min(axis=-1) <= (SAME_PLACE * bodies.size[:, None]) ** 2
    force = np.where(near[..., None], before.force[rows, which], 0.0) * h[:, None, None]
    guess = dot(problem.axes, force[:, :, None])
    normal = np.maximum(guess[..., 0], 0.0)
    length = np.sqrt(guess[..., 1] ** 2 + guess[..., 2] ** 2)
    limit = problem.friction * normal
    across = guess[..., 1:] * (limit / np.maximum(np.maximum(length, limit), 1e-300))[..., None]
    return np.concatenate([normal[..., None], across], axis=-1)


def _rolled(bodies: Bodies, state: State, turn: Array, impulses: Array) -> Array:
    """Return turning (B, 3) less what rolling resists: a moment of lever times force."""
    momentum = turned(bodies.inertia, state.w)
    length = np.sqrt(dot(momentum, momentum))
    force = np.zeros(len(turn))
    for k in range(impulses.shape[1]):
        force = force + impulses[:, k, 0]
    lost = bodies.rolling * force / np.maximum(length, 1e-300)
    return turn * np.maximum(1.0 - lost, 0.0)[:, None]


def paid(bodies: Bodies, before: State, after: State) -> State:
    """Return the state after a sub-step with no more energy than before it."""
    gained = energy(bodies, after) - energy(bodies, before)
    moves = kinetic(bodies, after.v, after.w)
    share = (moves - gained) / np.maximum(moves, 1e-300)
    slow = np.sqrt(np.clip(share, 0.0, 1.0))[:, None]
    slow = np.where((gained > 0.0)[:, None], slow, 1.0)
    stays = ((gained > 0.0) & (share < 0.0))[:, None]
    return State(
        np.where(stays, before.p, after.p),
        np.where(stays, before.q, after.q),
        slow * after.v,
        slow * after.w,
    )
