"""Telling: touches as the take has them, and who begins to touch whom."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pipeline.simulation.characters.events import Log
from pipeline.simulation.characters.layout import SOLID, TERRAIN, Crowd
from pipeline.simulation.characters.looks import MATERIALS
from pipeline.simulation.characters.making import PEOPLE
from pipeline.simulation.characters.person import LINK_NAMES
from pipeline.simulation.solid import Obstacle
from pipeline.simulation.take import Contact
from pipeline.spec.cast import Character

FEET = ("shin_l", "shin_r")
"""Whose touches of the ground are footfalls, which their steps tell of."""

BODY = "skin"
"""What people sound like."""


class Telling:
    """What of the log of a step is told.

    Attributes:
        solids: of other rooms, numbered from `SOLID` downward.
    """

    def __init__(self, cast: Sequence[Character], crowd: Crowd, surface: str) -> None:
        self.cast = cast
        self.surface = surface
        self._links = crowd.links
        self._owners = crowd.owners
        self.solids: Sequence[Obstacle] = ()

    def contacts(self, log: Log, step: int) -> tuple[Contact, ...]:
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

    def touched(self, log: Log) -> tuple[tuple[str, str], ...]:
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
            size=float(max(self._links["reach"][link, 0], 2.0 * self._links["girth"][link])),
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
