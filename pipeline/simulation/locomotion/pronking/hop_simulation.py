"""Simulation of one hopper, from event to event.

Phases of constant acceleration are advanced exactly, the attitude by Runge-Kutta. What ends a
phase, or happens within it, is located inside the step.

Source: Sims 1987, ch. 11.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.hop_events import (
    RISING_SPEED,
    WALL_HEIGHT,
    EventMargins,
    HopEvent,
    body_clearance,
    event_margins,
    lift_above_ground,
    swing_from_wall,
    touch,
    trip_on_wall,
)
from pipeline.simulation.locomotion.pronking.hop_phases import (
    begin_fall,
    begin_landing,
    begin_push,
    end_landing,
    finish_phase,
    hit_folded_legs,
    release_feet,
    update_landing,
)
from pipeline.simulation.locomotion.pronking.hop_state import (
    SUPPORT_PHASES,
    BodyState,
    HopState,
    is_overloaded,
)
from pipeline.simulation.locomotion.pronking.hopper import Hopper
from pipeline.simulation.locomotion.pronking.hopper_fall import Fall, JointState
from pipeline.simulation.locomotion.pronking.jump_planner import find_crossing
from pipeline.simulation.locomotion.pronking.leg_forces import distribute_force, moment
from pipeline.simulation.locomotion.pronking.start_states import initial_state
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

TIME_TOLERANCE = 1e-12
"""Remainder of a step that counts as zero [s]."""

TOPPLE_TILT = math.radians(68.0)
"""Tilt from which legs cannot right a body [rad]."""

LYING_TILT = math.radians(38.0)
"""Tilt at which a body that strikes the ground falls over [rad]."""

REARM_DEPTH = 0.01
"""Penetration at which a body that lies on the ground strikes it again, in leg lengths."""

MAX_EVENTS = 400
"""Bound on the events of one step; more mean that the creature is stuck."""

MAX_SUB_STEP = 1.0 / 90.0
"""Longest sub-step: no contact begins and ends unnoticed within it [s]."""

JointReader = Callable[[BodyState, Array, NDArray[np.bool_]], JointState]
"""Body, feet (n, 3) [m] and which of them are down (n,) -> joint state."""


class HopSimulation:
    """One hopper and what happens to it.

    Attributes:
        hopper: its constants.
        ground: that it hops over.
        state: its state.
        fall: how it falls once it has toppled.
        read_joints: reads its joints at that moment.
        events: since they were last cleared.
    """

    def __init__(
        self,
        hopper: Hopper,
        ground: Ground,
        above: float | None,
        fall: Fall,
        read_joints: JointReader,
        state: HopState | None = None,
    ) -> None:
        self.hopper, self.ground = hopper, ground
        self.highest = float(ground.field.heights.max())
        self.fall, self.read_joints = fall, read_joints
        self.events: list[HopEvent] = []
        self._next_margins: EventMargins | None = None
        # Which feet reached the ground within the last sub-step, and how high each is lifted out of
        # it while the body rises.
        self._touched = np.zeros(len(hopper.hips), dtype=bool)
        self._lifted = np.zeros(len(hopper.hips))
        self.state = initial_state(hopper, ground, above) if state is None else state

    def advance(self, end: float) -> None:
        """Advance to time `end` [s]."""
        for _ in range(MAX_EVENTS):
            state = self.state
            left = end - state.time
            if left <= TIME_TOLERANCE:
                break
            if state.phase == "fallen":
                self.events += self.fall.advance(self.state, left)
                break
            known = (
                self._margins(state.body(self.hopper))
                if self._next_margins is None
                else self._next_margins
            )
            due = bool((known.all <= 0.0).any())
            if due:
                self._handle_events(known)
                known = self._margins(state.body(self.hopper))
            if self.state.phase != "fallen":
                self._advance_sub_step(min(left, MAX_SUB_STEP), known)
        self.state.time = end
        self._release_missed_feet()
        if is_overloaded(self.hopper, self.state):
            self._topple("the legs that touch cannot carry it")

    def pose(self) -> tuple[BodyState, Array]:
        """Return the body, and its feet (n, 3) in the world [m]."""
        state, now = self.state, self.state.body(self.hopper)
        if state.down.all():
            return now, state.tips.copy()
        tips = now.to_world(state.swing.tips(state.time))
        if state.phase != "fallen":
            tips = lift_above_ground(self.hopper, self.ground, tips, self.highest)
        tips[state.down] = state.tips[state.down]
        return now, tips

    def leg_forces(self) -> Array:
        """Return the current forces (n, 3) of the legs [N]."""
        state, hopper = self.state, self.hopper
        forces = np.zeros_like(hopper.hips)
        down = state.down
        if state.phase in ("flight", "fallen") or not down.any():
            return forces
        now = state.body(hopper)
        m = moment(state.attitude, hopper.inertia, state.control, state.time)
        levers = (hopper.hips[down] - hopper.mass.centre) @ now.R.T
        force = hopper.mass.mass * (state.a + np.array([0.0, GRAVITY, 0.0]))
        forces[down] = distribute_force(force, np.array(m), levers, hopper.max_leg_force)
        return forces

    # --- within a step -----------------------------------------------------------

    def _margins(self, at: BodyState) -> EventMargins:
        return event_margins(self.hopper, self.state, self.ground, at, self.highest)

    def _advance_sub_step(self, h: float, known: EventMargins) -> None:
        """Advance to the end of a sub-step or of the phase, or to the first event.

        Args:
            h: the sub-step [s].
            known: margins at its start.
        """
        state, hopper = self.state, self.hopper
        before = state.body(hopper)
        remaining = state.phase_end - state.time
        if state.phase == "flight" and state.v[1] > RISING_SPEED:
            remaining = state.v[1] / GRAVITY
        is_ending = remaining <= h
        h = max(min(h, remaining), 0.0)
        next_body = state.predict(h, hopper)
        if state.phase == "flight" and is_ending:
            next_body.v[1] = 0.0
        next_margins = self._margins(next_body)
        crossed = np.flatnonzero((next_margins.all <= 0.0) & (known.all > 0.0))
        if len(crossed):

            def gap(t: float) -> float:
                return float(self._margins(state.predict(t, hopper)).all[crossed].min())

            next_body = state.predict(find_crossing(gap, 0.0, h), hopper)
            is_ending = False
        # Margins at the end hold at the next start, unless an event happens between.
        self._next_margins = None if is_ending or len(crossed) else next_margins
        # While the body rose, feet were lifted and not tested.
        tested = np.isfinite(known.touch) & (known.touch > 0.0)
        self._touched = tested & (state.v[1] <= RISING_SPEED)
        state.time, state.p, state.v, state.attitude = (
            next_body.time,
            next_body.p,
            next_body.v,
            next_body.attitude,
        )
        if next_body.tilt > TOPPLE_TILT:
            self._topple("it leaned too far")
        elif is_ending and state.phase != "flight":
            finish_phase(hopper, self.ground, state, self.events)
            self._lifted[:] = 0.0
        elif state.phase == "flight" and state.v[1] > RISING_SPEED:
            self._trip_while_rising(before, next_body)
        self._rearm_body()

    def _release_missed_feet(self) -> None:
        """Lift feet that their legs do not reach: joint limits are not a sphere around the hip."""
        state, hopper = self.state, self.hopper
        if not state.down.any() or state.phase == "fallen":
            return
        now = state.body(hopper)
        feet = (state.tips - now.origin) @ now.R
        missed = state.down & hopper.leg_reach.misses(feet)
        if missed.any():
            self._next_margins = None
            release_feet(hopper, self.ground, state, missed, self.events)

    def _trip_while_rising(self, before: BodyState, body: BodyState) -> None:
        """Trip feet that meet a wall while the body rises; they come up along it.

        Args:
            before: the body at the start of the sub-step.
            body: the body now.
        """
        state, hopper = self.state, self.hopper
        tips = body.to_world(state.swing.tips(body.time))
        lift = lift_above_ground(hopper, self.ground, tips, self.highest)[:, 1] - tips[:, 1]
        caught = lift - self._lifted > WALL_HEIGHT * hopper.leg_length
        if caught.any():
            trip_on_wall(hopper, state, np.flatnonzero(caught), tips, self.events)
            outside = before.to_world(state.swing.tips(before.time))
            outside = lift_above_ground(hopper, self.ground, outside, self.highest)
            state.swing = swing_from_wall(state.swing, caught, (before, body), (outside, tips))
            lift = np.where(caught, 0.0, lift)
        self._lifted = lift

    def _rearm_body(self) -> None:
        state = self.state
        if not state.body_armed and state.phase != "fallen":
            self._next_margins = None
            gap = body_clearance(self.hopper, self.ground, state.body(self.hopper))
            state.body_armed = gap > 0.01 or gap < -REARM_DEPTH * self.hopper.leg_length

    def _handle_events(self, margins: EventMargins) -> None:
        """Handle the events that are due."""
        hopper, state, ground = self.hopper, self.state, self.ground
        if margins.belly[0] <= 0.0 and self._strike_body():
            return
        if (margins.touch <= 0.0).any():
            legs = np.flatnonzero(margins.touch <= 0.0)
            touch(hopper, ground, state, legs, self._touched, self.events)
        if state.phase == "flight":
            due = (
                margins.grace[0] <= 0.0
                or (margins.stretch <= 0.0).any()
                or (margins.fold <= 0.0).any()
            )
            if state.down.all() or (due and state.down.any()):
                begin_landing(hopper, ground, state, self.events)
        elif state.phase == "landing" and (margins.touch <= 0.0).any():
            update_landing(hopper, ground, state, self.events)
        if state.phase in SUPPORT_PHASES and (margins.stretch <= 0.0).any():
            release_feet(hopper, ground, state, margins.stretch <= 0.0, self.events)
        if state.phase == "landing" and (margins.fold[state.down] <= 0.0).any():
            hit_folded_legs(hopper, ground, state, self.events)

    def _strike_body(self) -> bool:
        """Let the body strike the ground; return whether it topples."""
        hopper, state = self.hopper, self.state
        now = state.body(hopper)
        points = now.to_world(hopper.belly_points)
        gaps = points[:, 1] - self.ground.height(points[:, 0], points[:, 2])
        place = points[int(gaps.argmin())]
        normal = self.ground.normal(place[0], place[2])
        speed = -float(normal @ state.v)
        state.body_armed = False
        state.body_hits += 1
        if speed <= 0.0:
            return False
        energy = 0.5 * hopper.mass.mass * speed * speed
        self.events.append(HopEvent("body", state.time, -1, place, normal, speed, energy))
        lies = now.tilt > LYING_TILT or state.body_hits > 3
        if lies or not state.down.any():
            self._topple("its body struck the ground" + ("" if lies else " before its feet"))
            return True
        state.v = state.v + speed * normal
        if state.phase == "landing":
            end_landing(hopper, self.ground, state, self.events)
        elif state.phase == "pushing":
            begin_push(hopper, self.ground, state, self.events)
        return False

    def _topple(self, reason: str) -> None:
        state = self.state
        self.events.append(HopEvent.note("toppled", state.time, reason))
        now, tips = self.pose()
        joints = self.read_joints(now, tips, state.down)
        begin_fall(state, (tips - now.origin) @ now.R)
        self.fall.begin(self.hopper, self.ground, state, joints)
