"""Queues: the lines of people who wait to be served, one behind the other."""

from __future__ import annotations

from dataclasses import dataclass, field

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.spatial import Array

PITCH = 0.52  # from one person to the next, in heights of an adult
ADULT_HEIGHT = 1.72  # [m]


@dataclass(eq=False)
class Queue:
    """People in line.

    Attributes:
        places: (n, 2) where they stand, the head first [m].
        front: (2,) what the first one faces [m].
        away: (2,) unit vector from the head to the tail.
        persons: names of those in line, the first at the head.
        served: number of the character who was served last, or NOBODY.
    """

    places: Array
    front: Array
    away: Array
    persons: list[str] = field(default_factory=list)
    served: int = NOBODY

    def place(self, number: int) -> Array:
        """Return (2,) where the n-th in line stands, from 0; all others stand last [m]."""
        place: Array = self.places[min(number, len(self.places) - 1)]
        return place

    @property
    def pitch(self) -> float:
        """Distance from one person to the next [m]."""
        return PITCH * ADULT_HEIGHT


@dataclass(eq=False)
class Queues:
    """All queues of a scene.

    Attributes:
        lines: by the name of what is queued at.
    """

    lines: dict[str, Queue] = field(default_factory=dict)

    def join(self, target: str, queue: Queue, person: str) -> None:
        """Let a person join a queue at its tail; the first to do so decides where it stands."""
        self.leave(person)
        self.lines.setdefault(target, queue).persons.append(person)

    def leave(self, person: str) -> None:
        """Let a person leave the queue that it is in, if any."""
        for line in self.lines.values():
            if person in line.persons:
                line.persons.remove(person)
