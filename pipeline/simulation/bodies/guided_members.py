"""Guided members: which bodies of a troupe paths or hands may move, and the notes on them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from pipeline.simulation.bodies.body_guide import BodyGuide
from pipeline.simulation.bodies.body_instances import BodyInstance
from pipeline.simulation.bodies.prop_paths import path_of_prop
from pipeline.simulation.take import TakeNote
from pipeline.simulation.troupe import World
from pipeline.spec.body import Body, Many
from pipeline.spec.prop import Prop


@dataclass(frozen=True, eq=False)
class GuidedMember:
    """A body that is not always free.

    Attributes:
        number: of its performer in the cast.
        member: its performer.
        guide: what moves it.
    """

    number: int
    member: Body | Many | Prop
    guide: BodyGuide


def guided_members(
    cast: Sequence[tuple[int, Body | Many | Prop]],
    bodies: Sequence[BodyInstance],
    world: World,
    handled: Collection[str],
) -> list[GuidedMember]:
    """Returns the bodies that the scene holds or moves along paths, and those people may hold.

    Args:
        cast: performers with their numbers in the cast.
        bodies: of these performers.
        world: constants of the scene.
        handled: names of members that people may hold or kick.
    """
    performers = {member.name: (number, member) for number, member in cast}
    found = []
    for i, body in enumerate(bodies):
        number, member = performers[body.performer]
        path = path_of_prop(member, world) if isinstance(member, Prop) else None
        is_held = isinstance(member, Body) and bool(member.held)
        if path is not None or is_held or body.name in handled:
            found.append(GuidedMember(number, member, BodyGuide(i, path)))
    return found


def rigid_notes(bodies: Sequence[BodyInstance]) -> Iterator[TakeNote]:
    """Returns a note on each body whose soft impacts do not apply."""
    text = "soft does not apply: hands or feet may move it, and such bodies are rigid"
    for body in bodies:
        if body.model.soft > 0.0:
            yield TakeNote("rigid", 0, body.name, text)
