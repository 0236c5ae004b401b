"""Files that bodies of a cast name, from the scene's own folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pipeline.errors import Problem
from pipeline.spec.faults import Step
from pipeline.spec.terrain.files import content_digest
from pipeline.spec.tree import Leaf, Row, Table, Tree


def bodies_named_in_full(scene: Table, folder: Path | None) -> tuple[Table, list[Problem]]:
    """Name the files of a scene's bodies in full.

    Args:
        scene: what the file of the scene holds.
        folder: its folder, None where it has none.

    Returns:
        The scene, and what is wrong with the names.
    """
    cast = scene.get("cast")
    if not isinstance(cast, Row):
        return scene, []
    problems = list[Problem]()
    items = tuple(_named(one, folder, i, problems) for i, one in enumerate(cast.items))
    return scene.having("cast", scene.entries["cast"].key, Row(cast.place, items)), problems


def _named(member: Tree, folder: Path | None, i: int, problems: list[Problem]) -> Tree:
    many = member.get("many") if isinstance(member, Table) else None
    if isinstance(member, Table) and isinstance(many, Table):
        whole = _whole(many, "of", folder, ("cast", i, "many"), problems)
        return member.having("many", member.entries["many"].key, whole)
    if not isinstance(member, Table):
        return member
    return _whole(member, "body", folder, ("cast", i), problems)


def _whole(
    around: Table, key: str, folder: Path | None, path: tuple[Step, ...], problems: list[Problem]
) -> Table:
    """Return the table around a body's words with its file, if it has one, named in full."""
    body = around.get(key)
    file = body.get("file") if isinstance(body, Table) else None
    if not (isinstance(body, Table) and isinstance(file, Leaf)):
        return around
    if not (isinstance(file.value, str) and file.value):
        return around
    whole = ((folder or Path()) / file.value).absolute()
    try:
        there = whole.is_file()
    except (OSError, ValueError):
        there = False
    if not there:
        said = f"'{file.value}' is no file in {whole.parent}"
        problems.append(file.place.problem((*path, key, "file"), said))
    named = body.having("file", body.entries["file"].key, Leaf(file.place, str(whole)))
    return around.having(key, around.entries[key].key, named)


def cast_simulated(cast: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return what the simulation reads of a cast's words: of files, what they hold."""
    return [
        member | {"many": _held(member["many"], "of")}
        if "many" in member
        else _held(member, "body")
        for member in cast
    ]


def _held(around: dict[str, Any], key: str) -> dict[str, Any]:
    body = around.get(key) or {}
    if "file" not in body:
        return around
    return around | {key: body | {"file": content_digest(body["file"])}}
