"""Acting: what a child or an adult can be told, and what of it they cannot do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, get_args

from pydantic import BaseModel

from pipeline.spec.character import JOINTED, PARTS, PEOPLE, Kind
from pipeline.spec.faults import Fault, Step
from pipeline.spec.nearest import hint

PEOPLE_ALONE = ("reach", "grab", "let_go", "hug", "grapple", "sit", "stand", "freeze", "urge")
"""What only people are told."""

ACTING = ("go_to", "turn_deg", "walk", "stop", "wait", "speed", "look_at", "look", *PEOPLE_ALONE)
"""What people can be told."""

WRONG = "wrong"
"""A kind of character that there is not."""

SEATS = ("box", "bench")

FELT = ("character", "prop", "figure", "dancer")
"""What characters meet, by the block that says what it is."""

WHOM: Mapping[str, tuple[Sequence[str], str]] = {
    "hug": (JOINTED, "a child, an adult or a ragdoll"),
    "grapple": (JOINTED, "a child, an adult or a ragdoll"),
    "sit": (SEATS, "a box or a bench"),
    "grab": ((), "a character"),
    "reach": ((), "a character, or a place [x, y, z]"),
    "look_at": ((), "a character, or a place [x, y, z]"),
}
"""What can be named by what people are told; nothing is any character."""

Path = tuple[Step, ...]


def faults_of_acting(
    member: object, name: str, do: object, path: Path, cast: Mapping[str, object]
) -> Iterator[Fault]:
    """Find what a character is told that it cannot do.

    Args:
        member: it, typed or raw.
        name: of it.
        do: what it is told, likewise.
        path: of that.
        cast: all members, by name.
    """
    if (fault := fault_of_thing(member, name, (*path[:-1], "who"))) is not None:
        yield fault
        return
    word = do if isinstance(do, str) else next(iter(_given(do)), None)
    if word is not None and word not in ACTING:
        message = f"'{name}' is a person, who can be told {', '.join(ACTING)}"
        yield Fault(path if isinstance(do, str) else (*path, word), message, at_key=word != do)
    for key, (kinds, what) in WHOM.items():
        if isinstance(whom := _get(do, key), str):
            yield from faults_of_whom(whom, name, kinds, what, (*path, key), cast)
    part, whom = _get(do, "part"), _get(do, "grab")
    if isinstance(part, str) and isinstance(whom, str) and whom in cast:
        if _get(cast[whom], "character") not in JOINTED:
            message = f"'{whom}' has no parts with names; take this away"
            yield Fault((*path, "part"), message, at_key=True)
        elif part not in PARTS:
            message = f"no part of '{whom}' is called '{part}', {hint(part, PARTS)}"
            yield Fault((*path, "part"), message)


def fault_of_thing(member: object, name: str, path: Path) -> Fault | None:
    """Find who follows no script: a thing, or one who is limp."""
    kind = _kind(member)
    if kind not in (*PEOPLE, WRONG):
        return Fault(path, f"'{name}' is a {kind}, which no script moves")
    if _get(member, "limp") is True:
        return Fault(path, f"'{name}' is limp, and follows no script")
    return None


def faults_of_touch(pair: object, path: Path, cast: Mapping[str, object]) -> Iterator[Fault]:
    """Find what is waited for to touch, and never will."""
    names = pair if isinstance(pair, list | tuple) else ()
    for k, name in enumerate(names):
        if not isinstance(name, str):
            continue
        if name not in cast:
            message = f"nobody in the cast is called '{name}', {hint(name, cast)}"
            yield Fault((*path, k), message)
        elif name in names[:k]:
            yield Fault((*path, k), f"'{name}' cannot touch itself; name another")
        elif not _is_felt(cast[name]):
            yield Fault((*path, k), f"'{name}' is nothing that a character feels; name another")
    known = [name for name in names if isinstance(name, str) and name in cast]
    if len(set(known)) == 2 and all(_get(cast[name], "character") is None for name in known):
        message = f"neither '{known[0]}' nor '{known[1]}' is a character, who would feel it"
        yield Fault(path, message)


def _is_felt(member: object) -> bool:
    """Say whether characters meet this member of the cast."""
    if any(_get(member, word) is not None for word in FELT):
        return True
    return bool(_get(_get(member, "body"), "collide") == "all")


def faults_of_hug(pair: object, path: Path, cast: Mapping[str, object]) -> Iterator[Fault]:
    """Find a hug that is waited for and never comes: one of the two is not fit for it."""
    names = list(pair) if isinstance(pair, list | tuple) else []
    if len(names) != 2 or not all(isinstance(name, str) for name in names):
        return
    who, whom = names
    if who not in cast:
        yield Fault((*path, 0), f"nobody in the cast is called '{who}', {hint(who, cast)}")
    elif (kind := _kind(cast[who])) not in (*PEOPLE, WRONG):
        kind = kind or "no character"
        yield Fault((*path, 0), f"'{who}' is {_article(kind)}{kind}; name a child or an adult")
    elif _get(cast[who], "limp") is True:
        yield Fault((*path, 0), f"'{who}' is limp, and hugs nobody")
    yield from faults_of_whom(whom, who, *WHOM["hug"], (*path, 1), cast)


def faults_of_whom(
    whom: str,
    name: str,
    kinds: Sequence[str],
    what: str,
    path: Path,
    cast: Mapping[str, object],
) -> Iterator[Fault]:
    """Find who is named, where one of some kinds is wanted, and is nobody, oneself or another."""
    if whom not in cast:
        yield Fault(path, f"nobody in the cast is called '{whom}', {hint(whom, cast)}")
    elif whom == name:
        yield Fault(path, f"'{name}' cannot do that to itself; name {what}")
    elif (kind := _kind(cast[whom])) is None or (kinds and kind not in (*kinds, WRONG)):
        kind = kind or "no character"
        yield Fault(path, f"'{whom}' is {_article(kind)}{kind}; name {what}")


def _kind(member: object) -> Any:
    """Return what kind of character a member of the cast is; a slip is told where it stands."""
    kind = _get(member, "character")
    return kind if kind is None or kind in get_args(Kind) else WRONG


def _article(kind: str) -> str:
    return "" if kind == "no character" else "an " if kind == "adult" else "a "


def _given(do: object) -> Iterator[str]:
    """Yield the keys of an instruction, the one that says what is done first."""
    if isinstance(do, BaseModel):
        yield from (key for key in type(do).model_fields if key in do.model_fields_set)
    elif isinstance(do, Mapping):
        keys = [key for key in do if isinstance(key, str)]
        yield from sorted(keys, key=lambda key: key not in ACTING)


def _get(thing: object, key: str) -> Any:
    if isinstance(thing, Mapping):
        return thing.get(key)
    return getattr(thing, key, None) if isinstance(thing, BaseModel) else None
