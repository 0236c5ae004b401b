"""Partial scene: reads a scene that may be typed, or still raw and perhaps wrong elsewhere.

Checks between the parts of a scene read it through these functions, so that their errors are
found together with all others of the file.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel

from pipeline.spec.model_base import Fault, PathSegment
from pipeline.spec.suggestions import hint

Path = tuple[PathSegment, ...]

MEMBER_BLOCKS = ("figure", "prop", "body", "group", "many", "dancer", "character")
"""The block that says what a member of the cast is."""


def value_at(block: object, key: str) -> Any:
    """Return the value of a key, None where there is none."""
    if isinstance(block, Mapping):
        return block.get(key)
    return getattr(block, key, None) if isinstance(block, BaseModel) else None


def text_keys(block: object) -> set[str]:
    """Return the keys of a mapping that are text, none if it is no mapping."""
    return {key for key in block if isinstance(key, str)} if isinstance(block, Mapping) else set()


def given_keys(block: object) -> list[str]:
    """Return the keys that the author wrote, in their order, none if it is no mapping."""
    if isinstance(block, BaseModel):
        return [key for key in type(block).model_fields if key in block.model_fields_set]
    return [key for key in block if isinstance(key, str)] if isinstance(block, Mapping) else []


def items_of(block: object) -> Iterator[tuple[int, Any]]:
    """Yield the items of a list with their indices; none of anything else."""
    return iter(enumerate(block if isinstance(block, list | tuple) else ()))


def items_or_itself(block: object) -> Iterator[tuple[Path, Any]]:
    """Yield the items of a list, or the one value that stands instead of a list, with paths."""
    if isinstance(block, list | tuple):
        yield from (((i,), item) for i, item in enumerate(block))
    else:
        yield (), block


def located_instructions(scene: object) -> Iterator[tuple[Path, Any]]:
    """Yield the instructions of the script and of the beats of the story, with their paths."""
    for i, instruction in items_of(value_at(scene, "script")):
        yield ("script", i), instruction
    for b, beat in items_of(value_at(value_at(scene, "story"), "beats")):
        path: Path = ("story", "beats", b)
        for k, instruction in items_of(value_at(beat, "do")):
            yield (*path, "do", k), instruction
        for c, choice in items_of(value_at(beat, "choices")):
            for k, instruction in items_of(value_at(choice, "do")):
                yield (*path, "choices", c, "do", k), instruction


def named_cast(scene: object) -> list[tuple[str, Any]]:
    """Return the names and members of the cast, in order; a wrong file may repeat a name."""
    members = [member for _, member in items_of(value_at(scene, "cast"))]
    return list(zip(member_names(members), members, strict=True))


def cast_by_name(scene: object) -> dict[str, Any]:
    """Return the members of the cast by their names."""
    return dict(named_cast(scene))


def member_names(members: Sequence[object]) -> list[str]:
    """Return the names of the members of a cast.

    A member without a name is called after its kind, and numbered from the second on: the
    first keeps its name (and so its random numbers) when another is added.
    """
    given = [value_at(member, "name") for member in members]
    own_names = [name if isinstance(name, str) else "" for name in given]
    taken = {name for name in own_names if name}
    last: dict[str, int] = {}
    names = []
    for own, member in zip(own_names, members, strict=True):
        kind = _kind_name(member)
        # The bodies of `many` are numbered after a `_` themselves.
        mark = "" if _has_layout(member) else "_"
        name, number = own or kind, last.get(kind, 1)
        while not own and name in taken:
            number += 1
            name = f"{kind}{mark}{number}"
        if not own:
            last[kind] = number
        taken.add(name)
        names.append(name)
    return names


def _has_layout(member: object) -> bool:
    many = value_at(member, "many")
    return isinstance(many, Mapping | BaseModel)


def _kind_name(member: object) -> str:
    """Return what a member is called that has no name."""
    if isinstance(member, BaseModel):
        return str(getattr(member, "kind_name", ""))
    if not isinstance(member, Mapping):
        return ""
    shape, many = member.get("prop") or member.get("body"), member.get("many")
    kind = shape.get("shape") if isinstance(shape, Mapping) else member.get("figure")
    kind = kind or member.get("character")
    if isinstance(group := member.get("group"), Mapping):
        kind = group.get("rule")
    if isinstance(many, Mapping):
        kind = many.get("layout", "wall")
    if "dancer" in member:
        kind = "dancer"
    return kind if isinstance(kind, str) else ""


def kind_of(member: object) -> str | None:
    """Return the key of the block that makes a member what it is; `body` for `many`."""
    block = next((key for key in MEMBER_BLOCKS if value_at(member, key) is not None), None)
    return "body" if block == "many" else block


def unknown_name(name: str, known: Collection[str], path: Path) -> Fault:
    """Return the fault of a name that no member of the cast has."""
    return Fault(path, f"nobody in the cast is called '{name}', {hint(name, known)}")
