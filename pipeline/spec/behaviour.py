"""Behaviour: what a character does by itself, and how it is disposed (Horswill 2008).

A new behaviour is a class here, its line in `FORMS`, and its implementation in
`pipeline/simulation/characters`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from pipeline.spec.gesture import GESTURES
from pipeline.spec.model_base import ConfigModel, LengthOrZero, Name, Number, Positive, keyed_union
from pipeline.spec.suggestions import decided_by_key
from pipeline.spec.targets import BALL, CAROUSEL, CHARACTER, JOINTED_CHARACTER, TargetKind

Part = Annotated[Number, Field(ge=0, le=1)]


class Traits(ConfigModel):
    """Disposition of a character, each trait from 0 to 1."""

    anxiety: Part = Field(
        0.5, description="How soon it is afraid when away from its guardian, and of strangers."
    )
    curiosity: Part = Field(0.5, description="How strongly things attract it.")
    aggression: Part = Field(0.3, description="How soon it fights over something.")
    speed: Part = Field(0.5, description="How fast it goes: 0 strolls, 1 runs.")


class Urge(ConfigModel):
    """Settings of every behaviour."""

    target: ClassVar[TargetKind | None] = None
    """Kinds of performers that its key may name, None if it names nothing."""

    urge: Annotated[Number, Field(ge=-1, le=1)] = Field(
        0.0, description="Added to its activation, which goes from 0 to about 1."
    )


class Attachment(Urge):
    """Runs to its guardian and hugs them after too long away, until soothed."""

    target = JOINTED_CHARACTER
    attachment: Name = Field(description="Its guardian, a character.")


class Comfort(Urge):
    """Turns to somebody who comes for a hug, and hugs them too."""

    target = JOINTED_CHARACTER
    comfort: Name = Field(description="The other character.")


class Play(Urge):
    """Runs after a ball and kicks it."""

    target = BALL
    play: Name = Field(description="The ball, a character.")
    within: LengthOrZero = Field(
        7.0, description="About how far from its start the ball is kept [m]."
    )


class Carry(Urge):
    """Fetches something and carries it along."""

    target = CHARACTER
    carry: Name = Field(description="The thing, a character such as a ragdoll.")


class Push(Urge):
    """Goes to a merry-go-round, or another thing that can be pushed, and pushes it."""

    target = CHARACTER
    push: Name = Field(description="The thing, a character.")


class Ride(Urge):
    """Steps onto a merry-go-round and rides on it for a while."""

    target = CAROUSEL
    ride: Name = Field(description="The merry-go-round, a character.")


class Fight(Urge):
    """Shoves somebody near, when aggressive enough."""

    target = JOINTED_CHARACTER
    fight: Name = Field(description="The other character.")


class Approach(Urge):
    """Goes to somebody or something, around obstacles."""

    target = CHARACTER
    approach: Name = Field(description="The target, a character.")
    distance: LengthOrZero = Field(
        0.6, description="Distance from its surface at which to stop [m]."
    )
    from_deg: Annotated[Number, Field(ge=-3600, le=3600)] | None = Field(
        None,
        description="Side from which to come, as a heading seen from the target; the nearest if "
        "left out [degrees].",
    )


class Flee(Urge):
    """Runs from somebody who comes near."""

    target = JOINTED_CHARACTER
    flee: Name = Field(description="The character to run from.")


class Shyness(Urge):
    """Keeps away from others, and looks at those who come near."""

    keep_off: LengthOrZero = Field(description="Distance that others must keep [m].")


class Wander(Urge):
    """Strolls from place to place."""

    wander: LengthOrZero = Field(description="Largest distance from its start [m].")


class SitDown(Urge):
    """Sits down on the ground while nothing is more pressing."""

    rest: Annotated[Positive, Field(le=1e6)] = Field(
        description="Time for which nothing else must be pressing [s]."
    )


class Freeze(Urge):
    """Stands still before somebody who frightens it."""

    target = JOINTED_CHARACTER
    freeze: Name = Field(description="The character that frightens it.")


class Accompany(Urge):
    """Comes along with somebody who goes somewhere, side by side."""

    target = JOINTED_CHARACTER
    accompany: Name = Field(description="The other, a child or an adult.")


class Soothe(Urge):
    """Strokes the shoulder of somebody near who is sad or hurt."""

    target = JOINTED_CHARACTER
    soothe: Name = Field(description="The other, a child or an adult.")


FORMS: Mapping[str, type[Urge]] = {
    "attachment": Attachment,
    "comfort": Comfort,
    "play": Play,
    "carry": Carry,
    "push": Push,
    "fight": Fight,
    "approach": Approach,
    "flee": Flee,
    "keep_off": Shyness,
    "wander": Wander,
    "rest": SitDown,
    "freeze": Freeze,
    "ride": Ride,
    "accompany": Accompany,
    "soothe": Soothe,
}
"""Behaviours by the key that selects them."""

WITHDRAWAL = "withdrawal"
WITHDRAWAL_TEXT = "Withdraws from pain; needs no key."

NAMES = (WITHDRAWAL, *FORMS)
"""Names of all behaviours, in the order in which takes number them."""

TAKE_NAMES = (*NAMES, *GESTURES)
"""Names of behaviours and of gestures, in the order in which takes number them."""

TARGETS: Mapping[str, TargetKind] = {
    key: form.target for key, form in FORMS.items() if form.target is not None
}

if TYPE_CHECKING:
    Behaviour = Urge
else:
    Behaviour = Annotated[
        keyed_union(FORMS, default="Approach"),
        decided_by_key(FORMS, "behaviour", "behaviours", NAMES),
    ]
