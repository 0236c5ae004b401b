"""The phases of a pronk: how each begins, and how events change it.

Flight ends when all feet touch, or when the body has sunk a little since the first touch: over a
ditch some feet never do. A landing ends at rest above the crouch, a push at the velocity of the
next jump or when a foot no longer reaches the ground.

Source: Sims 1987, 11.1 to 11.3.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.flight_swing import (
    SwingPath,
    flight_swing,
    trunk_pitch,
)
from pipeline.simulation.locomotion.pronking.hop_events import HopEvent, HopEvents
from pipeline.simulation.locomotion.pronking.hop_state import (
    FREE_FALL,
    HopState,
    available_force,
    floor_height,
    leaning_attitude,
    level_height,
    standing_height,
)
from pipeline.simulation.locomotion.pronking.hopper import Hopper
from pipeline.simulation.locomotion.pronking.jump_planner import has_next_jump, plan_jump
from pipeline.simulation.locomotion.pronking.leg_forces import (
    NO_CONTROL,
    ZERO_VECTOR,
    AttitudeControl,
    lift_off_rate,
    phase_force,
)
from pipeline.simulation.scalar_rotation import Quaternion, Vector, vector_tuple
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

CROUCH_TIME, SINK_WEIGHT = 0.42, 0.7
"""Time in which a creature with legs of one metre crouches [s], and the greatest fraction of its
weight with which it sinks."""

MAX_LANDING_OFFSET = 0.3
"""Greatest horizontal distance of the body from above its feet at the end of a landing, in leg
lengths."""

MIN_LANDING_TRAVEL = 0.03
"""Least travel of a landing, in leg lengths."""

RELEASE_TIME = 0.15
"""Time in which a leg that came off the ground stretches again [s]."""

AUDIBLE_SPEED = 0.2
"""Speed from which a body that lands on its folded legs is an event [m/s]."""


def finish_phase(hopper: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Start the phase that follows one whose time is over."""
    match state.phase:
        case "standing":
            _begin_crouch(hopper, ground, state, events)
        case "crouching":
            begin_landing(hopper, ground, state, events)
        case "landing":
            state.v = np.array([state.v[0], 0.0, state.v[2]])
            _after_landing(hopper, ground, state, events)
        case "pushing":
            take_off(hopper, ground, state, events)
        case "rising":
            time = float(state.v[1] / state.a[1])
            state.phase, state.a = "straightening", -state.a
            state.phase_end = state.time + time
        case "straightening":
            _begin_standing(state)
            wake_if_jumping(hopper, state)
        case _:
            pass


# --- flight ---------------------------------------------------------------------


def take_off(hopper: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Leave the ground with all feet."""
    now = state.body(hopper)
    down = state.down.copy()
    tips = np.where(down[:, None], state.tips, now.to_world(state.swing.tips(state.time)))
    start = (tips - now.origin) @ now.R
    speed = float(np.linalg.norm(state.v))
    for leg in np.flatnonzero(down).tolist():
        place = tips[leg] - [0.0, hopper.foot_radii[leg], 0.0]
        normal = ground.normal(place[0], place[2])
        energy = 0.5 * float(hopper.leg_masses[leg]) * speed * speed
        events.append(HopEvent("lift", state.time, leg, place, normal, speed, energy))
    time = max(state.flight_time, 0.1)
    planned = state.queue.planned
    folds = planned is not None and planned.fold_legs
    own_velocity = now.R.T @ state.v
    state.swing = flight_swing(
        hopper, start, state.landing_feet, state.time, time, own_velocity, folds
    )
    state.pitch = trunk_pitch(hopper, state.swing, own_velocity)
    state.lift_off = state.p.copy(), state.v.copy()
    state.phase, state.a, state.phase_end, state.control = "flight", FREE_FALL, math.inf, NO_CONTROL
    state.down[:] = state.released[:] = False
    state.jump_count += 1
    state.first_touch_height, state.body_hits, state.saturated = math.inf, 0, False
    state.queue.record_take_off()
    if planned is not None:
        state.next_heading = planned.heading
    elif not hopper.config.land_at:
        state.next_heading += math.radians(hopper.config.turn_deg)
        state.travel_heading += math.radians(hopper.config.turn_deg)


# --- landing ----------------------------------------------------------------------


def begin_landing(hopper: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Start absorbing the fall with the legs that touch."""
    state.settle_pitch()
    state.phase = "landing"
    state.floor_height = floor_height(hopper, state)
    height = level_height(hopper, state.p) - state.floor_height
    state.landing_height = min(
        hopper.crouch_height, height - MIN_LANDING_TRAVEL * hopper.leg_length
    )
    update_landing(hopper, ground, state, events)


def update_landing(hopper: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Distribute the rest of a landing among the legs that touch."""
    if state.v[1] >= -1e-9:
        _after_landing(hopper, ground, state, events)
        return
    rise = min(
        state.landing_height - (level_height(hopper, state.p) - state.floor_height),
        -1e-3 * hopper.leg_length,
    )
    time = 2.0 * rise / float(state.v[1])
    x, z = _landing_velocity(hopper, state, time)
    force = phase_force(
        hopper.mass.mass, available_force(hopper, state), vector_tuple(state.v), (x, 0.0, z), rise
    )
    _note_saturation(force.saturated, state, events)
    state.a, state.phase_end = np.array(force.acceleration), state.time + force.time
    x, _, z = state.tips[state.down].mean(axis=0).tolist()
    q = leaning_attitude(hopper, ground, x, z, state.body(hopper).heading)
    state.control = _attitude_control(hopper, state, force.force, q, ZERO_VECTOR, time)


def _landing_velocity(hopper: Hopper, state: HopState, time: float) -> tuple[float, float]:
    """Return the horizontal velocity at the end of a landing [m/s].

    It is unchanged unless the body would move too far from above its feet.
    """
    v = state.v[[0, 2]]
    if not has_next_jump(hopper, state):
        return 0.0, 0.0
    now = state.body(hopper)
    own = state.down
    offset = (now.to_world(hopper.rest_feet) - state.tips)[own][:, [0, 2]].mean(axis=0)
    after = offset + time * v
    distance = float(np.hypot(*after))
    max_offset = MAX_LANDING_OFFSET * hopper.leg_length
    if distance <= max_offset:
        return float(v[0]), float(v[1])
    limited = after * (max_offset / distance)
    # Under constant acceleration the distance is the mean velocity times the time.
    end = 2.0 * (limited - offset) / time - v
    # The body never leaves faster than it came.
    k = min(1.0, float(np.hypot(*v)) / max(float(np.hypot(*end)), 1e-9))
    return k * float(end[0]), k * float(end[1])


def end_landing(hopper: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """End a landing at once: the body lies on the ground."""
    state.v = np.array([state.v[0], max(float(state.v[1]), 0.0), state.v[2]])
    _after_landing(hopper, ground, state, events)


def hit_folded_legs(hopper: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Stop a body that comes down on fully folded legs like one that hits the ground."""
    speed = -float(state.v[1])
    if speed > AUDIBLE_SPEED:
        place = state.tips[state.down].mean(axis=0)
        normal = ground.normal(place[0], place[2])
        energy = 0.5 * hopper.mass.mass * speed * speed
        events.append(HopEvent("body", state.time, -1, place, normal, speed, energy))
    end_landing(hopper, ground, state, events)


def release_feet(
    hopper: Hopper, ground: Ground, state: HopState, legs: NDArray[np.bool_], events: HopEvents
) -> None:
    """Lift feet that no longer reach the ground; during a push, all feet."""
    if state.phase == "pushing":
        take_off(hopper, ground, state, events)
        return
    now = state.body(hopper)
    feet = (
        np.where(state.down[:, None], state.tips, now.to_world(state.swing.tips(state.time)))
        - now.origin
    ) @ now.R
    released = np.asarray(legs, dtype=bool) & state.down
    state.swing = state.swing.restarted(released, state.time, feet, RELEASE_TIME)
    state.down[released], state.released[released] = False, True
    if state.down.any():
        if state.phase == "landing":
            update_landing(hopper, ground, state, events)
    else:
        state.phase, state.a, state.phase_end, state.control = (
            "flight",
            FREE_FALL,
            math.inf,
            NO_CONTROL,
        )
        state.first_touch_height = math.inf
        state.released[:] = released


def _after_landing(hopper: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    if has_next_jump(hopper, state):
        begin_push(hopper, ground, state, events)
    else:
        _begin_rise(hopper, ground, state)


# --- pushing -----------------------------------------------------------------------


def begin_push(hopper: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Push off for the next jump."""
    state.phase = "pushing"
    if state.v[1] < 0.0:
        state.v = np.array([state.v[0], 0.0, state.v[2]])
    state.queue.plan_next(hopper, state, ground)
    if not has_next_jump(hopper, state):
        _begin_rise(hopper, ground, state)
        return
    plan, is_allowed = plan_jump(hopper, state, ground)
    if not is_allowed:
        x, _, z = state.p
        text = f"no landing outside of forbidden zones; it jumps where it is, at [{x:.2f}, {z:.2f}]"
        events.append(HopEvent.note("stopped", state.time, text))
    push = phase_force(
        hopper.mass.mass,
        available_force(hopper, state),
        vector_tuple(state.v),
        vector_tuple(plan.velocity),
        plan.rise,
    )
    _note_saturation(push.saturated, state, events)
    if push.acceleration[1] <= 0.0:
        text = f"{int(state.down.sum())} legs on the ground cannot lift it"
        events.append(HopEvent.note("stopped", state.time, text))
        _begin_standing(state)
        return
    state.a, state.phase_end = np.array(push.acceleration), state.time + push.time
    state.flight_time, state.landing_feet = plan.flight_time, plan.landing_feet
    q, time = state.attitude[0], min(push.time, 1.0)
    goal, rate = lift_off_rate(q, plan.attitude, hopper.inertia, time, plan.flight_time)
    state.control = _attitude_control(hopper, state, push.force, goal, rate, time)


def _begin_crouch(hopper: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Sink half of the way into the first crouch; the landing phase covers the other half."""
    if not has_next_jump(hopper, state):
        state.phase_end = math.inf
        return
    travel = max(
        level_height(hopper, state.p) - state.floor_height - hopper.crouch_height,
        0.5 * MIN_LANDING_TRAVEL * hopper.leg_length,
    )
    time = max(
        CROUCH_TIME * math.sqrt(hopper.leg_length),
        math.sqrt(4.0 * travel / (SINK_WEIGHT * GRAVITY)),
    )
    state.phase, state.a = "crouching", np.array([0.0, -4.0 * travel / time**2, 0.0])
    state.phase_end = state.time + 0.5 * time
    force = 0.0, hopper.mass.mass * (float(state.a[1]) + GRAVITY), 0.0
    state.control = _attitude_control(hopper, state, force, state.attitude[0], ZERO_VECTOR, time)


def _begin_rise(hopper: Hopper, ground: Ground, state: HopState) -> None:
    """Rise from the last crouch, accelerating over half of the way."""
    state.v = np.zeros(3)
    now = state.body(hopper)
    x, _, z = now.origin.tolist()
    height = standing_height(
        hopper,
        now.R,
        state.tips[state.down],
        state.floor_height + hopper.standing_height,
        x,
        z,
        state.down,
    )
    travel = max(height - level_height(hopper, state.p), 1e-3 * hopper.leg_length)
    # Weak legs rise slowly; the body of legs that cannot lift it is overloaded.
    upward = max(available_force(hopper, state) / hopper.mass.mass - GRAVITY, 1e-3)
    time = max(
        1.4 * CROUCH_TIME * math.sqrt(hopper.leg_length),
        math.sqrt(4.0 * travel / min(SINK_WEIGHT * GRAVITY, upward)),
    )
    state.phase, state.a = "rising", np.array([0.0, 4.0 * travel / time**2, 0.0])
    state.phase_end = state.time + 0.5 * time
    force = 0.0, hopper.mass.mass * (float(state.a[1]) + GRAVITY), 0.0
    q = leaning_attitude(hopper, ground, x, z, now.heading)
    state.control = _attitude_control(hopper, state, force, q, ZERO_VECTOR, 0.5 * time)


def _begin_standing(state: HopState) -> None:
    queue = state.queue
    waits = queue.keep_hopping and state.time < queue.hops_from
    state.phase, state.phase_end = "standing", queue.hops_from if waits else math.inf
    state.v, state.a = np.zeros(3), np.zeros(3)
    state.attitude, state.control = (state.attitude[0], ZERO_VECTOR), NO_CONTROL


def wake_if_jumping(hopper: Hopper, state: HopState) -> None:
    """Start crouching if the creature stands and is to jump again."""
    if state.phase == "standing" and has_next_jump(hopper, state):
        state.phase_end = state.time


def begin_fall(state: HopState, feet: Array) -> None:
    """Fall as one rigid body with feet (n, 3) fixed in its frame [m]."""
    state.settle_pitch()
    state.phase, state.phase_end, state.control = "fallen", math.inf, NO_CONTROL
    state.down[:] = False
    state.swing = SwingPath.still(feet)


def _attitude_control(
    hopper: Hopper, state: HopState, force: Vector, goal: Quaternion, rate: Vector, time: float
) -> AttitudeControl:
    x, y, z = (hopper.hips[state.down].mean(axis=0) - hopper.mass.centre).tolist()
    end = state.time + (time if math.isfinite(time) else 0.3)
    return AttitudeControl(
        force, (x, y, z), goal, rate, end, hopper.max_balance_moment, hopper.max_twist_moment
    )


def _note_saturation(saturated: bool, state: HopState, events: HopEvents) -> None:
    if saturated and not state.saturated:
        state.saturated = True
        text = "its legs give all they have, which is less than it takes"
        events.append(HopEvent.note("saturated", state.time, text))
