"""Cast: who is in a scene, where they start and what they do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, Self, TypeGuard

from pydantic import Discriminator, Field, Tag, model_validator

from pipeline.spec.behaviour import Behaviour, Traits
from pipeline.spec.body import BodyWords
from pipeline.spec.character import HANDS, PEOPLE, Kind
from pipeline.spec.dancer import BuildOrName, DancerWords
from pipeline.spec.dancer_orders import faults_of_posing
from pipeline.spec.driving import ForceWords, Speed, VelocityKey, VelocityWords
from pipeline.spec.faults import Fault, refuse
from pipeline.spec.group import Fire, GroupWords
from pipeline.spec.keyframes import (
    Keyframe,
    Rates,
    Turn,
    faults_of_order,
    faults_of_tangents,
)
from pipeline.spec.many import ManyWords
from pipeline.spec.mood import MoodMix
from pipeline.spec.pose import PoseKey
from pipeline.spec.pronk import ITINERARY, Pronk
from pipeline.spec.prop import Hold, Shape
from pipeline.spec.values import Coordinate, Length, Name, Number, Target, Words
from pipeline.spec.walk import Walk
from render.config.base import TURN_DESCRIPTION

MOST_KEYS = 10_000
"""Keyframes of one performer."""

Velocity = tuple[Speed, Speed, Speed]

At = Annotated[tuple[Coordinate, ...], Field(min_length=2, max_length=3)]


class Performer(Words):
    """What all members of a cast have."""

    name: Name = Field(
        "", description="What it is called; after what it is if left out.", validate_default=False
    )
    heading_deg: Number = Field(
        0.0,
        ge=-3600,
        le=3600,
        description="Where it looks: 0 along +X, positive turns about +Y [degrees].",
    )
    material: Name | None = Field(
        None, description="Material of all its parts that name none, by name."
    )
    parent: str | None = Field(
        None,
        min_length=1,
        max_length=200,
        description="What it goes along with: a performer, or one of its links or nodes as "
        "bug.head; its place is then relative to that.",
    )


def _keyed(velocity: VelocityWords | None) -> TypeGuard[tuple[VelocityKey, ...]]:
    return velocity is not None and isinstance(velocity[0], VelocityKey)


class Creature(Performer):
    """A jointed figure that walks, hops or stands."""

    figure: Name = Field(
        description="Its figure: from this file, from a file of that name beside it or in "
        "figures/ beside it, or from the shipped library."
    )
    at: At = Field(
        (0.0, 0.0),
        description="Where it starts, [x, z] on the ground; on a parent [x, z], or [x, y, z] "
        "with the height that it stands at; who hops may begin in the air, [x, y, z] with the "
        "height of its feet above the ground [m].",
    )
    scale: Length = Field(1.0, description="Factor on all lengths of the figure.")
    walk: Walk | None = Field(None, description="How it walks; it stands still if left out.")
    pronk: Pronk | None = Field(
        None,
        description="How it hops, instead of walking; with walk, how it jumps when it is told to.",
    )
    mood: MoodMix = Field(
        {}, description="A mood by name, or weights of several: how it walks and carries itself."
    )
    look_at: Target | None = Field(
        None,
        description="What it looks at, as far as its neck turns: another creature, or a place "
        "[x, y, z] [m]; where it goes if left out.",
    )
    pose: Annotated[tuple[PoseKey, ...], Field(max_length=MOST_KEYS)] = Field(
        (),
        description="What its joints and limbs are to do, over or instead of walking; the keys of "
        "different limbs may stand in any order.",
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        faults = []
        if self.parent is None and len(self.at) == 3 and (self.pronk is None or self.walk):
            faults.append(Fault(("at",), "a creature stands on the ground: give [x, z]"))
        if self.pronk is not None:
            faults += self._faults_of_hopping()
        if self.parent is not None and self.walk is not None:
            message = "who walks does so on the ground; take parent or walk away"
            faults.append(Fault(("walk",), message, at_key=True))
        refuse(faults)
        return self

    def _faults_of_hopping(self) -> Iterator[Fault]:
        if self.walk is not None:
            message = "who walks jumps when a script says so; take it away, or walk"
            for word in sorted(self.pronk.model_fields_set & ITINERARY if self.pronk else ()):
                yield Fault(("pronk", word), message, at_key=True)
        if self.parent is not None:
            message = "who hops does so on the ground; take parent or pronk away"
            yield Fault(("pronk",), message, at_key=True)
        if self.pose:
            message = "the legs of who hops are not posed; take pose or pronk away"
            yield Fault(("pose",), message, at_key=True)

    @property
    def called(self) -> str:
        """What it is called if it has no name."""
        return self.figure


class Prop(Performer):
    """A thing that moves only as its author says."""

    prop: Shape = Field(description="What it looks like.")
    at: At = Field(
        (0.0, 0.0),
        description="Where its middle is, [x, y, z]; [x, z] puts it on the ground, or on the "
        "origin of its parent [m].",
    )
    rotation_deg: Turn = Field(
        (0.0, 0.0, 0.0), description=f"How it is turned, before its heading: {TURN_DESCRIPTION}."
    )
    keyframes: Annotated[tuple[Keyframe, ...], Field(max_length=MOST_KEYS)] = Field(
        (),
        description="Where it is at certain times; they replace at, rotation_deg and heading_deg.",
    )
    repeat: bool = Field(
        False,
        description="Whether the keyframes begin again when the last is reached, which should "
        "then be as the first; a rotation may be whole turns on.",
    )
    velocity: VelocityWords | None = Field(
        None,
        description="How fast it goes from where it is at the begin, [x, y, z], or a list of "
        "velocities at certain times; relative to its parent or the world [m/s].",
    )
    spin_deg: Rates | None = Field(
        None,
        description="How it turns all the time, about x, y and z of its parent or the world "
        "[degrees/s].",
    )
    force: ForceWords | None = Field(
        None, description="What pushes and turns it, as its mass lets it."
    )
    held: Annotated[tuple[Hold, ...], Field(max_length=MOST_KEYS)] = Field(
        (), description="By whom it is held, and when."
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        faults = [
            *faults_of_order(self.keyframes, "keyframes"),
            *faults_of_tangents(self.keyframes, "keyframes"),
            *self._faults_of_moving(),
        ]
        for i in range(1, len(self.held)):
            before = self.held[i - 1]
            if before.until is None or self.held[i].at < before.until:
                message = f"'{before.by}' still holds it then; let it go with `until` first"
                faults.append(Fault(("held", i, "at"), message))
        refuse(faults)
        return self

    def _faults_of_moving(self) -> Iterator[Fault]:
        ways = [word for word in ("keyframes", "velocity", "force") if getattr(self, word)]
        for word in ways[1:]:
            message = f"it is moved by its {ways[0]} already; take one of the two away"
            yield Fault((word,), message, at_key=True)
        if self.repeat and not (self.keyframes and self.keyframes[-1].at > self.keyframes[0].at):
            yield Fault(("repeat",), "needs two keyframes to go between", at_key=True)
        if self.spin_deg is not None and ways not in ([], ["velocity"]):
            message = f"it turns by its {ways[0]}; say there how"
            yield Fault(("spin_deg",), message, at_key=True)
        elif self.spin_deg is not None and _keyed(self.velocity):
            message = "give it in the keys of its velocity"
            yield Fault(("spin_deg",), message, at_key=True)
        if _keyed(self.velocity):
            yield from faults_of_order(self.velocity, "velocity")
        moving = [*ways, *(["spin_deg"] if self.spin_deg is not None else [])]
        if moving and self.held:
            message = f"what is held does not follow {moving[0]}; take one of the two away"
            yield Fault(("held",), message, at_key=True)

    @property
    def called(self) -> str:
        """What it is called if it has no name."""
        return self.prop.shape


class Body(Performer):
    """A rigid thing that falls, bounces and rolls by itself."""

    body: BodyWords = Field(description="Its shape, and what it is made of.")
    at: At = Field(
        (0.0, 0.0),
        description="Where its centre of mass begins, [x, y, z]; [x, z] puts it on the ground [m].",
    )
    rotation_deg: Turn = Field(
        (0.0, 0.0, 0.0),
        description=f"How it begins turned, before its heading: {TURN_DESCRIPTION}.",
    )
    velocity: Velocity = Field((0.0, 0.0, 0.0), description="At the begin, [x, y, z] [m/s].")
    spin_deg: Turn = Field(
        (0.0, 0.0, 0.0),
        description="How it turns at the begin, about x, y and z of the world [degrees/s].",
    )

    @model_validator(mode="after")
    def _moves_by_itself(self) -> Self:
        if self.parent is not None:
            message = "a body moves by itself; take parent away, or make it a prop"
            refuse([Fault(("parent",), message, at_key=True)])
        return self

    @property
    def called(self) -> str:
        """What it is called if it has no name."""
        return self.body.shape


class Group(Performer):
    """Many bodies that move by one rule."""

    group: GroupWords = Field(description="How many they are, and by which rule they move.")
    at: At = Field(
        (0.0, 0.0),
        description="About where they begin, [x, y, z]; [x, z] is on the ground [m].",
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.parent is not None and not isinstance(self.group, Fire):
            message = "only a fire goes along with a parent; a flock may follow somebody"
            refuse([Fault(("parent",), message, at_key=True)])
        return self

    @property
    def called(self) -> str:
        """What it is called if it has no name."""
        return self.group.rule


class Many(Performer):
    """Bodies of one kind that begin in some order and meet whatever there is."""

    many: ManyWords = Field(description="Of what, how many, and how they stand.")
    at: At = Field(
        (0.0, 0.0),
        description="The middle of the ground that they stand on, or where their row begins, "
        "[x, z]; [x, y, z] with the height that they stand at [m].",
    )
    velocity: Velocity = Field((0.0, 0.0, 0.0), description="At the begin, [x, y, z] [m/s].")

    @model_validator(mode="after")
    def _moves_by_itself(self) -> Self:
        if self.parent is not None:
            message = "bodies move by themselves; take parent away"
            refuse([Fault(("parent",), message, at_key=True)])
        return self

    @property
    def called(self) -> str:
        """What it is called if it has no name."""
        return self.many.layout


class Dancer(Performer, DancerWords):
    """A simulated torso that dances."""

    dancer: BuildOrName = Field(
        description="torso, adult or child; or how it is made, {build: adult, height: 1.8}."
    )
    at: tuple[Coordinate, Coordinate] = Field(
        (0.0, 0.0), description="Where it stands, [x, z] on the ground [m]."
    )
    pose: Annotated[tuple[PoseKey, ...], Field(max_length=MOST_KEYS)] = Field(
        (),
        description="Where hands and joints are to be at certain times, instead of dancing with "
        "that arm until it is released; waist and neck are released as trunk.",
    )

    @model_validator(mode="after")
    def _can_be_posed(self) -> Self:
        refuse([*faults_of_posing(self.pose, self.parent is not None)])
        return self

    @property
    def called(self) -> str:
        """What it is called if it has no name."""
        return "dancer"


class Character(Performer):
    """A body of nodes and links: a person, or what people play with."""

    character: Kind = Field(
        description="child and adult stand, walk, reach, hug and sit as the script tells them; "
        "a ragdoll, a ball, a merry-go-round, a box and a bench are pushed, thrown and carried."
    )
    at: At = Field(
        (0.0, 0.0),
        description="Where it begins, [x, z] on the ground; [x, y, z] in the air, with the height "
        "of its lowest place, if it is none who holds itself [m].",
    )
    scale: Annotated[Number, Field(ge=0.2, le=5)] = Field(
        1.0, description="Factor on all its lengths; its mass goes by the third power."
    )
    limp: bool = Field(
        False, description="Whether a child or an adult lets itself go: it holds nothing and falls."
    )
    rotation_deg: Turn = Field(
        (0.0, 0.0, 0.0),
        description="How what does not hold itself begins turned, before its heading: "
        f"{TURN_DESCRIPTION}.",
    )
    velocity: Velocity = Field(
        (0.0, 0.0, 0.0),
        description="Of what does not hold itself, at the begin, [x, y, z] [m/s].",
    )
    spin_deg: Turn = Field(
        (0.0, 0.0, 0.0),
        description="How what does not hold itself turns at the begin, about x, y and z of the "
        "world [degrees/s].",
    )

    pose: Annotated[tuple[PoseKey, ...], Field(max_length=MOST_KEYS)] = Field(
        (), description="Where hands are to be at certain times, over what else it does."
    )
    traits: Traits | None = Field(
        None,
        description="How a child or an adult is minded; who has traits or behaviours acts by "
        "itself.",
    )
    behaviours: Annotated[tuple[Behaviour, ...], Field(max_length=200)] = Field(
        (),
        description="What it does by itself, the most pressing first; who has traits alone plays "
        "with the nearest ball and is attached to the nearest adult, or hugs children who come.",
    )
    slapstick: bool = Field(
        False, description="Whether it runs into those whom it hugs instead of slowing down."
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        faults = []
        for word in ("traits", "behaviours", "slapstick"):
            if getattr(self, word) and not self.acts:
                message = f"a {self.character} that holds nothing has no mind; take this away"
                faults.append(Fault((word,), message, at_key=True))
        if self.parent is not None:
            message = "a character moves by itself; take parent away, or let it be grabbed"
            faults.append(Fault(("parent",), message, at_key=True))
        if self.limp and self.character not in PEOPLE:
            message = f"a {self.character} never holds itself; take this away"
            faults.append(Fault(("limp",), message, at_key=True))
        if self.acts:
            message = "who stands by itself cannot begin so; take this away, or give limp: true"
            for word in ("rotation_deg", "spin_deg", "velocity"):
                if getattr(self, word) != (0.0, 0.0, 0.0):
                    faults.append(Fault((word,), message, at_key=True))
            if len(self.at) == 3:
                message = "who stands by itself stands on the ground: give [x, z], or limp: true"
                faults.append(Fault(("at",), message))
        faults += self._faults_of_pose()
        refuse(faults)
        return self

    def _faults_of_pose(self) -> Iterator[Fault]:
        if self.pose and not self.acts:
            message = "it does not hold itself, and so holds no pose; take this away"
            yield Fault(("pose",), message, at_key=True)
        message = "of a person hands are posed: give limb arm_l or arm_r and reach, or release"
        for k, key in enumerate(self.pose):
            for word in ("aim", "turn_deg", "joints", "body"):
                if getattr(key, word) is not None:
                    yield Fault(("pose", k, word), message, at_key=True)
            for word in ("limb", "node", "release"):
                if getattr(key, word) not in (None, *HANDS):
                    yield Fault(("pose", k, word), message)

    @property
    def acts(self) -> bool:
        """Whether it holds itself, and does what it is told."""
        return self.character in PEOPLE and not self.limp

    @property
    def has_mind(self) -> bool:
        """Whether it acts by itself."""
        return self.acts and (self.traits is not None or bool(self.behaviours))

    @property
    def called(self) -> str:
        """What it is called if it has no name."""
        return self.character


BLOCKS = {
    "figure": "Creature",
    "prop": "Prop",
    "body": "Body",
    "group": "Group",
    "many": "Many",
    "dancer": "Dancer",
    "character": "Character",
}
"""What a member is, by the block that it has."""


def _what(words: Any) -> str:
    """Return what a member is by the block that it has."""
    if not isinstance(words, Mapping):
        return type(words).__name__
    return next((kind for block, kind in BLOCKS.items() if block in words), "Creature")


Member = Annotated[
    Annotated[Creature, Tag("Creature")]
    | Annotated[Prop, Tag("Prop")]
    | Annotated[Body, Tag("Body")]
    | Annotated[Group, Tag("Group")]
    | Annotated[Many, Tag("Many")]
    | Annotated[Dancer, Tag("Dancer")]
    | Annotated[Character, Tag("Character")],
    Discriminator(_what),
]


def names_of(cast: Sequence[tuple[str, str, str]]) -> list[str]:
    """Return the names of a cast, given what `called` says of each member.

    A member without a name is called after what it is, and numbered from the second on: the
    first keeps its name (and so its random numbers) when another is added.
    """
    taken = {name for name, _, _ in cast if name}
    last: dict[str, int] = {}
    names = []
    for own, kind, mark in cast:
        name, number = own or kind, last.get(kind, 1)
        while not own and name in taken:
            number += 1
            name = f"{kind}{mark}{number}"
        if not own:
            last[kind] = number
        taken.add(name)
        names.append(name)
    return names


def called(member: object) -> tuple[str, str, str]:
    """Return what a member is called, which may be still raw and perhaps wrong.

    Returns:
        Its own name or "", what it is, and what stands between that and a number: nothing
        for `many`, whose bodies are numbered after a `_`.
    """
    if isinstance(member, Creature | Prop | Body | Group | Many | Dancer | Character):
        return member.name, member.called, "" if isinstance(member, Many) else "_"
    if not isinstance(member, Mapping):
        return "", "", "_"
    shape, many = member.get("prop") or member.get("body"), member.get("many")
    kind = shape.get("shape") if isinstance(shape, Mapping) else member.get("figure")
    kind = kind or member.get("character")
    if isinstance(group := member.get("group"), Mapping):
        kind = group.get("rule")
    if isinstance(many, Mapping):
        kind = many.get("layout", "wall")
    if "dancer" in member:
        kind = "dancer"
    name = member.get("name")
    own, what = (word if isinstance(word, str) else "" for word in (name, kind))
    return own, what, "" if isinstance(many, Mapping) else "_"
