"""Character: a body of nodes and links; people walk, reach and hug (Horswill 2008)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Self

from pydantic import Field, model_validator

from pipeline.spec.behaviour import Accompany, Behaviour, Part, Traits
from pipeline.spec.character_kinds import HANDS, PEOPLE, WEARERS, Kind
from pipeline.spec.costume import Costume, HairLook
from pipeline.spec.keyframes import PoseKey, Turn
from pipeline.spec.model_base import Fault, Name, Number, raise_faults
from pipeline.spec.performer import MAX_KEYFRAMES, At, Performer, Velocity
from render.config.base import TURN_DESCRIPTION

MAX_COMPANIONS = 20
"""Greatest number of companions that one character names."""


class Character(Performer):
    """A body of nodes and links: a person, or a thing that people play with."""

    character: Kind = Field(
        description="child and adult stand, walk, reach, hug and sit as the script tells them; "
        "a ragdoll, a ball, a merry-go-round, a box and a bench are pushed, thrown and carried."
    )
    costume: Costume | None = Field(
        None,
        description="What it wears; by the seed if left out, and all different while there are "
        "enough costumes.",
    )
    hair: HairLook | None = Field(
        None, description="Hair on its head; by its name and the seed if left out."
    )
    at: At = Field(
        (0.0, 0.0),
        description="Where it starts, [x, z] on the ground; [x, y, z] in the air, with the height "
        "of its lowest point, if it does not stand by itself [m].",
    )
    scale: Annotated[Number, Field(ge=0.2, le=5)] = Field(
        1.0, description="Factor on all its lengths; its mass goes by the third power."
    )
    limp: bool = Field(
        False, description="Whether a child or an adult lets itself go: it holds nothing and falls."
    )
    rotation_deg: Turn = Field(
        (0.0, 0.0, 0.0),
        description="Initial rotation of a limp person or a thing, before its heading: "
        f"{TURN_DESCRIPTION}.",
    )
    velocity: Velocity = Field(
        (0.0, 0.0, 0.0),
        description="Initial velocity of a limp person or a thing, [x, y, z] [m/s].",
    )
    spin_deg: Turn = Field(
        (0.0, 0.0, 0.0),
        description="Initial spin of a limp person or a thing, about x, y and z of the world "
        "[degrees/s].",
    )

    pose: Annotated[tuple[PoseKey, ...], Field(max_length=MAX_KEYFRAMES)] = Field(
        (), description="Where hands are to be at certain times, over what else it does."
    )
    traits: Traits | None = Field(
        None,
        description="Disposition of a child or an adult, which acts by itself with traits or "
        "behaviours.",
    )
    behaviours: Annotated[tuple[Behaviour, ...], Field(max_length=200)] = Field(
        (),
        description="What it does by itself, the most pressing first. With traits alone it plays "
        "with the nearest ball and is attached to the nearest adult, or hugs children who come.",
    )
    obedience: Part = Field(
        0.5,
        description="How much pain a child or an adult bears while it does what it is told: "
        "0 none, 0.5 a hard blow, 1 any. It flinches at half of that, and steps back beyond it.",
    )
    companions: Annotated[tuple[Name, ...], Field(max_length=MAX_COMPANIONS)] = Field(
        (),
        description="Children and adults with whom it walks side by side, and who wait for one "
        "another; those who have no order of their own come along. One of two says so.",
    )
    slapstick: bool = Field(
        False, description="Whether it runs into the person it hugs instead of slowing down."
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        raise_faults([*self._faults_of_mind(), *self._faults_of_start(), *self._faults_of_pose()])
        return self

    def _faults_of_mind(self) -> Iterator[Fault]:
        for key in ("traits", "behaviours", "slapstick", "obedience", "companions"):
            if getattr(self, key) != type(self).model_fields[key].default and not self.acts:
                message = f"a {self.character} that does not stand does not act; remove this"
                yield Fault((key,), message, at_key=True)

    def _faults_of_start(self) -> Iterator[Fault]:
        if self.parent is not None:
            message = "a character moves by itself; remove parent, or let it be grabbed"
            yield Fault(("parent",), message, at_key=True)
        if self.limp and self.character not in PEOPLE:
            message = f"a {self.character} never stands by itself; remove this"
            yield Fault(("limp",), message, at_key=True)
        for key, nothing in (("costume", "wears nothing"), ("hair", "has no hair")):
            if getattr(self, key) is not None and self.character not in WEARERS:
                yield Fault((key,), f"a {self.character} {nothing}; remove this", at_key=True)
        if not self.acts:
            return
        for key in ("rotation_deg", "spin_deg", "velocity"):
            if getattr(self, key) != (0.0, 0.0, 0.0):
                message = "conflicts with standing; remove this, or write limp: true"
                yield Fault((key,), message, at_key=True)
        if len(self.at) == 3:
            yield Fault(("at",), "stands on the ground; write [x, z], or limp: true")

    def _faults_of_pose(self) -> Iterator[Fault]:
        if self.pose and not self.acts:
            message = "only a child or an adult that is not limp is posed; remove this"
            yield Fault(("pose",), message, at_key=True)
        hands = "only hands of a person are posed; write limb arm_l or arm_r and reach, or release"
        for k, pose_key in enumerate(self.pose):
            for key in ("aim", "turn_deg", "joints", "body"):
                if getattr(pose_key, key) is not None:
                    yield Fault(("pose", k, key), hands, at_key=True)
            for key in ("limb", "node", "release"):
                if getattr(pose_key, key) not in (None, *HANDS):
                    yield Fault(("pose", k, key), hands)

    @property
    def acts(self) -> bool:
        """Whether it stands by itself and follows orders."""
        return self.character in PEOPLE and not self.limp

    @property
    def has_mind(self) -> bool:
        """Whether it acts by itself."""
        return self.acts and (self.traits is not None or bool(self.behaviours))

    @property
    def kind_name(self) -> str:
        """Name of a member that is given none."""
        return self.character


def companions_of(member: Character, cast: Sequence[Character]) -> list[str]:
    """Return the names of those that a character names as companions, or that name it, sorted."""
    found = set(member.companions)
    found.update(other.name for other in cast if member.name in other.companions)
    return sorted(found & {other.name for other in cast if other.acts})


def company_of(cast: Sequence[Character]) -> list[list[str]]:
    """Return the names of people who belong together, also by others, group by group, sorted."""
    acting = {member.name for member in cast if member.acts}
    groups = dict[str, set[str]]()
    for member in cast:
        accompanied = [b.accompany for b in member.behaviours if isinstance(b, Accompany)]
        for name in (*member.companions, *accompanied):
            if member.acts and name in acting:
                joined = groups.get(member.name, {member.name}) | groups.get(name, {name})
                groups.update(dict.fromkeys(joined, joined))
    return sorted(
        sorted(group) for group in {min(group): group for group in groups.values()}.values()
    )
