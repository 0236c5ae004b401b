"""Task dispatcher: tasks of people become commands to their control, and facts to tell.

Source: Sims 1987, 3.2.4.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property

import numpy as np

from pipeline.simulation.characters import joint_tasks
from pipeline.simulation.characters.act_things import mark_act_things
from pipeline.simulation.characters.body_arrays import NOBODY, IntArray
from pipeline.simulation.characters.character_view import CharacterView
from pipeline.simulation.characters.gaze_targets import look_at_characters
from pipeline.simulation.characters.grasp import hold_members
from pipeline.simulation.characters.hand_over import HandOver
from pipeline.simulation.characters.hug_reception import HugReception
from pipeline.simulation.characters.ordered_tasks import members_named
from pipeline.simulation.characters.person_controller import (
    PersonController,
)
from pipeline.simulation.characters.person_tasks import (
    PosedHands,
    SitDown,
    Task,
)
from pipeline.simulation.characters.pursuit_tasks import (
    evade,
)
from pipeline.simulation.characters.seat_task import SitOn
from pipeline.simulation.characters.second_try import Regret, StepAside, place_aside
from pipeline.simulation.characters.task_book import TaskBook
from pipeline.simulation.dynamics.compiled import Records, bound
from pipeline.simulation.order_outcome import GripChange, Outcome
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array
from pipeline.simulation.troupe import Facts
from pipeline.spec.keyframes import PoseKey

NO_FACTS = Facts()
"""Of a step in which people do nothing to be told."""

WIDE_GRIP = 0.3
"""How far hands close that hold a thing between them, in how far one closes around a thing."""

LONGEST_FIRST_TRY = 4.0
"""Time at the place of an act after which there is no second try, for it has taken long [s]."""


class TaskDispatcher(TaskBook):
    """The tasks of all acting people of a troupe, and commands to their control.

    Args:
        view: all characters.
        persons: `PERSON` records.
        dt: a step [s].
        poses: keys of posed hands, by name.

    Attributes:
        suspended: indices of people whose tasks rest, such as in a withdrawal from pain.
    """

    def __init__(
        self,
        view: CharacterView,
        persons: Records,
        dt: float,
        poses: Mapping[str, Sequence[PoseKey]] | None = None,
    ) -> None:
        super().__init__(view, persons)
        self.suspended = set[int]()
        self._dt, self._steps = dt, 0
        # Who had something to do in this step.
        self._acting = list[int]()
        self._persons, self._embraces = persons, view.arrays.owners["embraces"]
        self._grips = persons["grip"][:, None] + np.arange(2)
        self._people = np.array([k in view.people for k in range(len(view.names))], dtype=bool)
        self._looked_at: IntArray = np.full(len(self.controllers), NOBODY)
        self._arrived: list[str] = []
        self._outcomes: list[Outcome] = []
        self._reception = HugReception(self)
        self._posed_hands = {name: PosedHands(keys) for name, keys in (poses or {}).items() if keys}

    def gripping(self) -> Array:
        """Return how far the left and the right hand (P, 2) of the people close around things."""
        grips = self.view.arrays.grips
        found = (grips[self._grips, 1] >= 0).astype(float)
        for k, controller in enumerate(self.controllers):
            found[k, list(controller.held_members)] = 1.0
        found[found.all(axis=-1)] = WIDE_GRIP
        return found

    def members_needed(self, orders: Orders) -> set[str]:
        """Return the names of the members whose states orders, tasks and glances need."""
        view, found = self.view, set[str]()
        for name in orders.keys() & self._by_name.keys():
            for order in orders[name]:
                found |= members_named(order, view)
        for k in self._active:
            controller, task = self.controllers[k], self._tasks[k]
            found |= self._gaze.members(k)
            if task is not None:
                found.update(task.members)
            if isinstance(task, StepAside) and (again := self._orders[k]) is not None:
                found |= members_named(again, view)
            if controller.avoided or controller.held_members:
                found.update(controller.avoided, controller.held_members.values())
        return found - view.places.keys()

    # --- for minds ------------------------------------------------------------------------

    @property
    def acting(self) -> list[PersonController]:
        """The people who had something to do in this step."""
        return [self.controllers[k] for k in self._acting]

    def glance(self, k: int, owner: int) -> None:
        """Let a person look at a character, unless an order says where to look."""
        self._gaze.glances[k] = owner

    # --- every step -----------------------------------------------------------------------

    def command(self) -> None:
        """Command all people for the coming step."""
        self._clear_facts()
        time = self._steps * self._dt
        self._steps += 1
        self.view.decks.forget_poses()
        self.view.decks.update(self._persons)
        joint_tasks.share_slots(self)
        joint_tasks.form_crews(self)
        joint_tasks.advance_crews(self, self._dt)
        self._reception.advance(self._dt)
        givings = joint_tasks.ask_holders(self, self._asked, self._dt)
        self.giving = joint_tasks.stand_to_give(self, givings)
        looked_at = self._looked_at.tolist()
        self._looked_at[:] = self._gaze.glances
        self._acting = sorted(self._active)
        for k in self._acting:
            controller, giving = self.controllers[k], givings.get(k)
            if controller.parting:
                controller.part_from_bars(self._dt)
            if self._rests(k, giving):
                self._looked_at[k] = looked_at[k]
            else:
                self._command_one(k, controller, giving, time)
        self._look_at_characters()
        for k, giving in givings.items():
            if giving.is_taken:
                giving.giver.release(giving.thing)
                self.end(k)

    @cached_property
    def _look_at_characters(self) -> Callable[[], None]:
        arrays = self.view.arrays
        looked = self._persons, arrays.nodes, arrays.owners, self._people, self._looked_at
        return bound(look_at_characters, *looked)

    def _rests(self, k: int, giving: HandOver | None) -> bool:
        """Tell whether a person goes on as it was commanded in the step before."""
        if self._resting[k] == 0 or giving is not None or k in self.suspended:
            return False
        if self.controllers[k].name in self._posed_hands:
            return False
        self._resting[k] -= 1
        return True

    def _command_one(
        self, k: int, controller: PersonController, giving: HandOver | None, time: float
    ) -> None:
        """Command a person, and see whether it has something to do in the next step."""
        if self._embraces.item(controller.owner) >= 0:
            controller.end_distant_embrace()
        if self._tasks[k] is not None:
            if not (self._waits[k] or k in self.suspended or k in self._reception.paused):
                self._advance(k, controller)
        task, holds = self._tasks[k], controller.is_gripping
        mark_act_things(controller, task)
        if task is None or not task.leads_hands:
            _hold(controller, holds)
        if giving is not None:
            giving.hold_out()
        if controller.avoided:
            evade(controller)
        if posed := self._posed_hands.get(controller.name):
            posed.advance(controller, time)
        self._looked_at[k] = self._gaze.choose(k, controller, task, time)
        has_work = task is not None or holds or controller.held_members or controller.parting
        if has_work or controller.avoided or posed or self._gaze.is_led(k):
            return
        if self._embraces.item(controller.owner) < 0:
            self._active.discard(k)

    def _clear_facts(self) -> None:
        """Forget what people did in the step before, of all before any acts."""
        self._arrived.clear()
        self._outcomes.clear()
        for k in self._active.union(self._acting):
            controller = self.controllers[k]
            if controller.grip_changes or controller.touched or controller.kicked_bodies:
                controller.grip_changes.clear()
                controller.touched.clear()
                controller.kicked_bodies.clear()

    def _advance(self, k: int, controller: PersonController) -> None:
        """Advance the task of a person, and see to what becomes of it."""
        task = self._tasks[k]
        assert task is not None
        dt = task.interval * self._dt
        self._resting[k] = task.interval - 1
        is_done = task.advance(controller, dt)
        self._stood[k] += 0.0 if controller.record.has_goal else dt
        if isinstance(task, StepAside):
            if is_done:
                self._begin_order(k, self._orders[k])
            return
        if is_done and not self._done[k]:
            self._arrived.append(controller.name)
        self._done[k] = is_done or self._done[k]
        self._ordered[k] = self._ordered[k] and (not is_done or self._persists(k))
        self._set_pace(k, *((0.0,) if is_done else (task.pace, task.most_pace)))
        if self._done[k] and task.failure:
            self._give_up(k, task.failure)
        elif self._done[k] and task.is_lost:
            self.end(k)
        elif task.failure and self._ordered[k]:
            self._mend(k, task)

    def _mend(self, k: int, task: Task) -> None:
        """Try an order that is stuck once more from elsewhere, or give it up."""
        controller = self.controllers[k]
        subject = task.subject(controller)
        if not task.is_stuck or self._tries[k] > 0 or self._stood[k] > LONGEST_FIRST_TRY:
            self._gaze.regrets[k] = Regret(subject, self._steps * self._dt)
            self._give_up(k, task.failure)
            return
        self._tries[k] += 1
        self._begin(k, StepAside(place_aside(controller, subject)))

    def _give_up(self, k: int, reason: str) -> None:
        """End an order that cannot be carried out, and stand."""
        controller, order = self.controllers[k], self._orders[k]
        if order is not None:
            self._outcomes.append(Outcome(controller.name, order, reason))
        self._set_pace(k, 0.0)
        self.end(k)
        self._ordered[k] = False

    def facts(self) -> Facts:
        """Return what people did in the last step: orders ended, touches of hands, and grips."""
        changes: list[GripChange] = []
        touched: list[tuple[str, str]] = []
        for k in self._acting:
            one = self.controllers[k]
            if one.grip_changes:
                changes += one.grip_changes
            if one.touched:
                touched += [(one.name, name) for name in one.touched]
        if not (changes or touched or self._arrived or self._outcomes):
            return NO_FACTS
        return Facts(
            arrived=tuple(self._arrived),
            touched=tuple(touched),
            outcomes=tuple(self._outcomes),
            # What goes from hand to hand is taken before it is let go of.
            grips=tuple(sorted(changes, key=lambda change: not change.taken)),
        )

    def _persists(self, k: int) -> bool:
        frozen = bool(self.controllers[k].record.frozen)
        return frozen or isinstance(self._tasks[k], SitDown | SitOn)


def _hold(controller: PersonController, may_grip: bool) -> None:
    """Hold what a person has in its hands; `may_grip` is false if no hand grips a node."""
    if may_grip:
        controller.hold_gripped_things()
    if controller.held_members:
        hold_members(controller)
