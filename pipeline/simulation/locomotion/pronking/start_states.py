"""Initial states of hoppers: standing, held above the ground, or taken over from a walk."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pipeline.simulation.locomotion.pronking.flight_swing import SwingPath
from pipeline.simulation.locomotion.pronking.hop_events import body_clearance
from pipeline.simulation.locomotion.pronking.hop_state import (
    FREE_FALL,
    HopState,
    JumpQueue,
    floor_height,
    is_overloaded,
    leaning_attitude,
    level_height,
    standing_height,
)
from pipeline.simulation.locomotion.pronking.hopper import Hopper
from pipeline.simulation.locomotion.pronking.jump_planner import landing_feet
from pipeline.simulation.locomotion.pronking.leg_forces import ZERO_VECTOR
from pipeline.simulation.locomotion.swing.swing_trajectory import lowest_center_height
from pipeline.simulation.scalar_rotation import rotation_matrix
from pipeline.simulation.spatial import Array, quaternion
from pipeline.simulation.terrain import Ground

LOWERING_STEP = 0.03
"""Step by which the initial stance is lowered until all feet reach, in leg lengths."""


def initial_state(hopper: Hopper, ground: Ground, above: float | None) -> HopState:
    """Return the initial state: standing, or with the feet `above` the ground [m], to fall."""
    if above is None:
        state = _standing_on_ground(hopper, ground)
        if body_clearance(hopper, ground, state.body(hopper)) >= 0.0 and not is_overloaded(
            hopper, state
        ):
            return state
    # A creature that cannot stand starts as low above the ground as there is room.
    return _held_above_ground(hopper, ground, above or 0.0)


def _standing_on_ground(hopper: Hopper, ground: Ground) -> HopState:
    """Return the state standing on the legs that reach the ground."""
    state = _at_start(hopper, ground)
    R = rotation_matrix(state.attitude[0])
    x, z = (float(c) for c in hopper.start)
    feet = hopper.rest_feet @ R.T + [x, 0.0, z]
    feet[:, 1] = lowest_center_height(ground, feet[:, 0], feet[:, 2], hopper.foot_radii)
    floor = float((feet[:, 1] - hopper.foot_radii).mean())
    origin = np.array(
        [x, standing_height(hopper, R, feet, floor + hopper.standing_height, x, z), z]
    )
    # On a slope, legs may reach joint limits before full stretch.
    while (
        hopper.leg_reach.misses((feet - origin) @ R).any()
        and origin[1] - floor > hopper.crouch_height
    ):
        origin[1] -= LOWERING_STEP * hopper.leg_length
    # On rough ground some legs may reach nothing: they hang.
    hangs = hopper.rest_feet - [0.0, min(hopper.standing_height, 0.8 * hopper.leg_length), 0.0]
    state.phase, state.phase_end = "standing", hopper.config.start
    state.queue.hops_from = hopper.config.start
    state.p, state.tips = origin + R @ hopper.mass.centre, feet
    state.down, state.swing = ~hopper.leg_reach.misses((feet - origin) @ R), SwingPath.still(hangs)
    state.floor_height = floor_height(hopper, state)
    return state


def _held_above_ground(hopper: Hopper, ground: Ground, above: float) -> HopState:
    """Return the state with the feet `above` the ground, raised until the body is clear of it."""
    state = _at_start(hopper, ground)
    R = rotation_matrix(state.attitude[0])
    feet = landing_feet(hopper, R, np.zeros(3), 1.0, stops=False)
    base = float(ground.height(hopper.start[0], hopper.start[1]))
    state.p[1] += base + above - float((feet[:, 1] - hopper.foot_radii).min())
    state.swing, state.a = SwingPath.still(feet), FREE_FALL
    now = state.body(hopper)
    tips = now.to_world(feet)
    deep = float(
        (lowest_center_height(ground, tips[:, 0], tips[:, 2], hopper.foot_radii) - tips[:, 1]).max()
    )
    state.p[1] += max(deep, -body_clearance(hopper, ground, now), 0.0)
    return state


def _at_start(hopper: Hopper, ground: Ground) -> HopState:
    """Return the state at the start place, with the body at height 0."""
    q = leaning_attitude(
        hopper, ground, float(hopper.start[0]), float(hopper.start[1]), hopper.heading
    )
    n, R = len(hopper.hips), rotation_matrix(q)
    return HopState(
        phase="flight",
        time=0.0,
        p=np.array([hopper.start[0], 0.0, hopper.start[1]]) + R @ hopper.mass.centre,
        v=np.zeros(3),
        attitude=(q, ZERO_VECTOR),
        tips=np.zeros((n, 3)),
        down=np.zeros(n, dtype=bool),
        released=np.zeros(n, dtype=bool),
        swing=SwingPath.still(np.zeros((n, 3))),
        next_heading=hopper.heading
        + (0.0 if hopper.config.land_at else math.radians(hopper.config.turn_deg)),
        travel_heading=hopper.heading + math.radians(hopper.config.direction_deg),
        queue=JumpQueue(hopper.jump),
    )


def standing_state(hopper: Hopper, R: Array, origin: Array, tips: Array, time: float) -> HopState:
    """Return the state of a creature that stands, and came there by other means than jumps.

    Args:
        hopper: the creature.
        R: (3, 3) orientation of its body.
        origin: (3,) of its body [m].
        tips: (n, 3) its feet, on the ground [m].
        time: since the start of the film [s].
    """
    a, b, c, d = quaternion(R[None])[0].tolist()
    angle = math.atan2(-R[2, 0], R[0, 0])
    own = (tips - origin) @ R
    state = HopState(
        phase="standing",
        time=time,
        p=origin + R @ hopper.mass.centre,
        v=np.zeros(3),
        attitude=((a, b, c, d), ZERO_VECTOR),
        tips=tips.copy(),
        down=~hopper.leg_reach.misses(own),
        released=np.zeros(len(tips), dtype=bool),
        swing=SwingPath.still(own),
        next_heading=angle,
        travel_heading=angle,
        queue=JumpQueue(hopper.jump, keep_hopping=False),
    )
    state.floor_height = floor_height(hopper, state)
    return state


def crouched_state(hopper: Hopper, state: HopState) -> HopState:
    """Return the state of a standing creature lowered to its crouch."""
    low = min(state.floor_height + hopper.crouch_height, level_height(hopper, state.p))
    return replace(state, p=np.array([state.p[0], low + hopper.mass.centre[1], state.p[2]]))
