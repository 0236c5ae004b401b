"""Hopping: one pronker on its way, from event to event.

Phases of constant acceleration are advanced exactly, the attitude by Runge and Kutta; what
ends a phase, or happens within it, is located inside the step.

Source: Sims 1987, ch. 11.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.foot_contact import (
    RISING_SPEED,
    WALL_HEIGHT,
    EventMargins,
    body_clearance,
    event_margins,
    lift_above_ground,
    touch,
    trip_on_wall,
)
from pipeline.simulation.locomotion.pronking.hop_events import HopEvent
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
from pipeline.simulation.locomotion.pronking.initial_stance import initial_state
from pipeline.simulation.locomotion.pronking.jump_planner import find_crossing
from pipeline.simulation.locomotion.pronking.leg_forces import distribute_force, moment
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

TIME_TOLERANCE = 1e-12
"""What is left of a step when it is over [s]."""

TOPPLE_TILT = math.radians(68.0)
"""Tilt from which no leg brings a body back."""

LYING_TILT = math.radians(38.0)
"""Tilt with which a body that strikes the ground falls."""

REARM_DEPTH = 0.01
"""How far a body that lies on the ground is let into it until it strikes again, in leg lengths."""

MAX_EVENTS = 400
"""Events of one step; more are a creature that is stuck."""

MAX_SUB_STEP = 1.0 / 90.0
"""Longest sub-step: between two of them nothing comes and goes unseen [s]."""

JointReader = Callable[[BodyState, Array, NDArray[np.bool_]], JointState]
"""Body, feet (n, 3) [m] and which of them are down (n,) -> joints."""


class HopSimulation:
    """One pronker and what happens to it.

    Attributes:
        of: its constants.
        ground: that it hops over.
        state: how it is.
        fall: once it has toppled.
        limbs: how its limbs are then, which it is told from outside.
        happened: since that was taken away.
    """

    def __init__(
        self,
        of: Hopper,
        ground: Ground,
        above: float | None,
        fall: Fall,
        limbs: JointReader,
        state: HopState | None = None,
    ) -> None:
        self.of, self.ground = of, ground
        self.highest = float(ground.field.heights.max())
        self.fall, self.limbs = fall, limbs
        self.happened: list[HopEvent] = []
        self._known: EventMargins | None = None
        # Which feet came to the ground within the last sub-step, and how high each has to be
        # lifted out of it while the body rises.
        self._met = np.zeros(len(of.hips), dtype=bool)
        self._lifted = np.zeros(len(of.hips))
        self.state = initial_state(of, ground, above) if state is None else state

    def advance(self, end: float) -> None:
        """Go on until `end` [s]."""
        for _ in range(MAX_EVENTS):
            state = self.state
            left = end - state.time
            if left <= TIME_TOLERANCE:
                break
            if state.phase == "fallen":
                self._lie(left)
                break
            known = self._margins(state.now(self.of)) if self._known is None else self._known
            due = bool((known.all <= 0.0).any())
            if due:
                self._look(known)
                known = self._margins(state.now(self.of))
            if self.state.phase != "fallen":
                self._go(min(left, MAX_SUB_STEP), known)
        self.state.time = end
        self._let_go_of_what_is_missed()
        if is_overloaded(self.of, self.state):
            self._topple("the legs that touch cannot carry it")

    def pose(self) -> tuple[BodyState, Array]:
        """Return the body, and its feet (n, 3) in the world [m]."""
        state, now = self.state, self.state.now(self.of)
        if state.down.all():
            return now, state.tips.copy()
        tips = now.points(state.swing.tips(state.time))
        if state.phase != "fallen":
            tips = lift_above_ground(self.of, self.ground, tips, self.highest)
        tips[state.down] = state.tips[state.down]
        return now, tips

    def leg_forces(self) -> Array:
        """Return the forces (n, 3) that legs give just now [N]."""
        state, of = self.state, self.of
        forces = np.zeros_like(of.hips)
        down = state.down
        if state.phase in ("flight", "fallen") or not down.any():
            return forces
        now = state.now(of)
        m = moment(state.turning, of.inertia, state.steering, state.time)
        levers = (of.hips[down] - of.mass.centre) @ now.R.T
        force = of.mass.mass * (state.a + np.array([0.0, GRAVITY, 0.0]))
        forces[down] = distribute_force(force, np.array(m), levers, of.most)
        return forces

    # --- within a step -----------------------------------------------------------

    def _margins(self, at: BodyState) -> EventMargins:
        return event_margins(self.of, self.state, self.ground, at, self.highest)

    def _go(self, h: float, known: EventMargins) -> None:
        """Go on to the end of a sub-step or of the phase, or to what happens first.

        Args:
            h: the sub-step [s].
            known: margins at its begin.
        """
        state, of = self.state, self.of
        ends = state.until - state.time
        if state.phase == "flight" and state.v[1] > RISING_SPEED:
            ends = state.v[1] / GRAVITY
        ending = ends <= h
        h = max(min(h, ends), 0.0)
        there = state.at(h, of)
        if state.phase == "flight" and ending:
            there.v[1] = 0.0
        found = self._margins(there)
        crossed = np.flatnonzero((found.all <= 0.0) & (known.all > 0.0))
        if len(crossed):

            def gap(t: float) -> float:
                return float(self._margins(state.at(t, of)).all[crossed].min())

            there = state.at(find_crossing(gap, 0.0, h), of)
            ending = False
        # What holds at the end holds at the next begin, unless something happens between.
        self._known = None if ending or len(crossed) else found
        # While it rose nobody looked, and feet were lifted.
        tested = np.isfinite(known.touch) & (known.touch > 0.0)
        self._met = tested & (state.v[1] <= RISING_SPEED)
        state.time, state.p, state.v, state.turning = there.time, there.p, there.v, there.turning
        if there.tilt > TOPPLE_TILT:
            self._topple("it leaned too far")
        elif ending and state.phase != "flight":
            finish_phase(of, self.ground, state, self.happened)
            self._lifted[:] = 0.0
        elif state.phase == "flight" and state.v[1] > RISING_SPEED:
            self._stumble(there)
        self._arm()

    def _let_go_of_what_is_missed(self) -> None:
        """Lift feet that legs do not come to: limits of joints are no sphere around hips."""
        state, of = self.state, self.of
        if not state.down.any() or state.phase == "fallen":
            return
        now = state.now(of)
        feet = (state.tips - now.origin) @ now.R
        missed = state.down & of.legs.misses(feet)
        if missed.any():
            self._known = None
            release_feet(of, self.ground, state, missed, self.happened)

    def _stumble(self, at: BodyState) -> None:
        """Let feet that meet a wall while the body rises pull at it; they are lifted over it."""
        state, of = self.state, self.of
        tips = at.points(state.swing.tips(at.time))
        lift = lift_above_ground(of, self.ground, tips, self.highest)[:, 1] - tips[:, 1]
        walls = np.flatnonzero(lift - self._lifted > WALL_HEIGHT * of.leg)
        self._lifted = lift
        if len(walls):
            trip_on_wall(of, state, walls, tips, self.happened)

    def _arm(self) -> None:
        state = self.state
        if not state.armed and state.phase != "fallen":
            self._known = None
            gap = body_clearance(self.of, self.ground, state.now(self.of))
            state.armed = gap > 0.01 or gap < -REARM_DEPTH * self.of.leg

    def _look(self, at: EventMargins) -> None:
        """Let happen what is due."""
        of, state, ground = self.of, self.state, self.ground
        if at.belly[0] <= 0.0 and self._struck():
            return
        if (at.touch <= 0.0).any():
            legs = np.flatnonzero(at.touch <= 0.0)
            touch(of, ground, state, legs, self._met, self.happened)
        if state.phase == "flight":
            due = at.grace[0] <= 0.0 or (at.stretch <= 0.0).any() or (at.fold <= 0.0).any()
            if state.down.all() or (due and state.down.any()):
                begin_landing(of, ground, state, self.happened)
        elif state.phase == "landing" and (at.touch <= 0.0).any():
            update_landing(of, ground, state, self.happened)
        if state.phase in SUPPORT_PHASES and (at.stretch <= 0.0).any():
            release_feet(of, ground, state, at.stretch <= 0.0, self.happened)
        if state.phase == "landing" and (at.fold[state.down] <= 0.0).any():
            hit_folded_legs(of, ground, state, self.happened)

    def _struck(self) -> bool:
        """Let the body strike the ground; tell whether it falls."""
        of, state = self.of, self.state
        now = state.now(of)
        points = now.points(of.belly)
        gaps = points[:, 1] - self.ground.height(points[:, 0], points[:, 2])
        place = points[int(gaps.argmin())]
        normal = self.ground.normal(place[0], place[2])
        speed = -float(normal @ state.v)
        state.armed = False
        state.hits += 1
        if speed <= 0.0:
            return False
        energy = 0.5 * of.mass.mass * speed * speed
        self.happened.append(HopEvent("body", state.time, -1, place, normal, speed, energy))
        lies = now.tilt > LYING_TILT or state.hits > 3
        if lies or not state.down.any():
            self._topple("its body struck the ground" + ("" if lies else " before its feet"))
            return True
        state.v = state.v + speed * normal
        if state.phase == "landing":
            end_landing(of, self.ground, state, self.happened)
        elif state.phase == "pushing":
            begin_push(of, self.ground, state, self.happened)
        return False

    def _topple(self, why: str) -> None:
        state = self.state
        self.happened.append(
            HopEvent("toppled", state.time, -1, state.p, np.array(UP), 0.0, 0.0, why)
        )
        now, tips = self.pose()
        limbs = self.limbs(now, tips, state.down)
        begin_fall(state, (tips - now.origin) @ now.R)
        self.fall.begin(self.of, self.ground, state, limbs)

    def _lie(self, h: float) -> None:
        self.happened += self.fall.advance(self.state, h)


UP = (0.0, 1.0, 0.0)
