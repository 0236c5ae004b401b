"""Targets: what a name in an order or a behaviour may refer to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, get_args

from pipeline.spec.character_kinds import PEOPLE, Kind
from pipeline.spec.model_base import Fault
from pipeline.spec.partial_scene import Path, kind_of, unknown_name, value_at

Cast = Mapping[str, object]
"""The members of a cast, typed or raw, by name."""

UNKNOWN = "unknown"
"""Kind of a member that is itself wrong, which is reported where it stands."""

MEMBER_TEXTS: Mapping[str, str] = {
    "creature": "a creature",
    "dancer": "a dancer",
    "group": "a group",
    "one of a group": "one of a group",
    "many": "many bodies",
    "prop": "a prop",
    "body": "a body",
    **{kind: f"a{'n' if kind[0] in 'aeiou' else ''} {kind}" for kind in get_args(Kind)},
    "place": "a place",
}
"""Kinds of targets as messages name them."""


@dataclass(frozen=True, slots=True)
class TargetKind:
    """Kinds of members and places that an order or a behaviour can be directed at.

    Attributes:
        kinds: keys of `MEMBER_TEXTS` that fit.
        text: these kinds in messages.
        shapes: shapes of bodies and props that fit; all if empty.
    """

    kinds: frozenset[str]
    text: str
    shapes: frozenset[str] = frozenset()


THINGS = frozenset({"ball", "merry-go-round", "box", "bench", "prop", "body"})
JOINTED = frozenset({*PEOPLE, "ragdoll"})

ANYTHING = TargetKind(frozenset(MEMBER_TEXTS) - {"many"}, "a member of the cast or a place")
ANYBODY = TargetKind(ANYTHING.kinds - {"place"}, "a member of the cast")
EVENT_MEMBER = TargetKind((ANYBODY.kinds - {"group"}) | {"many"}, ANYBODY.text)
EVENT_PLACE = TargetKind(ANYTHING.kinds | {"many"}, ANYTHING.text)
FALLING = TargetKind(
    EVENT_MEMBER.kinds - {"one of a group"}, "a member of the cast that is no group"
)
CHARACTER = TargetKind(frozenset(get_args(Kind)), "a character")
JOINTED_CHARACTER = TargetKind(JOINTED, "a child, an adult or a ragdoll")
BALL = TargetKind(frozenset({"ball"}), "a ball")
GRASPABLE = TargetKind(THINGS | JOINTED, "a prop, a body or a character; hands hold nothing else")
MOVABLE = TargetKind(THINGS | {"ragdoll"}, "a prop, a body or a thing among the characters")
SEAT = TargetKind(
    frozenset({"box", "bench", "prop", "body"}),
    "a bench, a box, a rock or what else has a top to sit on",
    frozenset({"box", "cube", "brick", "cylinder", "prism", "hull", "mesh"})
    | {"octahedron", "dodecahedron", "icosahedron"},
)
RIDEABLE = TargetKind(
    frozenset({"merry-go-round", "prop", "body"}),
    "a merry-go-round, or a prop or a body with a flat top",
    frozenset({"box", "cube", "brick", "cylinder"}),
)
CAROUSEL = TargetKind(frozenset({"merry-go-round"}), "a merry-go-round")
OBSTACLE = TargetKind(ANYBODY.kinds - {"group", "one of a group"}, "a prop, a body or a creature")


def kind_of_target(member: object) -> str:
    """Return what a member of the cast is, as a key of `MEMBER_TEXTS`."""
    kind = kind_of(member)
    if kind == "character":
        own = value_at(member, "character")
        return own if own in get_args(Kind) else UNKNOWN
    if value_at(member, "many") is not None:
        return "many"
    return "creature" if kind == "figure" else kind or UNKNOWN


def faults_of_target(
    target: Any, own: str, fitting: TargetKind, path: Path, cast: Cast, places: Cast | None = None
) -> Iterator[Fault]:
    """Find a target that does not exist, is the performer itself, or is of another kind.

    Args:
        target: a name; anything else is checked where it is read.
        own: name of the performer.
        fitting: kinds that the target may have.
        path: of the name.
        cast: the members by name, the bodies of `many` by theirs.
        places: the places by name, where they fit as well.
    """
    if not isinstance(target, str):
        return
    places = places or {}
    if target in places and "place" in fitting.kinds:
        return
    name, _, part = target.partition(".")
    if name not in cast:
        known = [*cast, *(places if "place" in fitting.kinds else ())]
        yield unknown_name(name, known, path)
    elif name == own:
        yield Fault(path, f"'{own}' cannot do that to itself; name {fitting.text}")
    elif (message := _mismatch(name, part, cast[name], fitting)) is not None:
        yield Fault(path, message)


def _mismatch(name: str, part: str, member: object, fitting: TargetKind) -> str | None:
    """Return why a member is no target of a kind, None if it is one."""
    kind = kind_of_target(member)
    if kind == "many" and kind not in fitting.kinds:
        # Whether one of many exists is known when they are built.
        several = f"'{name}' is {MEMBER_TEXTS[kind]}"
        return None if part else f"{several}; name one of them, such as {name}_1"
    if kind == "group" and part:
        kind, name = "one of a group", f"{name}.{part}"
    if kind == "group" and kind not in fitting.kinds and "one of a group" in fitting.kinds:
        return f"'{name}' is a group; name one of them, such as {name}.0"
    if kind not in (*fitting.kinds, UNKNOWN):
        return f"'{name}' is {MEMBER_TEXTS[kind]}; name {fitting.text}"
    shape = value_at(value_at(member, kind), "shape") if fitting.shapes else None
    if kind in ("prop", "body") and isinstance(shape, str) and shape not in fitting.shapes:
        return f"'{name}' is a {shape}; name {fitting.text}"
    return None
