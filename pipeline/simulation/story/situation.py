"""Situation: whether the conditions of a beat hold, and in words."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

from pipeline.simulation.script import Event, event_of
from pipeline.spec.script import When, flow_text
from pipeline.spec.story import Feeling, Situation


class Stage(Protocol):
    """The state of the simulation that conditions read."""

    def is_near(self, one: str, other: str, distance: float) -> bool:
        """Returns whether the surfaces of two members or places are within a distance [m]."""

    def feeling(self, who: str, feeling: str) -> float:
        """Returns what a person feels now, from 0 to 1."""


@dataclass(eq=False)
class Progress:
    """What has become of a story so far.

    Attributes:
        played: names of beats that are over, and of their choices as `beat.choice`.
        happened: events that have happened.
        reached: goals that are reached.
    """

    played: set[str] = field(default_factory=set)
    happened: set[Event] = field(default_factory=set)
    reached: set[str] = field(default_factory=set)


class Finding(NamedTuple):
    """A condition: whether it holds, and what is the case."""

    holds: bool
    text: str


def findings(
    situation: Situation, time: float, progress: Progress, stage: Stage
) -> Iterator[Finding]:
    """Yields all conditions of a situation at a time [s], the cheap ones first."""
    for name in situation.after:
        is_over = name in progress.played
        yield Finding(is_over, f"after {name}" if is_over else f"{name} was not played")
    for name in situation.without:
        was_played = name in progress.played
        yield Finding(not was_played, f"{name} was{'' if was_played else ' not'} played")
    if situation.time is not None:
        first, last = situation.time
        yield Finding(first <= time <= last, f"time {time:.1f} s of {first:g} to {last:g} s")
    yield from _found_among(situation.reached, situation.open, progress.reached)
    for when in situation.happened:
        has = event_of(when) in progress.happened
        yield Finding(has, f"{event_text(when)} has{'' if has else ' not'} happened")
    for when in situation.not_happened:
        has = event_of(when) in progress.happened
        yield Finding(not has, f"{event_text(when)} has{'' if has else ' not'} happened")
    yield from _feelings(situation.feels, stage)
    if situation.near is not None:
        is_near = stage.is_near(*situation.near, situation.within)
        yield Finding(is_near, _distance_text(*situation.near, situation.within, is_near))
    if situation.apart is not None:
        is_near = stage.is_near(*situation.apart, situation.beyond)
        yield Finding(not is_near, _distance_text(*situation.apart, situation.beyond, is_near))


def _found_among(
    reached: Collection[str], unreached: Collection[str], known: Collection[str]
) -> Iterator[Finding]:
    for name in reached:
        yield Finding(name in known, f"{name} is {'' if name in known else 'not '}reached")
    for name in unreached:
        yield Finding(name not in known, f"{name} is {'' if name in known else 'not '}reached")


def _feelings(
    feels: Mapping[str, Mapping[Feeling, float | tuple[float, float]]], stage: Stage
) -> Iterator[Finding]:
    for who, levels in feels.items():
        for feeling, level in levels.items():
            low, high = level if isinstance(level, tuple) else (level, 1.0)
            value = stage.feeling(who, feeling)
            yield Finding(low <= value <= high, f"{feeling} of {who} is {value:.2f}")


def _distance_text(one: str, other: str, distance: float, is_near: bool) -> str:
    return f"{one} and {other} are {'within' if is_near else 'beyond'} {distance:g} m"


def unmet(situation: Situation, time: float, progress: Progress, stage: Stage) -> str:
    """Returns the first condition that does not hold in words, "" if all do."""
    every = findings(situation, time, progress, stage)
    return next((found.text for found in every if not found.holds), "")


def met(situation: Situation, time: float, progress: Progress, stage: Stage) -> str:
    """Returns the conditions that hold in words."""
    every = findings(situation, time, progress, stage)
    return ", ".join(found.text for found in every if found.holds)


def event_text(when: When) -> str:
    """Returns an event as its author wrote it, such as `hug [kid, mother]`."""
    value = getattr(when, when.event)
    names = value if isinstance(value, str) else flow_text(list(value))
    more = f" to {when.act}" if when.act else ""
    return f"{when.event} {names}{more}"
