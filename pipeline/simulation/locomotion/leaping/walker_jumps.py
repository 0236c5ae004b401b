"""Leaps: the jumps of a herd that walks.

Who is told to jump comes to rest where it jumps best, all feet down. From there its body and
its feet are those of a pronker, from the crouch until it stands again; then it is set down on
the footholds where it landed, and its way goes on.

Source: Sims 1987, 3.2.4 and ch. 11.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.curves import ease
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.rest_ik import solve_near_rest
from pipeline.simulation.locomotion.foot_placement.foothold_search import Foothold
from pipeline.simulation.locomotion.foot_placement.leg_reachability import shortest_reaches
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.leaping.hurdle_approach import (
    plan_approach,
    route_onward,
)
from pipeline.simulation.locomotion.leaping.jump_handover import JumpingBody
from pipeline.simulation.locomotion.pronking.hop_events import HopEventRecorder
from pipeline.simulation.locomotion.pronking.hop_simulation import HopSimulation
from pipeline.simulation.locomotion.pronking.hop_state import BodyState, JumpOrder
from pipeline.simulation.locomotion.pronking.hopper import Hopper, build_hopper
from pipeline.simulation.locomotion.pronking.hopper_fall import JointState, RigidFall
from pipeline.simulation.locomotion.pronking.initial_stance import standing_state
from pipeline.simulation.locomotion.pronking.jump_orders import (
    HurdleJump,
    JumpToPoint,
    SingleJump,
    Solids,
    scripted_jump,
)
from pipeline.simulation.locomotion.routes.route import Route, straight_route, turn_in_place
from pipeline.simulation.locomotion.routes.route_progress import (
    CLOSING_CYCLES,
    RouteProgress,
)
from pipeline.simulation.locomotion.routes.walk_orders import apply_order
from pipeline.simulation.locomotion.stepping import Feet
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, Note
from pipeline.simulation.troupe import World
from pipeline.spec.cast import Creature
from pipeline.spec.pronk import Pronk
from pipeline.spec.script import (
    Do,
    GoTo,
    HopOver,
    Instruction,
    JumpOnce,
    TurnBy,
    Wait,
)

HANDOVER_TIME = 0.35
"""Time in which a body comes from where it walks to where it jumps, and back [s]."""

STANDING_TIME = 0.1
"""How long it stands before it crouches [s]."""

TURN_TOLERANCE = math.radians(8.0)
"""How far aside a place is that is turned to before a jump to it."""

Stage = Literal["coming", "leaping", "landed"]


@dataclass(eq=False)
class WalkerJump:
    """One jump of a walker, from the order until it walks again.

    Attributes:
        order: what it is to do.
        rest: its way before the order.
        left: where on it that was [m].
        stage: coming to where it jumps, leaping, or standing where it has landed.
        ready: whether it stands there, and looks once more at what it jumps over.
        since: when the last two began [s].
        hopping: the jump, once it is made.
        later: orders that wait for its end.
    """

    order: HopOver | JumpOnce
    rest: Route
    left: float
    stage: Stage = "coming"
    ready: bool = False
    since: float = 0.0
    hopping: HopSimulation | None = None
    later: list[Do] = field(default_factory=list)


class WalkerJumps:
    """Who of a herd jumps, and how.

    Attributes:
        hopper: how creatures jump of whom a script asks it.
        trips: of those who are about it.
        contacts, notes: of the last step.
        arrived: who came to the end of its way by a jump in it.
    """

    def __init__(
        self,
        cast: Sequence[tuple[int, Creature, Figure]],
        world: World,
        going: RouteProgress,
        feet: Feet,
        materials: Sequence[str],
    ) -> None:
        self.world, self.going, self.feet = world, going, feet
        self.herd: Herd = going.herd
        self.of: dict[int, Hopper] = {}
        self._cast = cast
        self.trips: dict[int, WalkerJump] = {}
        self.contacts: list[Contact] = []
        self.notes: list[Note] = []
        self.arrived: list[str] = []
        self._told: list[Note] = []
        self._solids: Solids = {}
        self._telling = HopEventRecorder(self.herd, world, materials)
        self._routes: tuple[Sequence[Route], tuple[int, ...], Sequence[Route]] | None = None
        problems = list[Problem]()
        for i, one in enumerate(world.script):
            try:
                self.prepare(one, f"script[{i}]")
            except SceneError as error:
                problems += error.problems
        if problems:
            raise SceneError(list(dict.fromkeys(problems)))

    @cached_property
    def _folds(self) -> Array:
        return shortest_reaches(self.herd)

    def prepare(self, one: Instruction, where: str) -> None:
        """Find out how somebody jumps who is asked to.

        Raises:
            SceneError: it cannot.
        """
        if one.who not in self.herd.names or not isinstance(one.do, HopOver | JumpOnce):
            return
        c = self.herd.names.index(one.who)
        number, member, figure = self._cast[c]
        if not figure.skeleton.legs:
            message = f"figure '{figure.name}' has no legs to jump on"
            raise SceneError([Problem(f"{where}.do", message)])
        if c not in self.of:
            words = member.pronk or Pronk()
            self.of[c] = build_hopper(self.herd, c, number, words, self._folds)
        if isinstance(one.do, JumpOnce):
            scripted_jump(self.of[c], one.do.jump, f"{where}.do.jump")

    # --- orders -----------------------------------------------------------------

    def sought(self, orders: Orders) -> Collection[str]:
        """Return over whom somebody is told to jump, or is about to."""
        if not self.of:
            return ()
        given = [one for c in self.of for one in orders.get(self.herd.names[c], ())]
        given += [trip.order for trip in self.trips.values() if trip.ready]
        landed = [trip for trip in self.trips.values() if trip.stage == "landed"]
        given += [one for trip in landed for one in trip.later]
        return {one.hop_over for one in given if isinstance(one, HopOver)}

    def see(self, solids: Solids) -> None:
        """Take in where the solids of others are."""
        self._solids = {**self._solids, **solids}

    def take(self, step: int, c: int, order: Do) -> bool:
        """Take an order; return whether it is for a jump, or waits for the end of one."""
        trip = self.trips.get(c)
        if trip is None:
            if isinstance(order, HopOver | JumpOnce):
                self._begin(step, c, order)
                return True
            return False
        jumps = isinstance(order, HopOver | JumpOnce)
        leads = isinstance(order, GoTo | TurnBy | Wait) or order in ("stop", "walk")
        if trip.stage == "coming" and leads:
            del self.trips[c]
            return False
        if jumps or leads:
            trip.later.append(order)
        return jumps or leads

    def _begin(self, step: int, c: int, order: HopOver | JumpOnce) -> None:
        """Let a creature come to where it jumps."""
        going, hopper = self.going, self.of[c]
        rest, left = going.path.routes[c], float(going.way[c])
        cause = self._unable(c)
        if isinstance(order, HopOver) and not cause:
            solids = self._solids.get(order.hop_over, ())
            found = (
                plan_approach(going, c, hopper, self.world.ground, solids)
                if solids
                else "it is not seen"
            )
            if isinstance(found, str):
                cause = f"cannot jump over '{order.hop_over}': {found}"
            else:
                going.lead(c, found)
        elif not cause:
            apply_order(going, c, "stop")
            spot = order.jump.land_at if isinstance(order, JumpOnce) else None
            if spot is not None:
                self._face(c, np.array(spot))
        if cause:
            self._told.append(Note("stopped", step, self.herd.names[c], cause))
        else:
            self.trips[c] = WalkerJump(order, rest, left)

    def _unable(self, c: int) -> str:
        """Return why a creature cannot jump, whatever over; empty if it can."""
        if self.going.halted[c]:
            return "cannot jump where it has no foothold to go on"
        if self.feet.tuck[1, self.herd.owner == c].any():
            return "cannot jump with legs held up"
        return ""

    def _face(self, c: int, spot: Array) -> None:
        """Let who comes to rest turn to a place (2,) there [m]."""
        route = self.going.path.routes[c]
        way = spot - route.xz[-1]
        towards = math.atan2(-way[1], way[0]) - float(route.heading[-1])
        angle = math.remainder(towards, 2.0 * math.pi)
        if abs(angle) > TURN_TOLERANCE and np.linalg.norm(way) > 0.1 * self.of[c].leg_length:
            radius = float(np.hypot(*self.herd.footprint[c]))
            spin = turn_in_place(route.xz[-1], float(route.heading[-1]), angle, radius)
            self.going.lead(c, route.then(spin))

    # --- a step -------------------------------------------------------------------

    def advance(self, step: int) -> None:
        """Go on to the end of a step that all have walked."""
        self.contacts.clear()
        self.arrived.clear()
        self.notes, self._told = self._told, []
        time = (step + 1) * self.world.clock.dt
        for c, trip in sorted(self.trips.items()):
            if trip.stage == "coming" and trip.ready:
                self._leap(c, trip, time)
            elif trip.stage == "coming":
                trip.ready = self._rests(c)
            elif trip.stage == "leaping":
                self._fly(step, c, trip, time)
            elif trip.stage == "landed" and time - trip.since >= HANDOVER_TIME and self._rests(c):
                self._go_on(step, c, trip)

    def is_coming(self, name: str) -> bool:
        """Tell whether somebody rests only to jump."""
        return self.herd.names.index(name) in self.trips

    def _rests(self, c: int) -> bool:
        """Tell whether a creature stands at the end of its way, on closed feet."""
        going, own = self.going, self.herd.owner == c
        if not going.arrived[c]:
            return False
        closed = going.halted[c] or going.phase[c] >= going.closed[c]
        return bool(closed and not self.feet.swinging[own].any() and going.vigour[c] == 0.0)

    def _leap(self, c: int, trip: WalkerJump, time: float) -> None:
        """Hand a creature that stands over to its jump."""
        hopper, own, trip.ready = self.of[c], self.herd.owner == c, False
        if self.feet.is_barred(c):
            text = "what bars its way keeps it from where it would jump"
            self._told.append(Note("stopped", round(time / self.world.clock.dt), hopper.name, text))
            del self.trips[c]
            return
        R, p = self._stands(c)
        state = standing_state(hopper, R, p, self.feet.end[own], time)
        state.queue.orders = [self._errand(hopper, trip.order)]
        state.phase_end = time + STANDING_TIME
        fall = RigidFall(self.herd.figures[c])
        trip.hopping = HopSimulation(
            hopper, self.world.ground, None, fall, partial(self._limbs, c), state
        )
        trip.stage, trip.since = "leaping", time

    def _limbs(self, c: int, now: BodyState, tips: Array, _: NDArray[np.bool_]) -> JointState:
        """Return the joints of a creature whose body and feet (n, 3) are somewhere [m]."""
        herd, skeleton = self.herd, self.herd.figures[c].skeleton
        own, goals = herd.owner == c, herd.legs.tips[None].copy()
        goals[0, own] = (tips - now.origin) @ now.R
        q = skeleton.preferred.copy()
        values = solve_near_rest(herd.legs, herd.chains, goals).q[0, own]
        for limb, some in zip(skeleton.legs, values, strict=True):
            q[list(limb.joints)] = some[: len(limb.joints)]
        return JointState(q, np.zeros_like(q))

    def _errand(self, hopper: Hopper, order: HopOver | JumpOnce) -> JumpOrder:
        if isinstance(order, HopOver):
            return HurdleJump(order.hop_over, self._solids[order.hop_over], can_approach=False)
        jump, spot = scripted_jump(hopper, order.jump, "do.jump"), order.jump.land_at
        return SingleJump(jump) if spot is None else JumpToPoint(spot, jump)

    def _stands(self, c: int) -> tuple[Array, Array]:
        """Return the pose (3, 3), (3,) of a body that stands at the end of its way [m]."""
        going = self.going
        at = np.array([c]), going.way[c : c + 1], going.phase[c : c + 1]
        R, p = going.path.pose(*at, going.vigour[c : c + 1])
        low = (self.feet.stoop[1, self.herd.owner == c] ** 4).sum() ** 0.25
        return R[0], p[0] - [0.0, low, 0.0]

    def _fly(self, step: int, c: int, trip: WalkerJump, time: float) -> None:
        hopping = trip.hopping
        assert hopping is not None
        hopping.events.clear()
        hopping.advance(time)
        contacts, notes = self._telling.records(step, c, hopping.events)
        self.contacts += contacts
        self.notes += notes
        state = hopping.state
        if state.phase == "standing" and not math.isfinite(state.phase_end):
            trip.stage, trip.since = "landed", time
            if state.jump_count:
                self._set_down(c, hopping)

    def _set_down(self, c: int, hopping: HopSimulation) -> None:
        """Let a creature stand, as a walker, where and as it has landed."""
        feet, going = self.feet, self.going
        moved, tips = hopping.pose()
        for leg, tip in zip(np.flatnonzero(self.herd.owner == c).tolist(), tips, strict=True):
            normal = self.world.ground.normal(tip[0], tip[2])
            feet.stand_at(leg, Foothold(tip - self.herd.sole[leg] * normal, normal, tip, 0.0))
        route = going.path.routes[c].upto(float(going.way[c]))
        place = moved.origin[[0, 2]]
        route = route.then(_route_to_landing(route, place, moved.heading))
        going.gone = going.gone.copy()
        going.gone[0, c] = route.length
        going.lead(c, route)
        feet.scout.forget(c)
        own = np.flatnonzero(self.herd.owner == c)
        astray = any(feet.is_astray(leg) for leg in own.tolist())
        going.closed[c] = feet.about_to_lift(
            c, float(going.phase[c]) + (CLOSING_CYCLES if astray else 0.0)
        )

    def _go_on(self, step: int, c: int, trip: WalkerJump) -> None:
        """Let a creature that has landed walk on."""
        going, hopping = self.going, trip.hopping
        assert hopping is not None
        del self.trips[c]
        here = going.path.routes[c]
        if hopping.state.jump_count:
            landed = here.xz[-1], float(here.heading[-1])
            on = route_onward(trip.rest, trip.left, landed, float(going.full[c]))
            if on is not None:
                going.lead(c, here.then(on))
            elif trip.rest.length > trip.left + 1e-9:
                self.arrived.append(self.herd.names[c])
        for order in trip.later:
            if not self.take(step, c, order):
                apply_order(going, c, order)

    # --- rows ---------------------------------------------------------------------

    def aloft(self, time: float) -> dict[int, JumpingBody]:
        """Return where creatures are that jump."""
        found = dict[int, JumpingBody]()
        for c, trip in self.trips.items():
            if trip.hopping is None:
                continue
            moved, tips = trip.hopping.pose()
            state = trip.hopping.state
            done = float(ease(np.array(min((time - trip.since) / HANDOVER_TIME, 1.0))))
            found[c] = JumpingBody(
                part=done if trip.stage == "leaping" else 1.0 - done,
                R=moved.R,
                p=moved.origin,
                tips=tips if trip.stage == "leaping" else None,
                down=state.down | (trip.stage == "landed"),
                speed=float(np.hypot(*state.v[[0, 2]])),
                limp=state.phase == "fallen",
            )
        return found

    def routes(self) -> Sequence[Route]:
        """Return the ways that creatures look along; who jumps looks straight ahead."""
        routes = self.going.path.routes
        away = tuple(c for c, trip in self.trips.items() if trip.hopping is not None)
        if not away:
            return routes
        if self._routes is None or self._routes[0] is not routes or self._routes[1] != away:
            seen = [
                straight_route(route.xz[-1], float(route.heading[-1])) if c in away else route
                for c, route in enumerate(routes)
            ]
            self._routes = routes, away, seen
        return self._routes[2]


def _route_to_landing(route: Route, place: Array, turned: float) -> Route:
    """Return the straight way from the end of a route to where a jump has landed."""
    start, before = route.xz[-1], float(route.heading[-1])
    length = float(np.linalg.norm(place - start))
    if length < 1e-6:
        angle = math.remainder(turned - before, 2.0 * math.pi)
        return turn_in_place(start, before, angle, 1.0)
    return Route(
        np.array([0.0, length]), np.array([start, place]), np.array([before, turned]), stops=True
    )
