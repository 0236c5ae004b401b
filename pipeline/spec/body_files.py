"""Files that bodies of a cast name, from the scene's own folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pipeline.errors import Problem
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
    body = member.get("body") if isinstance(member, Table) else None
    file = body.get("file") if isinstance(body, Table) else None
    if not (isinstance(member, Table) and isinstance(body, Table) and isinstance(file, Leaf)):
        return member
    if not (isinstance(file.value, str) and file.value):
        return member
    whole = ((folder or Path()) / file.value).absolute()
    try:
        there = whole.is_file()
    except (OSError, ValueError):
        there = False
    if not there:
        said = f"'{file.value}' is no file in {whole.parent}"
        problems.append(file.place.problem(("cast", i, "body", "file"), said))
    named = body.having("file", body.entries["file"].key, Leaf(file.place, str(whole)))
    return member.having("body", member.entries["body"].key, named)


def cast_simulated(cast: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return what the simulation reads of a cast's words: of files, what they hold."""
    return [
        member | {"body": member["body"] | {"file": content_digest(member["body"]["file"])}}
        if "file" in (member.get("body") or {})
        else member
        for member in cast
    ]
