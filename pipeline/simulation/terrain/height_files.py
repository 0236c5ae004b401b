"""Terrains from files: grayscale PNG pictures, and OBJ or PLY meshes that form a regular grid.

The faces of a mesh are not read: every cell is cut as those of all terrains are.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.errors import Problem, ProductionError, SceneError
from pipeline.foreign_files.reader_process import (
    ReaderMissing,
    ReaderProcessError,
    Reading,
    read_confined,
)
from pipeline.foreign_files.safe_file import TERRAIN_MESH, ForeignFileError
from pipeline.simulation.mesh_file import MeshError, mesh_vertices
from pipeline.simulation.png_reader import MAX_PIXELS, SAMPLE_TYPES
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.generators import generates
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.model_base import WORLD_LIMIT
from pipeline.spec.terrain.kinds import ImageTerrain, MeshTerrain


def refused(message: str) -> SceneError:
    """Return the error of a file that a terrain names."""
    return SceneError([Problem("file", message)])


WHITE_VALUES = {"1": 255.0, "L": 255.0, "I;16": 65535.0, "I;16B": 65535.0, "I": 65535.0}
"""Value of white by Pillow's mode of the picture."""

PNG_MEMORY, PNG_TIME = 512 * 2**20, 30.0
"""Memory [bytes] and processor time [s] that the decoding of a picture may take."""


@generates(ImageTerrain)
def image(terrain: ImageTerrain, rng: np.random.Generator) -> HeightField:
    """Return the heights of a picture: a vertex a pixel, or as many cells as are asked.

    The picture lies as it is seen from above with x to the right: its first row is at the
    lowest z.

    Raises:
        SceneError: the file is no such picture.
    """
    del rng
    field = HeightField(
        terrain.low + (terrain.high - terrain.low) * read_gray(terrain.file), terrain.size
    )
    if terrain.cells is None or terrain.cells == field.cells:
        return field
    n_x, n_z = terrain.cells
    x = np.linspace(-field.size[0] / 2.0, field.size[0] / 2.0, n_x + 1)
    z = np.linspace(-field.size[1] / 2.0, field.size[1] / 2.0, n_z + 1)
    return HeightField(field.height(*np.meshgrid(x, z)), terrain.size)


def read_gray(file: str) -> Array:
    """Return a grayscale picture (height, width) of values 0 to 1.

    Raises:
        SceneError: the file is no such picture.
        ProductionError: no picture can be read.
    """
    content = bytearray()
    reading = Reading(
        "pipeline.simulation.png_reader:read_gray",
        Path(file),
        PNG_MEMORY,
        PNG_TIME,
        max_bytes=4 * MAX_PIXELS**2,
    )
    try:
        facts = read_confined(reading, content.extend)
    except ForeignFileError as error:
        raise refused(f"'{Path(file).name}' {error}") from None
    except (ReaderMissing, ReaderProcessError) as error:
        raise ProductionError(f"{file}: cannot be read: {error}") from error
    width, height = facts["size"]
    values = np.frombuffer(content, SAMPLE_TYPES[facts["mode"]]).reshape(height, width)
    return values.astype(float) / WHITE_VALUES[facts["mode"]]


MAX_VERTICES, MIN_VERTICES = 4001, 3
"""Vertices of a mesh along one side."""

LINE_TOLERANCE = 1e-5
"""Coordinates nearer than this fraction of the mesh's extent belong to one line of the grid."""

SPACING_TOLERANCE = 0.01
"""Largest deviation from even spacing, as a fraction of the spacing."""


@generates(MeshTerrain)
def mesh(terrain: MeshTerrain, rng: np.random.Generator) -> HeightField:
    """Return the heights of a mesh, at its own places in x and z.

    Raises:
        SceneError: the file is no mesh that can be read, or no regular grid.
    """
    del rng
    name = f"'{Path(terrain.file).name}'"
    try:
        vertices = mesh_vertices(Path(terrain.file), TERRAIN_MESH, MAX_VERTICES**2)
    except MeshError as error:
        raise refused(f"{name} {error}") from None
    if len(vertices) < MIN_VERTICES**2:
        raise refused(f"{name} has {len(vertices)} vertices, fewer than {MIN_VERTICES**2}")
    if np.abs(vertices).max() > WORLD_LIMIT / terrain.scale:
        raise refused(f"{name} reaches farther than {WORLD_LIMIT:g} m; is its scale right?")
    vertices *= terrain.scale
    if terrain.up == "z":
        vertices = np.stack([vertices[:, 0], vertices[:, 2], -vertices[:, 1]], axis=-1)
    try:
        return grid_of(vertices)
    except MeshError as error:
        raise refused(f"{name} is no regular grid in x and z: {error}") from None


def grid_of(vertices: Array) -> HeightField:
    """Return the height field whose grid vertices (V, 3) are, in any order.

    Raises:
        MeshError: they form no regular grid.
    """
    lines, places = [], []
    for axis in (0, 2):
        values, place = _lines(vertices[:, axis])
        if not MIN_VERTICES <= len(values) <= MAX_VERTICES:
            counted = f"{len(values)} different values of {'x z'[axis]}"
            raise MeshError(f"{counted}, where {MIN_VERTICES} to {MAX_VERTICES} are needed")
        even = np.linspace(values[0], values[-1], len(values))
        if np.abs(values - even).max() > SPACING_TOLERANCE * (even[1] - even[0]):
            raise MeshError(f"its values of {'x z'[axis]} are not evenly spaced")
        lines.append(values)
        places.append(place)
    (x, z), (i, j) = lines, places
    if len(vertices) != len(x) * len(z):
        raise MeshError(f"it has {len(vertices)} vertices, and {len(x)} x {len(z)} places for them")
    heights = np.full((len(z), len(x)), np.nan)
    heights[j, i] = vertices[:, 1]
    if np.isnan(heights).any():
        raise MeshError("two of its vertices lie above one another")
    size = float(x[-1] - x[0]), float(z[-1] - z[0])
    return HeightField(heights, size, (float(x[0] + x[-1]) / 2.0, float(z[0] + z[-1]) / 2.0))


def _lines(values: Array) -> tuple[Array, np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """Return the different values in order, and the number of that which each is."""
    order = np.argsort(values, kind="stable")
    ordered = values[order]
    apart = np.diff(ordered) > LINE_TOLERANCE * max(float(ordered[-1] - ordered[0]), 1e-12)
    number = np.concatenate([[0], np.cumsum(apart)])
    place = np.empty(len(values), dtype=np.int64)
    place[order] = number
    counts = np.bincount(number)
    return np.bincount(number, ordered) / counts, place
