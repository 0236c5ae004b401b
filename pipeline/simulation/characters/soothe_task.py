"""Soothe task: going up to somebody, and stroking its shoulder."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.contact_tasks import PALM_OFFSET
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import SHOULDER, SWINGING
from pipeline.simulation.characters.person_tasks import Approach, Task, place_text
from pipeline.simulation.characters.task_progress import TaskProgress
from pipeline.simulation.spatial import Array

REACH = 0.72  # from which a hand is laid on a shoulder, in arm lengths
NEAR = 0.15  # beyond it, within which one stays [m]
FACING = math.radians(25.0)  # of one who reaches out
LAID = 0.1  # of the hand from its place, from which it strokes [m]
STROKING_TIME, STROKE_RATE, STROKE_LENGTH = 2.0, 0.9, 0.05  # [s], [1/s], [m]
PATIENCE = 2.5  # of a hand that comes no nearer [s]


@dataclass
class Soothe(Task):
    """Go up to a person, lay a hand on its near shoulder and stroke it.

    Attributes:
        owner: number of the person.
        hand: number of the hand, None before one is chosen.
        time: for which it has stroked [s].
        is_over: whether it has.
        approach: to the person.
        progress: of the hand.
    """

    owner: int
    hand: int | None = None
    time: float = 0.0
    is_over: bool = False
    approach: Approach = field(default_factory=Approach)
    progress: TaskProgress = field(default_factory=TaskProgress)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.is_over:
            return True
        if self.hand is None:
            free = [k for k in (1, 0) if not controller.is_holding(k)]
            if not free:
                self.failure = "has its hands full"
                return False
            self.hand = free[0]
        view, person = controller.view, controller.record
        pelvis = view.pelvis(self.owner)
        left = controller.ground_distance(pelvis) - REACH * controller.arm
        if left > (NEAR if not person.has_goal else 0.0):
            self._let_sink(controller)
            reason = self.approach.walk_to(
                controller, pelvis, REACH * controller.arm, self.owner, dt
            )
            self.stick(reason, self.approach)
            if left > NEAR:
                return False
        controller.face_to(pelvis)
        if controller.is_standing and controller.is_facing(FACING):
            self._stroke(controller, self.hand, dt)
        return self.is_over

    def leave(self, controller: PersonController) -> None:
        """See `Task`."""
        self._let_sink(controller)
        controller.record.has_facing = False

    def _stroke(self, controller: PersonController, hand: int, dt: float) -> None:
        shoulders = controller.view.nodes(self.owner)[SHOULDER : SHOULDER + 2]
        own = controller.shoulder(hand)
        offset = shoulders - own
        near = shoulders[int(np.argmin((offset * offset).sum(axis=1)))]
        size = max(math.dist(own, near), 1e-9)
        palm = PALM_OFFSET * float(controller.record.height)
        place: Array = near + min(palm / size, 1.0) * (own - near)
        place = place + np.array([0.0, 0.5 * palm, 0.0])
        swing = 0.5 * STROKE_LENGTH * (math.cos(2.0 * math.pi * STROKE_RATE * self.time) - 1.0)
        controller.put_hand(hand, place + np.array([0.0, swing, 0.0]))
        off = math.dist(controller.hand(hand), place)
        if off < LAID + STROKE_LENGTH or self.time > 0.0:
            self.time += dt
        elif self.progress.update(off, dt) > PATIENCE:
            self.failure = f"{off:.2f} m out of reach at {place_text(controller)}"
        if self.time > STROKING_TIME:
            self.is_over = True
            self.leave(controller)

    def _let_sink(self, controller: PersonController) -> None:
        if self.hand is not None and not controller.is_holding(self.hand):
            controller.record.arm_mode[self.hand] = SWINGING
