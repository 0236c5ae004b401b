"""Creature: a jointed figure that walks, hops or stands (Sims 1987, ch. 9 and 11)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.spec.costume import Costume, HairLook
from pipeline.spec.keyframes import PoseKey
from pipeline.spec.model_base import (
    ConfigModel,
    Fault,
    FigureName,
    Integer,
    Length,
    LengthOrZero,
    Number,
    Point,
    Positive,
    Target,
    raise_faults,
)
from pipeline.spec.mood import MoodMix
from pipeline.spec.performer import MAX_KEYFRAMES, At, Performer
from pipeline.spec.walk import Walk

ITINERARY = frozenset({"direction_deg", "turn_deg", "land_at", "avoid", "start", "jumps"})
"""Keys of the jumps that a hopper makes by itself; a walker jumps by script only."""


class Pronk(ConfigModel):
    """Jumps of a figure; keys left out are chosen to suit its legs.

    At lift-off speed² = g distance² / (8 height) + 2 g height, so two of the three say the
    third.
    """

    distance: LengthOrZero | None = Field(
        None, description="From lift-off until back at that height, over the ground [m]."
    )
    height: Length | None = Field(None, description="Of a jump, above the lift-off [m].")
    speed: Annotated[Positive, Field(le=1000)] | None = Field(
        None,
        description="At lift-off, along the way of the jump [m/s]; with a distance it says the "
        "height, of two that do the lower one.",
    )
    crouch: Length | None = Field(
        None, description="Height of the body above the ground at which a landing ends [m]."
    )
    max_force: Annotated[Positive, Field(le=1000)] | None = Field(
        None, description="That a leg gives at most [body weights]; enough if left out."
    )
    balance: Annotated[Number, Field(ge=0, le=1000)] | None = Field(
        None,
        description="Greatest moment with which legs keep the body level [body weights times "
        "leg length]; enough for level ground if left out, with 0 it soon falls.",
    )
    fall: Literal["ragdoll", "rigid"] = Field(
        "ragdoll",
        description="How it falls once it has toppled: limp, or stiff as one body.",
    )
    direction_deg: Number = Field(
        0.0,
        ge=-3600,
        le=3600,
        description="Where it jumps, from where it looks; positive to the left [degrees].",
    )
    turn_deg: Number = Field(
        0.0, ge=-360, le=360, description="By how much it turns from jump to jump [degrees]."
    )
    land_at: Annotated[tuple[Point, ...], Field(max_length=1000)] = Field(
        (), description="Where jumps land, [x, z] one after the other; then it stands [m]."
    )
    avoid: bool = Field(
        False, description="Whether it looks for landings outside of forbidden zones."
    )
    start: Annotated[Number, Field(ge=0, le=1e6)] = Field(
        0.0,
        description="When it begins to crouch for the first jump of its own; orders of the script "
        "are carried out before, too [s].",
    )
    jumps: Annotated[Integer, Field(ge=1, le=1_000_000)] | None = Field(
        None, description="How many jumps until it stands; it hops on if left out."
    )

    @model_validator(mode="after")
    def _aims_or_goes(self) -> Self:
        faults = [
            Fault((key,), "conflicts with land_at; remove one", at_key=True)
            for key in ("distance", "speed", "jumps")
            if self.land_at and getattr(self, key) is not None
        ]
        faults += [
            Fault((key,), "conflicts with land_at; remove one", at_key=True)
            for key in ("direction_deg", "turn_deg")
            if self.land_at and getattr(self, key) != 0.0
        ]
        raise_faults(faults)
        return self


class Creature(Performer):
    """A jointed figure that walks, hops or stands."""

    figure: FigureName = Field(
        description="Its figure: from this file, from a file of that name beside it or in "
        "figures/ beside it, or from the shipped library."
    )
    at: At = Field(
        (0.0, 0.0),
        description="Where it starts, [x, z] on the ground; on a parent [x, z], or [x, y, z] "
        "with the height that it stands at; a hopper may start in the air, [x, y, z] with the "
        "height of its feet above the ground [m].",
    )
    scale: Length = Field(1.0, description="Factor on all lengths of the figure.")
    walk: Walk | None = Field(None, description="How it walks; it stands still if left out.")
    pronk: Pronk | None = Field(
        None,
        description="How it hops, instead of walking; with walk, how it jumps when it is told to.",
    )
    costume: Costume | None = Field(
        None,
        description="What a figure with a person's skin wears; by the seed if left out, and all "
        "different while there are enough costumes.",
    )
    hair: HairLook | None = Field(
        None, description="Hair on its head; by its name and the seed if left out."
    )
    mood: MoodMix = Field(
        {}, description="A mood by name, or weights of several: how it walks and carries itself."
    )
    look_at: Target | None = Field(
        None,
        description="What it looks at, as far as its neck turns: another creature, or a place "
        "[x, y, z] [m]; where it goes if left out.",
    )
    pose: Annotated[tuple[PoseKey, ...], Field(max_length=MAX_KEYFRAMES)] = Field(
        (),
        description="What its joints and limbs are to do, over or instead of walking; the keys of "
        "different limbs may stand in any order.",
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        faults = []
        if self.parent is None and len(self.at) == 3 and (self.pronk is None or self.walk):
            faults.append(Fault(("at",), "a creature stands on the ground; write [x, z]"))
        if self.pronk is not None:
            faults += self._faults_of_hopping()
        start = (self.at[0], self.at[-1])
        if self.walk is not None and self.walk.path and {*self.walk.path} == {start}:
            message = (
                "leads nowhere, because the creature starts there; write another place, or leave "
                "`walk` out for one that stands"
            )
            faults.append(Fault(("walk", "path"), message))
        if self.parent is not None and self.walk is not None:
            message = "conflicts with parent; remove one"
            faults.append(Fault(("walk",), message, at_key=True))
        raise_faults(faults)
        return self

    def _faults_of_hopping(self) -> Iterator[Fault]:
        if self.walk is not None:
            message = "conflicts with walk, which jumps by script; remove one"
            for key in sorted(self.pronk.model_fields_set & ITINERARY if self.pronk else ()):
                yield Fault(("pronk", key), message, at_key=True)
        if self.parent is not None:
            message = "conflicts with parent; remove one"
            yield Fault(("pronk",), message, at_key=True)
        if self.pose:
            message = "conflicts with pronk; remove one"
            yield Fault(("pose",), message, at_key=True)

    @property
    def kind_name(self) -> str:
        """Name of a member that is given none."""
        return self.figure
