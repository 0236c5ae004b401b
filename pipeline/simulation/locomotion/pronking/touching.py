"""Touching: feet in flight, and how they come to the ground.

Source: Sims 1987, 9.4 and 11.1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.pronking import spin
from pipeline.simulation.locomotion.pronking.happening import Events, Happening
from pipeline.simulation.locomotion.pronking.pronker import Pronker
from pipeline.simulation.locomotion.pronking.state import State
from pipeline.simulation.locomotion.pronking.swing import Swing
from pipeline.simulation.locomotion.swing.swing_trajectory import lowest_center_height
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

TUCK = 0.3
"""How high feet are drawn up in the middle of a flight, in leg lengths."""

TRAIL = 0.35
"""Speed with which feet trail behind after a lift-off, in that of the body."""

WALL = 0.06
"""How high a foot would have to be lifted at once where it meets a wall, in leg lengths."""


def drawn_up(
    of: Pronker, start: Array, ends: Array, begin: float, time: float, v: Array, folds: bool
) -> Swing:
    """Return the ways of feet that leave the ground and are held out for the landing.

    Args:
        of: whose feet.
        start: (n, 3) where they leave it, and
        ends: (n, 3) where they are held, in the frame of the body [m].
        begin: when it leaves the ground [s].
        time: how long the flight takes [s].
        v: (3,) velocity of the body, in its frame [m/s].
        folds: whether they are drawn up as far as legs fold.
    """
    n = len(start)
    middle = 0.5 * (start + ends)
    low, room = np.maximum(start[:, 1], ends[:, 1]), of.hips[:, 1] - 1.15 * of.folds
    top = room if folds else np.minimum(low + TUCK * of.leg * min(1.0, time / 0.5), room)
    middle[:, 1] = np.maximum(top, low)
    trail = np.tile([-TRAIL * v[0], 0.0, -TRAIL * v[2]], (n, 1))
    return Swing(np.full(n, begin), np.full(n, 0.97 * time), start, middle, ends, trail)


def touch(
    of: Pronker,
    ground: Ground,
    state: State,
    legs: NDArray[np.int64],
    met: NDArray[np.bool_],
    events: Events,
) -> None:
    """Put feet down where they are: these are their footholds until the next lift-off.

    Args:
        of: whose feet.
        ground: that they come to.
        state: in flight or landing.
        legs: whose feet they are.
        met: (n,) which came to it just now; the others were lifted over it.
        events: to be added to.
    """
    now, own = state.now(of), state.swing.tips(state.time)
    tips = now.points(own)
    moves = now.R @ ((own - state.swing.tips(state.time - 1e-5)) / 1e-5).T
    v = state.v + np.cross(state.turning[1], tips - state.p) + moves.T
    if not state.down.any():
        state.first = float(state.p[1])
    caught, floors = list[int](), lowest_center_height(ground, tips[:, 0], tips[:, 2], of.soles)
    for leg in legs.tolist():
        (x, y, z), least = tips[leg].tolist(), float(floors[leg])
        if met[leg] and least - y > WALL * of.leg:
            caught.append(leg)
        else:
            y = max(least, y)
        state.tips[leg], state.down[leg] = (x, y, z), True
        place, normal = np.array([x, y - of.soles[leg], z]), ground.normal(x, z)
        speed = max(-float(normal @ v[leg]), 0.0)
        energy = 0.5 * of.mass.mass / len(of.hips) * speed * speed
        events.append(Happening("touch", state.time, leg, place, normal, speed, energy))
        if not bool(ground.steppable(x, z)):
            text = f"a foot landed in a forbidden zone, at ({x:.2f}, {z:.2f})"
            events.append(Happening("misplaced", state.time, leg, place, normal, 0.0, 0.0, text))
    if caught:
        _trip(of, state, np.array(caught), tips, v, events)


def trip(of: Pronker, state: State, legs: NDArray[np.int64], tips: Array, events: Events) -> None:
    """Let feet (n, 3) that go with the body meet a wall."""
    v = np.broadcast_to(state.v, tips.shape)
    _trip(of, state, legs, tips, v, events)


def _trip(
    of: Pronker, state: State, legs: NDArray[np.int64], tips: Array, v: Array, events: Events
) -> None:
    """Catch feet on a wall: what stops the legs pulls at the body.

    Source: Sims 1987, 9.4.
    """
    pull = -of.leg_mass[legs, None] * v[legs] * [1.0, 0.0, 1.0]
    state.v = state.v + pull.sum(axis=0) / of.mass.mass
    R = np.array(spin.rows(state.turning[0]))
    inverse = R @ np.array(of.inertia.inverse) @ R.T
    twist = np.cross(tips[legs] - state.p, pull).sum(axis=0)
    x, y, z = (state.turning[1] + inverse @ twist).tolist()
    state.turning = state.turning[0], (x, y, z)
    up = np.array([0.0, 1.0, 0.0])
    for leg in legs.tolist():
        text = "a foot caught on a wall"
        events.append(Happening("tripped", state.time, leg, tips[leg], up, 0.0, 0.0, text))
