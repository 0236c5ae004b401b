"""Events of hoppers, and how a take records them as contacts and notes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.inventory import foot_materials
from pipeline.simulation.scalar_rotation import vector_tuple
from pipeline.simulation.spatial import UP, Array
from pipeline.simulation.take import Contact, ContactKind, TakeNote
from pipeline.simulation.troupe import World

HopEventKind = Literal[
    "touch", "lift", "body", "toppled", "saturated", "stopped", "misplaced", "tripped", "dropped"
]


CONTACT_KINDS: dict[str, ContactKind] = {"touch": "touch", "lift": "lift", "body": "hit"}

NOTE_KINDS = {
    "toppled": "toppled",
    "saturated": "clamped",
    "stopped": "stopped",
    "misplaced": "misplaced",
    "tripped": "tripped",
    "dropped": "dropped",
}


@dataclass(frozen=True, eq=False)
class HopEvent:
    """An event.

    Attributes:
        kind: of event.
        time: [s].
        leg: number of the leg, -1 for the body.
        place: (3,) [m].
        normal: (3,) of the ground.
        speed: along the normal [m/s].
        energy: kinetic energy of the moving mass at that speed [J].
        text: of the note.
        link: number of the link, for events of the body.
    """

    kind: HopEventKind
    time: float
    leg: int
    place: Array
    normal: Array
    speed: float
    energy: float
    text: str = ""
    link: int = 0

    @staticmethod
    def note(kind: HopEventKind, time: float, text: str, leg: int = -1) -> HopEvent:
        """Return an event that a take records as a note."""
        return HopEvent(kind, time, leg, np.zeros(3), UP, 0.0, 0.0, text)


HopEvents = list[HopEvent]
"""Events in the order of time."""


class HopEventRecorder:
    """Converts the events of a herd to the contacts and notes of a take.

    Attributes:
        herd: the creatures.
        world: of the simulation.
        materials: of each creature's links that name none.
    """

    def __init__(self, herd: Herd, world: World, materials: Sequence[str]) -> None:
        self.herd, self.world, self.materials = herd, world, list(materials)
        self._feet = foot_materials(herd, materials)

    def part(self, leg: int) -> str:
        """Return the part name of a leg."""
        return f"{self.herd.names[self.herd.owner[leg]]}.{self.herd.leg_names[leg]}"

    def records(
        self, step: int, c: int, events: Iterable[HopEvent]
    ) -> tuple[list[Contact], list[TakeNote]]:
        """Return the contacts and notes of creature `c` in a step."""
        contacts, notes = list[Contact](), list[TakeNote]()
        for event in events:
            record = self._record(step, c, event)
            if isinstance(record, TakeNote):
                notes.append(record)
            else:
                contacts.append(record)
        return contacts, notes

    def _record(self, step: int, c: int, event: HopEvent) -> Contact | TakeNote:
        herd, name = self.herd, self.herd.names[c]
        link = herd.figures[c].skeleton.links[event.link]
        leg = int(herd.first_leg[c]) + event.leg
        part = f"{name}.{link.name}" if event.leg < 0 else self.part(leg)
        if event.kind in NOTE_KINDS:
            return TakeNote(NOTE_KINDS[event.kind], step, part, event.text)
        dt = self.world.clock.dt
        fraction = min(max(event.time / dt - step, 0.0), float(np.nextafter(1.0, 0.0)))
        body = link.material or self.materials[c]
        length = self._length(c, event.link)
        return Contact(
            step=step,
            fraction=fraction,
            performer=name,
            part=part,
            other="terrain",
            place=vector_tuple(event.place),
            normal=vector_tuple(event.normal),
            speed=event.speed,
            energy=event.energy,
            material=body if event.leg < 0 else self._feet[leg],
            surface=self.world.ground.material,
            size=length if event.leg < 0 else float(herd.legs.lengths[leg]),
            kind=CONTACT_KINDS[event.kind],
        )

    def _length(self, c: int, link: int) -> float:
        figure = self.herd.figures[c]
        return next(piece.size for piece in figure.pieces if piece.link == link)
