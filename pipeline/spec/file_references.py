"""File references: names of files in a scene, completed from the scene's own folder.

Sound fonts, songs, pictures of light, meshes of bodies and files of terrains are all found here.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.errors import FilmingError, Problem
from pipeline.foreign_files.confinement import Confinement
from pipeline.foreign_files.safe_file import (
    BODY_MESH,
    HEIGHT_MAP,
    PANORAMA,
    SONG,
    SOUNDFONT,
    TERRAIN_MESH,
    FileKind,
    ForeignFileError,
    require_file,
)
from pipeline.foreign_files.safe_file import content_digest as digest_of
from pipeline.spec.model_base import PathSegment
from pipeline.spec.yaml_tree import (
    ListNode,
    MappingNode,
    ScalarNode,
    SourceNode,
    find_node,
    with_node,
)

if TYPE_CHECKING:
    from pipeline.spec.scene import Scene

Steps = tuple[PathSegment, ...]
FileCheck = Callable[[Path, str], str | None]
"""Takes a file and the name that the author gave it; returns its error, None if it has none."""

TERRAIN_FILE_KINDS = {"image": HEIGHT_MAP, "mesh": TERRAIN_MESH}
"""Kinds of files by the kinds of terrain that read them."""

LOG = logging.getLogger("pronk")


def complete_file_names(
    scene: MappingNode, folder: Path | None, confinement: Confinement | None = None
) -> tuple[MappingNode, list[Problem]]:
    """Replace the file names in a scene by absolute ones.

    Args:
        scene: what the file of the scene holds.
        folder: its folder, None where it has none.
        confinement: of an untrusted scene; its names then lead to files without links.

    Returns:
        The scene, and the problems of the files.
    """
    problems: list[Problem] = []
    changed = scene
    for path, kind, file_fault in _file_keys(scene):
        name = find_node(scene, path)
        if len(name.path) < len(path) or not isinstance(name.tree, ScalarNode):
            continue
        text, place = name.tree.value, name.tree.place
        if not (isinstance(text, str) and text):
            continue
        whole = ((folder or Path()) / text).absolute()
        fault = None
        if confinement is not None:
            try:
                whole = confinement.located(whole)
                confinement.require(whole, kind)
            except ForeignFileError as error:
                fault = f"'{text}' {error}"
        fault = fault or file_fault(whole, text)
        if fault is not None:
            problems.append(place.problem(path, fault))
        changed = with_node(changed, path, ScalarNode(place, str(whole)))
    return changed, problems


def file_names(scene: Scene) -> Iterator[tuple[Steps, str]]:
    """Yield where a scene names files, and the complete name of each."""
    tree = scene.source_map.tree
    if not isinstance(tree, MappingNode):
        return
    for path, _, _ in _file_keys(tree):
        name = find_node(tree, path)
        if len(name.path) == len(path) and isinstance(name.tree, ScalarNode):
            yield path, str(name.tree.value)


def _file_keys(scene: MappingNode) -> Iterator[tuple[Steps, FileKind, FileCheck]]:
    """Yield the paths at which a scene may name files, with the kind and the check of each."""
    yield from _terrain_keys(scene.get("terrain"), ("terrain",))
    cast = scene.get("cast")
    for i, member in enumerate(cast.items if isinstance(cast, ListNode) else ()):
        if isinstance(member, MappingNode):
            is_many = isinstance(member.get("many"), MappingNode)
            body: Steps = ("many", "of") if is_many else ("body",)
            yield ("cast", i, *body, "file"), BODY_MESH, partial(_file_fault, BODY_MESH)
    yield ("sound", "soundfont"), SOUNDFONT, _soundfont_fault
    yield ("sound", "music", "file"), SONG, _song_fault
    yield ("light", "hdr", "file"), PANORAMA, _panorama_fault


def _terrain_keys(
    terrain: SourceNode | None, path: Steps
) -> Iterator[tuple[Steps, FileKind, FileCheck]]:
    if not isinstance(terrain, MappingNode):
        return
    terms = terrain.get("of")
    if isinstance(terms, ListNode):
        for i, term in enumerate(terms.items):
            yield from _terrain_keys(term, (*path, "of", i))
        return
    kind = terrain.get("kind")
    if isinstance(kind, ScalarNode) and isinstance(kind.value, str):
        file_kind = TERRAIN_FILE_KINDS.get(kind.value)
        if file_kind is not None:
            yield (*path, "file"), file_kind, partial(_file_fault, file_kind)


def _file_fault(kind: FileKind, path: Path, name: str) -> str | None:
    try:
        require_file(path, kind)
    except ForeignFileError as error:
        return f"'{name}' {error}"
    return None


def _panorama_fault(path: Path, name: str) -> str | None:
    # Only scenes with panoramas wait for what reads them.
    from render.errors import RenderError
    from render.panorama_file import panorama_fault

    try:
        fault = panorama_fault(path)
    except RenderError as error:
        raise FilmingError(str(error)) from error
    return fault and f"'{name}' {fault}"


def _soundfont_fault(path: Path, name: str) -> str | None:
    # Only scenes with SoundFonts wait for what reads them.
    from audio.errors import SoundFontPlayerError
    from audio.soundfont import soundfont_fault

    try:
        fault = soundfont_fault(path)
    except SoundFontPlayerError as error:
        # Only the sound needs it.
        LOG.warning("sound.soundfont: '%s' is not checked: %s", name, error)
        return None
    return fault and f"'{name}' {fault}"


def _song_fault(path: Path, name: str) -> str | None:
    # Only scenes with songs wait for what reads them.
    from audio.music.song_file import read_song

    try:
        read_song(path)
    except ForeignFileError as error:
        return f"'{name}' {error}"
    return None


def content_digest(file: str) -> str:
    """Return a digest of the content of a file, empty if it cannot be read."""
    try:
        # Its own limit, which may be lower, is kept where it is read.
        return digest_of(Path(file), TERRAIN_MESH)
    except ForeignFileError:
        return ""
