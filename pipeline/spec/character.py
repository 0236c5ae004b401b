"""Character: a body of nodes and links, of which some walk, reach and hug (Horswill 2008)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.spec.behaviour import Behaviour, Traits
from pipeline.spec.keyframes import PoseKey, Turn
from pipeline.spec.model_base import Fault, Number, raise_faults
from pipeline.spec.performer import MAX_KEYFRAMES, At, Performer, Velocity
from render.config.base import TURN_DESCRIPTION

PEOPLE = ("child", "adult")
"""Those who act."""

JOINTED = (*PEOPLE, "ragdoll")
"""Those who have the joints of people."""

PARTS = (
    *("pelvis", "spine", "shoulders", "head"),
    *(f"{joint}_{side}" for joint in ("shoulder", "elbow", "hand") for side in "lr"),
    *(f"{joint}_{side}" for joint in ("hip", "knee", "foot") for side in "lr"),
)
"""Of these, what can be taken."""

HANDS = {"arm_l": 0, "arm_r": 1, "hand_l": 0, "hand_r": 1}
"""What of people is posed: limbs and nodes."""

Kind = Literal["child", "adult", "ragdoll", "ball", "merry-go-round", "box", "bench"]
"""What there is."""


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

    pose: Annotated[tuple[PoseKey, ...], Field(max_length=MAX_KEYFRAMES)] = Field(
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
        raise_faults(faults)
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
    def kind_name(self) -> str:
        """Name of a member that is given none."""
        return self.character
