"""Mind scheduler."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.characters.behaviours.registry import (
    MotorCommand,
    behaviour_number,
    behaviours_of,
)
from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.contact_tasks import Hug
from pipeline.simulation.characters.mind.mind import Mind
from pipeline.simulation.characters.mind.perception import Surroundings
from pipeline.simulation.characters.person_record import REACHING
from pipeline.simulation.characters.person_tasks import SitDown
from pipeline.simulation.characters.step_report import CRIES, WHIMPER, loudness
from pipeline.simulation.characters.task_dispatcher import TaskDispatcher
from pipeline.simulation.script import Orders
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Channel
from pipeline.spec.behaviour import Attachment, Comfort, Play, Traits, Urge
from pipeline.spec.character import Character
from pipeline.spec.script import SetUrges

EVERY = 0.1
"""How often a mind thinks, about [s]."""

DISTRESS, AGAIN = 0.5, 3.0
"""Anxiety from which on one who runs back to its caregiver cries, and how often it does [s]."""

BREATH = 0.8
"""How long a cry lasts, after which the next can come [s]."""

GLANCING_BACK = 1.2
"""Beyond this angle from the way one goes it stops to look [rad]."""


class MindScheduler:
    """All minds of a troupe.

    Args:
        cast: all characters.
        dispatcher: what the script tells them, and through which minds act.
        surroundings: all characters as they are seen.
        seed: of the scene.
        dt: a step [s].
        sub_step: of it [s].
    """

    def __init__(
        self,
        cast: Sequence[Character],
        dispatcher: TaskDispatcher,
        surroundings: Surroundings,
        seed: int,
        dt: float,
        sub_step: float,
    ) -> None:
        self.dispatcher, self.surroundings = dispatcher, surroundings
        self.dt, self.sub_step = dt, sub_step
        self.every = max(round(EVERY / dt), 1)
        self.minds: list[Mind] = []
        self.places: list[int] = []
        for k, controller in enumerate(dispatcher.controllers):
            member = cast[int(controller.record.owner)]
            if member.has_mind:
                self.minds.append(_mind(member, cast, controller, surroundings, seed))
                self.places.append(k)
        dispatcher.minded = frozenset(self.places)
        acting = np.array([member.acts for member in cast], dtype=bool)
        arms = {
            int(controller.record.owner): controller.record for controller in dispatcher.controllers
        }
        for mind in self.minds:
            mind.acting, mind.arms = acting, arms
        owners = np.array([mind.me for mind in self.minds], dtype=np.int64)
        self._owners = owners
        self._pain = np.zeros(len(owners))
        self._pains_now = surroundings.view.arrays.owners["pain"]
        self.cries: list[tuple[int, int, float]] = []

    @property
    def channels(self) -> tuple[Channel, ...]:
        """What of minds is kept in the take."""
        kinds = (("anxiety", "1"), ("distance", "m"), ("focus", "1"), ("gaze", "1"))
        return tuple(
            Channel(f"{mind.controller.name}.{what}", unit)
            for mind in self.minds
            for what, unit in (*kinds, ("behaviour", "1"))
        )

    def values(self) -> list[float]:
        """Return the values of the channels now.

        Focus and gaze are numbers of characters in the order of the cast, behaviours those of
        the registry; -1 is none.
        """
        found = list[float]()
        for mind in self.minds:
            focus, looks = mind.attention.focus, mind.glances.at
            found += (mind.anxiety, mind.distance, focus, looks, behaviour_number(mind.doing))
        return found

    def read(self, orders: Orders) -> None:
        """Take in what the script gives somebody a mind to."""
        for mind in self.minds:
            for do in orders.get(mind.controller.name, ()):
                if isinstance(do, SetUrges):
                    mind.biases = {} if not do.urge else {**mind.biases, **do.urge}

    def think(self, step: int, now: float) -> None:
        """Let those think whose turn it is, or who were hurt in the last step."""
        hurt = self._feel(now)
        for n, (k, mind) in enumerate(zip(self.places, self.minds, strict=True)):
            if (step + n) % self.every and n not in hurt:
                continue
            self.surroundings.look(now, self.sub_step)
            dt = now - mind.now
            mind.notice(now, dt)
            if self.dispatcher.is_told(k):
                mind.leave()
            else:
                mind.choose()
                self._act(k, mind)
                self._cry(k, mind)
            mind.look(dt)
            self.dispatcher.glance(k, mind.glances.at)

    def _cry(self, k: int, mind: Mind) -> None:
        """Let one cry that is on its way back in distress, and not in its caregiver's arms yet."""
        calm = mind.anxiety < DISTRESS or isinstance(mind.motor.task, Hug)
        if mind.doing == "attachment" and not calm and mind.now - mind.cried >= AGAIN:
            mind.cried = mind.now
            self.cries.append((k, NOBODY, WHIMPER + mind.anxiety))

    def _feel(self, now: float) -> set[int]:
        """Let those feel it who were hurt in the last step; return them."""
        self.cries.clear()
        pain = self._pains_now[self._owners]
        more = pain - self._pain
        self._pain = pain
        if not len(more) or float(more.max()) <= 0.0:
            return set()
        hurt = set[int]()
        for n in np.flatnonzero(more > 0.0).tolist():
            mind, much = self.minds[n], float(more[n])
            by = self._by_whom(mind.me)
            if mind.hurt(much, by, now) and much > CRIES and now - mind.cried >= BREATH:
                mind.cried = now
                self.cries.append((self.places[n], by, loudness(much)))
            hurt.add(n)
        return hurt

    def _by_whom(self, owner: int) -> int:
        """Return whose touch was the hardest in the last step, -1 for the ground's."""
        arrays = self.surroundings.view.arrays
        first, count = (int(n) for n in arrays.owners["links"][owner])
        links = arrays.links[first : first + count]
        hardest = int(np.argmax(links["energy"]))
        return max(int(links["touched_owner"][hardest]), NOBODY)

    def _act(self, k: int, mind: Mind) -> None:
        """Hand on to the controls what a mind has chosen."""
        motor, controller, dispatcher = mind.motor, mind.controller, self.dispatcher
        me = controller.record
        me.frozen = motor.frozen
        me.pace = max(motor.pace, 0.05)
        if motor.sits:
            if not isinstance(dispatcher.errand(k), SitDown):
                dispatcher.begin(k, SitDown())
            return
        if motor.task is not None:
            if dispatcher.errand(k) is not motor.task:
                dispatcher.begin(k, motor.task)
            return
        if dispatcher.errand(k) is not None:
            dispatcher.end(k)
        _walk(mind, motor)
        for hand in range(2):
            if controller.held(hand) < 0:
                me.arm_mode[hand] = REACHING if motor.reaching else 0


def _walk(mind: Mind, motor: MotorCommand) -> None:
    """Walk, or stand, as a motor vector says."""
    controller = mind.controller
    goal = motor.goal
    if goal is not None and mind.glances.glancing and motor.facing is None and mind.anxiety > 0.2:
        # Who looks back stops for it.
        place = mind.place(mind.glances.at)
        turn = abs(_wrapped(mind.heading_to(place) - mind.heading_to(np.array(goal))))
        goal = None if turn > GLANCING_BACK else goal
    if goal is not None:
        controller.go(*goal, whom=motor.target if motor.touching else NOBODY)
    else:
        controller.stop()
        controller.record.posture = 0
    if motor.facing is not None:
        controller.record.has_facing, controller.record.facing = True, motor.facing
    elif goal is None:
        controller.record.has_facing = False


def _wrapped(angle: float) -> float:
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)


def _mind(
    member: Character,
    cast: Sequence[Character],
    controller: object,
    surroundings: Surroundings,
    seed: int,
) -> Mind:
    """Return the mind of a member."""
    asked = member.behaviours or _usual(member, cast)
    bonds = [one.attachment for one in asked if isinstance(one, Attachment)]
    bond = surroundings.view.number(bonds[0]) if bonds else NOBODY
    mind = Mind(controller, surroundings, member.traits or Traits(), bond)  # type: ignore[arg-type]
    mind.slapstick = member.slapstick
    mind.begin(generator(seed, f"{member.name}.mind"), behaviours_of(asked, mind))
    return mind


def _usual(member: Character, cast: Sequence[Character]) -> list[Urge]:
    """Return what one does of whom nothing is said but traits."""
    mine: Array = np.array([member.at[0], member.at[-1]])

    def away(other: Character) -> float:
        return float(np.hypot(*(np.array([other.at[0], other.at[-1]]) - mine)))

    others = sorted((one for one in cast if one is not member), key=away)
    balls = [Play(play=one.name) for one in others if one.character == "ball"]
    if member.character == "adult":
        return [Comfort(comfort=one.name) for one in others if one.character == "child"]
    adults = [one for one in others if one.character == "adult" and one.acts]
    return [*(Attachment(attachment=one.name) for one in adults[:1]), *balls[:1]]
