"""Happening: what is known of an event of a pronker."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.inventory import foot_materials
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, ContactKind, Note
from pipeline.simulation.troupe import World

HopEventKind = Literal[
    "touch", "lift", "body", "toppled", "saturated", "stopped", "misplaced", "tripped", "dropped"
]


@dataclass(frozen=True, eq=False)
class HopEvent:
    """An event.

    Attributes:
        kind: of it.
        time: when [s].
        leg: whose foot it is, -1 for the body.
        place: (3,) where [m].
        normal: (3,) of the ground.
        speed: with which it came or went [m/s].
        energy: of what came or went at this speed [J].
        text: what there is to say.
        link: number of the link that it is about, if it is of the body.
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


HopEvents = list[HopEvent]
"""What has happened, in the order of time."""


CONTACT_KINDS: dict[str, ContactKind] = {"touch": "touch", "lift": "lift", "body": "hit"}
NOTE_KINDS = {
    "toppled": "toppled",
    "saturated": "clamped",
    "stopped": "stopped",
    "misplaced": "misplaced",
    "tripped": "tripped",
    "dropped": "dropped",
}


class HopEventRecorder:
    """What a herd's events are called in a take.

    Attributes:
        herd: to which they happen.
        world: that it is in.
        materials: of each creature, where its figure names none.
    """

    def __init__(self, herd: Herd, world: World, materials: Sequence[str]) -> None:
        self.herd, self.world, self.materials = herd, world, list(materials)
        self._feet = foot_materials(herd, materials)

    def part(self, leg: int) -> str:
        """Return what a leg is called."""
        return f"{self.herd.names[self.herd.owner[leg]]}.{self.herd.leg_names[leg]}"

    def of(
        self, step: int, c: int, happened: Iterable[HopEvent]
    ) -> tuple[list[Contact], list[Note]]:
        """Return the events of creature `c` in a step, as the take has them."""
        contacts, notes = list[Contact](), list[Note]()
        for one in happened:
            told = self._of(step, c, one)
            if isinstance(told, Note):
                notes.append(told)
            else:
                contacts.append(told)
        return contacts, notes

    def _of(self, step: int, c: int, one: HopEvent) -> Contact | Note:
        herd, name = self.herd, self.herd.names[c]
        link = herd.figures[c].skeleton.links[one.link]
        leg = int(herd.first_leg[c]) + one.leg
        part = f"{name}.{link.name}" if one.leg < 0 else self.part(leg)
        if one.kind in NOTE_KINDS:
            return Note(NOTE_KINDS[one.kind], step, part, one.text)
        dt = self.world.clock.dt
        fraction = min(max(one.time / dt - step, 0.0), float(np.nextafter(1.0, 0.0)))
        body = link.material or self.materials[c]
        length = self._length(c, one.link)
        return Contact(
            step=step,
            fraction=fraction,
            performer=name,
            part=part,
            other="terrain",
            place=_vector_tuple(one.place),
            normal=_vector_tuple(one.normal),
            speed=one.speed,
            energy=one.energy,
            material=body if one.leg < 0 else self._feet[leg],
            surface=self.world.ground.material,
            size=length if one.leg < 0 else float(herd.legs.lengths[leg]),
            kind=CONTACT_KINDS[one.kind],
        )

    def _length(self, c: int, link: int) -> float:
        """Return the size of a link [m]."""
        figure = self.herd.figures[c]
        return next(piece.size for piece in figure.pieces if piece.link == link)


def _vector_tuple(v: Array) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in v)
    return x, y, z
