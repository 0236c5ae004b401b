"""Queue task: waiting in line for one's turn, being served, and stepping aside."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.pursuit_tasks import TargetTask
from pipeline.simulation.characters.queue_layout import queue_at
from pipeline.simulation.characters.queues import Queue
from pipeline.simulation.characters.visibility_route import SHRINK_FACTOR, are_free
from pipeline.simulation.spatial import Array

JOINING_RANGE = 1.3  # of the tail, within which one joins it [m]
AT_PLACE, MOVING_UP = 0.2, 0.4  # distances from the own place: there; off it [m]
LEFT_PLACE = 0.65  # from its place at which the next moves up to it, in the pitch
FACING = math.radians(15.0)  # of the head, who is served then
NEAR_PLACE = 2.5  # from its place, within which it accepts others beside it [m]
NEIGHBOUR_SPACE = 0.8  # distance to them, in the pitch
ASIDE, BACK = (1.3, 2.1, 2.9), 0.5  # where one goes who was served, from the head [m]
ROOM = 0.75  # around that, in which nobody stands [m]


@dataclass
class QueueUp(TargetTask):
    """Join a queue at its tail, move up, be served at its head, and step aside.

    Attributes:
        lasts: how long one is served [s].
        from_heading: side on which the queue stands [rad]; None for that of the first who comes.
        is_near: whether it is near the tail, and joins.
        has_joined: whether it stands in line.
        time: for which it has been served [s].
        is_served: whether it has been.
        aside: (2,) where it goes then; None before [m].
    """

    lasts: float = 3.0
    from_heading: float | None = None
    is_near: bool = False
    has_joined: bool = False
    time: float = 0.0
    is_served: bool = False
    aside: Array | None = field(default=None)

    @property
    def wants_slot(self) -> bool:
        """See `Task`; the tail is joined by the nearest first."""
        return self.is_near and not self.has_joined

    def slot_distance(self, controller: PersonController) -> float:
        """See `Task`."""
        queue = self._queue(controller)
        return _distance(controller, queue.place(len(queue.persons)))

    def take_slot(self, controller: PersonController) -> None:
        """See `Task`."""
        queues = controller.view.queues
        queues.join(self.target, self._queue(controller), controller.name)
        self.has_joined = True

    def leave(self, controller: PersonController) -> None:
        """See `Task`."""
        controller.view.queues.leave(controller.name)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.is_served:
            self._step_aside(controller, dt)
            return True
        if self.is_missing(controller):
            return False
        queue = self._queue(controller)
        if not self.has_joined:
            self._come(controller, queue, dt)
            return False
        number = queue.persons.index(controller.name)
        place = queue.place(number)
        off = _distance(controller, place)
        is_off = off > (AT_PLACE if controller.record.has_goal else MOVING_UP)
        if is_off and (controller.record.has_goal or self._may_move_up(controller, queue, number)):
            self._walk(controller, queue, place, dt)
        else:
            self._stand(controller, queue, number)
        is_first = number == 0 and off < MOVING_UP and controller.is_standing
        if is_first and controller.record.has_facing and controller.is_facing(FACING):
            self.time += dt
        if self.time >= self.lasts:
            self._be_served(controller, queue)
        return self.is_served

    def _queue(self, controller: PersonController) -> Queue:
        """Return the queue, or one as it would begin with this person."""
        view = controller.view
        known = view.queues.lines.get(self.target)
        return known or queue_at(view.state(self.target), controller, self.from_heading)

    def _come(self, controller: PersonController, queue: Queue, dt: float) -> None:
        """Go to the tail."""
        place = queue.place(len(queue.persons))
        self.stick(self._walk(controller, queue, place, dt), self.approach)
        self.is_near = _distance(controller, place) < JOINING_RANGE

    def _walk(self, controller: PersonController, queue: Queue, place: Array, dt: float) -> str:
        """Walk to a place (2,) in line [m]; return why that gets no nearer."""
        reason = self.walk_to(controller, np.array([place[0], 0.0, place[1]]), 0.0, dt)
        if _distance(controller, place) < NEAR_PLACE:
            # Beside those in line it needs no more space than they leave.
            controller.record.neighbour_distance = NEIGHBOUR_SPACE * queue.pitch
        return reason

    def _may_move_up(self, controller: PersonController, queue: Queue, number: int) -> bool:
        """Tell whether who was before a person has gone on from the place that it moves up to."""
        view, place = controller.view, queue.place(number)
        before = view.number(queue.persons[number - 1]) if number else queue.served
        record = view.persons.get(before)
        return record is None or math.dist(record.at, place) > LEFT_PLACE * queue.pitch

    def _stand(self, controller: PersonController, queue: Queue, number: int) -> None:
        """Stand in line, facing its head."""
        if controller.record.has_goal:
            controller.stop()
        elif controller.is_standing:
            front = queue.front if number == 0 else queue.place(number) - queue.away
            controller.face_to(np.array([front[0], 0.0, front[1]]))

    def _be_served(self, controller: PersonController, queue: Queue) -> None:
        self.is_served = True
        queue.served = int(controller.record.owner)
        controller.view.queues.leave(controller.name)
        self.aside = self._way_out(controller, queue)
        controller.go(self.aside[0], self.aside[1])

    def _way_out(self, controller: PersonController, queue: Queue) -> Array:
        """Return (2,) where one who was served is in nobody's way, the nearest to the right [m]."""
        head, away = queue.place(0), queue.away
        right = np.array([-away[1], away[0]])
        sides = np.stack(
            [head + BACK * away + far * side for far in ASIDE for side in (right, -right)]
        )
        middles, radii = controller.obstacles()
        at, view = np.array(controller.record.at), controller.view
        reaches = radii + controller.body_radius
        reaches = np.minimum(reaches, SHRINK_FACTOR * np.hypot(*(middles - at).T))
        low, high = view.edges
        is_free = are_free(at, sides, middles, reaches)
        is_free &= ((sides > low) & (sides < high)).all(axis=1)
        for owner, record in view.persons.items():
            if owner != controller.owner:
                is_free &= np.hypot(*(sides - np.array(record.at)).T) > ROOM
        chosen: Array = sides[int(np.argmax(is_free))]
        return chosen

    def _step_aside(self, controller: PersonController, dt: float) -> None:
        """Go on out of the way, which nothing depends on."""
        if self.aside is not None and controller.record.has_goal:
            self.approach.advance(controller, self.aside, dt)


def _distance(controller: PersonController, place: Array) -> float:
    return math.dist(controller.record.at, place)
