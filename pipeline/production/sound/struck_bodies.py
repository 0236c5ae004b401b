"""Struck bodies: shapes and point of impact of what an event sounds on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from audio.body_shape import BodyShape
from pipeline.production.sound.body_shapes import body_shape
from pipeline.production.sound.sounding_parts import RigidPart, SoundingParts
from pipeline.production.sound.strike_positions import StrikePositions
from pipeline.simulation.take import SoundEvent, Take
from pipeline.spec.body import Body, Many
from pipeline.spec.performer import Performer
from pipeline.spec.prop import Prop


@dataclass(frozen=True, slots=True)
class StruckBody:
    """What sounds in an event; None for what is unknown.

    Attributes:
        shape: of the part.
        struck_shape: of the part that it meets; None for the ground.
        spot: point of impact along the part's longest axis, 0 to 1.
    """

    shape: BodyShape | None = None
    struck_shape: BodyShape | None = None
    spot: float | None = None


def hollow_walls(cast: Iterable[Performer]) -> dict[str, float]:
    """Return the thickness of the walls of hollow bodies and props, by performer [m]."""
    walls = dict[str, float]()
    for member in cast:
        matter: object = None
        if isinstance(member, Body):
            matter = member.body
        elif isinstance(member, Prop):
            matter = member.prop
        elif isinstance(member, Many):
            matter = member.many.of
        wall = getattr(matter, "hollow", None)
        if wall is not None and member.name is not None:
            walls[member.name] = wall
    return walls


class StruckBodies:
    """Finds the bodies of the events of a take.

    Args:
        take: the recorded motion and sound events.
        walls: thickness of the walls of hollow bodies, by performer [m].
    """

    def __init__(self, take: Take, walls: Mapping[str, float]) -> None:
        self._walls = walls
        self._parts = SoundingParts(take)
        self._strikes = StrikePositions(take)
        self._shapes: dict[int, BodyShape | None] = {}

    def body(self, event: SoundEvent) -> StruckBody:
        """Return what sounds in an event."""
        part, other = self._parts.striking(event), self._parts.struck(event)
        return StruckBody(
            shape=self._shape(part),
            struck_shape=self._shape(other),
            spot=None if part is None else self._strikes.position(event, part),
        )

    def _shape(self, part: RigidPart | None) -> BodyShape | None:
        if part is None:
            return None
        if part.node not in self._shapes:
            self._shapes[part.node] = body_shape(part, self._walls.get(part.performer, 0.0))
        return self._shapes[part.node]
