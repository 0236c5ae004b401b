"""Pursuit tasks: going up to a member of the cast, following, chasing and fleeing.

Targets are members of any room, parts of them and places, by name; they may move meanwhile.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_tasks import (
    BLOCKED_TIME,
    Approach,
    Task,
    place_text,
)
from pipeline.simulation.characters.task_progress import TaskProgress
from pipeline.simulation.characters.terrain_edge import refuge

ARRIVAL_TOLERANCE = 0.06  # of the distance to a surface [m]
EASING = 0.2  # distance too much below which a follower slows down to the target's speed [m]
SETTING_OUT = 0.3  # by which a target moves off before a follower sets out again [m]
CLOSING_RATE = 0.8  # speed of a follower beyond that of its target, by the distance [1/s]
LEAD_TIME = 0.6  # longest time for which the motion of a target is predicted [s]
CHASE_PATIENCE = 5.0  # without getting nearer to what is chased [s]
TOUCH_RANGE = 0.09  # of a hand that touches, in heights
TOUCH_LEVEL = 0.4  # of a place that hands touch in running; feet run up to lower ones, in heights
FLIGHT_DISTANCE = 4.0  # to the next place of refuge [m]


@dataclass
class TargetTask(Task):
    """A task directed at a target.

    Attributes:
        target: name of the target.
        approach: to it.
    """

    target: str
    approach: Approach = field(default_factory=Approach, init=False)

    @property
    def members(self) -> tuple[str, ...]:
        """See `Task`."""
        return (self.target,)

    def walk_to(
        self, controller: PersonController, place: np.ndarray, stop: float, dt: float
    ) -> str:
        """Walk to a place (3,), up to a distance [m]; return why that gets no nearer."""
        partner = self.giver if self.giver >= 0 else controller.view.owner(self.target)
        return self.approach.walk_to(controller, place, stop, partner, dt)

    def is_missing(self, controller: PersonController) -> bool:
        """Tell whether the target does not exist now, which ends the task."""
        if controller.view.state(self.target).is_present:
            return False
        self.failure = f"'{self.target}' is not there"
        return True


@dataclass
class WalkUp(TargetTask):
    """Walk up to the surface of a target, wherever it is by then.

    Attributes:
        gap: distance from the surface [m].
        is_there: whether it has arrived.
    """

    gap: float = 0.0
    is_there: bool = False

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.is_there or self.is_missing(controller):
            return self.is_there
        state = controller.view.state(self.target)
        place = state.nearest(controller.waist())
        # A place has no surface to keep clear of.
        stop = self.gap + (controller.body_radius if state.radius > 0.0 else 0.0)
        left = controller.ground_distance(place) - stop
        if left < ARRIVAL_TOLERANCE:
            controller.stop()
            self.is_there = controller.is_standing
            return self.is_there
        self.stick(self.walk_to(controller, place, stop, dt), self.approach)
        return False


@dataclass
class FollowTarget(TargetTask):
    """Go after a target, keep a distance, and look at it.

    Attributes:
        gap: distance from its surface [m].
    """

    gap: float = 1.0

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.is_missing(controller):
            return False
        state = controller.view.state(self.target)
        place = state.nearest(controller.waist())
        stop = self.gap + controller.body_radius
        left = controller.ground_distance(place) - stop
        speed = math.hypot(state.v[0], state.v[2])
        self.pace = min(speed + CLOSING_RATE * max(left, 0.0), controller.best_pace)
        if left > (ARRIVAL_TOLERANCE if controller.record.has_goal else SETTING_OUT):
            # Where it will be: one who heads for where it is slows down behind it.
            lead = LEAD_TIME * min(max(left / EASING, 0.0), 1.0)
            self.walk_to(controller, place + lead * state.v, stop, dt)
        elif controller.is_standing:
            controller.face_to(state.centre)
        else:
            controller.stop()
        return False


@dataclass
class ChaseTarget(TargetTask):
    """Run after a target until a hand or the body touches it.

    Attributes:
        has_touched: whether it has.
        pursuit: the distance to the target.
    """

    has_touched: bool = False
    pursuit: TaskProgress = field(default_factory=TaskProgress)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.has_touched or self.is_missing(controller):
            return self.has_touched
        state, person = controller.view.state(self.target), controller.record
        self.pace = controller.best_pace
        place = state.nearest(controller.waist())
        distance = controller.ground_distance(place)
        is_high = place[1] - person.floor > TOUCH_LEVEL * person.height
        hand = None
        if is_high and distance < 1.4 * controller.arm:
            ahead, right = controller.direction_to(place), 1
            hand = state.nearest(controller.shoulder(right) + 0.5 * controller.arm * ahead)
            controller.put_hand(right, hand)
            self.has_touched = math.dist(controller.hand(right), hand) < (
                TOUCH_RANGE * person.height
            )
        self.has_touched |= distance < controller.body_radius + ARRIVAL_TOLERANCE
        if self.has_touched:
            controller.stop()
            if hand is not None:
                controller.let_go(1)
            return True
        lead = min(distance / self.pace, LEAD_TIME)
        self.walk_to(controller, place + lead * state.v, 0.0, dt)
        if person.frozen:
            return False
        if self.pursuit.update(distance, dt, person.at) > BLOCKED_TIME:
            self.stick(f"the way is blocked at {place_text(controller)}", self.approach)
        elif self.pursuit.idle_time > CHASE_PATIENCE:
            self.failure = f"is not fast enough; still {distance:.2g} m off"
        return False


@dataclass
class FleeTarget(TargetTask):
    """Run from a target until far enough from its surface.

    Attributes:
        distance: far enough [m].
        is_safe: whether it is.
        flight: the distance from the target.
    """

    distance: float = 5.0
    is_safe: bool = False
    flight: TaskProgress = field(default_factory=TaskProgress)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.is_safe:
            return True
        state, person = controller.view.state(self.target), controller.record
        place = state.nearest(controller.waist())
        gap = controller.ground_distance(place) - controller.body_radius
        if gap >= self.distance or not state.is_present:
            controller.stop()
            self.is_safe = controller.is_standing
            return self.is_safe
        self.pace = controller.best_pace
        at = np.array(person.at)
        low, high = controller.view.edges
        away = at - place[[0, 2]] - 0.4 * state.v[[0, 2]]
        goal = refuge(at, low, high, away, FLIGHT_DISTANCE)
        self.walk_to(controller, np.array([goal[0], 0.0, goal[1]]), 0.0, dt)
        if self.flight.update(-gap, dt, at) > BLOCKED_TIME and not person.frozen:
            self.failure = f"is cornered at {place_text(controller)}, {gap:.1f} m from it"
        return False


def evade(controller: PersonController) -> None:
    """Step away from targets that are nearer than they may come."""
    person, push = controller.record, np.zeros(2)
    for name, distance in controller.avoided.items():
        state = controller.view.state(name)
        place = state.nearest(controller.waist())
        gap = controller.ground_distance(place) - controller.body_radius
        if state.is_present and gap < distance:
            away = -controller.direction_to(place)[[0, 2]]
            share = min(2.0 * (1.0 - gap / distance), 1.0)
            push += 1.2 * float(person.pace) * share * away
    person.evasion[:] = push
