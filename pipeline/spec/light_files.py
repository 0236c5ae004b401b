"""The picture of a place that lights a scene, from the scene's own folder."""

from __future__ import annotations

from pathlib import Path

from pipeline.errors import Problem
from pipeline.spec.tree import Leaf, Table


def light_named_in_full(scene: Table, folder: Path | None) -> tuple[Table, list[Problem]]:
    """Name the picture of a scene's light in full.

    Args:
        scene: what the file of the scene holds.
        folder: its folder, None where it has none.

    Returns:
        The scene, and what is wrong with the picture.
    """
    light = scene.get("light")
    hdr = light.get("hdr") if isinstance(light, Table) else None
    file = hdr.get("file") if isinstance(hdr, Table) else None
    if not (isinstance(light, Table) and isinstance(hdr, Table) and isinstance(file, Leaf)):
        return scene, []
    if not (isinstance(file.value, str) and file.value):
        return scene, []
    whole = ((folder or Path()) / file.value).absolute()
    fault = _fault(whole, file.value)
    path = ("light", "hdr", "file")
    problems = [] if fault is None else [file.place.problem(path, fault)]
    named = hdr.having("file", hdr.entries["file"].key, Leaf(file.place, str(whole)))
    lit = light.having("hdr", light.entries["hdr"].key, named)
    return scene.having("light", scene.entries["light"].key, lit), problems


def _fault(whole: Path, said: str) -> str | None:
    # Only scenes with pictures wait for the library that reads them.
    from render.panorama_file import panorama_fault

    try:
        there = whole.is_file()
    except (OSError, ValueError):
        there = False
    return panorama_fault(whole) if there else f"'{said}' is no file in {whole.parent}"
