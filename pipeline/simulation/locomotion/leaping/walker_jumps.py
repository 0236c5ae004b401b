"""Jumps of a walking herd.

A creature that is told to jump comes to rest with all feet down where it jumps best. From crouch to
stand its body and feet are those of a hopper. It is then set down on the footholds where it landed,
and its route continues.

Source: Sims 1987, 3.2.4 and ch. 11.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.curves import ease
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.tip_ik import solve_tips
from pipeline.simulation.locomotion.foot_placement.foothold_search import Foothold
from pipeline.simulation.locomotion.foot_placement.leg_reachability import shortest_reaches
from pipeline.simulation.locomotion.foot_state import place_foot
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.leaping.hurdle_approach import (
    plan_approach,
    route_onward,
    route_to_landing,
    turn_towards,
)
from pipeline.simulation.locomotion.leaping.jump_handover import JumpingBody
from pipeline.simulation.locomotion.pronking.hop_events import HopEventRecorder
from pipeline.simulation.locomotion.pronking.hop_simulation import HopSimulation
from pipeline.simulation.locomotion.pronking.hop_state import BodyState, JumpOrder
from pipeline.simulation.locomotion.pronking.hopper import Hopper, build_hopper
from pipeline.simulation.locomotion.pronking.hopper_fall import JointState, RigidFall
from pipeline.simulation.locomotion.pronking.jump_orders import (
    FALLEN,
    HurdleJump,
    Members,
    jump_once,
    scripted_jump,
)
from pipeline.simulation.locomotion.pronking.start_states import standing_state
from pipeline.simulation.locomotion.routes.route import Route, straight_route
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress, is_blocked, redirect
from pipeline.simulation.locomotion.routes.speed_control import CLOSING_CYCLES
from pipeline.simulation.locomotion.routes.walk_orders import apply_order
from pipeline.simulation.locomotion.stepping.setting_out import phase_before_lift
from pipeline.simulation.locomotion.stepping.standing import is_standing, standing_pose
from pipeline.simulation.locomotion.stepping.step_sequencer import StepSequencer
from pipeline.simulation.locomotion.stepping.taking_steps import is_astray
from pipeline.simulation.order_outcome import Outcome
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, TakeNote
from pipeline.simulation.troupe import World
from pipeline.spec.creature import Creature, Pronk
from pipeline.spec.script import (
    Chase,
    Do,
    Flee,
    Follow,
    GoTo,
    HopOver,
    Instruction,
    JumpOnce,
    TurnBy,
    Wait,
)

HANDOVER_TIME = 0.35
"""Blend time of a body from its walking pose to its jumping pose, and back [s]."""

STANDING_TIME = 0.1
"""Time that it stands before it crouches [s]."""

Stage = Literal["coming", "leaping", "landed"]


@dataclass(eq=False)
class WalkerJump:
    """One jump of a walker, from the order until it walks again.

    Attributes:
        order: the scripted order.
        route_before: the route before the order.
        route_distance: distance along it at the order [m].
        stage: approaching the take-off place, jumping, or standing where it landed.
        is_ready: whether it stands there, and its hurdle is looked at once more.
        stage_start: start of the jump, then of the landed stage [s].
        simulation: of the jump, once it is made.
        pending_orders: orders that wait for its end.
        is_over: whether its outcome is told.
    """

    order: HopOver | JumpOnce
    route_before: Route
    route_distance: float
    stage: Stage = "coming"
    is_ready: bool = False
    stage_start: float = 0.0
    simulation: HopSimulation | None = None
    pending_orders: list[Do] = field(default_factory=list)
    is_over: bool = False


LEADING_ORDERS = (GoTo, Follow, Chase, Flee, TurnBy, Wait)
"""Orders that say where to go: they end the approach to a jump, and wait for the end of one."""


class WalkerJumps:
    """The jumps of a herd.

    Args:
        cast: place in the scene's cast, config and figure of each creature.
        world: constants of the scene.
        progress: of the herd on its routes.
        sequencer: of its steps.
        materials: default material of each creature.
        apply: carries out an order that waited for the end of a jump.

    Attributes:
        hoppers: jump constants of the creatures that the script lets jump.
        trips: jumps in progress.
        contacts, notes, outcomes: of the last step.
        arrived: creatures that reached the end of their route by a jump in the last step.
    """

    def __init__(
        self,
        cast: Sequence[tuple[int, Creature, Figure]],
        world: World,
        progress: RouteProgress,
        sequencer: StepSequencer,
        materials: Sequence[str],
        apply: Callable[[int, Do], None],
    ) -> None:
        self.world, self.progress, self._apply = world, progress, apply
        self.sequencer, self.feet = sequencer, sequencer.feet
        self.herd: Herd = progress.herd
        self.hoppers: dict[int, Hopper] = {}
        self._cast = cast
        self.trips: dict[int, WalkerJump] = {}
        self.contacts: list[Contact] = []
        self.notes: list[TakeNote] = []
        self.arrived: list[str] = []
        self.outcomes: list[Outcome] = []
        self._pending_outcomes: list[Outcome] = []
        self._members: Members = {}
        self._recorder = HopEventRecorder(self.herd, world, materials)
        self._routes: tuple[Sequence[Route], tuple[int, ...], Sequence[Route]] | None = None
        problems = list[Problem]()
        for path, instruction in world.instructions:
            try:
                self.prepare(instruction, path)
            except SceneError as error:
                problems += error.problems
        if problems:
            raise SceneError(list(dict.fromkeys(problems)))

    @cached_property
    def _folds(self) -> Array:
        return shortest_reaches(self.herd)

    def prepare(self, instruction: Instruction, where: str) -> None:
        """Resolve how a creature jumps that an instruction asks to.

        Raises:
            SceneError: it cannot jump so.
        """
        order = instruction.do
        if instruction.who not in self.herd.names or not isinstance(order, HopOver | JumpOnce):
            return
        c = self.herd.names.index(instruction.who)
        cast_index, member, figure = self._cast[c]
        if not figure.skeleton.legs:
            message = f"figure '{figure.name}' has no legs to jump on"
            raise SceneError([Problem(f"{where}.do", message)])
        if c not in self.hoppers:
            config = member.pronk or Pronk()
            self.hoppers[c] = build_hopper(self.herd, c, cast_index, config, self._folds)
        if isinstance(order, JumpOnce):
            scripted_jump(self.hoppers[c], order.jump, f"{where}.do.jump")

    # --- orders -----------------------------------------------------------------

    def sought(self, orders: Orders) -> Collection[str]:
        """Return the performers whose solids are needed for jumps."""
        if not self.hoppers:
            return ()
        orders_now = [order for c in self.hoppers for order in orders.get(self.herd.names[c], ())]
        orders_now += [trip.order for trip in self.trips.values() if trip.is_ready]
        landed = [trip for trip in self.trips.values() if trip.stage == "landed"]
        orders_now += [order for trip in landed for order in trip.pending_orders]
        return {order.hop_over for order in orders_now if isinstance(order, HopOver)}

    def see(self, members: Members) -> None:
        """Take in where the members are that are to be jumped over."""
        self._members = {**self._members, **members}

    def take(self, c: int, order: Do) -> bool:
        """Take an order; return whether it is for a jump, or waits for the end of one."""
        trip = self.trips.get(c)
        jumps = isinstance(order, HopOver | JumpOnce)
        if trip is None:
            if isinstance(order, HopOver | JumpOnce):
                self._begin(c, order)
            return jumps
        leads = isinstance(order, LEADING_ORDERS) or order in ("stop", "walk")
        if trip.stage == "coming" and leads:
            del self.trips[c]
            return False
        if trip.simulation is not None and trip.simulation.state.phase == "fallen":
            self._pending_outcomes.append(Outcome(self.herd.names[c], order, FALLEN))
        elif jumps or leads:
            trip.pending_orders.append(order)
        return jumps or leads

    def _begin(self, c: int, order: HopOver | JumpOnce) -> None:
        """Let a creature approach its take-off place."""
        progress, hopper = self.progress, self.hoppers[c]
        route, distance = progress.trajectory.routes[c], float(progress.distance[c])
        reason = self._reason_against(c)
        if isinstance(order, HopOver) and not reason:
            solids = self._members[order.hop_over].solids
            approach: Route | str = "it is not in sight"
            if solids:
                approach = plan_approach(progress, c, hopper, self.world.ground, solids)
            if isinstance(approach, str):
                reason = f"cannot jump over '{order.hop_over}': {approach}"
            else:
                redirect(progress, c, approach)
        elif not reason:
            apply_order(progress, c, "stop")
            target = order.jump.land_at if isinstance(order, JumpOnce) else None
            if target is not None:
                radius = float(np.hypot(*self.herd.footprint[c]))
                turned = turn_towards(
                    progress.trajectory.routes[c], np.array(target), 0.1 * hopper.leg_length, radius
                )
                if turned is not None:
                    redirect(progress, c, turned)
        if reason:
            self._pending_outcomes.append(Outcome(self.herd.names[c], order, reason))
        else:
            self.trips[c] = WalkerJump(order, route, distance)

    def _reason_against(self, c: int) -> str:
        """Return why a creature cannot jump at all; empty if it can."""
        if self.progress.halted[c]:
            return "cannot jump where it has no foothold to go on"
        if self.feet.held_up[1, self.herd.owner == c].any():
            return "cannot jump with legs held up"
        return ""

    # --- a step -------------------------------------------------------------------

    def advance(self, step: int) -> None:
        """Advance to the end of a step, after all have walked."""
        self.contacts.clear()
        self.arrived.clear()
        self.notes = []
        self.outcomes, self._pending_outcomes = self._pending_outcomes, []
        time = (step + 1) * self.world.clock.dt
        for c, trip in sorted(self.trips.items()):
            if trip.stage == "coming" and trip.is_ready:
                self._start_jump(c, trip, time)
            elif trip.stage == "coming":
                trip.is_ready = self._is_standing(c)
            elif trip.stage == "leaping":
                self._advance_jump(step, c, trip, time)
            elif time - trip.stage_start >= HANDOVER_TIME and is_standing(
                self.progress, self.feet, c
            ):
                self._resume_walking(c, trip)

    def is_coming(self, name: str) -> bool:
        """Return whether a creature rests only in order to jump."""
        return self.herd.names.index(name) in self.trips

    def _is_standing(self, c: int) -> bool:
        return is_standing(self.progress, self.feet, c)

    def _start_jump(self, c: int, trip: WalkerJump, time: float) -> None:
        """Hand a standing creature over to its jump."""
        hopper, own, trip.is_ready = self.hoppers[c], self.herd.owner == c, False
        if is_blocked(self.progress, c):
            self.outcomes.append(Outcome(hopper.name, trip.order, "its way to the jump is barred"))
            del self.trips[c]
            return
        R, p = standing_pose(self.progress, self.feet, c)
        state = standing_state(hopper, R, p, self.feet.end[own], time)
        state.queue.orders = [self._jump_order(hopper, trip.order)]
        state.phase_end = time + STANDING_TIME
        fall = RigidFall(self.herd.figures[c])
        trip.simulation = HopSimulation(
            hopper, self.world.ground, None, fall, partial(self._joint_state, c), state
        )
        trip.stage, trip.stage_start = "leaping", time

    def _joint_state(self, c: int, now: BodyState, tips: Array, _: NDArray[np.bool_]) -> JointState:
        """Return the joints of a creature with a given body and feet (n, 3) [m]."""
        herd, skeleton = self.herd, self.herd.figures[c].skeleton
        own, goals = herd.owner == c, herd.legs.tips[None].copy()
        goals[0, own] = (tips - now.origin) @ now.R
        q = skeleton.preferred.copy()
        values = solve_tips(herd.legs, herd.chains, goals).q[0, own]
        for limb, joint_values in zip(skeleton.legs, values, strict=True):
            q[list(limb.joints)] = joint_values[: len(limb.joints)]
        return JointState(q, np.zeros_like(q))

    def _jump_order(self, hopper: Hopper, order: HopOver | JumpOnce) -> JumpOrder:
        if isinstance(order, HopOver):
            return HurdleJump(
                order.hop_over, self._members[order.hop_over].solids, can_approach=False
            )
        return jump_once(hopper, order.jump)

    def _advance_jump(self, step: int, c: int, trip: WalkerJump, time: float) -> None:
        simulation = trip.simulation
        assert simulation is not None
        simulation.events.clear()
        simulation.advance(time)
        contacts, notes = self._recorder.records(step, c, simulation.events)
        self.contacts += contacts
        self.notes += notes
        state = simulation.state
        if state.phase == "fallen":
            self._end(c, trip, FALLEN)
        if state.phase == "standing" and not math.isfinite(state.phase_end):
            trip.stage, trip.stage_start = "landed", time
            reasons = [reason for _, reason in state.queue.dropped]
            self._end(c, trip, "" if state.jump_count else (reasons or ["it cannot lift off"])[0])
            if state.jump_count:
                self._set_down(c, simulation)

    def _end(self, c: int, trip: WalkerJump, reason: str) -> None:
        """Tell the outcome of a jump, once."""
        if not trip.is_over:
            self.outcomes.append(Outcome(self.herd.names[c], trip.order, reason))
            trip.is_over = True

    def _set_down(self, c: int, simulation: HopSimulation) -> None:
        """Let a creature stand, as a walker, where it has landed."""
        sequencer, progress = self.sequencer, self.progress
        body, tips = simulation.pose()
        for leg, tip in zip(np.flatnonzero(self.herd.owner == c).tolist(), tips, strict=True):
            normal = self.world.ground.normal(tip[0], tip[2])
            hold = Foothold(tip - self.herd.foot_radius[leg] * normal, normal, tip, 0.0)
            place_foot(self.feet, leg, hold)
        route = progress.trajectory.routes[c].upto(float(progress.distance[c]))
        place = body.origin[[0, 2]]
        route = route.then(route_to_landing(route, place, body.heading))
        progress.distance = progress.distance.copy()
        progress.distance[c] = route.length
        redirect(progress, c, route)
        sequencer.lookahead.forget(c)
        own = np.flatnonzero(self.herd.owner == c)
        astray = any(is_astray(sequencer, leg) for leg in own.tolist())
        progress.closing_phase[c] = phase_before_lift(
            sequencer, c, float(progress.phase[c]) + (CLOSING_CYCLES if astray else 0.0)
        )

    def _resume_walking(self, c: int, trip: WalkerJump) -> None:
        """Let a landed creature walk on."""
        progress, simulation = self.progress, trip.simulation
        assert simulation is not None
        del self.trips[c]
        here = progress.trajectory.routes[c]
        if simulation.state.jump_count:
            landed = here.xz[-1], float(here.heading[-1])
            onward = route_onward(
                trip.route_before, trip.route_distance, landed, float(progress.stride[c])
            )
            if onward is not None:
                redirect(progress, c, here.then(onward))
            elif trip.route_before.length > trip.route_distance + 1e-9:
                self.arrived.append(self.herd.names[c])
        for order in trip.pending_orders:
            if not self.take(c, order):
                self._apply(c, order)

    # --- rows ---------------------------------------------------------------------

    def aloft(self, time: float) -> dict[int, JumpingBody]:
        """Return the jumping creatures at a time."""
        bodies = dict[int, JumpingBody]()
        for c, trip in self.trips.items():
            if trip.simulation is None:
                continue
            body, tips = trip.simulation.pose()
            state = trip.simulation.state
            blend = float(ease(np.array(min((time - trip.stage_start) / HANDOVER_TIME, 1.0))))
            bodies[c] = JumpingBody(
                blend=blend if trip.stage == "leaping" else 1.0 - blend,
                R=body.R,
                p=body.origin,
                tips=tips if trip.stage == "leaping" else None,
                down=state.down | (trip.stage == "landed"),
                speed=float(np.hypot(*state.v[[0, 2]])),
                limp=state.phase == "fallen",
            )
        return bodies

    def routes(self) -> Sequence[Route]:
        """Return the routes that creatures look along; a jumping creature looks straight ahead."""
        routes = self.progress.trajectory.routes
        jumping = tuple(c for c, trip in self.trips.items() if trip.simulation is not None)
        if not jumping:
            return routes
        if self._routes is None or self._routes[0] is not routes or self._routes[1] != jumping:
            seen = [
                straight_route(route.xz[-1], float(route.heading[-1])) if c in jumping else route
                for c, route in enumerate(routes)
            ]
            self._routes = routes, jumping, seen
        return self._routes[2]
