"""Task dispatcher: orders of a script become tasks of people and commands to their control.

Source: Sims 1987, 3.2.4; Horswill 2008, "High-level Control", for the orders.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.contact_tasks import Grab, Grapple, Hug, Reach
from pipeline.simulation.characters.person_controller import (
    HANDS,
    CharacterView,
    PersonController,
)
from pipeline.simulation.characters.person_record import STANDING, SWINGING
from pipeline.simulation.characters.person_tasks import (
    PosedHands,
    SitDown,
    SitOn,
    StandUp,
    Task,
    Turn,
    Walk,
)
from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.script import Orders
from pipeline.spec import script as spec
from pipeline.spec.keyframes import PoseKey
from pipeline.spec.model_base import Target
from pipeline.spec.script import Do

UNLIMITED_WALK = 1000.0
"""Length of a walk without a goal [m]."""

SIDE_ORDERS = (spec.LookAt, spec.LookAhead, spec.SetSpeed, spec.LetGo, spec.SetUrges)
"""Orders that leave the task as it is."""


class TaskDispatcher:
    """The tasks of all acting people of a troupe.

    Args:
        view: all characters.
        persons: `PERSON` records.
        dt: a step [s].
        poses: keys of posed hands, by name.

    Attributes:
        view: all characters.
        controllers: of the people, in the order of their records.
        minded: indices of people with a mind.
    """

    def __init__(
        self,
        view: CharacterView,
        persons: Records,
        dt: float,
        poses: Mapping[str, Sequence[PoseKey]] | None = None,
    ) -> None:
        self.view = view
        self.minded: frozenset[int] = frozenset()
        self.controllers = [
            PersonController(view.names[person.owner], person, view) for person in persons
        ]
        self._dt, self._steps = dt, 0
        self._by_name = {person.name: k for k, person in enumerate(self.controllers)}
        count = len(self.controllers)
        self._tasks: list[Task | None] = [None] * count
        self._done, self._ordered = [True] * count, [False] * count
        self._look_targets: list[Target | None] = [None] * count
        self._glances = [NOBODY] * count
        self._arrived: list[str] = []
        self._posed_hands = {name: PosedHands(keys) for name, keys in (poses or {}).items() if keys}

    def read(self, orders: Orders) -> None:
        """Accept the orders of a script for this step."""
        for name, given in orders.items():
            if (k := self._by_name.get(name)) is not None:
                for order in given:
                    self._accept(k, order)

    # --- for minds ------------------------------------------------------------------------

    def is_ordered(self, k: int) -> bool:
        """Tell whether a person follows an order that is not done yet."""
        return self._ordered[k]

    def task(self, k: int) -> Task | None:
        """Return the task of a person."""
        return self._tasks[k]

    def begin(self, k: int, task: Task) -> None:
        """Start a task of a person's own choice."""
        self.controllers[k].record.posture = STANDING
        self._begin(k, task, keeps_arms=True)

    def end(self, k: int) -> None:
        """End the task of a person; held objects stay in the hands."""
        controller = self.controllers[k]
        controller.stop()
        person = controller.record
        person.posture, person.has_facing, person.stoop_depth = STANDING, False, 0.0
        controller.part_hands()
        for hand in range(2):
            if controller.held_node(hand) < 0:
                controller.let_go(hand)
            else:
                person.arm_mode[hand] = SWINGING
        self._tasks[k], self._done[k] = None, True

    def glance(self, k: int, owner: int) -> None:
        """Let a person look at a character, unless an order says where to look."""
        self._glances[k] = owner

    # --- every step -----------------------------------------------------------------------

    def command(self) -> None:
        """Command all people for the coming step."""
        self._arrived.clear()
        time = self._steps * self._dt
        self._steps += 1
        for k, controller in enumerate(self.controllers):
            controller.end_distant_embrace()
            task = self._tasks[k]
            if task is not None:
                is_done = task.advance(controller, self._dt)
                if is_done and not self._done[k]:
                    self._arrived.append(controller.name)
                self._done[k] = is_done or self._done[k]
                self._ordered[k] = self._ordered[k] and (not is_done or self._persists(k))
            controller.hold_gripped_things()
            if controller.name in self._posed_hands:
                self._posed_hands[controller.name].advance(controller, time)
            self._look(k, controller)

    def arrived(self) -> tuple[str, ...]:
        """Return the names of people whose orders were done in the last step."""
        return tuple(self._arrived)

    def _persists(self, k: int) -> bool:
        frozen = bool(self.controllers[k].record.frozen)
        return frozen or isinstance(self._tasks[k], SitDown | SitOn)

    def _look(self, k: int, controller: PersonController) -> None:
        target, owner = self._look_targets[k], self._glances[k]
        if owner < 0:
            owner = getattr(self._tasks[k], "owner", NOBODY)
        if isinstance(target, str):
            controller.look_at(self.view.face(self.view.number(target)))
        elif target is not None:
            controller.look_at(np.array(target))
        elif owner >= 0:
            controller.look_at(self.view.face(owner))
        else:
            controller.record.has_look_target = False

    # --- orders ---------------------------------------------------------------------------

    def _accept(self, k: int, order: Do) -> None:
        controller = self.controllers[k]
        controller.record.frozen = order == "freeze"
        self._ordered[k] |= not isinstance(order, SIDE_ORDERS)
        if order == "walk" and k in self.minded:
            # The person's own mind says where to.
            self._ordered[k] = False
            self.end(k)
        elif isinstance(order, str):
            self._accept_word(k, controller, order)
        elif isinstance(order, spec.LookAt):
            self._look_targets[k] = order.look_at
        elif isinstance(order, spec.LookAhead):
            self._look_targets[k] = None
        elif isinstance(order, spec.SetSpeed):
            controller.record.pace = order.speed
        elif isinstance(order, spec.Wait):
            controller.stop()
        elif isinstance(order, spec.LetGo):
            self._let_go(k, HANDS[order.let_go])
        else:
            self._start_ordered(k, controller, order)

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
        if isinstance(self._tasks[k], Walk) and not self._done[k]:
            person.has_goal, person.posture = True, STANDING
            return
        controller.go(
            person.at[0] + UNLIMITED_WALK * math.cos(person.heading),
            person.at[1] - UNLIMITED_WALK * math.sin(person.heading),
        )
        self._begin(k, Walk())

    def _start_ordered(self, k: int, controller: PersonController, order: Do) -> None:
        number = self.view.number
        controller.record.posture = STANDING
        if isinstance(order, spec.GoTo):
            controller.go(*order.go_to)
            self._begin(k, Walk(np.array(order.go_to, dtype=float)), keeps_arms=True)
        elif isinstance(order, spec.TurnBy):
            controller.turn_to(float(controller.record.heading) + math.radians(order.turn_deg))
            self._begin(k, Turn(), keeps_arms=True)
        elif isinstance(order, spec.Reach):
            place = None if isinstance(order.reach, str) else np.array(order.reach)
            owner = number(order.reach) if isinstance(order.reach, str) else NOBODY
            self._begin(k, Reach(HANDS[order.hand], place, owner), keeps_arms=True)
        elif isinstance(order, spec.Grab):
            grab = Grab(HANDS[order.hand], number(order.grab), order.part)
            self._begin(k, grab, keeps_arms=True)
        elif isinstance(order, spec.Hug):
            partner = number(order.hug)
            self._begin(k, Hug(partner, self.view.size(partner)))
        elif isinstance(order, spec.Grapple):
            self._begin(k, Grapple(number(order.grapple)))
        elif isinstance(order, spec.SitOn):
            self._begin(k, SitOn(number(order.sit)))

    def _begin(self, k: int, task: Task, keeps_arms: bool = False) -> None:
        """Start a task; empty hands hang again, unless they are kept after a task that is done."""
        controller = self.controllers[k]
        keeps_arms = keeps_arms and (self._done[k] or not isinstance(self._tasks[k], Grab))
        self._tasks[k], self._done[k] = task, False
        controller.record.stoop_depth = 0.0
        controller.part_hands()
        for hand in range(2):
            if not keeps_arms and controller.held_node(hand) < 0:
                controller.record.arm_mode[hand] = SWINGING

    def _let_go(self, k: int, hands: Sequence[int]) -> None:
        controller = self.controllers[k]
        controller.part_hands()
        for hand in hands:
            controller.let_go(hand)
        if isinstance(self._tasks[k], Hug | Reach | Grab | Grapple):
            controller.stop()
            controller.record.has_facing, controller.record.stoop_depth = False, 0.0
            self._tasks[k] = None
