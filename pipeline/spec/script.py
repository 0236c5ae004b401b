"""Script: orders to performers, at a time or after an event (Sims, 3.2.4)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, model_validator
from pydantic.fields import FieldInfo

from pipeline.spec.events import EVENTS
from pipeline.spec.expression import Shown
from pipeline.spec.keyframes import Angle, Time
from pipeline.spec.model_base import (
    BehaviourName,
    ConfigModel,
    DanceName,
    Fault,
    Goal,
    Integer,
    Length,
    LengthOrZero,
    MemberName,
    Name,
    Number,
    Point,
    Positive,
    Target,
    keyed_union,
    raise_faults,
)
from pipeline.spec.mood import MoodMix
from pipeline.spec.suggestions import decided_by_key
from pipeline.spec.verbs import VERBS
from pipeline.spec.walk import GAIT, Gait, Manner


class GoTo(ConfigModel):
    """Go to a place, or up to a member of the cast wherever it is by then, and stop there."""

    go_to: Goal = Field(description="Where to: [x, z] [m], a member of the cast, or a place.")
    gap: LengthOrZero | None = Field(
        None,
        description="Distance from the surface of a member at which it stops [m]; just clear of "
        "it if left out.",
    )


class Follow(ConfigModel):
    """Go after a member of the cast, and keep a distance, until told otherwise."""

    follow: MemberName = Field(description="Whom or what: a member of the cast.")
    gap: LengthOrZero = Field(1.0, description="Distance from its surface that it keeps [m].")


class Chase(ConfigModel):
    """Run after a member of the cast until it touches it."""

    chase: MemberName = Field(description="Whom or what: a member of the cast.")


class Flee(ConfigModel):
    """Run from a member of the cast or a place, until far enough away."""

    flee: Target = Field(description="From whom, what or where.")
    distance: Length = Field(5.0, description="How far away it stops [m].")


class Avoid(ConfigModel):
    """Keep off a member of the cast or a place from now on, whatever else it does."""

    avoid: Target = Field(description="Whom, what or where.")
    distance: Length = Field(2.0, description="How near it lets it come [m].")


class TurnBy(ConfigModel):
    """Turns: on the spot when standing, along an arc when walking, in the air when hopping."""

    turn_deg: Angle = Field(description="By how much; positive turns to the left [degrees].")


class SetSpeed(ConfigModel):
    """Go faster or slower from now on."""

    speed: Annotated[Positive, Field(le=1000)] = Field(
        description="The new speed on level ground [m/s]."
    )


class Wait(ConfigModel):
    """Stop, and go on later."""

    wait: Annotated[Positive, Field(le=1e6)] = Field(
        description="How long it stops before it goes on [s]."
    )


class ChangeGait(Manner):
    """Go over into another gait."""

    gait: Gait = Field(description=GAIT)


class ChangeMood(ConfigModel):
    """Feel otherwise from now on."""

    mood: MoodMix = Field(description="A mood by name, or weights of several; {} takes all away.")


class LookAt(ConfigModel):
    """Look at something from now on, wherever it goes."""

    look_at: Target = Field(description="Another creature, or a place [x, y, z] [m].")


class LookAhead(ConfigModel):
    """Look where it goes again."""

    look: Literal["ahead"] = Field(description="ahead.")


class HopOver(ConfigModel):
    """Jump over somebody or something, and go on."""

    hop_over: Name = Field(description="Over whom or what: a prop, a body or a creature.")


class JumpSettings(ConfigModel):
    """One jump; what is left out is as the creature's `pronk` block says, or suits its legs."""

    distance: LengthOrZero | None = Field(
        None, description="From lift-off until back at that height, over the ground [m]."
    )
    height: Length | None = Field(None, description="Above the lift-off [m].")
    speed: Annotated[Positive, Field(le=1000)] | None = Field(
        None, description="At lift-off, along the way of the jump [m/s]."
    )
    land_at: Point | None = Field(
        None, description="Where the middle of its feet is to land, [x, z] [m]."
    )

    @model_validator(mode="after")
    def _aims_or_goes(self) -> Self:
        message = "conflicts with land_at; remove one"
        given = [key for key in ("distance", "speed") if getattr(self, key) is not None]
        raise_faults([Fault((key,), message, at_key=True) for key in given if self.land_at])
        return self


class JumpOnce(ConfigModel):
    """Make one jump, and go on."""

    jump: JumpSettings = Field(description="The jump; {} is an ordinary one.")


Side = Literal["left", "right", "both"]


class Reach(ConfigModel):
    """Hold a hand out to something, wherever it goes."""

    reach: Target = Field(description="Another character, or a place [x, y, z] [m].")
    hand: Side = Field("right", description="With which hand: left, right or both.")


class Grab(ConfigModel):
    """Go near something, take it and hold on to it; it hangs from the hand."""

    grab: Name = Field(description="What or whom: a character.")
    hand: Side = Field("right", description="With which hand: left, right or both.")
    part: Name | None = Field(
        None,
        description="Where it is taken, such as hand_l or head; where it is nearest if left out.",
    )


class LetGo(ConfigModel):
    """Let go of what is held, reached for or hugged; the arm hangs again."""

    let_go: Side = Field(description="With which hand: left, right or both.")


class Carry(ConfigModel):
    """Take something, go somewhere with it, and put it down there."""

    carry: Name = Field(description="What or whom: a member of the cast.")
    to: Goal = Field(description="Where to: [x, z] [m], a member of the cast, or a place.")
    hand: Side = Field("right", description="With which hand: left, right or both.")


class Throw(ConfigModel):
    """Throw what is in the hand."""

    throw: Name = Field(description="What: a member of the cast that it holds by then.")
    to: Target = Field(description="Where to: [x, y, z] [m], a member of the cast, or a place.")


class Kick(ConfigModel):
    """Go up to something and kick it."""

    kick: Name = Field(description="What: a member of the cast.")
    to: Target | None = Field(
        None,
        description="Where to: [x, y, z] [m], a member of the cast, or a place; straight ahead if "
        "left out.",
    )
    speed: Annotated[Positive, Field(le=40)] = Field(
        5.0, description="Speed of the foot where it meets it [m/s]."
    )


class Hug(ConfigModel):
    """Go to somebody and put both arms around them."""

    hug: Name = Field(description="Whom: a character.")


class Grapple(ConfigModel):
    """Go to somebody and shove, with both arms ahead."""

    grapple: Name = Field(description="Whom: a character.")


class SitOn(ConfigModel):
    """Go to something and sit down on it."""

    sit: Name = Field(description="On what: a bench, a box, a rock or a low wall of seat height.")


class Ride(ConfigModel):
    """Step onto something that moves, and stay on it until another order."""

    ride: Name = Field(description="On what: a merry-go-round, or what has a flat top.")


class PushRound(ConfigModel):
    """Push a merry-go-round round."""

    push: Name = Field(description="Which merry-go-round.")
    turns: Annotated[Positive, Field(le=1000)] = Field(2.0, description="How many turns.")


class QueueUp(ConfigModel):
    """Line up at something, be served in turn, and step aside."""

    queue: Goal = Field(
        description="Where: [x, z] [m], a member of the cast such as a counter, or a place."
    )
    lasts: Annotated[Positive, Field(le=1e6)] = Field(
        3.0, description="How long it is served at the head of the queue [s]."
    )
    from_deg: Annotated[Number, Field(ge=-3600, le=3600)] | None = Field(
        None,
        description="Side on which the queue stands, as a heading seen from there; that from "
        "which the first one comes if left out [degrees].",
    )


class Greet(ConfigModel):
    """Wave at somebody, whatever else it does."""

    greet: Target = Field(description="At whom or what, or a place [x, y, z] [m].")


class PointAt(ConfigModel):
    """Point at something, whatever else it does."""

    point: Target = Field(description="At whom or what, or a place [x, y, z] [m].")


class Refuse(ConfigModel):
    """Hold up a hand against somebody and shake the head, whatever else it does."""

    refuse: Target = Field(description="Whom or what, or a place [x, y, z] [m].")


class Soothe(ConfigModel):
    """Go up to somebody and stroke a shoulder."""

    soothe: Name = Field(description="Whom: a child or an adult.")


class SetUrges(ConfigModel):
    """Have more or less of a mind to do something, from now on."""

    urge: dict[BehaviourName, Annotated[Number, Field(ge=-2, le=2)]] = Field(
        description="What is added to the activation of behaviours that it does by itself, by "
        "their names, such as {play: 0.3}; {} takes all away."
    )


class Express(ConfigModel):
    """Show an emotion from now on, whatever it feels; pain shows all the same."""

    express: Shown = Field(
        description="What its face shows; `neutral` is a calm face, `own` what it feels again."
    )
    strength: Annotated[Number, Field(ge=0, le=1)] = Field(1.0, description="How much of it shows.")


class Perform(ConfigModel):
    """Dance something from now on, or so many bars of it."""

    dance: DanceName = Field(
        description="What: a dance of this scene, of a file beside it or of the library."
    )
    bars: Annotated[Integer, Field(ge=1, le=100_000)] | None = Field(
        None, description="How often; then it goes on with what it did before."
    )
    tempo_bpm: Annotated[Number, Field(ge=10, le=480)] | None = Field(
        None, description="Beats a minute; the dancer's own, or else the dance's, if left out."
    )


Plain = Literal["stop", "walk", "hop", "sit", "stand", "freeze", "let_go", "dance"]
"""Orders of one word."""

FORMS: Mapping[str, type[ConfigModel]] = {
    "gait": ChangeGait,
    "mood": ChangeMood,
    "go_to": GoTo,
    "turn_deg": TurnBy,
    "wait": Wait,
    "look_at": LookAt,
    "look": LookAhead,
    "hop_over": HopOver,
    "jump": JumpOnce,
    "follow": Follow,
    "chase": Chase,
    "flee": Flee,
    "avoid": Avoid,
    "reach": Reach,
    "grab": Grab,
    "carry": Carry,
    "throw": Throw,
    "kick": Kick,
    "let_go": LetGo,
    "hug": Hug,
    "grapple": Grapple,
    "sit": SitOn,
    "ride": Ride,
    "push": PushRound,
    "queue": QueueUp,
    "greet": Greet,
    "point": PointAt,
    "refuse": Refuse,
    "soothe": Soothe,
    "urge": SetUrges,
    "express": Express,
    "dance": Perform,
    # Last, for gait and kick have a key of this name too.
    "speed": SetSpeed,
}
"""Orders by the key that selects them; the first of these keys that an order has decides."""


if TYPE_CHECKING:
    Do = Plain | ConfigModel
else:
    Do = Annotated[
        keyed_union(FORMS, default="GoTo", word=Plain),
        decided_by_key(FORMS, "order", "verbs", VERBS),
    ]


def order_keys(order: str) -> dict[str, FieldInfo]:
    """Return the keys that an order may have besides the one that selects it.

    Those of a jump stand in its block.
    """
    form: type[ConfigModel] | None = JumpSettings if order == "jump" else FORMS.get(order)
    fields = form.model_fields if form else {}
    return {key: field for key, field in fields.items() if key != order}


def order_text(do: Do) -> str:
    """Return an instruction as its author wrote it, such as "go_to [3, 4.5]"."""
    if isinstance(do, str):
        return do
    values = do.model_dump(mode="json", exclude_unset=True)
    return ", ".join(f"{key} {flow_text(value)}" for key, value in values.items())


def flow_text(value: Any) -> str:
    """Return a value as YAML in one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {flow_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(flow_text(item) for item in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)


def _event(key: str) -> Any:
    """Return the field of an event."""
    kind = EVENTS[key]
    return Field(None, description=f"Happens when {kind.meaning}; such as {kind.example}.")


class When(ConfigModel):
    """An event that an instruction waits for."""

    arrived: Name | None = _event("arrived")
    touch: tuple[Name, Name] | None = _event("touch")
    near: tuple[MemberName, MemberName] | None = _event("near")
    within: LengthOrZero = Field(
        1.0, description="With near: the distance between their surfaces that counts [m]."
    )
    fell: Name | None = _event("fell")
    at_rest: Name | None = _event("at_rest")
    hug: tuple[Name, Name] | None = _event("hug")
    failed: Name | None = _event("failed")
    served: Name | None = _event("served")
    act: Name | None = Field(
        None, description="With failed: the order that is given up, such as hug; any if left out."
    )

    @model_validator(mode="after")
    def _is_one_thing(self) -> Self:
        given = [key for key in EVENTS if getattr(self, key) is not None]
        if len(given) != 1:
            raise_faults([Fault((), f"should have one of {', '.join(EVENTS)}")])
        return self

    @property
    def event(self) -> str:
        """Kind of the event, one of `EVENTS`."""
        return next(key for key in EVENTS if getattr(self, key) is not None)


class Instruction(ConfigModel):
    """An order to a performer, and when it is given."""

    at: Time | None = Field(None, description="When, from the start of the film [s].")
    when: When | None = Field(
        None,
        description="The event to wait for. Instructions to one performer that wait for the same "
        "event are given one after the other, each time that it happens.",
    )
    who: Name = Field(description="The performer that gets the order.")
    do: Do = Field(description=f"The order: {', '.join(VERBS)}.")

    @model_validator(mode="after")
    def _has_a_time(self) -> Self:
        if (self.at is None) == (self.when is None):
            raise_faults([Fault((), "should have either at or when")])
        return self
