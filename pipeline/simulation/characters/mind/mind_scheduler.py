"""Mind scheduler: updates the minds of a troupe in turn.

Source: Horswill 2008, "High-level Control".
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from types import MappingProxyType

import numpy as np

from pipeline.simulation.characters.behaviours.registry import (
    behaviour_number,
    behaviours_of,
)
from pipeline.simulation.characters.body_arrays import NOBODY, IntArray
from pipeline.simulation.characters.carousel_pose import way_off_deck
from pipeline.simulation.characters.gestures import Gestures
from pipeline.simulation.characters.hug_tasks import Hug
from pipeline.simulation.characters.mind.consent import Consent
from pipeline.simulation.characters.mind.felt_emotions import show_feelings
from pipeline.simulation.characters.mind.mind import Mind
from pipeline.simulation.characters.mind.mind_arrays import MindArrays, mind_arrays
from pipeline.simulation.characters.mind.motor_command import MotorCommand
from pipeline.simulation.characters.mind.own_gestures import OwnGestures
from pipeline.simulation.characters.mind.perception import Surroundings, notice
from pipeline.simulation.characters.mind.walk_command import write_manner, write_walk_command
from pipeline.simulation.characters.pain_rise import PainRise
from pipeline.simulation.characters.person_tasks import SitDown
from pipeline.simulation.characters.step_report import CRY, Voice, hardest_toucher, loudness
from pipeline.simulation.characters.task_dispatcher import TaskDispatcher
from pipeline.simulation.dynamics.compiled import Records, bound
from pipeline.simulation.script import Orders
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Channel
from pipeline.spec.behaviour import Accompany, Attachment, Comfort, Play, Traits, Urge
from pipeline.spec.character import Character, companions_of
from pipeline.spec.expression import EMOTIONS
from pipeline.spec.relations import Attitudes
from pipeline.spec.script import SetUrges

CHANNELS = (
    *(("anxiety", "1"), ("distance", "m"), ("focus", "1"), ("gaze", "1")),
    ("behaviour", "1"),
)
"""Names and units of what the take tells of a mind."""

THINKING_INTERVAL = 0.125  # of a mind, about [s]
DISTRESS_ANXIETY = 0.5  # from which a child that returns to its caregiver cries
DISTRESS_CRY_INTERVAL = 3.0  # [s]
MIN_CRY_INTERVAL = 0.8  # [s]
FEARFUL = ("withdrawal", "flee")  # behaviours that begin with a gasp
GASP_INTERVAL = 3.0  # [s]
MERRY_ANXIETY = 0.35  # below which a child at play laughs
LAUGH_INTERVAL = 6.0  # on average, at play [s]
STOPPING_ANXIETY = 0.2  # from which one stops to glance back
GLANCING_BACK_ANGLE = 1.2  # from the way, beyond which one does [rad]


class MindScheduler:
    """All minds of a troupe.

    Args:
        cast: all characters.
        dispatcher: of tasks, through which minds act.
        persons: `PERSON` records.
        surroundings: all characters as they are seen.
        seed: of the scene.
        dt: a step [s].
        sub_step: [s].
        pains: of all acting people.
        attitudes: of people towards others, by the relations of the story.

    Attributes:
        voices: of the last step.
        felt: (P, 6) emotions of all acting people, zero for those without a mind.
    """

    def __init__(
        self,
        cast: Sequence[Character],
        dispatcher: TaskDispatcher,
        persons: Records,
        surroundings: Surroundings,
        seed: int,
        dt: float,
        sub_step: float,
        pains: PainRise,
        attitudes: Attitudes = MappingProxyType({}),
    ) -> None:
        self.voices: list[Voice] = []
        self._dispatcher, self._surroundings, self._persons = dispatcher, surroundings, persons
        self._sub_step, self._interval = sub_step, max(round(THINKING_INTERVAL / dt), 1)
        acting = np.array([member.acts for member in cast], dtype=bool)
        records = {int(person.record.owner): person.record for person in dispatcher.controllers}
        members = [cast[int(person.record.owner)] for person in dispatcher.controllers]
        self._indices = [k for k, member in enumerate(members) if member.has_mind]
        minded = [members[k] for k in self._indices]
        configs = [
            [*(member.behaviours or _default_behaviours(member, cast)), *_company(member, cast)]
            for member in minded
        ]
        self._arrays = _arrays_of(minded, configs, self._indices, dispatcher, surroundings)
        _feel_attitudes(self._arrays, minded, surroundings, attitudes)
        self.minds = [
            Mind(
                dispatcher.controllers[k],
                surroundings,
                self._arrays,
                n,
                traits=member.traits or Traits(),
                slapstick=member.slapstick,
                rng=generator(seed, f"{member.name}.mind"),
                acting=acting,
                records=records,
            )
            for n, (k, member) in enumerate(zip(self._indices, minded, strict=True))
        ]
        for mind, urges in zip(self.minds, configs, strict=True):
            mind.behaviours = behaviours_of(urges, mind)
        self._laughter = [
            generator(seed, f"{mind.controller.name}.laughter") for mind in self.minds
        ]
        for k in self._indices:
            self._put_off_laugh(k, 0.0)
        consents = map(Consent, self.minds)
        dispatcher.minded = dict(zip(self._indices, consents, strict=True))
        self.felt: Array = np.zeros((len(members), len(EMOTIONS)))
        # Of the channels: nobody is looked at, and nothing done yet.
        self._values = np.full((len(self.minds), len(CHANNELS)), float(NOBODY))
        everybody = np.arange(len(self.minds))
        show_feelings(self._arrays, np.zeros_like(self.felt), self._values, everybody)
        self._numbers = self._arrays.minds["delight"], self._values[:, 3], self._values[:, 4]
        self._pains = pains
        self._own_gestures = OwnGestures(
            dict(zip(self._indices, self.minds, strict=True)),
            {
                k: self._friends(member, cast, attitudes)
                for k, member in zip(self._indices, minded, strict=True)
            },
            *(dispatcher, self._values, self.felt),
        )

    def _friends(
        self, member: Character, cast: Sequence[Character], attitudes: Attitudes
    ) -> set[int]:
        """Return the numbers of the friends of a character: by a relation, or companions."""
        names = {one.accompany for one in _company(member, cast)}
        names.update(
            other
            for (who, other), several in attitudes.items()
            if who == member.name and any(attitude.interest > 0.0 for attitude in several)
        )
        return {self._surroundings.view.number(name) for name in names}

    def gesture(self, gestures: Gestures, now: float) -> None:
        """Let minds begin gestures of their own at a time [s]."""
        self._own_gestures.advance(gestures, now)

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Channels of the take."""
        return tuple(
            Channel(f"{mind.controller.name}.{kind}", unit)
            for mind in self.minds
            for kind, unit in CHANNELS
        )

    def values(self) -> Array:
        """Return the values of the channels now.

        Focus and gaze are numbers of characters in the order of names, behaviours those of
        the scene language; -1 is none.
        """
        return self._values.flatten()

    def feelings(self) -> dict[str, dict[str, float]]:
        """Return what each mind feels now, by the names of `Feeling`."""
        return {
            mind.controller.name: {
                **dict(zip(EMOTIONS, self.felt[k].tolist(), strict=True)),
                "anxiety": mind.anxiety,
            }
            for k, mind in zip(self._indices, self.minds, strict=True)
        }

    def read(self, orders: Orders) -> None:
        """Accept the urges that the script sets."""
        for mind in self.minds if orders else ():
            for order in orders.get(mind.controller.name, ()):
                if isinstance(order, SetUrges):
                    mind.biases = {} if not order.urge else {**mind.biases, **order.urge}

    def think(self, step: int, now: float) -> None:
        """Let the minds think whose turn it is, or that were hurt in the last step."""
        hurt = self._feel_blows(now)
        turns = list(range(-step % self._interval, len(self.minds), self._interval))
        if hurt:
            turns = sorted(hurt.union(turns))
        if not turns:
            return
        numbers = np.array(turns)
        self._notice(turns, numbers, now)
        ordered, giving = self._dispatcher.is_ordered, self._dispatcher.giving
        delights, gazes, behaviours = self._numbers
        led = {n for n in turns if ordered(k := self._indices[n]) or k in giving}
        before = {n: self.minds[n].doing for n in turns if n not in led}
        # All choose before any of them acts, so that their order has no effect.
        for n in before:
            self.minds[n].choose()
        for n in turns:
            k, mind = self._indices[n], self.minds[n]
            if n in before:
                self._act(k, mind)
                self._cry_in_distress(k, mind)
                self._laugh_or_gasp(k, mind, before[n])
            else:
                mind.end_behaviour()
            mind.look()
            self._dispatcher.glance(k, mind.glances.at)
            delights[n], gazes[n] = mind.delight, mind.glances.at
            behaviours[n] = behaviour_number(mind.doing)
        self._show_feelings(numbers)

    def _notice(self, turns: Sequence[int], numbers: IntArray, now: float) -> None:
        """Let minds, whose numbers come twice, perceive, remember, feel and attend."""
        self._surroundings.update(now, self._sub_step)
        for n in turns:
            self.minds[n].prepare()
        self._notice_all(numbers, now)
        for n in turns:
            self.minds[n].take_over(now)

    @cached_property
    def _notice_all(self) -> Callable[[IntArray, float], None]:
        seen = self._surroundings
        known = seen.places, seen.velocities, seen.radius, seen.valence
        examples = np.arange(1), 0.0
        return bound(notice, self._arrays, self._persons, *known, examples=examples)

    @cached_property
    def _show_feelings(self) -> Callable[[IntArray], None]:
        shown = self._arrays, self.felt, self._values
        return bound(show_feelings, *shown, examples=(np.arange(1),))

    def _cry_in_distress(self, k: int, mind: Mind) -> None:
        """Let a distressed child cry on its way back, until it is in its caregiver's arms."""
        is_calm = mind.anxiety < DISTRESS_ANXIETY or isinstance(mind.command.task, Hug)
        is_due = mind.now - mind.cried >= DISTRESS_CRY_INTERVAL
        if mind.doing == "attachment" and not is_calm and is_due:
            mind.cried = mind.now
            self.voices.append(Voice("cry", k, NOBODY, CRY.faintest + mind.anxiety))

    def _laugh_or_gasp(self, k: int, mind: Mind, before: str) -> None:
        """Let a calm child laugh at play, now and then, and who takes to flight gasp first.

        Args:
            k: index of the controller.
            mind: the mind.
            before: its behaviour until now.
        """
        doing, now = mind.doing.split(" ")[0], mind.now
        takes_fright = doing in FEARFUL and doing != before.split(" ")[0]
        has_cried = now - mind.cried < MIN_CRY_INTERVAL
        if takes_fright and not has_cried and now - mind.gasped >= GASP_INTERVAL:
            mind.gasped = now
            self.voices.append(Voice("gasp", k, mind.attention.focus, CRY.faintest + mind.anxiety))
        elif doing == "play" and mind.anxiety < MERRY_ANXIETY and now >= mind.next_laugh:
            self._put_off_laugh(k, now)
            self.voices.append(Voice("laugh", k, NOBODY, CRY.faintest))

    def _put_off_laugh(self, k: int, now: float) -> None:
        """Choose when a mind laughs next; children at play do not laugh in step."""
        n = self._indices.index(k)
        self.minds[n].next_laugh = now + LAUGH_INTERVAL * (0.5 + self._laughter[n].random())

    def _feel_blows(self, now: float) -> set[int]:
        """Let minds feel the blows of the last step; return the indices of those hurt."""
        self.voices.clear()
        if self._pains.largest <= 0.0:
            return set()
        added = self._pains.added[self._indices]
        hurt = np.flatnonzero(added > 0.0).tolist()
        for n in hurt:
            mind, blow = self.minds[n], float(added[n])
            arrays = self._surroundings.view.arrays
            striker = max(hardest_toucher(arrays, mind.number_of_self), NOBODY)
            is_shock = mind.feel_blow(blow, striker, now)
            if is_shock and blow > CRY.cry and now - mind.cried >= MIN_CRY_INTERVAL:
                mind.cried = now
                self.voices.append(Voice("cry", self._indices[n], striker, loudness(blow)))
        return set(hurt)

    def _act(self, k: int, mind: Mind) -> None:
        """Command a person to do what its mind has chosen."""
        command, dispatcher, startled = mind.command, self._dispatcher, mind.command.startled
        if not command.sits and command.task is None and dispatcher.task(k) is not None:
            dispatcher.end(k)
            startled = False
        write_manner(mind.controller.record, command, startled)
        if command.sits:
            if not isinstance(dispatcher.task(k), SitDown):
                dispatcher.begin(k, SitDown())
            return
        if command.task is not None:
            if dispatcher.task(k) is not command.task:
                dispatcher.begin(k, command.task)
            return
        goal, facing = _goal_of_walk(mind, command), command.facing
        x, z = goal or (0.0, 0.0)
        self._write_command(
            *(k, goal is not None, x, z),
            command.target if command.touching else NOBODY,
            *(facing is not None, facing or 0.0, command.reaching),
        )

    @cached_property
    def _write_command(self) -> Callable[..., None]:
        examples = 0, False, 0.0, 0.0, 0, False, 0.0, False
        grips = self._surroundings.view.arrays.grips
        return bound(write_walk_command, self._persons, grips, examples=examples)


def _goal_of_walk(mind: Mind, command: MotorCommand) -> tuple[float, float] | None:
    """Return x and z of where a mind lets its person go next [m], None to stand."""
    controller, goal = mind.controller, command.goal
    glances_back = mind.glances.glancing and command.facing is None
    if goal is not None and glances_back and mind.anxiety > STOPPING_ANXIETY:
        way, place = np.array(goal), mind.place(mind.glances.at)
        turn = abs(_wrapped(mind.heading_to(place) - mind.heading_to(way)))
        goal = None if turn > GLANCING_BACK_ANGLE else goal
    if goal is not None and (first := way_off_deck(controller, goal)) is not None:
        goal = float(first[0]), float(first[1])
    return goal


def _wrapped(angle: float) -> float:
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)


def _arrays_of(
    members: Sequence[Character],
    configs: Sequence[Sequence[Urge]],
    indices: Sequence[int],
    dispatcher: TaskDispatcher,
    surroundings: Surroundings,
) -> MindArrays:
    """Return the arrays of minds.

    Args:
        members: that have minds.
        configs: behaviours of each.
        indices: of their controllers.
        dispatcher: of tasks.
        surroundings: all characters.
    """
    traits = [member.traits or Traits() for member in members]
    interest = np.array([surroundings.interest(own.curiosity) for own in traits])
    arrays = mind_arrays(surroundings.places, interest, surroundings.valence)
    minds = arrays.minds
    minds["person"] = indices
    minds["owner"] = [int(dispatcher.controllers[k].record.owner) for k in indices]
    minds["natural_anxiety"] = [own.anxiety for own in traits]
    for mind, urges in zip(minds, configs, strict=True):
        bonds = [urge.attachment for urge in urges if isinstance(urge, Attachment)]
        if bonds:
            mind.caregiver = surroundings.view.number(bonds[0])
            offset = surroundings.places[mind.caregiver] - surroundings.places[mind.owner]
            mind.caregiver_distance = math.hypot(offset[0], offset[2])
    return arrays


def _feel_attitudes(
    arrays: MindArrays,
    members: Sequence[Character],
    surroundings: Surroundings,
    attitudes: Attitudes,
) -> None:
    """Let minds, those of `members`, feel what relations make them feel towards others."""
    numbers = {member.name: n for n, member in enumerate(members)}
    for (who, other), several in attitudes.items():
        if who not in numbers:
            continue
        n, c = numbers[who], surroundings.view.number(other)
        fear = max(attitude.fear for attitude in several)
        arrays.lasting_fears[n, c] = arrays.fears[n, c] = fear
        arrays.interest[n, c] += max(attitude.interest for attitude in several)


def _default_behaviours(member: Character, cast: Sequence[Character]) -> list[Urge]:
    """Return the behaviours of a character with traits alone, towards the nearest others."""

    def distance(other: Character) -> float:
        x, z = other.at[0] - member.at[0], other.at[-1] - member.at[-1]
        return float(np.hypot(x, z))

    others = sorted((other for other in cast if other is not member), key=distance)
    balls = [Play(play=other.name) for other in others if other.character == "ball"]
    if member.character == "adult":
        return [Comfort(comfort=other.name) for other in others if other.character == "child"]
    adults = [other for other in others if other.character == "adult" and other.acts]
    return [*(Attachment(attachment=other.name) for other in adults[:1]), *balls[:1]]


def _company(member: Character, cast: Sequence[Character]) -> list[Accompany]:
    """Return what makes a character come along with its companions."""
    known = {one.accompany for one in member.behaviours if isinstance(one, Accompany)}
    return [Accompany(accompany=name) for name in companions_of(member, cast) if name not in known]
