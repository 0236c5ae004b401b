"""Step report: what a step tells: contacts, pains, cries and hugs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.body_arrays import SOLID, TERRAIN, CharacterArrays
from pipeline.simulation.characters.character_plans import LINK_NAMES, PEOPLE
from pipeline.simulation.characters.contact_response import TouchLog
from pipeline.simulation.characters.hug_tasks import HUG, Hug
from pipeline.simulation.characters.pain_rise import PainRise
from pipeline.simulation.characters.person_record import HEAD, SHOULDERS
from pipeline.simulation.characters.playthings import DECK_MATERIAL, MATERIALS
from pipeline.simulation.characters.queue_task import QueueUp
from pipeline.simulation.characters.task_dispatcher import TaskDispatcher
from pipeline.simulation.dynamics.compiled import Record
from pipeline.simulation.obstacles import Obstacle
from pipeline.simulation.signals import Signal
from pipeline.simulation.take import Contact
from pipeline.spec.character import Character

FOOTFALL_LINKS = ("shin_l", "shin_r")
"""Links of acting people whose touches of the ground are reported as footfalls."""

LATEST = math.nextafter(1.0, 0.0)
"""Greatest fraction of a step."""

SKIN = "skin"
"""Sound material of people."""


@dataclass(frozen=True)
class CryLimits:
    """When pain is told and cried out, and how loud.

    Attributes:
        pain: of a step that is a signal.
        cry: pain of a step that is cried out.
        faintest: strength of the faintest cry [m/s].
        per_pain: strength added by pain [m/s].
        loudest: strength of the loudest cry [m/s].
        throat: size of what sounds in a cry, in heights.
    """

    pain: float = 0.2
    cry: float = 0.4
    faintest: float = 1.0
    per_pain: float = 1.5
    loudest: float = 5.0
    throat: float = 0.1


CRY = CryLimits()

HUG_SOUND_SIZE = 0.15  # of a chest, in heights
# Of arms that go from beside a partner to its back, in heights of the partner [1/s].
ARM_CLOSING_SPEED = 0.13 / HUG.closing_time


def loudness(pain: float) -> float:
    """Return the strength of a cry for the pain of a blow [m/s]."""
    return min(CRY.faintest + CRY.per_pain * pain, CRY.loudest)


def hardest_toucher(arrays: CharacterArrays, owner: int) -> int:
    """Return the owner of the link whose touch was the hardest in the last step, -1 for none."""
    first, count = (int(n) for n in arrays.owners["links"][owner])
    links = arrays.links[first : first + count]
    return int(links["touched_owner"][int(np.argmax(links["energy"]))])


class ContactReporter:
    """The touch log of a step as contacts of the take.

    Attributes:
        solids: of other rooms, numbered from `SOLID` downward.
        surface: material of the terrain.
    """

    def __init__(self, cast: Sequence[Character], arrays: CharacterArrays, surface: str) -> None:
        self.solids: Sequence[Obstacle] = ()
        self._cast, self.surface = cast, surface
        self._links, self._owners = arrays.links, arrays.owners

    def contacts(self, log: TouchLog, step: int) -> tuple[Contact, ...]:
        """Return the touches of a step, except for the feet of walkers."""
        if not log.filled.item(0):
            return ()
        found = []
        for event in log.events[: log.filled[0]]:
            member = self._member(int(event["link"]))
            name = self._link_name(member, int(event["link"]))
            if event["other"] == TERRAIN and member.acts and name in FOOTFALL_LINKS:
                continue
            found.append(self._contact(event, member, name, step))
        return tuple(found)

    def touched(self, log: TouchLog) -> tuple[tuple[str, str], ...]:
        """Return the pairs of performers that began to touch in a step."""
        if not log.filled.item(0):
            return ()
        pairs = dict[tuple[str, str], None]()
        for event in log.events[: log.filled[0]]:
            other = int(event["other"])
            if other == TERRAIN:
                continue
            is_solid = other <= SOLID
            name = self.solids[SOLID - other].performer if is_solid else self._member(other).name
            pairs[self._member(int(event["link"])).name, name] = None
        return tuple(pairs)

    def _contact(self, event: Record, member: Character, name: str, step: int) -> Contact:
        link, other = int(event["link"]), int(event["other"])
        other_name, surface = self._touched_thing(other)
        x, y, z = (float(c) for c in event["place"])
        u, v, w = (float(c) for c in event["normal"])
        length, diameter = self._links["length_limits"][link, 0], 2.0 * self._links["radius"][link]
        return Contact(
            step=step,
            fraction=min(float(event["moment"]), LATEST),
            performer=member.name,
            part=f"{member.name}.{name}" if name else member.name,
            other=other_name,
            place=(x, y, z),
            normal=(u, v, w),
            speed=float(event["speed"]),
            energy=float(event["energy"]),
            material=_material(member),
            surface=surface,
            size=float(max(length, diameter)),
            kind="hit",
        )

    def deck_below(self, person: Record) -> tuple[str, str]:
        """Return the name and the material of the deck that a person stands on."""
        if person.deck >= 0:
            return self._cast[int(person.deck)].name, DECK_MATERIAL
        solid = self.solids[SOLID - int(person.deck)]
        return solid.name, solid.material

    def _member(self, link: int) -> Character:
        return self._cast[int(self._links["owner"][link])]

    def _touched_thing(self, other: int) -> tuple[str, str]:
        if other == TERRAIN:
            return "terrain", self.surface
        if other <= SOLID:
            solid = self.solids[SOLID - other]
            return solid.name, solid.material
        member = self._member(other)
        return member.name, _material(member)

    def _link_name(self, member: Character, link: int) -> str:
        """Return the name of a person's link, "" for a thing's."""
        if member.character not in PEOPLE:
            return ""
        first = int(self._owners["links"][self._links["owner"][link], 0])
        return LINK_NAMES[link - first] if link - first < len(LINK_NAMES) else ""


def _material(member: Character) -> str:
    return member.material or MATERIALS.get(member.character, SKIN)


class Voice(NamedTuple):
    """A sound that a person with a mind makes.

    Attributes:
        kind: of the signal.
        k: index of the controller.
        cause: number of the character that caused it, -1 for none.
        strength: [m/s].
    """

    kind: str
    k: int
    cause: int
    strength: float


class SignalDetector:
    """The onsets of pains, voices and hugs of all acting people of a troupe.

    Args:
        dispatcher: of their tasks.
        pains: of the people.
    """

    def __init__(self, dispatcher: TaskDispatcher, pains: PainRise) -> None:
        self._dispatcher, self._pain = dispatcher, pains
        self._hugged = dict[int, Hug]()
        self._served = dict[int, QueueUp]()

    def signals(self, voices: Sequence[Voice] = ()) -> tuple[Signal, ...]:
        """Return the signals that began in the last step.

        Args:
            voices: of people with a mind.
        """
        hugs, services = self._dispatcher.busy(Hug), self._dispatcher.busy(QueueUp)
        is_quiet = not (voices or hugs or services or self._hugged or self._served)
        if is_quiet and self._pain.largest <= CRY.pain:
            return ()
        found = list(self._pains()) if self._pain.largest > CRY.pain else []
        found += [self._voiced(voice) for voice in voices]
        if self._hugged or hugs:
            found += self._hugs()
        if self._served or services:
            found += self._services()
        return tuple(found)

    def _pains(self) -> Iterator[Signal]:
        view, added = self._dispatcher.view, self._pain.added
        for k in np.flatnonzero(added > CRY.pain).tolist():
            owner = int(self._dispatcher.controllers[k].record.owner)
            cause = hardest_toucher(view.arrays, owner)
            name = view.names[cause] if cause >= 0 else ""
            pain = float(added[k])
            yield Signal("pain", self._dispatcher.controllers[k].name, name)
            if pain > CRY.cry and k not in self._dispatcher.minded:
                yield self._voiced(Voice("cry", k, cause, loudness(pain)))

    def _voiced(self, voice: Voice) -> Signal:
        return self._sounding(*voice[:3], "head", voice.strength, CRY.throat)

    def _hugs(self) -> Iterator[Signal]:
        before, self._hugged = self._hugged, {}
        for k, task in self._dispatcher.busy(Hug):
            if task.touched > HUG.closing_time:
                if task is not before.get(k):
                    strength = ARM_CLOSING_SPEED * task.size
                    yield self._sounding("hug", k, task.owner, "chest", strength, HUG_SOUND_SIZE)
                self._hugged[k] = task

    def _services(self) -> Iterator[Signal]:
        before, self._served = self._served, {}
        for k, task in self._dispatcher.busy(QueueUp):
            if task.is_served:
                if task is not before.get(k):
                    yield Signal("served", self._dispatcher.controllers[k].name, task.target)
                self._served[k] = task

    def _sounding(
        self, kind: str, k: int, other: int, part: str, strength: float, heights: float
    ) -> Signal:
        """Return a signal that sounds at a part, of a size in heights."""
        controller, view = self._dispatcher.controllers[k], self._dispatcher.view
        joint = HEAD if part == "head" else SHOULDERS
        x, y, z = view.nodes(int(controller.record.owner))[joint].tolist()
        name, size = controller.name, heights * float(controller.record.height)
        other_name = view.names[other] if other >= 0 else ""
        return Signal(kind, name, other_name, f"{name}.{part}", (x, y, z), strength, size)
