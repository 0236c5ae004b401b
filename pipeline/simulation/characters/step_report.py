"""Step report."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from pipeline.simulation.characters.body_arrays import SOLID, TERRAIN, CharacterArrays
from pipeline.simulation.characters.character_plans import LINK_NAMES, PEOPLE
from pipeline.simulation.characters.contact_response import TouchLog
from pipeline.simulation.characters.contact_tasks import CLOSES, Hug
from pipeline.simulation.characters.person_record import HEAD, SHOULDERS
from pipeline.simulation.characters.playthings import MATERIALS
from pipeline.simulation.characters.task_dispatcher import TaskDispatcher
from pipeline.simulation.clock import Clock
from pipeline.simulation.dynamics.compiled import Record, Records
from pipeline.simulation.obstacles import Obstacle
from pipeline.simulation.people.proportions import SEGMENT_MASSES
from pipeline.simulation.signals import Signal
from pipeline.simulation.take import Contact
from pipeline.simulation.terrain import Ground
from pipeline.spec.character import Character

FEET = ("shin_l", "shin_r")
"""Whose touches of the ground are footfalls, which their steps tell of."""

BODY = "skin"
"""What people sound like."""


class ContactReporter:
    """What of the log of a step is told.

    Attributes:
        solids: of other rooms, numbered from `SOLID` downward.
    """

    def __init__(self, cast: Sequence[Character], arrays: CharacterArrays, surface: str) -> None:
        self.cast = cast
        self.surface = surface
        self._links = arrays.links
        self._owners = arrays.owners
        self.solids: Sequence[Obstacle] = ()

    def contacts(self, log: TouchLog, step: int) -> tuple[Contact, ...]:
        """Return the touches of a step, but for the feet of those who walk."""
        found = []
        for event in log.events[: int(log.filled[0])]:
            member = self.cast[int(self._links["owner"][event["link"]])]
            name = self._name(member, int(event["link"]))
            on_ground = event["other"] == TERRAIN
            if on_ground and member.acts and name in FEET:
                continue
            found.append(self._contact(event, member, name, step))
        return tuple(found)

    def touched(self, log: TouchLog) -> tuple[tuple[str, str], ...]:
        """Return who began to touch whom in a step."""
        pairs = dict[tuple[str, str], None]()
        for event in log.events[: int(log.filled[0])]:
            if event["other"] == TERRAIN:
                continue
            one = self.cast[int(self._links["owner"][event["link"]])].name
            pairs[one, self._whom(int(event["other"]))] = None
        return tuple(pairs)

    def _contact(self, event: object, member: Character, name: str, step: int) -> Contact:
        link, other = int(event["link"]), int(event["other"])  # type: ignore[index]
        whom, surface = self._other(other)
        x, y, z = (float(c) for c in event["place"])  # type: ignore[index]
        u, v, w = (float(c) for c in event["normal"])  # type: ignore[index]
        return Contact(
            step=step,
            fraction=min(float(event["moment"]), math.nextafter(1.0, 0.0)),  # type: ignore[index]
            performer=member.name,
            part=f"{member.name}.{name}" if name else member.name,
            other=whom,
            place=(x, y, z),
            normal=(u, v, w),
            speed=float(event["speed"]),  # type: ignore[index]
            energy=float(event["energy"]),  # type: ignore[index]
            material=_material(member),
            surface=surface,
            size=float(
                max(self._links["length_limits"][link, 0], 2.0 * self._links["radius"][link])
            ),
            kind="hit",
        )

    def _whom(self, other: int) -> str:
        """Return whom a link, or a solid of another room, belongs to."""
        if other <= SOLID:
            return self.solids[SOLID - other].performer
        return self.cast[int(self._links["owner"][other])].name

    def _other(self, other: int) -> tuple[str, str]:
        """Return what is touched, by name, and its material."""
        if other == TERRAIN:
            return "terrain", self.surface
        if other <= SOLID:
            solid = self.solids[SOLID - other]
            return solid.name, solid.material
        member = self.cast[int(self._links["owner"][other])]
        return member.name, _material(member)

    def _name(self, member: Character, link: int) -> str:
        """Return what a link of a person is called, "" for a thing's."""
        if member.character not in PEOPLE:
            return ""
        first = int(self._owners["links"][self._links["owner"][link], 0])
        return LINK_NAMES[link - first] if link - first < len(LINK_NAMES) else ""


def _material(member: Character) -> str:
    return member.material or MATERIALS.get(member.character, BODY)


LEG = SEGMENT_MASSES["thigh"] + SEGMENT_MASSES["shin"] + SEGMENT_MASSES["foot"]
"""What of a body comes down with a foot."""


def footfalls(
    persons: Records,
    names: Sequence[str],
    masses: Sequence[float],
    material: str,
    ground: Ground,
    clock: Clock,
    step: int,
) -> list[Contact]:
    """Return the footfalls since they were last asked for, and begin anew.

    Args:
        persons: records.
        names: of them.
        masses: of them [kg].
        material: of their shoes.
        ground: the terrain.
        clock: of the scene.
        step: that was taken.
    """
    found = []
    for n, k in np.argwhere(persons["touchdowns"]).tolist():
        found.append(
            _contact(persons[n], k, names[n], masses[n] * LEG, material, ground, clock, step)
        )
    persons["touchdowns"], persons["report_time"] = 0, 0.0
    return found


def _contact(
    person: Record,
    k: int,
    name: str,
    mass: float,
    material: str,
    ground: Ground,
    clock: Clock,
    step: int,
) -> Contact:
    x, y, z = (float(c) for c in person.stance_place[k])
    normal = ground.field.normal(np.asarray(x), np.asarray(z))
    speed = float(person.touchdown_speed[k])
    fraction = min(
        max(float(person.touchdown_time[k]) / clock.dt, 0.0), float(np.nextafter(1.0, 0.0))
    )
    return Contact(
        step=step,
        fraction=fraction,
        performer=name,
        part=f"{name}.foot_{'lr'[k]}",
        other="terrain",
        place=(x, y - float(person.ankle), z),
        normal=(float(normal[0]), float(normal[1]), float(normal[2])),
        speed=speed,
        energy=0.5 * mass * speed * speed,
        material=material,
        surface=ground.material,
        size=float(person.thigh + person.shin),
        kind="touch",
    )


HURTS = 0.2
"""Pain of a step that is told of, in what is just felt as pain."""

CRIES = 0.4
"""Pain of a step that is cried out for."""

WHIMPER, LOUDER, SCREAM = 1.0, 1.5, 5.0
"""Strength of the faintest cry, what pain adds, and of the loudest [m/s]."""

THROAT, BREAST = 0.1, 0.15
"""Sizes of what is heard in a cry and in a hug, in heights."""

CLOSING = 0.13 / CLOSES
"""How fast arms close, in heights of whom they close around [1/s]."""


def loudness(pain: float) -> float:
    """Return the strength of a cry for a blow that hurts so much [m/s]."""
    return min(WHIMPER + LOUDER * pain, SCREAM)


class SignalDetector:
    """Pains, cries and hugs of all people of a troupe, each told of when it begins."""

    def __init__(self, dispatcher: TaskDispatcher) -> None:
        self.dispatcher = dispatcher
        self._owners = [int(controller.record.owner) for controller in dispatcher.controllers]
        self._pain = np.zeros(len(self._owners))
        self._pains_now = dispatcher.view.arrays.owners["pain"]
        self._hugged: list[Hug | None] = [None for _ in self._owners]

    def of_step(self, cries: Sequence[tuple[int, int, float]] = ()) -> tuple[Signal, ...]:
        """Return what has begun in the last step.

        Args:
            cries: of those who have a mind: numbers of the controller and of the character by whom,
                -1 for nobody; and strength [m/s].
        """
        return (*self._pains(), *(self._cry(*cry) for cry in cries), *self._hugs())

    def _pains(self) -> Iterator[Signal]:
        view = self.dispatcher.view
        before, self._pain = self._pain, self._pains_now[self._owners]
        more = self._pain - before
        if not len(more) or float(more.max()) <= HURTS:
            return
        owners, links = view.arrays.owners, view.arrays.links
        for k in np.flatnonzero(more > HURTS).tolist():
            first, count = (int(n) for n in owners["links"][self._owners[k]])
            own = links[first : first + count]
            by = int(own["touched_owner"][int(np.argmax(own["energy"]))])
            whom = view.names[by] if by >= 0 else ""
            much = float(self._pain[k] - before[k])
            yield Signal("pain", self.dispatcher.controllers[k].name, whom)
            if much > CRIES and k not in self.dispatcher.minded:
                yield self._cry(k, by, loudness(much))

    def _cry(self, k: int, by: int, strength: float) -> Signal:
        size = THROAT * float(self.dispatcher.controllers[k].record.height)
        return self._voice("cry", k, by, "head", strength, size)

    def _voice(self, kind: str, k: int, by: int, part: str, strength: float, size: float) -> Signal:
        controller, view = self.dispatcher.controllers[k], self.dispatcher.view
        joint = HEAD if part == "head" else SHOULDERS
        x, y, z = view.nodes(int(controller.record.owner))[joint].tolist()
        whom = view.names[by] if by >= 0 else ""
        return Signal(
            kind, controller.name, whom, f"{controller.name}.{part}", (x, y, z), strength, size
        )

    def _hugs(self) -> Iterator[Signal]:
        for k in range(len(self.dispatcher.controllers)):
            errand = self.dispatcher.errand(k)
            hug = errand if isinstance(errand, Hug) and errand.touched > CLOSES else None
            if hug is not None and hug is not self._hugged[k]:
                size = BREAST * float(self.dispatcher.controllers[k].record.height)
                yield self._voice("hug", k, hug.owner, "chest", CLOSING * hug.size, size)
            self._hugged[k] = hug
