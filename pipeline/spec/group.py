"""Group: many bodies that move by one rule (Sims, chapter 3.2)."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.spec.model_base import (
    WORLD_LIMIT,
    ConfigModel,
    Fault,
    Integer,
    LengthOrZero,
    Name,
    Number,
    Position,
    fault_error,
    raise_faults,
)
from pipeline.spec.performer import At, Performer

Weight = Annotated[Number, Field(ge=0, le=100)]
Wind = Annotated[Number, Field(ge=-100, le=100)]
Whom = Annotated[str, Field(min_length=1, max_length=200)]
Size = Annotated[Number, Field(ge=1e-4, le=WORLD_LIMIT)]
Pace = Annotated[Number, Field(ge=1e-3, le=100)]
Extent = tuple[Size, Size]

MAX_MEMBERS = 5000
"""Members of one group."""


class GroupBase(ConfigModel):
    """What every group has."""

    count: Annotated[Integer, Field(ge=1, le=MAX_MEMBERS)] = Field(
        100, description="How many they are."
    )


class Steered(GroupBase):
    """Keys of flocks and schools, which steer by their neighbours."""

    separation: Weight = Field(1.0, description="How much each keeps away from those too near.")
    alignment: Weight = Field(1.0, description="How much each goes where its neighbours go.")
    cohesion: Weight = Field(1.0, description="How much each keeps to its neighbours.")
    goal: Weight = Field(1.0, description="How much each makes for what all of them make for.")
    path: Annotated[tuple[Position, ...], Field(max_length=1000)] = Field(
        (), description="Places [x, y, z] that they make for, one after the other, again and again."
    )
    follow: Whom | None = Field(
        None, description="Whom they make for, such as bug or bug.head, instead of a path."
    )
    above: Annotated[Number, Field(ge=-1000, le=1000)] = Field(
        0.0, description="Height above the performer that they follow [m]."
    )
    avoid: Annotated[tuple[Name, ...], Field(max_length=200)] = Field(
        (), description="Performers that they keep out of the way of."
    )

    @model_validator(mode="after")
    def _makes_for_one(self) -> Self:
        if self.path and self.follow is not None:
            raise fault_error("give either path or follow, not both", "follow")
        return self


class Flock(Steered):
    """A flock of birds."""

    rule: Literal["flock"] = Field(description="A flock of birds.")
    size: Size = Field(0.5, description="Span of their wings [m].")
    speed: Pace = Field(6.0, description="At which they like to fly [m/s].")
    agility: Annotated[Number, Field(ge=1e-3, le=1000)] = Field(
        12.0, description="Largest acceleration [m/s²]."
    )
    spread: LengthOrZero = Field(3.0, description="How far around `at` they begin [m].")
    height: LengthOrZero = Field(1.5, description="How far above the ground they stay [m].")


class School(Steered):
    """A school of fish in a volume of water."""

    rule: Literal["school"] = Field(description="A school of fish.")
    size: Size = Field(0.2, description="Their length [m].")
    speed: Pace = Field(0.7, description="At which they like to swim [m/s].")
    agility: Annotated[Number, Field(ge=1e-3, le=1000)] = Field(
        2.5, description="Largest acceleration [m/s²]."
    )
    volume: tuple[Size, Size, Size] = Field(
        (4.0, 1.5, 4.0), description="Extent of their water along x, y and z, about `at` [m]."
    )


class Swarm(GroupBase):
    """A swarm of insects around a target."""

    rule: Literal["swarm"] = Field(description="A swarm of insects.")
    size: Size = Field(0.03, description="Their length [m].")
    around: Whom | None = Field(
        None, description="Whom they swarm around, such as bug or bug.head; `at` if left out."
    )
    radius: Size = Field(0.4, description="How far from it they are, as a mean square [m].")
    speed: Pace = Field(1.2, description="How fast they fly, as a mean square [m/s].")


class Rain(GroupBase):
    """Drops that fall and end on the ground."""

    rule: Literal["rain"] = Field(description="Rain.")
    count: Annotated[Integer, Field(ge=1, le=MAX_MEMBERS)] = Field(
        400, description="How many are in the air at once."
    )
    size: Size = Field(0.12, description="Length of a drop as it is seen [m].")
    area: Extent = Field((6.0, 6.0), description="Where they fall, along x and z, about `at` [m].")
    height: Size = Field(5.0, description="How far above the ground they begin [m].")
    speed: Pace = Field(7.0, description="At which they fall [m/s].")
    wind: tuple[Wind, Wind] = Field((0.0, 0.0), description="Along x and z [m/s].")
    splash: bool = Field(
        False, description="Whether each strikes the ground as a body does: it can be heard then."
    )


class Fire(GroupBase):
    """Flames that rise, shrink and die."""

    rule: Literal["fire"] = Field(description="Flames of a fire, or smoke.")
    size: Size = Field(0.16, description="Of a flame at its largest [m].")
    radius: LengthOrZero = Field(0.2, description="Of the place they come from [m].")
    height: Size = Field(1.0, description="How far they rise [m].")
    life: Annotated[Number, Field(ge=0.01, le=1000)] = Field(
        0.9, description="How long each lasts, about [s]."
    )
    wind: tuple[Wind, Wind] = Field((0.0, 0.0), description="Along x and z [m/s].")


class Grass(GroupBase):
    """Blades of grass on the ground."""

    rule: Literal["grass"] = Field(description="Grass.")
    count: Annotated[Integer, Field(ge=1, le=MAX_MEMBERS)] = Field(
        500, description="How many blades."
    )
    size: Size = Field(0.3, description="Their height, about [m].")
    area: Extent = Field((2.0, 2.0), description="Where they stand, along x and z, about `at` [m].")
    wind: tuple[Wind, Wind] = Field((2.0, 0.0), description="Along x and z [m/s].")
    avoid: Annotated[tuple[Name, ...], Field(max_length=200)] = Field(
        (), description="Performers whose links they bend away from."
    )


GroupRule = Annotated[Flock | School | Swarm | Rain | Fire | Grass, Field(discriminator="rule")]

DIRECTED = ("flock", "school")
"""Rules of groups that follow the order go_to."""


class Group(Performer):
    """Many bodies that move by one rule."""

    group: GroupRule = Field(description="How many they are, and by which rule they move.")
    at: At = Field(
        (0.0, 0.0),
        description="Middle of the place where they start, [x, y, z]; [x, z] is on the ground [m].",
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.parent is not None and not isinstance(self.group, Fire):
            message = "only a fire has a parent; remove this, or write follow for a flock"
            raise_faults([Fault(("parent",), message, at_key=True)])
        return self

    @property
    def kind_name(self) -> str:
        """Name of a member that is given none."""
        return self.group.rule
