"""Relations between people: what they make each of the two do and feel by itself."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from pipeline.spec.behaviour import Attachment, Comfort, Fight, Flee, Soothe, Urge
from pipeline.spec.character import Character
from pipeline.spec.model_base import ConfigModel, Fault, Name, keyed_union
from pipeline.spec.partial_scene import Path, cast_by_name, items_of, unknown_name, value_at
from pipeline.spec.suggestions import decided_by_key
from pipeline.spec.targets import MEMBER_TEXTS, kind_of_target

FOE_URGE = -0.25
"""Of foes to fight: only anger, or a strong aggression, makes them."""

FOE_FEAR, THREAT_FEAR = 0.3, 0.6
"""Lasting fears; from 0.25 on nobody lets the other hug it."""

FRIENDLY_INTEREST = 0.25
"""Added to the interest of friends in one another."""

OTHER, WHOSE = "of", "Whose: a child or an adult."
"""Key of the second person of a relation, after the one that selects it, and its description."""


@dataclass(frozen=True, slots=True)
class Attitude:
    """What one person feels and does towards another.

    Attributes:
        behaviours: what it does by itself.
        fear: that lasts, from 0 to 1.
        interest: added to its natural interest.
    """

    behaviours: tuple[Urge, ...] = ()
    fear: float = 0.0
    interest: float = 0.0


class RelationTo(ConfigModel):
    """A relation of one person, whom its key names, to another."""

    key: ClassVar[str]

    @property
    def who(self) -> str:
        """Name of the first person."""
        return str(getattr(self, self.key))

    @property
    def other(self) -> str:
        """Name of the second person."""
        return str(getattr(self, OTHER))

    def attitude(self) -> Attitude:
        """Return what the first person feels towards the second."""
        return Attitude()

    def attitude_back(self) -> Attitude:
        """Return what the second person feels towards the first."""
        return Attitude()


class ParentOf(RelationTo):
    """A parent: the child comes to it when anxious, and it hugs the child then."""

    key = "parent"
    parent: Name = Field(description="The parent, a child or an adult.")
    of: Name = Field(description=WHOSE)

    def attitude(self) -> Attitude:
        """See `RelationTo`."""
        return Attitude((Comfort(comfort=self.of),))

    def attitude_back(self) -> Attitude:
        """See `RelationTo`."""
        return Attitude((Attachment(attachment=self.parent),))


def _friendship(friend: str) -> tuple[Urge, ...]:
    """Return what a person does for a friend."""
    return Comfort(comfort=friend), Soothe(soothe=friend)


class FriendOf(RelationTo):
    """A friend: each attends to the other, and hugs it when it comes for a hug."""

    key = "friend"
    friend: Name = Field(description="The friend, a child or an adult.")
    of: Name = Field(description=WHOSE)

    def attitude(self) -> Attitude:
        """See `RelationTo`."""
        return Attitude(_friendship(self.of), interest=FRIENDLY_INTEREST)

    def attitude_back(self) -> Attitude:
        """See `RelationTo`."""
        return Attitude(_friendship(self.friend), interest=FRIENDLY_INTEREST)


class FoeOf(RelationTo):
    """A foe: each watches the other, refuses its hugs, and shoves it when angry."""

    key = "foe"
    foe: Name = Field(description="The foe, a child or an adult.")
    of: Name = Field(description=WHOSE)

    def attitude(self) -> Attitude:
        """See `RelationTo`."""
        return Attitude((Fight(fight=self.of, urge=FOE_URGE),), fear=FOE_FEAR)

    def attitude_back(self) -> Attitude:
        """See `RelationTo`."""
        return Attitude((Fight(fight=self.foe, urge=FOE_URGE),), fear=FOE_FEAR)


class ThreatTo(RelationTo):
    """A threat: the other is afraid of it and runs away when it comes near."""

    key = "threat"
    threat: Name = Field(description="Who frightens the other, a child or an adult.")
    of: Name = Field(description=WHOSE)

    def attitude_back(self) -> Attitude:
        """See `RelationTo`."""
        return Attitude((Flee(flee=self.threat),), fear=THREAT_FEAR)


RELATIONS: Mapping[str, type[RelationTo]] = {
    model.key: model for model in (ParentOf, FriendOf, FoeOf, ThreatTo)
}
"""Relations by the key that selects them."""

if TYPE_CHECKING:
    Relation = RelationTo
else:
    Relation = Annotated[
        keyed_union(RELATIONS, default="ParentOf"),
        decided_by_key(RELATIONS, "relation", "relations"),
    ]

Attitudes = Mapping[tuple[str, str], Sequence[Attitude]]
"""What each person, the first of a pair, feels and does towards the second."""


def attitudes_of(relations: Iterable[RelationTo]) -> Attitudes:
    """Return the attitudes that relations make."""
    found: dict[tuple[str, str], list[Attitude]] = {}
    for one in relations:
        found.setdefault((one.who, one.other), []).append(one.attitude())
        found.setdefault((one.other, one.who), []).append(one.attitude_back())
    return found


def related_behaviours(name: str, relations: Iterable[RelationTo]) -> tuple[Urge, ...]:
    """Return what relations make a person do by itself, each once, in their order."""
    found = [
        behaviour
        for (who, _), attitudes in attitudes_of(relations).items()
        if who == name
        for attitude in attitudes
        for behaviour in attitude.behaviours
    ]
    return tuple(one for k, one in enumerate(found) if one not in found[:k])


def with_behaviours(member: Character, behaviours: Sequence[Urge]) -> Character:
    """Return a person that does more by itself, unless it does so already; these come first."""
    more = tuple(one for one in behaviours if one not in member.behaviours)
    if not more:
        return member
    return member.model_copy(update={"behaviours": (*more, *member.behaviours)})


def faults_of_relations(scene: object, relations: object, path: Path) -> Iterator[Fault]:
    """Find relations of nobody, to oneself, or of what has no feelings."""
    cast = cast_by_name(scene)
    for i, relation in items_of(relations):
        key = next((key for key in RELATIONS if value_at(relation, key) is not None), None)
        if key is None:
            continue
        who, other = value_at(relation, key), value_at(relation, OTHER)
        for field, name in ((key, who), (OTHER, other)):
            if isinstance(name, str):
                yield from faults_of_person(name, cast, (*path, i, field))
        if isinstance(who, str) and who == other:
            yield Fault((*path, i, OTHER), f"'{who}' is no {key} of itself; name another")


def faults_of_person(name: str, cast: Mapping[str, object], path: Path) -> Iterator[Fault]:
    """Find a name that is not that of a child or an adult that acts."""
    if name not in cast:
        yield unknown_name(name, cast, path)
        return
    kind = kind_of_target(cast[name])
    if kind not in ("child", "adult", "unknown"):
        yield Fault(path, f"'{name}' is {MEMBER_TEXTS[kind]}; name a child or an adult")
    elif value_at(cast[name], "limp") is True:
        yield Fault(path, f"'{name}' is limp, and feels nothing; remove limp there")


def people_with_minds(scene: object) -> set[str]:
    """Return the names of the people that act by themselves: by traits, relations or goals."""
    story = value_at(scene, "story")
    found = {
        name
        for name, member in cast_by_name(scene).items()
        if value_at(member, "behaviours") or value_at(member, "traits") is not None
    }
    for _, relation in items_of(value_at(story, "relations")):
        found.update(
            name for key in (*RELATIONS, OTHER) if isinstance(name := value_at(relation, key), str)
        )
    for _, goal in items_of(value_at(story, "goals")):
        if isinstance(who := value_at(goal, "who"), str):
            found.add(who)
    return found
