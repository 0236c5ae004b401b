"""Behaviour: what a character does by itself, and how it is minded (Horswill 2008)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from pipeline.spec.values import LengthOrZero, Name, Number, Words

Part = Annotated[Number, Field(ge=0, le=1)]


class Traits(Words):
    """How somebody is minded, each from 0 to 1."""

    anxiety: Part = Field(
        0.5, description="How soon it is afraid away from who cares for it, and of others."
    )
    curiosity: Part = Field(0.5, description="How much things draw it.")
    aggression: Part = Field(0.3, description="How soon it fights over something.")
    speed: Part = Field(0.5, description="How fast it goes: 0 strolls, 1 runs.")


class Urge(Words):
    """What all behaviours have."""

    urge: Annotated[Number, Field(ge=-1, le=1)] = Field(
        0.0, description="What is added to its activation, which goes from 0 to about 1."
    )


class Attachment(Urge):
    """Run to somebody and hug them when away for too long, until soothed."""

    attachment: Name = Field(description="To whom: a character that cares for it.")


class Comfort(Urge):
    """Turn to somebody who comes to be hugged, and hug them too."""

    comfort: Name = Field(description="Whom: a character.")


class Play(Urge):
    """Run after a ball and kick it."""

    play: Name = Field(description="With which ball: a character.")
    within: LengthOrZero = Field(
        7.0, description="How far from where it began the ball is kept, about [m]."
    )


class Carry(Urge):
    """Fetch something, and carry it along."""

    carry: Name = Field(description="What: a character, such as a ragdoll.")


class Push(Urge):
    """Go to a merry-go-round, or what else can be pushed, and push it."""

    push: Name = Field(description="What: a character.")


class Fight(Urge):
    """Shove somebody who is near, when aggressive enough."""

    fight: Name = Field(description="Whom: a character.")


class Approach(Urge):
    """Go to somebody or something, around what stands in the way."""

    approach: Name = Field(description="Whom or what: a character.")
    distance: LengthOrZero = Field(0.6, description="How far from its surface to stop [m].")
    from_deg: Annotated[Number, Field(ge=-3600, le=3600)] | None = Field(
        None,
        description="From which side, as a heading seen from the target; the nearest if left out "
        "[degrees].",
    )


class Flee(Urge):
    """Run from somebody who comes near."""

    flee: Name = Field(description="From whom: a character.")


class Shyness(Urge):
    """Keep away from others, and look at those who come near."""

    keep_off: LengthOrZero = Field(description="How near others may come [m].")


class Wander(Urge):
    """Stroll from place to place."""

    wander: LengthOrZero = Field(description="How far from where it began, at most [m].")


class SitDown(Urge):
    """Sit down on the ground where nothing is more pressing, and get up when something is."""

    rest: Annotated[Number, Field(gt=0, le=1e6)] = Field(
        description="How long nothing has to be more pressing [s]."
    )


class Freeze(Urge):
    """Stand quite still in the face of somebody who frightens."""

    freeze: Name = Field(description="Of whom it is afraid: a character.")


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
}
"""Behaviours, by the key that says them; withdrawal from pain has everybody who has a mind."""

WITHDRAWAL = "withdrawal"

NAMES = (WITHDRAWAL, *FORMS)
"""All behaviours, as takes number them."""

WHOM: Mapping[str, tuple[tuple[str, ...], str]] = {
    **dict.fromkeys(
        ("attachment", "comfort", "fight", "flee", "freeze"),
        (("child", "adult", "ragdoll"), "a child, an adult or a ragdoll"),
    ),
    "play": (("ball",), "a ball"),
    "carry": ((), "a character"),
    "push": ((), "a character"),
    "approach": ((), "a character"),
}
"""Those whose key names another character: what that can be; nothing is any."""


def _form(words: Any) -> str | None:
    if isinstance(words, Mapping):
        return next((FORMS[key].__name__ for key in words if key in FORMS), "Approach")
    return type(words).__name__ if isinstance(words, Words) else None


Behaviour = Annotated[
    Annotated[Attachment, Tag("Attachment")]
    | Annotated[Comfort, Tag("Comfort")]
    | Annotated[Play, Tag("Play")]
    | Annotated[Carry, Tag("Carry")]
    | Annotated[Push, Tag("Push")]
    | Annotated[Fight, Tag("Fight")]
    | Annotated[Approach, Tag("Approach")]
    | Annotated[Flee, Tag("Flee")]
    | Annotated[Shyness, Tag("Shyness")]
    | Annotated[Wander, Tag("Wander")]
    | Annotated[SitDown, Tag("SitDown")]
    | Annotated[Freeze, Tag("Freeze")],
    Discriminator(_form),
]
