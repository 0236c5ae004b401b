"""Gestures: waving, pointing and refusing, over whatever else a person does.

A gesture takes a hand that has nothing to do, and the gaze; without a free hand the head alone
makes it. A person that stands about turns to whom it is meant for. Afterwards the arm hangs again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.company_task import WalkAlong
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import PLACED, SWINGING
from pipeline.simulation.characters.person_tasks import SitDown, StandUp, Task, Turn, Walk
from pipeline.simulation.characters.pursuit_tasks import FollowTarget, WalkUp
from pipeline.simulation.characters.queue_task import QueueUp
from pipeline.simulation.characters.seat_task import SitOn
from pipeline.simulation.characters.task_dispatcher import TaskDispatcher
from pipeline.simulation.spatial import Array
from pipeline.spec.gesture import GREET, POINT, REFUSE

LEAVING_HANDS = (Walk, WalkUp, WalkAlong, FollowTarget, Turn, StandUp, QueueUp, SitDown, SitOn)
"""Tasks that leave hands free for gestures."""

STANDING_ABOUT = (Walk, WalkUp, WalkAlong, Turn, StandUp)
"""Tasks after which a person may turn to whom a gesture is meant for."""

DURATIONS: Mapping[str, float] = {GREET: 2.2, POINT: 2.0, REFUSE: 2.0}
"""Of gestures, until the arm sinks [s]."""

TURNED_AWAY = math.radians(40.0)  # from which one who stands about turns to it
ACROSS = math.radians(35.0)  # to the left, from which the left hand is used
BEHIND = math.radians(110.0)  # from which no hand is raised while one goes on
PREPARATION = 0.35  # of a wave or a shake, before the stroke [s]
WAVE_RATE, WAVE_WIDTH = 2.0, 0.2  # of a waving hand [1/s], in arm lengths
SHAKE_RATE, SHAKE_ANGLE = 1.3, math.radians(32.0)  # of a head that is shaken [1/s]
POINTING_REACH = 0.9  # of an arm that points, in its length


class HandPlace(NamedTuple):
    """Where a hand is held, from the shoulder: towards another, up, outward, in arm lengths."""

    towards: float
    up: float
    outward: float


WAVING, REFUSING = HandPlace(0.35, 0.6, 0.22), HandPlace(0.6, 0.05, -0.12)

LOWERED = HandPlace(0.5, -0.5, 0.05)
"""Where a hand passes on its way up and down: straight past the shoulder the elbow would swing."""

RAISING, LOWERING = 0.3, 0.6  # times for which it does so, at the start and before the end [s]


@dataclass(eq=False)
class Gesture:
    """A gesture that a person makes.

    Attributes:
        kind: key of `DURATIONS`.
        target: name of whom or what it is meant for.
        time: since it began [s].
        hand: number of the hand; None for the head alone.
        place: (3,) where that was put last [m].
        turns: whether the person turns to the target.
    """

    kind: str
    target: str
    time: float = 0.0
    hand: int | None = None
    place: Array = field(default_factory=lambda: np.zeros(3))
    turns: bool = False


class Gestures:
    """The gestures of all acting people of a troupe.

    Args:
        dispatcher: of their tasks.
    """

    def __init__(self, dispatcher: TaskDispatcher) -> None:
        self._dispatcher = dispatcher
        self._made = dict[int, Gesture]()

    @property
    def members(self) -> set[str]:
        """Names of members whose states gestures need."""
        view = self._dispatcher.view
        others = {one.target for one in self._made.values() if view.owner(one.target) == NOBODY}
        return others - view.places.keys()

    @property
    def are_made(self) -> bool:
        """Whether anybody makes a gesture."""
        return bool(self._made)

    def kind(self, k: int) -> str:
        """Return the gesture that a person makes, "" for none."""
        return self._made[k].kind if k in self._made else ""

    def begin(self, k: int, kind: str, target: str) -> None:
        """Let a person make a gesture; another one that it makes ends."""
        if k in self._made:
            self._end(k)
        self._made[k] = Gesture(kind, target)
        self._prepare(k, self._made[k])

    def advance(self, dt: float) -> None:
        """Command hands and heads for the coming step, after all tasks [s]."""
        dispatcher = self._dispatcher
        for k, kind, target in dispatcher.gestures:
            self.begin(k, kind, target)
        dispatcher.gestures.clear()
        for k, gesture in tuple(self._made.items()):
            controller = dispatcher.controllers[k]
            gesture.time += dt
            if gesture.time > DURATIONS[gesture.kind] or not _may_move(controller):
                self._end(k)
            else:
                self._move(k, gesture)

    def _prepare(self, k: int, gesture: Gesture) -> None:
        """Choose the hand, and whether to turn."""
        dispatcher, controller = self._dispatcher, self._dispatcher.controllers[k]
        record, task = controller.record, dispatcher.task(k)
        angle = _angle_to(controller, self._place(gesture))
        is_idle = task is None or (isinstance(task, STANDING_ABOUT) and not record.has_goal)
        gesture.turns = (
            is_idle
            and not dispatcher.is_ordered(k)
            and k not in dispatcher.minded
            and record.sit_blend == 0.0
            and not record.frozen
            and abs(angle) > TURNED_AWAY
        )
        if not (task is None or isinstance(task, LEAVING_HANDS)):
            return
        if abs(angle) > BEHIND and not gesture.turns:
            return
        hands = (0, 1) if angle > ACROSS and gesture.kind != REFUSE else (1, 0)
        free = [h for h in hands if not controller.is_holding(h) and _hangs(controller, h)]
        gesture.hand = free[0] if free else None

    def _move(self, k: int, gesture: Gesture) -> None:
        controller, place = self._dispatcher.controllers[k], self._place(gesture)
        if gesture.turns:
            controller.face_to(place)
        hand = gesture.hand
        if hand is not None:
            if self._is_taken(controller, gesture, self._dispatcher.task(k)):
                gesture.hand = None
            elif not gesture.turns or abs(_angle_to(controller, place)) < BEHIND:
                gesture.place = hand_place(controller, gesture, hand, place)
                controller.put_hand(hand, gesture.place)
        controller.look_at(self._gaze(controller, gesture, place))

    def _is_taken(self, controller: PersonController, gesture: Gesture, task: Task | None) -> bool:
        """Tell whether a task has taken the hand of a gesture."""
        assert gesture.hand is not None
        leaves = task is None or isinstance(task, LEAVING_HANDS)
        return not leaves or controller.is_holding(gesture.hand)

    def _end(self, k: int) -> None:
        """Let the arm hang, unless something else has taken it."""
        gesture, controller = self._made.pop(k), self._dispatcher.controllers[k]
        record = controller.record
        if gesture.turns:
            record.has_facing = False
        hand = gesture.hand
        if hand is not None and int(record.arm_mode[hand]) == PLACED:
            if np.array_equal(record.arm_target[hand], gesture.place):
                record.arm_mode[hand] = SWINGING

    def _place(self, gesture: Gesture) -> Array:
        """Return (3,) the place of the target [m]."""
        view = self._dispatcher.view
        owner = view.owner(gesture.target)
        return view.face(owner) if owner >= 0 else view.state(gesture.target).face

    def _gaze(self, controller: PersonController, gesture: Gesture, place: Array) -> Array:
        """Return (3,) where the person looks [m]: at the target, to and fro in refusing."""
        since = gesture.time - PREPARATION
        if gesture.kind != REFUSE or since < 0.0:
            return place
        head = controller.view.face(int(controller.record.owner))
        turn = SHAKE_ANGLE * math.sin(2.0 * math.pi * SHAKE_RATE * since)
        x, y, z = place - head
        c, s = math.cos(turn), math.sin(turn)
        looked: Array = head + np.array([c * x + s * z, y, -s * x + c * z])
        return looked


def hand_place(controller: PersonController, gesture: Gesture, hand: int, place: Array) -> Array:
    """Return (3,) where the hand of a gesture towards a place is [m].

    Args:
        controller: of the person.
        gesture: that it makes.
        hand: number of the hand.
        place: (3,) of the target [m].
    """
    shoulder, arm = controller.shoulder(hand), controller.arm
    if gesture.kind == POINT:
        offset = place - shoulder
        reach = POINTING_REACH * arm / max(float(np.linalg.norm(offset)), 1e-9)
        pointed: Array = shoulder + reach * offset
        return pointed
    form = WAVING if gesture.kind == GREET else REFUSING
    ahead = controller.ahead
    outward = (1.0 if hand == 1 else -1.0) * np.array([-ahead[2], 0.0, ahead[0]])
    low = _lowered(gesture)
    ahead_of, up, aside = (
        high + low * (down - high) for high, down in zip(form, LOWERED, strict=True)
    )
    since = gesture.time - PREPARATION
    if gesture.kind == GREET and since > 0.0:
        aside += (1.0 - low) * WAVE_WIDTH * math.sin(2.0 * math.pi * WAVE_RATE * since)
    towards = controller.direction_to(place)
    # The arm is raised before the body, whoever it is meant for.
    towards = 0.5 * (ahead + towards)
    held: Array = shoulder + arm * (ahead_of * towards + np.array([0.0, up, 0.0]) + aside * outward)
    return held


def _lowered(gesture: Gesture) -> float:
    """Return how much of the way the hand of a gesture is lowered, from 0 to 1."""
    left = DURATIONS[gesture.kind] - gesture.time
    share = max(1.0 - gesture.time / RAISING, 1.0 - left / LOWERING, 0.0)
    share = min(share, 1.0)
    return share * share * (3.0 - 2.0 * share)


def _may_move(controller: PersonController) -> bool:
    record = controller.record
    return not record.frozen and float(record.stun) < 0.3 and record.down_time == 0.0


def _hangs(controller: PersonController, hand: int) -> bool:
    return int(controller.record.arm_mode[hand]) == SWINGING


def _angle_to(controller: PersonController, place: Array) -> float:
    """Return the angle to the left of a person at which a place is [rad]."""
    x, z = place[0] - controller.record.at[0], place[2] - controller.record.at[1]
    return math.remainder(math.atan2(-z, x) - float(controller.record.heading), 2.0 * math.pi)
