"""Pursuit: creatures that go to, follow, chase, flee from and avoid members of the cast.

The route of a pursuing creature is planned anew when its goal has moved; in between it is walked
as any other route, so that feet are placed and speeds change as always.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.locomotion.routes.pursuit_limits import LIMITS
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress, update_pace
from pipeline.simulation.locomotion.routes.walk_orders import (
    apply_order,
    chooses_speed,
    go_near,
)
from pipeline.simulation.members import MemberState
from pipeline.simulation.order_outcome import Outcome
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground
from pipeline.spec.model_base import Target
from pipeline.spec.script import (
    Avoid,
    Chase,
    Do,
    Flee,
    Follow,
    GoTo,
    HopOver,
    JumpOnce,
    TurnBy,
    Wait,
)

PURSUITS = (GoTo, Follow, Chase, Flee)
"""Orders that are carried out by planning routes again and again."""

NO_FOOTHOLD = "found no foothold on its way; wider or nearer footholds, or a slower walk, may help"
"""Why a creature gives up that stands before a barrier."""


@dataclass(eq=False, slots=True)
class Pursuit:
    """A creature's pursuit.

    Attributes:
        order: `GoTo` a name, `Follow`, `Chase` or `Flee`.
        planned_for: (2,) place of the target for which the route was planned [m]; None where there
            is no such route.
        planned: time of that plan [s].
        nearest: least distance to the target so far [m]; of one that flees, the greatest, negative.
        since: time at which that was reached [s].
        has_stopped: whether it has been told to stop, near enough to its target.
        is_evasion: whether it is no order, but a step away from what is avoided.
    """

    order: GoTo | Follow | Chase | Flee
    planned_for: Array | None = None
    planned: float = -math.inf
    nearest: float = math.inf
    since: float = 0.0
    has_stopped: bool = False
    is_evasion: bool = False

    @property
    def target(self) -> Target:
        """Name or place (3,) that it is about."""
        order = self.order
        if isinstance(order, GoTo):
            assert isinstance(order.go_to, str)
            return order.go_to
        if isinstance(order, Follow):
            return order.follow
        return order.chase if isinstance(order, Chase) else order.flee


class Pursuits:
    """The pursuits of a herd.

    Args:
        progress: of the herd on its routes.
        ground: the terrain.

    Attributes:
        outcomes: orders that ended in the last step.
        arrived: numbers of creatures that have reached what they went to or chased.
        touched: pairs of a chaser and a member that it has caught.
    """

    def __init__(self, progress: RouteProgress, ground: Ground) -> None:
        self.progress, self.ground = progress, ground
        self.outcomes: list[Outcome] = []
        self.arrived: list[int] = []
        self.touched: list[tuple[str, str]] = []
        self._active: dict[int, Pursuit] = {}
        self._avoided: dict[int, Avoid] = {}
        self._interrupted: dict[int, tuple[Do, bool]] = {}
        self._speed_chosen: dict[int, int] = {}
        self._members: Mapping[str, MemberState] = {}

    def is_active(self, c: int) -> bool:
        """Return whether a creature pursues something, so that the end of a route is no arrival."""
        return c in self._active

    def members_needed(self) -> set[str]:
        """Return the members on which pursuits depend."""
        targets = [pursuit.target for pursuit in self._active.values()]
        targets += [order.avoid for order in self._avoided.values()]
        return {target for target in targets if isinstance(target, str)}

    def see_members(self, members: Mapping[str, MemberState]) -> None:
        """Take in where members are."""
        self._members = members

    def take(self, c: int, order: Do) -> bool:
        """Take an order; return whether it is carried out here."""
        if isinstance(order, Avoid):
            self._avoided[c] = order
            return True
        if chooses_speed(order):
            self.keep_speed(c)
        is_pursuit = isinstance(order, PURSUITS)
        if isinstance(order, GoTo) and not isinstance(order.go_to, str):
            is_pursuit = False
        if is_pursuit or _leads(order):
            self._interrupted.pop(c, None)
            self._end(c)
        if is_pursuit:
            assert isinstance(order, PURSUITS)
            is_chosen = self._speed_chosen.get(c) == self.progress.steps
            self._begin(c, order, hurries=isinstance(order, Chase | Flee) and not is_chosen)
        return is_pursuit

    def keep_speed(self, c: int) -> None:
        """Let a creature that is told how fast to go not hurry by orders of this step."""
        self._speed_chosen[c] = self.progress.steps
        if c in self._interrupted:
            self._interrupted[c] = self._interrupted[c][0], False

    def advance(self) -> None:
        """Plan the routes of all pursuing creatures again where their goals have moved."""
        self.arrived, self.touched, self.outcomes = [], [], []
        for c, order in self._avoided.items():
            self._keep_off(c, order)
        for c, pursuit in list(self._active.items()):
            if self.progress.halted[c]:
                self._give_up(c, pursuit, NO_FOOTHOLD)
            else:
                self._pursue(c, pursuit)

    # --- one creature -------------------------------------------------------------------

    def _begin(
        self,
        c: int,
        order: GoTo | Follow | Chase | Flee,
        *,
        hurries: bool = False,
        is_evasion: bool = False,
    ) -> None:
        since = self.progress.time
        self._active[c] = Pursuit(order, since=since, is_evasion=is_evasion)
        if hurries:
            self.progress.hurrying.add(c)
            update_pace(self.progress, c)

    def _end(self, c: int) -> None:
        self._active.pop(c, None)
        if c in self.progress.hurrying:
            self.progress.hurrying.discard(c)
            update_pace(self.progress, c)

    def _give_up(self, c: int, pursuit: Pursuit, reason: str) -> None:
        self._end(c)
        if not self.progress.halted[c]:
            apply_order(self.progress, c, "stop")
        self.outcomes.append(Outcome(self.progress.herd.names[c], pursuit.order, reason))

    def _pursue(self, c: int, pursuit: Pursuit) -> None:
        state = self._state(pursuit.target)
        here = self._place(c)
        offset = state.centre[[0, 2]] - here
        distance = float(np.hypot(*offset))
        order = pursuit.order
        if not state.is_present:
            self._give_up(c, pursuit, f"'{pursuit.target}' is gone")
        elif isinstance(order, Flee):
            self._flee(c, pursuit, order.distance, offset, distance - state.radius)
        elif isinstance(order, Chase):
            self._chase(c, pursuit, state, offset, distance)
        else:
            self._approach(c, pursuit, state, offset, distance)

    def _approach(
        self, c: int, pursuit: Pursuit, state: MemberState, offset: Array, distance: float
    ) -> None:
        """Go up to a target, and after it if it moves."""
        order, stride = pursuit.order, float(self.progress.stride[c])
        follows = isinstance(order, Follow)
        gap = order.gap if isinstance(order, Follow | GoTo) and order.gap is not None else None
        reach = self._reach(c) + state.radius + (0.1 * stride if gap is None else gap)
        beyond = distance - reach
        if beyond <= LIMITS.tolerance * stride:
            if not follows:
                self._end(c)
                self.arrived.append(c)
            if not pursuit.has_stopped and not self.progress.arrived[c]:
                apply_order(self.progress, c, "stop")
            pursuit.planned_for, pursuit.has_stopped = None, True
            return
        if follows and pursuit.planned_for is None and beyond <= LIMITS.slack * stride:
            return
        if not follows and not self._gets_nearer(pursuit, stride, distance):
            self._give_up(c, pursuit, f"cannot get nearer than {max(beyond, 0.0):.2g} m")
            return
        # Where a moving target will be, so that nobody brakes behind it again and again.
        lead = _short_of(state.v[[0, 2]] * LIMITS.prediction, offset / distance, beyond)
        predicted = offset + lead
        way = predicted * (1.0 - reach / float(np.hypot(*predicted)))
        here = self._place(c)
        self._plan(c, pursuit, here + offset, here + way)

    def _chase(
        self, c: int, pursuit: Pursuit, state: MemberState, offset: Array, distance: float
    ) -> None:
        """Run to where a target will be."""
        stride = float(self.progress.stride[c])
        if distance <= self._reach(c) + state.radius:
            assert isinstance(pursuit.order, Chase)
            self._end(c)
            apply_order(self.progress, c, "stop")
            self.arrived.append(c)
            self.touched.append(
                (self.progress.herd.names[c], pursuit.order.chase.partition(".")[0])
            )
            return
        if not self._gets_nearer(pursuit, stride, distance):
            self._give_up(c, pursuit, f"is not fast enough; still {distance:.2g} m off")
            return
        progress = self.progress
        ahead = min(distance / self._speed(c), LIMITS.prediction)
        room = distance - self._reach(c) - state.radius
        lead = _short_of(state.v[[0, 2]] * ahead, offset / distance, room)
        goal = self._place(c) + offset + lead
        way = goal - self._place(c)
        way /= max(float(np.hypot(*way)), 1e-6)
        full = progress.paces.last(c).speed
        closing = LIMITS.closing + max(float(state.v[[0, 2]] @ way), 0.0) / full
        braking = float(progress.braking_distance[c]) * closing * closing
        beyond = braking + LIMITS.overrun * stride - self._reach(c) - state.radius
        self._plan(c, pursuit, goal, goal + way * beyond)

    def _flee(
        self, c: int, pursuit: Pursuit, enough: float, offset: Array, distance: float
    ) -> None:
        """Run away from a target, along the edge of the terrain if need be."""
        stride = float(self.progress.stride[c])
        if distance - self._reach(c) >= enough:
            self._end(c)
            apply_order(self.progress, c, "stop")
            if not pursuit.is_evasion:
                self.arrived.append(c)
            return
        if not self._gets_nearer(pursuit, stride, -distance):
            self._give_up(c, pursuit, f"cannot get farther than {distance:.2g} m")
            return
        here, away = self._place(c), -offset / max(float(np.hypot(*offset)), 1e-6)
        length = max(enough - distance + self._reach(c), LIMITS.escape * stride)
        ways = [away, *(_turned(away, side * turn) for turn in (0.8, 1.6) for side in (1.0, -1.0))]
        goals = [self._inside(c, here + length * way) for way in ways]
        # Away as far as the ground reaches, else along its edge.
        farthest = max(goals, key=lambda goal: round(float(np.hypot(*(goal - here - offset))), 3))
        self._plan(c, pursuit, here + offset, farthest)

    def _keep_off(self, c: int, order: Avoid) -> None:
        """Step away from an avoided member that is near, and then go on as before."""
        state = self._state(order.avoid)
        offset = state.centre[[0, 2]] - self._place(c)
        distance = float(np.hypot(*offset)) - state.radius - self._reach(c)
        flight = self._active.get(c)
        if flight is not None and isinstance(flight.order, Flee):
            return
        if distance < order.distance:
            if flight is not None:
                self._interrupted[c] = flight.order, c in self.progress.hurrying
                self._end(c)
            elif (goal := self._goal(c)) is not None:
                self._interrupted[c] = GoTo(go_to=goal), False
            escape = Flee(flee=order.avoid, distance=LIMITS.reserve * order.distance)
            self._begin(c, escape, is_evasion=True)
        elif c in self._interrupted:
            again, hurries = self._interrupted.pop(c)
            if isinstance(again, GoTo) and not isinstance(again.go_to, str):
                apply_order(self.progress, c, again)
                return
            assert isinstance(again, PURSUITS)
            self._begin(c, again, hurries=hurries)

    def _goal(self, c: int) -> tuple[float, float] | None:
        """Return the end (x, z) of the route that a creature is on [m]; None without one."""
        route = self.progress.trajectory.routes[c]
        if self.progress.arrived[c] or not route.stops:
            return None
        x, z = route.xz[-1].tolist()
        return x, z

    def _plan(self, c: int, pursuit: Pursuit, target: Array, goal: Array) -> None:
        """Plan the route to a goal (2,) again if the target (2,) moved, or the route is over."""
        progress, here = self.progress, self._place(c)
        if pursuit.planned_for is not None:
            moved = float(np.hypot(*(target - pursuit.planned_for)))
            far = LIMITS.shift * max(
                float(progress.stride[c]), LIMITS.share * float(np.hypot(*(target - here)))
            )
            is_over = progress.arrived[c] and progress.time > pursuit.planned + LIMITS.interval
            is_recent = progress.time < pursuit.planned + LIMITS.interval
            # Planned again within a turn in place, it would never come to its end.
            turns = progress.trajectory.routes[c].turns_at(float(progress.distance[c]))
            if is_recent or turns or (moved < far and not is_over):
                return
        pursuit.planned_for, pursuit.planned = target, progress.time
        pursuit.has_stopped = False
        go_near(progress, c, self._inside(c, goal))

    def _gets_nearer(self, pursuit: Pursuit, stride: float, distance: float) -> bool:
        """Return whether the distance has shrunk within the time that is waited for that."""
        now = self.progress.time
        if distance < pursuit.nearest - LIMITS.progress * stride:
            pursuit.nearest, pursuit.since = distance, now
        return now - pursuit.since <= LIMITS.patience

    def _state(self, target: Target) -> MemberState:
        if isinstance(target, str):
            return self._members[target]
        return MemberState.of_place(np.array(target))

    def _place(self, c: int) -> Array:
        """Return where a creature is (2,) [m]."""
        route = self.progress.trajectory.routes[c]
        place: Array = route.at(self.progress.distance[c : c + 1])[0][0]
        return place

    def _speed(self, c: int) -> float:
        """Return the speed that a creature is to have on level ground [m/s]."""
        progress = self.progress
        return float(progress.requested_fraction[c]) * progress.paces.last(c).speed

    def _reach(self, c: int) -> float:
        """Return how far a creature's feet stand ahead of its middle [m]."""
        return float(self.progress.herd.footprint[c].max())

    def _inside(self, c: int, goal: Array) -> Array:
        """Return the place on the terrain nearest to a goal (2,) [m]."""
        low, high = self.ground.field.inner_bounds
        margin = np.minimum(LIMITS.edge * self._reach(c), 0.5 * (high - low))
        return np.clip(goal, low + margin, high - margin)


def _leads(order: Do) -> bool:
    """Return whether an order says where to go, so that a pursuit ends."""
    return isinstance(order, GoTo | TurnBy | Wait | HopOver | JumpOnce) or order in ("stop", "walk")


def _short_of(lead: Array, towards: Array, room: float) -> Array:
    """Return the predicted way of a target (2,), cut off where its pursuer would meet it [m].

    Args:
        lead: (2,) predicted way of the target [m].
        towards: (2,) unit vector from the pursuer to the target.
        room: by which the target may come nearer to the pursuer [m].
    """
    nearer = -float(lead @ towards)
    return lead * (room / nearer) if nearer > room else lead


def _turned(way: Array, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * way[0] - s * way[1], s * way[0] + c * way[1]])
