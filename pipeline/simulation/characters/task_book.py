"""Task book: which task each person of a troupe has, and how orders of a script begin and end it.

Source: Horswill 2008, "High-level Control", for the orders.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from pipeline.simulation.characters.character_view import CharacterView
from pipeline.simulation.characters.contact_tasks import Grab, Reach
from pipeline.simulation.characters.crew import CarryEnd
from pipeline.simulation.characters.dance_task import Dance
from pipeline.simulation.characters.gaze_choice import GazeChoice
from pipeline.simulation.characters.handling_tasks import CarryTo, GrabMember, ThrowAt
from pipeline.simulation.characters.hug_tasks import STEP_BACK, Hug, LoosenHug
from pipeline.simulation.characters.kick_task import KickThing
from pipeline.simulation.characters.mind.consent import Consent
from pipeline.simulation.characters.ordered_tasks import task_of_order
from pipeline.simulation.characters.person_controller import (
    HANDS,
    PersonController,
)
from pipeline.simulation.characters.person_record import STANDING, SWINGING
from pipeline.simulation.characters.person_tasks import (
    SitDown,
    StandUp,
    Task,
    Walk,
)
from pipeline.simulation.characters.pursuit_tasks import (
    ChaseTarget,
)
from pipeline.simulation.characters.push_task import PushRound
from pipeline.simulation.characters.shove_task import Grapple
from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.dynamics.record_view import record_view
from pipeline.simulation.expressions import told_emotions
from pipeline.simulation.script import Orders
from pipeline.spec import script as spec
from pipeline.spec.expression import EMOTIONS
from pipeline.spec.gesture import GESTURES
from pipeline.spec.script import Do
from pipeline.spec.verbs import key_of_order

AnyTask = TypeVar("AnyTask", bound=Task)

UNLIMITED_WALK = 1000.0
"""Length of a walk without a goal [m]."""

SIDE_ORDERS = (
    *(spec.Avoid, spec.LookAt, spec.LookAhead, spec.SetSpeed, spec.LetGo, spec.SetUrges),
    *(spec.Express, spec.Greet, spec.PointAt, spec.Refuse),
)
"""Orders that leave the task as it is."""

ARM_TASKS = (Grab, GrabMember, CarryTo, ThrowAt, ChaseTarget)
"""Tasks that leave empty hands in the air when they are broken off."""


BUSY_TASKS = (CarryTo, CarryEnd, ThrowAt, Dance)
"""Tasks that are not left off for a hug."""


class TaskBook:
    """The tasks and orders of all acting people of a troupe.

    Args:
        view: all characters.
        persons: `PERSON` records.

    Attributes:
        view: all characters.
        controllers: of the people, in the order of their records.
        minded: what people with a mind consent to, by their index.
        expressions: (P, 6) emotions that orders ask to show, NaN where none does. Replaced, never
            changed.
        gestures: that people are to begin, by their index: kind and name of the target.
        giving: indices of people with a mind who stand and hold out what another comes for.
    """

    def __init__(self, view: CharacterView, persons: Records) -> None:
        self.view = view
        self.minded: Mapping[int, Consent] = {}
        self.gestures = list[tuple[int, str, str]]()
        self.giving = set[int]()
        self.controllers = [
            PersonController(view.names[owner], record_view(persons, k), view)
            for k, owner in enumerate(persons["owner"].tolist())
        ]
        self.expressions = np.full((len(self.controllers), len(EMOTIONS)), np.nan)
        view.persons.update({int(one.record.owner): one.record for one in self.controllers})
        self._by_name = {person.name: k for k, person in enumerate(self.controllers)}
        count = len(self.controllers)
        self._tasks: list[Task | None] = [None] * count
        self._busy = dict[type[Task], Sequence[tuple[int, Any]]]()
        self._done, self._ordered = [True] * count, [False] * count
        self._gaze = GazeChoice(view, count)
        # Who may have something to do in the next step.
        self._active = set(range(count))
        self._orders: list[Do | None] = [None] * count
        self._tries, self._asked, self._stood = [0] * count, [0.0] * count, [0.0] * count
        self._usual_paces: list[float | None] = [None] * count
        self._waits = [False] * count
        # Steps for which a task goes on as it was last commanded.
        self._resting = [0] * count

    def read(self, orders: Orders) -> None:
        """Accept the orders of a script for this step."""
        for name, given in orders.items():
            if (k := self._by_name.get(name)) is not None:
                for order in given:
                    self._accept(k, order)

    def index(self, name: str) -> int | None:
        """Return the index of an acting person, None for another member of the cast."""
        return self._by_name.get(name)

    def is_ordered(self, k: int) -> bool:
        """Tell whether a person follows an order that is not done yet."""
        return self._ordered[k]

    def task(self, k: int) -> Task | None:
        """Return the task of a person."""
        return self._tasks[k]

    def busy(self, kind: type[AnyTask]) -> Sequence[tuple[int, AnyTask]]:
        """Return the people who have tasks of a kind, by index, and these."""
        if kind not in self._busy:
            tasks = enumerate(self._tasks)
            self._busy[kind] = tuple((k, task) for k, task in tasks if isinstance(task, kind))
        return self._busy[kind]

    def refusal_to_hug(self, k: int, asker: int) -> str:
        """Return why a person does not let a character hug it, "" if it does."""
        if k in self.minded and not self._ordered[k]:
            return self.minded[k].refusal(asker)
        task = self._tasks[k]
        if isinstance(task, Hug) and task.owner != asker and task.touched > 0.0:
            return f"hugs {self.view.names[task.owner]}"
        is_busy = isinstance(task, BUSY_TASKS) and not self._done[k]
        words = "dances" if isinstance(task, Dance) else "has its hands full"
        return words if is_busy else ""

    def begin(self, k: int, task: Task) -> None:
        """Start a task of a person's own choice."""
        self.controllers[k].record.posture = STANDING
        self._begin(k, task, keeps_arms=True)

    def replace(self, k: int, task: Task) -> None:
        """Go on with another task for the same order."""
        self._begin(k, task)

    def end(self, k: int) -> None:
        """End the task of a person; held objects stay in the hands."""
        controller = self.controllers[k]
        self._active.add(k)
        if (task := self._tasks[k]) is not None:
            task.leave(controller)
        controller.stop()
        person = controller.record
        person.posture, person.has_facing, person.stoop_depth = STANDING, False, 0.0
        person.startled = False
        for hand in range(2):
            if not controller.is_holding(hand):
                controller.let_go(hand)
            else:
                person.arm_mode[hand] = SWINGING
        self._set_task(k, None)
        self._done[k] = True
        self.view.slots.leave(controller.name)

    def _set_task(self, k: int, task: Task | None) -> None:
        self._tasks[k], self._resting[k] = task, 0
        self._busy.clear()

    def _set_pace(self, k: int, least: float, most: float = math.inf) -> None:
        """Let a person walk as fast as a task asks for [m/s]; 0 and ∞ for the usual pace."""
        record, usual = self.controllers[k].record, self._usual_paces[k]
        if least > 0.0 or most < math.inf:
            if usual is None:
                usual = self._usual_paces[k] = float(record.pace)
            record.pace = min(max(usual, least), most)
        elif usual is not None:
            record.pace, self._usual_paces[k] = usual, None

    def _begin(self, k: int, task: Task, keeps_arms: bool = False) -> None:
        """Start a task; empty hands hang again, unless they are kept after a task that is done."""
        controller = self.controllers[k]
        self._active.add(k)
        last = self._tasks[k]
        if last is not None:
            last.leave(controller)
        keeps_arms = keeps_arms and (self._done[k] or not isinstance(last, ARM_TASKS))
        self._set_task(k, task)
        self._done[k] = False
        self.view.slots.leave(controller.name)
        self._set_pace(k, 0.0)
        controller.record.stoop_depth = 0.0
        if controller.record.kick_foot >= 0 and isinstance(last, KickThing):
            last.put_foot_down(controller)
        for hand in range(2):
            if not keeps_arms and not controller.is_holding(hand):
                controller.record.arm_mode[hand] = SWINGING

    # --- orders ---------------------------------------------------------------------------

    def _accept(self, k: int, order: Do) -> None:
        controller = self.controllers[k]
        self._active.add(k)
        self._resting[k] = 0
        controller.record.frozen, controller.record.fearful = order == "freeze", False
        if isinstance(order, SIDE_ORDERS):
            self._accept_aside(k, controller, order)
            return
        self._ordered[k] = True
        self._waits[k] = isinstance(order, spec.Wait)
        resumes = order == "walk" and self._tasks[k] is not None and not self._done[k]
        if not (resumes or self._waits[k]):
            self._orders[k] = order
            self._tries[k], self._asked[k], self._stood[k] = 0, 0.0, 0.0
        self._gaze.regrets[k] = None
        if order == "walk" and k in self.minded:
            # The person's own mind says where to.
            self._ordered[k] = False
            self.end(k)
        elif isinstance(order, str):
            self._accept_word(k, controller, order)
        elif self._waits[k]:
            controller.stop()
        else:
            self._begin_order(k, order)

    def _begin_order(self, k: int, order: Do | None) -> None:
        """Start the task for an order."""
        controller = self.controllers[k]
        controller.record.posture = STANDING
        if order is not None and (task := task_of_order(controller, order)) is not None:
            self._begin(k, task)

    def _accept_aside(self, k: int, controller: PersonController, order: Do) -> None:
        """Accept an order that leaves the task as it is."""
        if isinstance(order, spec.LookAt):
            self._gaze.targets[k] = order.look_at
        elif isinstance(order, spec.LookAhead):
            self._gaze.targets[k] = None
        elif isinstance(order, spec.SetSpeed):
            if self._usual_paces[k] is not None:
                self._usual_paces[k] = order.speed
            else:
                controller.record.pace = order.speed
        elif isinstance(order, spec.Avoid):
            controller.avoided[self.view.target_name(order.avoid)] = order.distance
        elif isinstance(order, spec.LetGo):
            self._let_go(k, HANDS[order.let_go])
        elif isinstance(order, spec.Express):
            self.expressions = self.expressions.copy()
            self.expressions[k] = told_emotions(order)
        elif (kind := key_of_order(order)) in GESTURES:
            target = self.view.target_name(getattr(order, kind))
            self.gestures.append((k, kind, target))

    def _accept_word(self, k: int, controller: PersonController, word: str) -> None:
        if word == "stop":
            controller.stop()
            self._begin(k, Walk())
        elif word == "walk":
            self._walk_on(k, controller)
        elif word == "sit":
            self._begin(k, SitDown())
        elif word == "stand":
            controller.stop()
            self._begin(k, StandUp())
        elif word == "let_go":
            self._let_go(k, HANDS["both"])

    def _walk_on(self, k: int, controller: PersonController) -> None:
        """Resume an unfinished walk, or walk straight on."""
        person = controller.record
        if self._tasks[k] is not None and not self._done[k]:
            person.has_goal = person.has_goal or isinstance(self._tasks[k], Walk)
            person.posture = STANDING
            return
        controller.go(
            person.at[0] + UNLIMITED_WALK * math.cos(person.heading),
            person.at[1] - UNLIMITED_WALK * math.sin(person.heading),
        )
        self._begin(k, Walk())

    def _let_go(self, k: int, hands: Sequence[int]) -> None:
        controller, task = self.controllers[k], self._tasks[k]
        if isinstance(task, Hug) and task.touched > 0.0:
            # Arms that are just dropped are torn out, or caught between the two.
            self._begin(k, LoosenHug(task, STEP_BACK), keeps_arms=True)
            self._done[k], self._ordered[k] = True, False
            return
        for hand in hands:
            controller.let_go(hand)
        if isinstance(task, (Hug, Reach, Grapple, PushRound, *ARM_TASKS)):
            task.leave(controller)
            controller.stop()
            controller.record.has_facing, controller.record.stoop_depth = False, 0.0
            self._set_task(k, None)
