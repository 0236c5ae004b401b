"""Phases: how each begins, and what its events change.

Flight ends when all feet touch, or when the body has sunk a little since the first one did:
over a ditch some never do. A landing ends at rest above the crouch, a push with the velocity
of the next jump or when a foot no longer reaches the ground.

Source: Sims 1987, 11.1 to 11.3.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.foot_contact import flight_swing
from pipeline.simulation.locomotion.pronking.hop_events import HopEvent, HopEvents
from pipeline.simulation.locomotion.pronking.hop_state import (
    FREE_FALL,
    HopState,
    SwingPath,
    available_force,
    floor_height,
    level_height,
    standing_height,
)
from pipeline.simulation.locomotion.pronking.hopper import Hopper
from pipeline.simulation.locomotion.pronking.jump_planner import (
    has_next_jump,
    leaning_attitude,
    plan_jump,
)
from pipeline.simulation.locomotion.pronking.leg_forces import (
    NO_CONTROL,
    ZERO_VECTOR,
    AttitudeControl,
    lift_off_rate,
    phase_force,
)
from pipeline.simulation.scalar_rotation import Quaternion, Vector
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

CROUCH_TIME, SINK_WEIGHT = 0.42, 0.7
"""How long a creature with legs of one metre takes to crouch [s], and with which part of its
weight it sinks at most."""

MAX_LANDING_OFFSET = 0.3
"""How far from above its feet a body may be when a landing ends, in leg lengths."""

MIN_LANDING_TRAVEL = 0.03
"""Way of a landing at least, in leg lengths."""

RELEASE_TIME = 0.15
"""How long a leg that came off the ground takes to be ready again [s]."""

AUDIBLE_SPEED = 0.2
"""Speed from which a body that comes down on its folded legs is heard [m/s]."""


def finish_phase(of: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Go over from a phase whose time has come to the next."""
    match state.phase:
        case "standing":
            _begin_crouch(of, ground, state, events)
        case "crouching":
            begin_landing(of, ground, state, events)
        case "landing":
            state.v = np.array([state.v[0], 0.0, state.v[2]])
            _after_landing(of, ground, state, events)
        case "pushing":
            take_off(of, ground, state, events)
        case "rising":
            _begin_straightening(state)
        case "straightening":
            _begin_standing(state)
            wake_if_jumping(of, state)
        case _:
            pass


# --- flight ---------------------------------------------------------------------


def take_off(of: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Leave the ground with all feet."""
    now = state.now(of)
    down = state.down.copy()
    tips = np.where(down[:, None], state.tips, now.points(state.swing.tips(state.time)))
    start = (tips - now.origin) @ now.R
    speed = float(np.linalg.norm(state.v))
    for leg in np.flatnonzero(down).tolist():
        place = tips[leg] - [0.0, of.soles[leg], 0.0]
        normal = ground.normal(place[0], place[2])
        energy = 0.5 * float(of.leg_mass[leg]) * speed * speed
        events.append(HopEvent("lift", state.time, leg, place, normal, speed, energy))
    time = max(state.flight, 0.1)
    leap = state.course.leap
    folds = leap is not None and leap.folds
    state.swing = flight_swing(of, start, state.ends, state.time, time, now.R.T @ state.v, folds)
    state.lift = state.p.copy(), state.v.copy()
    state.phase, state.a, state.until, state.steering = "flight", FREE_FALL, math.inf, NO_CONTROL
    state.down[:] = state.released[:] = False
    state.jumps += 1
    state.first, state.hits, state.saturated = math.inf, 0, False
    state.course.took_off()
    if leap is not None:
        state.facing = leap.facing
    elif not of.words.land_at:
        state.facing += math.radians(of.words.turn_deg)
        state.going += math.radians(of.words.turn_deg)


# --- landing ----------------------------------------------------------------------


def begin_landing(of: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Let the legs that touch absorb the fall."""
    state.phase = "landing"
    state.floor = floor_height(of, state)
    here = level_height(of, state.p) - state.floor
    state.goal = min(of.crouch, here - MIN_LANDING_TRAVEL * of.leg)
    update_landing(of, ground, state, events)


def update_landing(of: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Share the landing anew among the legs that touch."""
    if state.v[1] >= -1e-9:
        _after_landing(of, ground, state, events)
        return
    rise = min(state.goal - (level_height(of, state.p) - state.floor), -1e-3 * of.leg)
    time = 2.0 * rise / float(state.v[1])
    x, z = _landing_velocity(of, state, time)
    one = phase_force(
        of.mass.mass, available_force(of, state), _vector_tuple(state.v), (x, 0.0, z), rise
    )
    _note_saturation(one.saturated, state, events)
    state.a, state.until = np.array(one.acceleration), state.time + one.time
    x, _, z = state.tips[state.down].mean(axis=0).tolist()
    q = leaning_attitude(of, ground, x, z, state.now(of).heading)
    state.steering = _attitude_control(of, state, one.force, q, ZERO_VECTOR, time)


def _landing_velocity(of: Hopper, state: HopState, time: float) -> tuple[float, float]:
    """Return the horizontal velocity wanted at the end of a landing [m/s].

    It stays what it is, unless the body would get too far from above its feet.
    """
    v = state.v[[0, 2]]
    if not has_next_jump(of, state):
        return 0.0, 0.0
    now = state.now(of)
    own = state.down
    offset = (now.points(of.rest) - state.tips)[own][:, [0, 2]].mean(axis=0)
    after = offset + time * v
    far = float(np.hypot(*after))
    most = MAX_LANDING_OFFSET * of.leg
    if far <= most:
        return float(v[0]), float(v[1])
    wanted = after * (most / far)
    # With a constant acceleration the way is the mean of both velocities times the time.
    end = 2.0 * (wanted - offset) / time - v
    # Who is thrown far aside is not to be thrown back harder.
    k = min(1.0, float(np.hypot(*v)) / max(float(np.hypot(*end)), 1e-9))
    return k * float(end[0]), k * float(end[1])


def end_landing(of: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """End a landing at once: the body lies on the ground."""
    state.v = np.array([state.v[0], max(float(state.v[1]), 0.0), state.v[2]])
    _after_landing(of, ground, state, events)


def hit_folded_legs(of: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Let the body come down on legs that fold no farther, as hard as on the ground."""
    speed = -float(state.v[1])
    if speed > AUDIBLE_SPEED:
        place = state.tips[state.down].mean(axis=0)
        normal = ground.normal(place[0], place[2])
        energy = 0.5 * of.mass.mass * speed * speed
        events.append(HopEvent("body", state.time, -1, place, normal, speed, energy))
    end_landing(of, ground, state, events)


def release_feet(
    of: Hopper, ground: Ground, state: HopState, legs: NDArray[np.bool_], events: HopEvents
) -> None:
    """Lift feet that no longer reach the ground; in a push, with them all others."""
    if state.phase == "pushing":
        take_off(of, ground, state, events)
        return
    now = state.now(of)
    own = (
        np.where(state.down[:, None], state.tips, now.points(state.swing.tips(state.time)))
        - now.origin
    ) @ now.R
    which = np.asarray(legs, dtype=bool) & state.down
    state.swing = state.swing.again(which, state.time, own, RELEASE_TIME)
    state.down[which], state.released[which] = False, True
    if state.down.any():
        if state.phase == "landing":
            update_landing(of, ground, state, events)
    else:
        state.phase, state.a, state.until, state.steering = (
            "flight",
            FREE_FALL,
            math.inf,
            NO_CONTROL,
        )
        state.first = math.inf
        state.released[:] = False


def _after_landing(of: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    if has_next_jump(of, state):
        begin_push(of, ground, state, events)
    else:
        _begin_rise(of, ground, state)


# --- pushing -----------------------------------------------------------------------


def begin_push(of: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Push off for the next jump."""
    state.phase = "pushing"
    if state.v[1] < 0.0:
        state.v = np.array([state.v[0], 0.0, state.v[2]])
    for text in state.course.choose(of, state, ground):
        up = np.array([0.0, 1.0, 0.0])
        events.append(HopEvent("stopped", state.time, -1, state.p, up, 0.0, 0.0, text))
    if not has_next_jump(of, state):
        _begin_rise(of, ground, state)
        return
    one, good = plan_jump(of, state, ground)
    if not good:
        text = "no landing outside of forbidden zones; it jumps where it is"
        place = np.array([one.spot[0], 0.0, one.spot[1]])
        up = np.array([0.0, 1.0, 0.0])
        events.append(HopEvent("stopped", state.time, -1, place, up, 0.0, 0.0, text))
    push = phase_force(
        of.mass.mass,
        available_force(of, state),
        _vector_tuple(state.v),
        _vector_tuple(one.velocity),
        one.rise,
    )
    _note_saturation(push.saturated, state, events)
    if push.acceleration[1] <= 0.0:
        text = f"{int(state.down.sum())} legs on the ground cannot lift it"
        events.append(HopEvent("stopped", state.time, -1, state.p, np.zeros(3), 0.0, 0.0, text))
        _begin_standing(state)
        return
    state.a, state.until = np.array(push.acceleration), state.time + push.time
    state.flight, state.ends = one.flight, one.ends
    q, time = state.turning[0], min(push.time, 1.0)
    goal, rate = lift_off_rate(q, one.attitude, of.inertia, time, one.flight)
    state.steering = _attitude_control(of, state, push.force, goal, rate, time)


def _begin_crouch(of: Hopper, ground: Ground, state: HopState, events: HopEvents) -> None:
    """Sink for half of the way into the first crouch; the landing ends the other half."""
    if not has_next_jump(of, state):
        state.until = math.inf
        return
    way = max(
        level_height(of, state.p) - state.floor - of.crouch, 0.5 * MIN_LANDING_TRAVEL * of.leg
    )
    time = max(CROUCH_TIME * math.sqrt(of.leg), math.sqrt(4.0 * way / (SINK_WEIGHT * GRAVITY)))
    state.phase, state.a = "crouching", np.array([0.0, -4.0 * way / time**2, 0.0])
    state.until = state.time + 0.5 * time
    force = 0.0, of.mass.mass * (float(state.a[1]) + GRAVITY), 0.0
    state.steering = _attitude_control(of, state, force, state.turning[0], ZERO_VECTOR, time)


def _begin_rise(of: Hopper, ground: Ground, state: HopState) -> None:
    """Rise from the last crouch, half of the way ever faster."""
    state.v = np.zeros(3)
    now = state.now(of)
    x, _, z = now.origin.tolist()
    height = standing_height(
        of, now.R, state.tips[state.down], state.floor + of.stand, x, z, state.down
    )
    way = max(height - level_height(of, state.p), 1e-3 * of.leg)
    # Weak legs rise slowly; those that cannot rise at all give way.
    lift = max(available_force(of, state) / of.mass.mass - GRAVITY, 1e-3)
    time = max(
        1.4 * CROUCH_TIME * math.sqrt(of.leg),
        math.sqrt(4.0 * way / min(SINK_WEIGHT * GRAVITY, lift)),
    )
    state.phase, state.a = "rising", np.array([0.0, 4.0 * way / time**2, 0.0])
    state.until = state.time + 0.5 * time
    force = 0.0, of.mass.mass * (float(state.a[1]) + GRAVITY), 0.0
    q = leaning_attitude(of, ground, x, z, now.heading)
    state.steering = _attitude_control(of, state, force, q, ZERO_VECTOR, 0.5 * time)


def _begin_straightening(state: HopState) -> None:
    time = float(state.v[1] / state.a[1])
    state.phase, state.a = "straightening", -state.a
    state.until = state.time + time


def _begin_standing(state: HopState) -> None:
    state.phase, state.until = "standing", math.inf
    state.v, state.a = np.zeros(3), np.zeros(3)
    state.turning, state.steering = (state.turning[0], ZERO_VECTOR), NO_CONTROL


def wake_if_jumping(of: Hopper, state: HopState) -> None:
    """Let who stands begin to crouch if it is to jump again."""
    if state.phase == "standing" and has_next_jump(of, state):
        state.until = min(state.until, max(state.time, of.words.start))


def begin_fall(state: HopState, feet: Array) -> None:
    """Fall as one rigid body, feet (n, 3) where they are in its frame [m]."""
    state.phase, state.until, state.steering = "fallen", math.inf, NO_CONTROL
    state.down[:] = False
    state.swing = SwingPath.still(feet)


def _attitude_control(
    of: Hopper, state: HopState, force: Vector, goal: Quaternion, rate: Vector, time: float
) -> AttitudeControl:
    x, y, z = (of.hips[state.down].mean(axis=0) - of.mass.centre).tolist()
    end = state.time + (time if math.isfinite(time) else 0.3)
    return AttitudeControl(force, (x, y, z), goal, rate, end, of.balance, of.twist)


def _note_saturation(saturated: bool, state: HopState, events: HopEvents) -> None:
    if saturated and not state.saturated:
        state.saturated = True
        text = "its legs give all they have, which is less than it takes"
        up = np.array([0.0, 1.0, 0.0])
        events.append(HopEvent("saturated", state.time, -1, state.p, up, 0.0, 0.0, text))


def _vector_tuple(v: Array) -> Vector:
    x, y, z = v.tolist()
    return x, y, z
