"""The SoundFont that a scene names, from the scene's own folder."""

from __future__ import annotations

from pathlib import Path

from pipeline.errors import Problem
from pipeline.spec.tree import Leaf, Table


def sound_named_in_full(scene: Table, folder: Path | None) -> tuple[Table, list[Problem]]:
    """Name the file of a scene's sound in full.

    Args:
        scene: what the file of the scene holds.
        folder: its folder, None where it has none.

    Returns:
        The scene, and what is wrong with the name.
    """
    sound = scene.get("sound")
    font = sound.get("soundfont") if isinstance(sound, Table) else None
    if not (isinstance(sound, Table) and isinstance(font, Leaf)):
        return scene, []
    if not (isinstance(font.value, str) and font.value):
        return scene, []
    whole = ((folder or Path()) / font.value).absolute()
    problems = list[Problem]()
    try:
        there = whole.is_file()
    except (OSError, ValueError):
        there = False
    if not there:
        said = f"'{font.value}' is no file in {whole.parent}"
        problems.append(font.place.problem(("sound", "soundfont"), said))
    named = sound.having("soundfont", sound.entries["soundfont"].key, Leaf(font.place, str(whole)))
    return scene.having("sound", scene.entries["sound"].key, named), problems
