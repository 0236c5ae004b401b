"""Pronk: how a figure hops (Sims, 9.1 and chapter 11)."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.spec.faults import Fault, refuse
from pipeline.spec.values import Length, LengthOrZero, Number, Point, Whole, Words

ITINERARY = frozenset({"direction_deg", "turn_deg", "land_at", "avoid", "start", "jumps"})
"""Words that say when and where it hops by itself, which a creature that walks does not."""


class Pronk(Words):
    """How a figure hops; what is left out is chosen to suit its legs.

    At lift-off speed² = g distance² / (8 height) + 2 g height, so two of the three say the
    third.
    """

    distance: LengthOrZero | None = Field(
        None, description="From lift-off until back at that height, over the ground [m]."
    )
    height: Length | None = Field(None, description="Of a jump, above the lift-off [m].")
    speed: Annotated[Number, Field(gt=0, le=1000)] | None = Field(
        None,
        description="At lift-off, along the way of the jump [m/s]; with a distance it says the "
        "height, of two that do the lower one.",
    )
    crouch: Length | None = Field(
        None, description="Height of the body above the ground at which a landing ends [m]."
    )
    max_force: Annotated[Number, Field(gt=0, le=1000)] | None = Field(
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
        0.0, description="When it begins to crouch for its first jump [s]."
    )
    jumps: Annotated[Whole, Field(ge=1, le=1_000_000)] | None = Field(
        None, description="How many jumps until it stands; it hops on if left out."
    )

    @model_validator(mode="after")
    def _aims_or_goes(self) -> Self:
        faults = [
            Fault((word,), "land_at says how far it jumps; take one of the two away", at_key=True)
            for word in ("distance", "speed", "jumps")
            if self.land_at and getattr(self, word) is not None
        ]
        faults += [
            Fault((word,), "land_at says where it jumps; take one of the two away", at_key=True)
            for word in ("direction_deg", "turn_deg")
            if self.land_at and getattr(self, word) != 0.0
        ]
        refuse(faults)
        return self
