"""Hug reception: what a person does that somebody comes to hug.

It accepts or declines when the other's arms open. One that is walking somewhere goes on, and the
other waits where it is out of the way; after a while it interrupts its walk for the hug. One that
has nothing to do turns to who hugs it.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.characters.hug_tasks import Hug, LoosenHug
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import STANDING
from pipeline.simulation.characters.person_tasks import StandUp, Turn, Walk
from pipeline.simulation.characters.pursuit_tasks import WalkUp
from pipeline.simulation.characters.second_try import StepAside
from pipeline.simulation.characters.task_book import TaskBook
from pipeline.spec.gesture import REFUSE

GOING = Walk, WalkUp
"""Tasks that end somewhere, and that a hug may interrupt."""

WAITING_TIME = 5.0  # for one that walks, after which it is asked to interrupt that [s]
WAITING_RANGE = 2.0  # of one that waits, beyond touching, in arm lengths
MEETING_RANGE = 2.5  # of where a partner walks to from where it is, to be met there [m]
TURNING_RANGE = 1.0  # of who comes, from touching, at which one turns [m]
FACING = math.radians(30.0)  # turned away by less, nobody turns
NEARLY_FACING = math.radians(60.0)  # from which the other comes near


class HugReception:
    """The reception of hugs by all acting people of a troupe.

    Args:
        dispatcher: of their tasks.

    Attributes:
        paused: people whose walk rests for a hug, and who hugs each of them, by index.
    """

    def __init__(self, dispatcher: TaskBook) -> None:
        self.paused = dict[int, int]()
        self._dispatcher = dispatcher
        self._waited = dict[int, float]()

    def advance(self, dt: float) -> None:
        """Let all that are to be hugged accept, decline, and see to the hug."""
        dispatcher = self._dispatcher
        self._forget_waits()
        for k, task in dispatcher.busy(Hug):
            partner = dispatcher.index(dispatcher.view.names[task.owner])
            if partner is None or not dispatcher.is_ordered(k):
                continue
            if task.is_near and not task.is_answered:
                task.is_answered = True
                asker = int(dispatcher.controllers[k].record.owner)
                if refusal := dispatcher.refusal_to_hug(partner, asker):
                    name = dispatcher.controllers[partner].name
                    task.failure = f"{name} {refusal}, and declines"
                    dispatcher.gestures.append((partner, REFUSE, dispatcher.view.names[asker]))
                    continue
            if task.touched == 0.0:
                self._prepare(k, task, partner, dt)
        for partner, k in tuple(self.paused.items()):
            if not self._is_held(partner, k):
                self._resume(partner)

    def _forget_waits(self) -> None:
        """Forget the waits of those who hug nobody any more."""
        for k in tuple(self._waited):
            if not isinstance(self._dispatcher.task(k), Hug):
                del self._waited[k]

    def _prepare(self, k: int, task: Hug, partner: int, dt: float) -> None:
        """Let a partner end its walk and turn before a person comes near."""
        asker, other = (self._dispatcher.controllers[n] for n in (k, partner))
        task.meeting, task.is_turning = None, False
        if self._is_going(partner):
            at, goal = np.array(other.record.at), np.array(other.record.goal)
            is_near_goal = math.dist(at, goal) < MEETING_RANGE
            task.meeting = goal if other.record.has_goal and is_near_goal else at
            room = task.closeness(asker) + WAITING_RANGE * asker.arm
            if asker.ground_distance(asker.view.pelvis(task.owner)) < room:
                self._waited[k] = self._waited.get(k, 0.0) + dt
            is_late = self._waited.get(k, 0.0) > WAITING_TIME
            if is_late and isinstance(self._dispatcher.task(partner), GOING):
                self.paused[partner] = k
                other.stop()
            return
        gap = asker.ground_distance(asker.view.pelvis(task.owner)) - task.closeness(asker)
        if gap < TURNING_RANGE and self._is_free(partner):
            place = asker.waist()
            other.record.facing = float(other.record.heading)
            other.face_to(place)
            task.is_turning = other.turn_left > NEARLY_FACING
            if other.turn_left < FACING:
                other.record.has_facing = False

    def _is_going(self, k: int) -> bool:
        """Tell whether a person walks somewhere because it was told to."""
        dispatcher = self._dispatcher
        return (
            k not in self.paused
            and dispatcher.is_ordered(k)
            and isinstance(dispatcher.task(k), (*GOING, StepAside))
        )

    def _is_free(self, k: int) -> bool:
        """Tell whether a person may turn to who hugs it."""
        dispatcher, record = self._dispatcher, self._dispatcher.controllers[k].record
        is_up = float(record.sit_blend) == 0.0 and int(record.posture) == STANDING
        if record.frozen or not is_up:
            return False
        if k in self.paused:
            return True
        task = dispatcher.task(k)
        is_idle = task is None or isinstance(task, (*GOING, Turn, StandUp))
        return is_idle and not dispatcher.is_ordered(k) and k not in dispatcher.minded

    def _is_held(self, partner: int, k: int) -> bool:
        """Tell whether a person still hugs a partner that has interrupted its walk."""
        dispatcher, task = self._dispatcher, self._dispatcher.task(k)
        hug = task.hug if isinstance(task, LoosenHug) else task
        owner = int(dispatcher.controllers[partner].record.owner)
        is_hug = isinstance(hug, Hug) and hug.owner == owner and not hug.failure
        return is_hug and isinstance(dispatcher.task(partner), GOING)

    def _resume(self, partner: int) -> None:
        """Let a person go on with the walk that it has interrupted."""
        del self.paused[partner]
        task, controller = self._dispatcher.task(partner), self._dispatcher.controllers[partner]
        if isinstance(task, Walk):
            resume_walk(controller, task)


def resume_walk(controller: PersonController, walk: Walk) -> None:
    """Let a person go on to where it was going."""
    if walk.goal is not None:
        controller.go(float(walk.goal[0]), float(walk.goal[1]))
    else:
        controller.record.has_goal, controller.record.has_facing = True, False
