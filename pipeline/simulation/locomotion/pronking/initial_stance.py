"""Beginning: how a creature stands before its first jump.

On its own ground, held up above it, or as it has come there by walking.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pipeline.simulation.locomotion.pronking.foot_contact import body_clearance
from pipeline.simulation.locomotion.pronking.hop_state import (
    FREE_FALL,
    HopState,
    JumpQueue,
    SwingPath,
    floor_height,
    is_overloaded,
    level_height,
    standing_height,
)
from pipeline.simulation.locomotion.pronking.hopper import Hopper
from pipeline.simulation.locomotion.pronking.jump_planner import (
    landing_feet,
    leaning_attitude,
)
from pipeline.simulation.locomotion.pronking.leg_forces import ZERO_VECTOR
from pipeline.simulation.locomotion.swing.swing_trajectory import lowest_center_height
from pipeline.simulation.scalar_rotation import matrix_rows
from pipeline.simulation.spatial import Array, quaternion
from pipeline.simulation.terrain import Ground

LOWERING_STEP = 0.03
"""Steps in which who cannot stand upright stands lower, in leg lengths."""


def initial_state(of: Hopper, ground: Ground, above: float | None) -> HopState:
    """Return how it begins: standing, or with its feet `above` the ground [m], to fall."""
    if above is None:
        state = _standing_on_ground(of, ground)
        if body_clearance(of, ground, state.now(of)) >= 0.0 and not is_overloaded(of, state):
            return state
    # Where it cannot stand it comes down from as low as there is room for it.
    return _held_above_ground(of, ground, above or 0.0)


def _standing_on_ground(of: Hopper, ground: Ground) -> HopState:
    """Return it standing, on what legs come to the ground."""
    state = _at_start(of, ground)
    R = np.array(matrix_rows(state.turning[0]))
    x, z = (float(c) for c in of.start)
    feet = of.rest @ R.T + [x, 0.0, z]
    feet[:, 1] = lowest_center_height(ground, feet[:, 0], feet[:, 2], of.soles)
    floor = float((feet[:, 1] - of.soles).mean())
    origin = np.array([x, standing_height(of, R, feet, floor + of.stand, x, z), z])
    # Legs that stand on a slope may come to limits of their joints before they are long.
    while of.legs.misses((feet - origin) @ R).any() and origin[1] - floor > of.crouch:
        origin[1] -= LOWERING_STEP * of.leg
    # On rough ground some legs may have nothing to stand on: they hang.
    hangs = of.rest - [0.0, min(of.stand, 0.8 * of.leg), 0.0]
    state.phase, state.until = "standing", of.words.start
    state.p, state.tips = origin + R @ of.mass.centre, feet
    state.down, state.swing = ~of.legs.misses((feet - origin) @ R), SwingPath.still(hangs)
    state.floor = floor_height(of, state)
    return state


def _held_above_ground(of: Hopper, ground: Ground, above: float) -> HopState:
    """Return it with its feet so high above the ground, or as low as its body is out of it."""
    state = _at_start(of, ground)
    R = np.array(matrix_rows(state.turning[0]))
    feet = landing_feet(of, R, np.zeros(3), 1.0, stops=False)
    base = float(ground.height(of.start[0], of.start[1]))
    state.p[1] += base + above - float((feet[:, 1] - of.soles).min())
    state.swing, state.a = SwingPath.still(feet), FREE_FALL
    now = state.now(of)
    tips = now.points(feet)
    deep = float(
        (lowest_center_height(ground, tips[:, 0], tips[:, 2], of.soles) - tips[:, 1]).max()
    )
    state.p[1] += max(deep, -body_clearance(of, ground, now), 0.0)
    return state


def _at_start(of: Hopper, ground: Ground) -> HopState:
    """Return it where it begins, its body at height 0."""
    q = leaning_attitude(of, ground, float(of.start[0]), float(of.start[1]), of.heading)
    n, R = len(of.hips), np.array(matrix_rows(q))
    return HopState(
        phase="flight",
        time=0.0,
        p=np.array([of.start[0], 0.0, of.start[1]]) + R @ of.mass.centre,
        v=np.zeros(3),
        turning=(q, ZERO_VECTOR),
        tips=np.zeros((n, 3)),
        down=np.zeros(n, dtype=bool),
        released=np.zeros(n, dtype=bool),
        swing=SwingPath.still(np.zeros((n, 3))),
        facing=of.heading + (0.0 if of.words.land_at else math.radians(of.words.turn_deg)),
        going=of.heading + math.radians(of.words.direction_deg),
        course=JumpQueue(of.jump),
    )


def standing_state(of: Hopper, R: Array, origin: Array, tips: Array, time: float) -> HopState:
    """Return the state of one that stands, and has come there by other ways than jumps.

    Args:
        of: who.
        R: (3, 3) and
        origin: (3,) of its body [m].
        tips: (n, 3) its feet, which are on the ground [m].
        time: since the start of the film [s].
    """
    a, b, c, d = quaternion(R[None])[0].tolist()
    angle = math.atan2(-R[2, 0], R[0, 0])
    own = (tips - origin) @ R
    state = HopState(
        phase="standing",
        time=time,
        p=origin + R @ of.mass.centre,
        v=np.zeros(3),
        turning=((a, b, c, d), ZERO_VECTOR),
        tips=tips.copy(),
        down=~of.legs.misses(own),
        released=np.zeros(len(tips), dtype=bool),
        swing=SwingPath.still(own),
        facing=angle,
        going=angle,
        course=JumpQueue(of.jump, onward=False),
    )
    state.floor = floor_height(of, state)
    return state


def crouched_state(of: Hopper, state: HopState) -> HopState:
    """Return the state of one that stands as it will be at the begin of a push."""
    low = min(state.floor + of.crouch, level_height(of, state.p))
    return replace(state, p=np.array([state.p[0], low + of.mass.centre[1], state.p[2]]))
