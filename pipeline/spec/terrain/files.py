"""Ground from a file: a picture of heights, or a mesh that is a grid.

A scene names the file from its own folder. What the file holds is read by the simulation.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from pipeline.errors import Problem
from pipeline.spec.faults import Step
from pipeline.spec.terrain.ground import SIZE, Cells, Ground, Size
from pipeline.spec.tree import Leaf, Row, Table, Tree
from pipeline.spec.values import Coordinate, Length

KINDS = ("image", "mesh")


class ImageTerrain(Ground):
    """Heights from a grayscale picture: its columns along x, its rows along z."""

    kind: Literal["image"] = Field("image", description="Heights from a picture.")
    file: str = Field(
        min_length=1,
        max_length=1000,
        description="A grayscale PNG of 8 or 16 bits, named from the scene's folder.",
    )
    size: Size = Field((30.0, 30.0), description=SIZE)
    cells: Cells | None = Field(
        None,
        description="Number of cells of the grid along x and z; one from pixel to pixel if left "
        "out.",
    )
    low: Coordinate = Field(0.0, description="Height of black [m].")
    high: Coordinate = Field(1.5, description="Height of white [m].")


class MeshTerrain(Ground):
    """Heights from a mesh whose vertices form a regular grid; its faces are not read."""

    kind: Literal["mesh"] = Field("mesh", description="Heights from a mesh.")
    file: str = Field(
        min_length=1,
        max_length=1000,
        description="An OBJ or PLY mesh, named from the scene's folder.",
    )
    up: Literal["y", "z"] = Field("y", description="The axis of the file that points up.")
    scale: Length = Field(1.0, description="Metres a unit of the file.")


def beside(scene: Table, folder: Path | None) -> tuple[Table, list[Problem]]:
    """Name the files of a scene's terrain in full.

    Args:
        scene: what the file of the scene holds.
        folder: its folder, None where it has none.

    Returns:
        The scene, and what is wrong with the names.
    """
    terrain = scene.get("terrain")
    if not isinstance(terrain, Table):
        return scene, []
    problems = list[Problem]()
    found = _named(terrain, folder, ("terrain",), problems)
    return scene.having("terrain", scene.entries["terrain"].key, found), problems


def _named(
    terrain: Tree, folder: Path | None, path: tuple[Step, ...], problems: list[Problem]
) -> Tree:
    if not isinstance(terrain, Table):
        return terrain
    terms = terrain.get("of")
    if isinstance(terms, Row):
        items = [
            _named(item, folder, (*path, "of", i), problems) for i, item in enumerate(terms.items)
        ]
        return terrain.having("of", terrain.entries["of"].key, Row(terms.place, tuple(items)))
    kind, file = terrain.get("kind"), terrain.get("file")
    if not (isinstance(kind, Leaf) and kind.value in KINDS):
        return terrain
    if not (isinstance(file, Leaf) and isinstance(file.value, str) and file.value):
        return terrain
    whole = ((folder or Path()) / file.value).absolute()
    wrong = _cannot_be_read(whole)
    if wrong:
        problems.append(file.place.problem((*path, "file"), f"'{file.value}' {wrong}"))
    return terrain.having("file", terrain.entries["file"].key, Leaf(file.place, str(whole)))


def _cannot_be_read(path: Path) -> str:
    try:
        if path.is_dir():
            return "is a folder, not a file"
        return "" if path.exists() else f"does not exist in {path.parent}"
    except (OSError, ValueError) as error:
        return f"cannot be the name of a file: {error}"


def content_digest(file: str) -> str:
    """Return a digest of what a file holds, empty if it cannot be read."""
    try:
        return hashlib.blake2b(Path(file).read_bytes(), digest_size=20).hexdigest()
    except (OSError, ValueError):
        return ""


SHOWN = ("show_forbidden", "footprints")
"""Words of a terrain that only its picture follows."""


def simulated(words: dict[str, Any]) -> dict[str, Any]:
    """Return what the simulation reads of a terrain's words.

    Of files that is what they hold, not what they are called; forbidden zones and
    footprints are there whether they are shown or not.
    """
    words = {key: value for key, value in words.items() if key not in SHOWN}
    if "file" in words:
        words["file"] = content_digest(words["file"])
    if "of" in words:
        words["of"] = [simulated(term) for term in words["of"]]
    return words
