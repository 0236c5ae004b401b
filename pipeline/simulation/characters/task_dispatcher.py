"""Task dispatcher: orders of a script become tasks of people and commands to their control.

Source: Sims 1987, 3.2.4; Horswill 2008, "High-level Control", for the orders.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from pipeline.simulation.characters import joint_tasks
from pipeline.simulation.characters.act_things import mark_act_things
from pipeline.simulation.characters.body_arrays import NOBODY, IntArray
from pipeline.simulation.characters.character_view import CharacterView
from pipeline.simulation.characters.contact_tasks import Grab, Reach
from pipeline.simulation.characters.crew import CarryEnd
from pipeline.simulation.characters.dance_task import Dance
from pipeline.simulation.characters.gaze_choice import GazeChoice
from pipeline.simulation.characters.gaze_targets import look_at_characters
from pipeline.simulation.characters.grasp import hold_members
from pipeline.simulation.characters.hand_over import HandOver
from pipeline.simulation.characters.handling_tasks import CarryTo, GrabMember, ThrowAt
from pipeline.simulation.characters.hug_reception import HugReception
from pipeline.simulation.characters.hug_tasks import STEP_BACK, Hug, LoosenHug
from pipeline.simulation.characters.kick_task import KickThing
from pipeline.simulation.characters.mind.consent import Consent
from pipeline.simulation.characters.ordered_tasks import members_named, task_of_order
from pipeline.simulation.characters.person_controller import (
    HANDS,
    JOINED_GRIP,
    PersonController,
)
from pipeline.simulation.characters.person_record import STANDING, SWINGING
from pipeline.simulation.characters.person_tasks import (
    PosedHands,
    SitDown,
    StandUp,
    Task,
    Walk,
)
from pipeline.simulation.characters.pursuit_tasks import (
    ChaseTarget,
    evade,
)
from pipeline.simulation.characters.push_task import PushRound
from pipeline.simulation.characters.seat_task import SitOn
from pipeline.simulation.characters.second_try import Regret, StepAside, place_aside
from pipeline.simulation.characters.shove_task import Grapple
from pipeline.simulation.dynamics.compiled import Records, bound
from pipeline.simulation.dynamics.record_view import record_view
from pipeline.simulation.expressions import told_emotions
from pipeline.simulation.order_outcome import GripChange, Outcome
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array
from pipeline.simulation.troupe import Facts
from pipeline.spec import script as spec
from pipeline.spec.expression import EMOTIONS
from pipeline.spec.gesture import GESTURES
from pipeline.spec.keyframes import PoseKey
from pipeline.spec.script import Do
from pipeline.spec.verbs import key_of_order

AnyTask = TypeVar("AnyTask", bound=Task)

NO_FACTS = Facts()
"""Of a step in which people do nothing to be told."""

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

WIDE_GRIP = 0.3
"""How far hands close that hold a thing between them, in how far one closes around a thing."""

LONGEST_FIRST_TRY = 4.0
"""Time at the place of an act after which there is no second try, for it has taken long [s]."""


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
        minded: what people with a mind consent to, by their index.
        expressions: (P, 6) emotions that orders ask to show, NaN where none does. Replaced, never
            changed.
        gestures: that people are to begin, by their index: kind and name of the target.
        suspended: indices of people whose tasks rest, such as in a withdrawal from pain.
        giving: indices of people with a mind who stand and hold out what another comes for.
    """

    def __init__(
        self,
        view: CharacterView,
        persons: Records,
        dt: float,
        poses: Mapping[str, Sequence[PoseKey]] | None = None,
    ) -> None:
        self.view = view
        self.minded: Mapping[int, Consent] = {}
        self.suspended, self.giving = set[int](), set[int]()
        self.gestures = list[tuple[int, str, str]]()
        self.controllers = [
            PersonController(view.names[owner], record_view(persons, k), view)
            for k, owner in enumerate(persons["owner"].tolist())
        ]
        self.expressions = np.full((len(self.controllers), len(EMOTIONS)), np.nan)
        self._dt, self._steps = dt, 0
        view.persons.update({int(one.record.owner): one.record for one in self.controllers})
        self._by_name = {person.name: k for k, person in enumerate(self.controllers)}
        count = len(self.controllers)
        self._tasks: list[Task | None] = [None] * count
        self._busy = dict[type[Task], Sequence[tuple[int, Any]]]()
        self._done, self._ordered = [True] * count, [False] * count
        self._gaze = GazeChoice(view, count)
        # Who may have something to do in the next step, and who had in this one.
        self._active, self._acting = set(range(count)), list[int]()
        self._persons, self._embraces = persons, view.arrays.owners["embraces"]
        self._grips = persons["grip"][:, None] + np.arange(JOINED_GRIP)
        self._people = np.array([k in view.people for k in range(len(view.names))], dtype=bool)
        self._looked_at: IntArray = np.full(count, NOBODY)
        self._arrived: list[str] = []
        self._outcomes: list[Outcome] = []
        self._orders: list[Do | None] = [None] * count
        self._tries, self._asked, self._stood = [0] * count, [0.0] * count, [0.0] * count
        self._usual_paces: list[float | None] = [None] * count
        self._waits = [False] * count
        # Steps for which a task goes on as it was last commanded.
        self._resting = [0] * count
        self._reception = HugReception(self)
        self._posed_hands = {name: PosedHands(keys) for name, keys in (poses or {}).items() if keys}

    def gripping(self) -> Array:
        """Return how far the left and the right hand (P, 2) of the people close around things."""
        grips = self.view.arrays.grips
        found = (grips[self._grips, 1] >= 0).astype(float)
        for k, controller in enumerate(self.controllers):
            found[k, list(controller.held_members)] = 1.0
        is_wide = found.all(axis=-1) | (grips[self._persons["grip"] + JOINED_GRIP, 1] >= 0)
        found[is_wide] = WIDE_GRIP
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

    def read(self, orders: Orders) -> None:
        """Accept the orders of a script for this step."""
        for name, given in orders.items():
            if (k := self._by_name.get(name)) is not None:
                for order in given:
                    self._accept(k, order)

    # --- for hugs -------------------------------------------------------------------------

    def index(self, name: str) -> int | None:
        """Return the index of an acting person, None for another member of the cast."""
        return self._by_name.get(name)

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

    # --- for minds ------------------------------------------------------------------------

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

    def _set_task(self, k: int, task: Task | None) -> None:
        self._tasks[k], self._resting[k] = task, 0
        self._busy.clear()

    @property
    def acting(self) -> list[PersonController]:
        """The people who had something to do in this step."""
        return [self.controllers[k] for k in self._acting]

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
        controller.part_hands()
        for hand in range(2):
            if not controller.is_holding(hand):
                controller.let_go(hand)
            else:
                person.arm_mode[hand] = SWINGING
        self._set_task(k, None)
        self._done[k] = True
        self.view.slots.leave(controller.name)

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
        if self._embraces[controller.owner] >= 0:
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
        keeps = controller.avoided or posed or self._embraces[controller.owner] >= 0
        if not (has_work or self._gaze.is_led(k) or keeps):
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

    def _set_pace(self, k: int, least: float, most: float = math.inf) -> None:
        """Let a person walk as fast as a task asks for [m/s]; 0 and ∞ for the usual pace."""
        record, usual = self.controllers[k].record, self._usual_paces[k]
        if least > 0.0 or most < math.inf:
            if usual is None:
                usual = self._usual_paces[k] = float(record.pace)
            record.pace = min(max(usual, least), most)
        elif usual is not None:
            record.pace, self._usual_paces[k] = usual, None

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
        controller.part_hands()
        if controller.record.kick_foot >= 0 and isinstance(last, KickThing):
            last.put_foot_down(controller)
        for hand in range(2):
            if not keeps_arms and not controller.is_holding(hand):
                controller.record.arm_mode[hand] = SWINGING

    def _let_go(self, k: int, hands: Sequence[int]) -> None:
        controller, task = self.controllers[k], self._tasks[k]
        if isinstance(task, Hug) and task.touched > 0.0:
            # Arms that are just dropped are torn out, or caught between the two.
            self._begin(k, LoosenHug(task, STEP_BACK), keeps_arms=True)
            self._done[k], self._ordered[k] = True, False
            return
        controller.part_hands()
        for hand in hands:
            controller.let_go(hand)
        if isinstance(task, (Hug, Reach, Grapple, PushRound, *ARM_TASKS)):
            task.leave(controller)
            controller.stop()
            controller.record.has_facing, controller.record.stoop_depth = False, 0.0
            self._set_task(k, None)


def _hold(controller: PersonController, may_grip: bool) -> None:
    """Hold what a person has in its hands; `may_grip` is false if no hand grips a node."""
    if may_grip:
        controller.hold_gripped_things()
    if controller.held_members:
        hold_members(controller)
