"""Touching: feet in flight, and how they come to the ground.

Source: Sims 1987, 9.4 and 11.1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.pronking.hop_events import HopEvent, HopEvents
from pipeline.simulation.locomotion.pronking.hop_state import BodyState, HopState, SwingPath
from pipeline.simulation.locomotion.pronking.hopper import STANCE_STRETCH, Hopper
from pipeline.simulation.locomotion.swing.swing_trajectory import lowest_center_height
from pipeline.simulation.scalar_rotation import matrix_rows
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

TUCK_HEIGHT = 0.3
"""How high feet are drawn up in the middle of a flight, in leg lengths."""

TRAIL_SPEED = 0.35
"""Speed with which feet trail behind after a lift-off, in that of the body."""

WALL_HEIGHT = 0.06
"""How high a foot would have to be lifted at once where it meets a wall, in leg lengths."""


def flight_swing(
    of: Hopper, start: Array, ends: Array, begin: float, time: float, v: Array, folds: bool
) -> SwingPath:
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
    top = room if folds else np.minimum(low + TUCK_HEIGHT * of.leg * min(1.0, time / 0.5), room)
    middle[:, 1] = np.maximum(top, low)
    trail = np.tile([-TRAIL_SPEED * v[0], 0.0, -TRAIL_SPEED * v[2]], (n, 1))
    return SwingPath(np.full(n, begin), np.full(n, 0.97 * time), start, middle, ends, trail)


def touch(
    of: Hopper,
    ground: Ground,
    state: HopState,
    legs: NDArray[np.int64],
    met: NDArray[np.bool_],
    events: HopEvents,
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
        if met[leg] and least - y > WALL_HEIGHT * of.leg:
            caught.append(leg)
        else:
            y = max(least, y)
        state.tips[leg], state.down[leg] = (x, y, z), True
        place, normal = np.array([x, y - of.soles[leg], z]), ground.normal(x, z)
        speed = max(-float(normal @ v[leg]), 0.0)
        energy = 0.5 * of.mass.mass / len(of.hips) * speed * speed
        events.append(HopEvent("touch", state.time, leg, place, normal, speed, energy))
        if not bool(ground.steppable(x, z)):
            text = f"a foot landed in a forbidden zone, at ({x:.2f}, {z:.2f})"
            events.append(HopEvent("misplaced", state.time, leg, place, normal, 0.0, 0.0, text))
    if caught:
        _catch_feet(of, state, np.array(caught), tips, v, events)


def trip_on_wall(
    of: Hopper, state: HopState, legs: NDArray[np.int64], tips: Array, events: HopEvents
) -> None:
    """Let feet (n, 3) that go with the body meet a wall."""
    v = np.broadcast_to(state.v, tips.shape)
    _catch_feet(of, state, legs, tips, v, events)


def _catch_feet(
    of: Hopper, state: HopState, legs: NDArray[np.int64], tips: Array, v: Array, events: HopEvents
) -> None:
    """Catch feet on a wall: what stops the legs pulls at the body.

    Source: Sims 1987, 9.4.
    """
    pull = -of.leg_mass[legs, None] * v[legs] * [1.0, 0.0, 1.0]
    state.v = state.v + pull.sum(axis=0) / of.mass.mass
    R = np.array(matrix_rows(state.turning[0]))
    inverse = R @ np.array(of.inertia.inverse) @ R.T
    twist = np.cross(tips[legs] - state.p, pull).sum(axis=0)
    x, y, z = (state.turning[1] + inverse @ twist).tolist()
    state.turning = state.turning[0], (x, y, z)
    up = np.array([0.0, 1.0, 0.0])
    for leg in legs.tolist():
        text = "a foot caught on a wall"
        events.append(HopEvent("tripped", state.time, leg, tips[leg], up, 0.0, 0.0, text))


SETTLE_DISTANCE = 0.16
"""How far a body sinks after a first foot touched until its legs carry, in leg lengths."""

FOLD_LIMIT = 1.01
"""How near to their hips legs draw feet at most, in what they can."""

RISING_SPEED = 1e-9
"""Vertical speed at which a body is not falling yet [m/s]."""


@dataclass(frozen=True, eq=False)
class EventMargins:
    """What is left until something happens; infinite for what cannot [m].

    Attributes:
        touch: (n,) feet above the ground.
        stretch, fold: (n,) legs.
        belly: (1,) the body above the ground.
        grace: (1,) way that the body may sink.
    """

    touch: Array
    stretch: Array
    fold: Array
    belly: Array
    grace: Array

    @property
    def all(self) -> Array:
        """All of them one after the other."""
        return np.concatenate([self.touch, self.stretch, self.fold, self.belly, self.grace])


def event_margins(
    of: Hopper, state: HopState, ground: Ground, at: BodyState, highest: float
) -> EventMargins:
    """Return what is left at some time of the phase.

    Args:
        of: the creature.
        state: at the begin of a sub-step.
        ground: below it.
        at: where it is at the time.
        highest: point of the ground [m].
    """
    n = len(of.hips)
    touch, stretch, fold, belly, grace = (np.full(k, np.inf) for k in (n, n, n, 1, 1))
    falls = at.v[1] <= RISING_SPEED
    if state.phase in ("flight", "landing") and falls and not state.down.all():
        tips = at.points(state.swing.tips(at.time))
        if float(tips[:, 1].min()) - float(of.soles.max()) < highest + 0.05:
            air = ~state.down & ~state.released
            touch[air] = (
                tips[:, 1] - lowest_center_height(ground, tips[:, 0], tips[:, 2], of.soles)
            )[air]
    if state.down.any() and state.phase not in ("standing",):
        way = at.points(of.hips) - state.tips
        far = np.sqrt((way * way).sum(axis=-1))
        down = state.down
        stretch[down] = (STANCE_STRETCH * of.lengths - far)[down]
        if state.phase in ("flight", "landing"):
            fold[down] = (far - FOLD_LIMIT * of.folds)[down]
    if state.armed and state.phase != "standing":
        belly[0] = body_clearance(of, ground, at, highest)
    if state.phase == "flight" and state.down.any():
        grace[0] = at.p[1] - (state.first - SETTLE_DISTANCE * of.leg)
    return EventMargins(touch, stretch, fold, belly, grace)


def body_clearance(of: Hopper, ground: Ground, at: BodyState, highest: float = np.inf) -> float:
    """Return how high the body is above the ground, at least [m]."""
    points = at.points(of.belly)
    if float(points[:, 1].min()) > highest + 0.5:
        return float(points[:, 1].min()) - highest
    return float((points[:, 1] - ground.height(points[:, 0], points[:, 2])).min())


def lift_above_ground(of: Hopper, ground: Ground, tips: Array, highest: float) -> Array:
    """Return feet (n, 3) lifted out of the ground [m]."""
    if float(tips[:, 1].min()) - float(of.soles.max()) > highest:
        return tips
    result = tips.copy()
    np.maximum(
        tips[:, 1], lowest_center_height(ground, tips[:, 0], tips[:, 2], of.soles), out=result[:, 1]
    )
    return result
