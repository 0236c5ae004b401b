"""Story: relations, goals and beats, which a director inside the scene sequences by state.

Source: Mateas and Stern 2003, "Façade: an experiment in building a fully-realized interactive
    drama"; 2005, "Structuring content in the Façade interactive drama architecture": beats are
    chosen by preconditions, priority, weight and their effect on a wanted arc of tension.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from pipeline.spec.behaviour import Behaviour, Part, Urge
from pipeline.spec.keyframes import Time
from pipeline.spec.model_base import (
    ConfigModel,
    Fault,
    Integer,
    Length,
    LengthOrZero,
    MemberName,
    Name,
    Positive,
    raise_faults,
)
from pipeline.spec.relations import Relation, related_behaviours
from pipeline.spec.script import Instruction, When

Feeling = Literal["joy", "sadness", "anger", "fear", "curiosity", "anxiety"]
"""What a person with a mind feels: the emotions of its face without pain, and its anxiety."""

MAX_BEATS, MAX_CHOICES, MAX_BEAT_ORDERS = 200, 20, 200
MAX_RELATIONS = 1000


def _listed(value: Any) -> Any:
    """Let one value stand for a list of one."""
    return value if isinstance(value, list | tuple) else (value,)


BeatNames = Annotated[
    tuple[MemberName, ...],
    Field(max_length=MAX_BEATS),
    BeforeValidator(_listed, json_schema_input_type=MemberName | tuple[MemberName, ...]),
]
"""Beats by name, or choices of beats, such as quarrel.shove."""

GoalNames = Annotated[
    tuple[Name, ...],
    Field(max_length=MAX_BEATS),
    BeforeValidator(_listed, json_schema_input_type=Name | tuple[Name, ...]),
]

Events = Annotated[
    tuple[When, ...],
    Field(max_length=MAX_BEATS),
    BeforeValidator(_listed, json_schema_input_type=When | tuple[When, ...]),
]

Range = tuple[Part, Part]


class Situation(ConfigModel):
    """Conditions on the state of the story; all that are given must hold."""

    after: BeatNames = Field((), description="Beats, or choices, that are over.")
    without: BeatNames = Field((), description="Beats, or choices, that were not played.")
    happened: Events = Field((), description="Events that have happened, as in the script.")
    not_happened: Events = Field((), description="Events that have not happened.")
    near: tuple[MemberName, MemberName] | None = Field(
        None, description="Two members, or one and a place, that are near each other now."
    )
    within: LengthOrZero = Field(
        1.0, description="With near: largest distance between their surfaces [m]."
    )
    apart: tuple[MemberName, MemberName] | None = Field(
        None, description="Two members, or one and a place, that are far from each other now."
    )
    beyond: Length = Field(
        2.0, description="With apart: least distance between their surfaces [m]."
    )
    feels: dict[Name, dict[Feeling, Part | Range]] = Field(
        {},
        description="What people with minds feel, 0 to 1: at least so much, or [from, to], such "
        "as {anna: {fear: [0, 0.2]}}.",
    )
    reached: GoalNames = Field((), description="Goals that are reached.")
    open: GoalNames = Field((), description="Goals that are not reached yet.")
    time: tuple[Time, Time] | None = Field(
        None, description="Times of the film between which the beat may begin [s]."
    )


class BeatOrder(Instruction):
    """An order to a performer in a beat."""

    at: Time | None = Field(
        None, description="When, from the beginning of the beat [s]; at once if left out."
    )

    @model_validator(mode="after")
    def _has_a_time(self) -> Self:
        if self.at is not None and self.when is not None:
            raise_faults([Fault((), "should have at or when, not both")])
        return self


BeatOrders = Annotated[tuple[BeatOrder, ...], Field(max_length=MAX_BEAT_ORDERS)]


class Choice(ConfigModel):
    """One of the ways in which a beat can be played."""

    name: Name = Field(description="Its name; conditions name it as beat.choice.")
    when: Situation = Field(Situation(), description="Conditions under which it can be picked.")
    weight: Positive = Field(1.0, description="How likely it is beside others.")
    tension: Part | None = Field(
        None, description="Tension that it leads to, 0 to 1; that of the beat if left out."
    )
    do: BeatOrders = Field(description="Orders, as in the script, beside those of the beat.")


class Beat(ConfigModel):
    """A small piece of the story: what a few people do until it is over."""

    name: Name = Field(description="Its name in conditions, notes and plots.")
    when: Situation = Field(Situation(), description="Conditions under which it can be picked.")
    priority: Integer = Field(
        0,
        ge=-1000,
        le=1000,
        description="Of the beats that can be picked, those of the highest priority compete.",
    )
    weight: Positive = Field(1.0, description="How likely it is beside others.")
    tension: Part = Field(0.5, description="Tension that it leads to, 0 to 1.")
    repeat: bool = Field(False, description="Whether it can be played more than once.")
    do: BeatOrders = Field((), description="Orders, as in the script.")
    choices: Annotated[tuple[Choice, ...], Field(max_length=MAX_CHOICES)] = Field(
        (), description="Ways to play it, one of which the director picks by state and seed."
    )
    until: Events = Field(
        (), description="Events, one of which ends it; until all orders have ended if left out."
    )
    lasts: Annotated[Positive, Field(le=1e6)] | None = Field(
        None,
        description="How long it lasts [s]; with until, how long at most (12 if left out, as "
        "for orders that do not end).",
    )


class StoryGoal(ConfigModel):
    """What a person wants, beside its orders, until it is reached."""

    name: Name = Field(description="Its name in conditions.")
    who: Name = Field(description="The person, a child or an adult.")
    wants: Behaviour = Field(
        description="A behaviour of people, such as {play: ball, urge: 0.3}; it ends when the "
        "goal is reached."
    )
    until: When = Field(description="The event by which it is reached.")


class Story(ConfigModel):
    """A story that the scene directs by itself."""

    relations: Annotated[tuple[Relation, ...], Field(max_length=MAX_RELATIONS)] = Field(
        (), description="Relations between people, such as {parent: mother, of: anna}."
    )
    goals: Annotated[tuple[StoryGoal, ...], Field(max_length=MAX_BEATS)] = Field(
        (), description="What people want by themselves until it is reached."
    )
    tension: Annotated[tuple[tuple[Time, Part], ...], Field(max_length=1000)] = Field(
        (),
        description="Wanted tension over the film: times [s] with values from 0 to 1, straight "
        "between them.",
    )
    patience: Annotated[Time, Field(le=60)] = Field(
        2.0,
        description="How long a beat is put off at most while its tension is far from the wanted "
        "one [s].",
    )
    beats: Annotated[tuple[Beat, ...], Field(max_length=MAX_BEATS)] = Field(
        (), description="Pieces of the story; when one is over the director picks the next."
    )

    @model_validator(mode="after")
    def _times_ascend(self) -> Self:
        times = [time for time, _ in self.tension]
        raise_faults(
            Fault(("tension", k, 0), f"should come after {before:g} s, is {after:g}")
            for k, (before, after) in enumerate(pairwise(times), 1)
            if after <= before
        )
        return self

    def behaviours_of(self, name: str) -> tuple[Urge, ...]:
        """Return what goals, and then relations, make a person do by itself."""
        wanted = tuple(goal.wants for goal in self.goals if goal.who == name)
        return (*wanted, *related_behaviours(name, self.relations))
