"""Story checks: names in a story, and beats that can never come.

The scene is read as it stands, typed or still raw (see `partial_scene`).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, get_args

from pipeline.spec.beat_sequence import BeatSequence
from pipeline.spec.behaviour import FORMS as BEHAVIOURS
from pipeline.spec.behaviour import TARGETS
from pipeline.spec.model_base import Fault
from pipeline.spec.order_support import NamedThings, faults_of_event
from pipeline.spec.partial_scene import (
    Path,
    given_keys,
    items_of,
    items_or_itself,
    text_keys,
    value_at,
)
from pipeline.spec.relations import faults_of_person, faults_of_relations
from pipeline.spec.script import Wait
from pipeline.spec.story import Feeling, Situation
from pipeline.spec.suggestions import hint
from pipeline.spec.targets import EVENT_PLACE, faults_of_target
from pipeline.spec.verbs import VERBS, key_of_order

STORY: Path = ("story",)


def faults_of_story(scene: object) -> Iterator[Fault]:
    """Find names of what a story does not have, and beats that never come or never end."""
    story = value_at(scene, "story")
    if story is None:
        return
    yield from faults_of_relations(scene, value_at(story, "relations"), (*STORY, "relations"))
    named = NamedThings.of(scene)
    yield from _faults_of_goals(story, named)
    sequence = BeatSequence.of(scene)
    yield from sequence.faults_of_names()
    goals = {name for _, goal in items_of(value_at(story, "goals")) if (name := _name(goal))}
    for path, situation in _situations(story):
        yield from _faults_of_situation(situation, path, named, goals)
    for b, beat in items_of(value_at(story, "beats")):
        path = (*STORY, "beats", b)
        for place, when in items_or_itself(value_at(beat, "until")):
            yield from faults_of_event(when, (*path, "until", *place), named)
        yield from _faults_of_end(beat, path)
    yield from sequence.faults_of_order()


def _name(block: object) -> str:
    name = value_at(block, "name")
    return name if isinstance(name, str) else ""


def _faults_of_goals(story: object, named: NamedThings) -> Iterator[Fault]:
    """Find goals of nobody, of the same name, and of the same behaviour of one person."""
    first: dict[str, int] = {}
    wanted: dict[tuple[str, str], int] = {}
    for i, goal in items_of(value_at(story, "goals")):
        path = (*STORY, "goals", i)
        name, who, wants = _name(goal), value_at(goal, "who"), value_at(goal, "wants")
        if name in first:
            message = f"the name '{name}' is taken by story.goals[{first[name]}]"
            yield Fault((*path, "name"), message)
        if name:
            first.setdefault(name, i)
        yield from faults_of_event(value_at(goal, "until"), (*path, "until"), named)
        if not isinstance(who, str):
            continue
        yield from faults_of_person(who, named.cast, (*path, "who"))
        for key, fitting in TARGETS.items():
            target = value_at(wants, key)
            yield from faults_of_target(target, who, fitting, (*path, "wants", key), named.cast)
        kind = next((key for key in BEHAVIOURS if value_at(wants, key) is not None), "")
        if kind and (other := wanted.setdefault((who, kind), i)) != i:
            message = f"'{who}' wants to {kind} by story.goals[{other}] already; join the two"
            yield Fault((*path, "wants"), message)


def _situations(story: object) -> Iterator[tuple[Path, Any]]:
    """Yield the conditions of all beats and choices, with their paths."""
    for b, beat in items_of(value_at(story, "beats")):
        path = (*STORY, "beats", b)
        yield (*path, "when"), value_at(beat, "when")
        for c, choice in items_of(value_at(beat, "choices")):
            yield (*path, "choices", c, "when"), value_at(choice, "when")


def _faults_of_situation(
    when: object, path: Path, named: NamedThings, goals: set[str]
) -> Iterator[Fault]:
    """Find conditions that name what does not exist, or that never hold."""
    for key in ("happened", "not_happened"):
        for place, event in items_or_itself(value_at(when, key)):
            yield from faults_of_event(event, (*path, key, *place), named)
    yield from _faults_of_pairs(when, path, named)
    for key in ("reached", "open"):
        for place, name in items_or_itself(value_at(when, key)):
            if isinstance(name, str) and name not in goals:
                message = f"no goal is called '{name}', {hint(name, goals)}"
                yield Fault((*path, key, *place), message)
    yield from _faults_of_feelings(value_at(when, "feels"), (*path, "feels"), named)


def _faults_of_pairs(when: object, path: Path, named: NamedThings) -> Iterator[Fault]:
    """Find distances of what does not exist, and lengths that belong to no pair."""
    for key in ("near", "apart"):
        pair = value_at(when, key)
        names = list(pair) if isinstance(pair, list | tuple) else []
        for k, name in enumerate(names):
            if isinstance(name, str) and name in names[:k]:
                yield Fault((*path, key, k), f"'{name}' is always where it is; name another")
            else:
                place = (*path, key, k)
                yield from faults_of_target(name, "", EVENT_PLACE, place, named.cast, named.places)
    given = given_keys(when)
    for key, owner in (("within", "near"), ("beyond", "apart")):
        # A scene that is written in full has the default beside no pair.
        default = Situation.model_fields[key].default
        if key in given and value_at(when, key) != default and owner not in given:
            yield Fault((*path, key), f"belongs to {owner}; remove this", at_key=True)


def _faults_of_feelings(feels: object, path: Path, named: NamedThings) -> Iterator[Fault]:
    """Find feelings of people that have none, unknown ones, and ranges without a value."""
    for name in sorted(text_keys(feels)):
        before = list(faults_of_person(name, named.cast, (*path, name)))
        yield from (Fault(fault.path, fault.message, at_key=True) for fault in before)
        if not before and name not in named.minds:
            message = f"'{name}' has no mind and feels nothing; give it traits: {{}}, or a relation"
            yield Fault((*path, name), message, at_key=True)
        levels = value_at(feels, name)
        for feeling in sorted(text_keys(levels)):
            if feeling not in get_args(Feeling):
                close = hint(feeling, get_args(Feeling))
                message = f"no feeling is called '{feeling}', {close}"
                yield Fault((*path, name, feeling), message, at_key=True)
            level = value_at(levels, feeling)
            if isinstance(level, list | tuple) and len(level) == 2:
                low, high = level
                if _is_number(low) and _is_number(high) and low > high:
                    message = f"holds no value; write [{high:g}, {low:g}]"
                    yield Fault((*path, name, feeling), message)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _faults_of_end(beat: object, path: Path) -> Iterator[Fault]:
    """Find a beat that nobody plays, and one that is over as soon as it begins."""
    choices = list(items_of(value_at(beat, "choices")))
    own = [order for _, order in items_of(value_at(beat, "do"))]
    known = [value_at(choice, "do") is not None for _, choice in choices]
    if not own and not choices and value_at(beat, "lasts") is None and "name" in given_keys(beat):
        yield Fault(path, "has nothing to do; give it do, choices, or lasts for a pause")
        return
    if value_at(beat, "until") or value_at(beat, "lasts") is not None or not all(known):
        return
    for _, choice in choices or [(0, None)]:
        orders = [*own, *(order for _, order in items_of(value_at(choice, "do")))]
        if orders and not any(map(_takes_time, orders)):
            message = "is over as soon as it begins; give it lasts, until, or an order that ends"
            yield Fault(path, message)
            return


def _takes_time(instruction: object) -> bool:
    """Return whether an instruction keeps a beat going for a while."""
    order = value_at(instruction, "do")
    key = key_of_order(order)
    if key is None or key == "wait" or isinstance(order, Wait):
        return True
    return VERBS[key].ends or bool(value_at(instruction, "at") or value_at(instruction, "when"))
