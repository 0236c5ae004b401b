"""File references: names of files in a scene, completed from the scene's own folder.

Sound fonts, pictures of light, meshes of bodies and files of terrains are all found here.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from pathlib import Path

from pipeline.errors import Problem
from pipeline.spec.model_base import PathSegment
from pipeline.spec.yaml_tree import (
    ListNode,
    MappingNode,
    ScalarNode,
    SourceNode,
    find_node,
    with_node,
)

Steps = tuple[PathSegment, ...]
FileCheck = Callable[[Path, str], str | None]
"""Takes a file and the name that the author gave it; returns its error, None if it has none."""

TERRAIN_FILE_KINDS = ("image", "mesh")
"""Kinds of terrain that read a file."""


def complete_file_names(
    scene: MappingNode, folder: Path | None
) -> tuple[MappingNode, list[Problem]]:
    """Replace the file names in a scene by absolute ones.

    Args:
        scene: what the file of the scene holds.
        folder: its folder, None where it has none.

    Returns:
        The scene, and the problems of the files.
    """
    problems: list[Problem] = []
    changed = scene
    for path, file_fault in _file_keys(scene):
        name = find_node(scene, path)
        if len(name.path) < len(path) or not isinstance(name.tree, ScalarNode):
            continue
        text, place = name.tree.value, name.tree.place
        if not (isinstance(text, str) and text):
            continue
        whole = ((folder or Path()) / text).absolute()
        fault = file_fault(whole, text)
        if fault is not None:
            problems.append(place.problem(path, fault))
        changed = with_node(changed, path, ScalarNode(place, str(whole)))
    return changed, problems


def _file_keys(scene: MappingNode) -> Iterator[tuple[Steps, FileCheck]]:
    """Yield the paths at which a scene may name files, with the check of each file."""
    yield from _terrain_keys(scene.get("terrain"), ("terrain",))
    cast = scene.get("cast")
    for i, member in enumerate(cast.items if isinstance(cast, ListNode) else ()):
        if isinstance(member, MappingNode):
            is_many = isinstance(member.get("many"), MappingNode)
            body: Steps = ("many", "of") if is_many else ("body",)
            yield ("cast", i, *body, "file"), _missing_file
    yield ("sound", "soundfont"), _missing_file
    yield ("light", "hdr", "file"), _panorama_fault


def _terrain_keys(terrain: SourceNode | None, path: Steps) -> Iterator[tuple[Steps, FileCheck]]:
    if not isinstance(terrain, MappingNode):
        return
    terms = terrain.get("of")
    if isinstance(terms, ListNode):
        for i, term in enumerate(terms.items):
            yield from _terrain_keys(term, (*path, "of", i))
        return
    kind = terrain.get("kind")
    if isinstance(kind, ScalarNode) and kind.value in TERRAIN_FILE_KINDS:
        yield (*path, "file"), _unreadable_file


def _missing_file(path: Path, name: str) -> str | None:
    try:
        exists = path.is_file()
    except (OSError, ValueError):
        exists = False
    return None if exists else f"'{name}' is no file in {path.parent}"


def _panorama_fault(path: Path, name: str) -> str | None:
    fault = _missing_file(path, name)
    if fault is not None:
        return fault
    # Only scenes with pictures wait for the library that reads them.
    from render.panorama_file import panorama_fault

    return panorama_fault(path)


def _unreadable_file(path: Path, name: str) -> str | None:
    try:
        if path.is_dir():
            return f"'{name}' is a folder, not a file"
        return None if path.exists() else f"'{name}' does not exist in {path.parent}"
    except (OSError, ValueError) as error:
        return f"'{name}' cannot be the name of a file: {error}"


def content_digest(file: str) -> str:
    """Return a digest of the content of a file, empty if it cannot be read."""
    try:
        return hashlib.blake2b(Path(file).read_bytes(), digest_size=20).hexdigest()
    except (OSError, ValueError):
        return ""
