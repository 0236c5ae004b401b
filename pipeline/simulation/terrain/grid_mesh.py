"""Heights from a mesh whose vertices form a regular grid in x and z.

The faces are not read: every cell is cut as those of all terrains are.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.from_file import refused
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.simulation.terrain.mesh_vertices import NotRead, obj_vertices, ply_vertices
from pipeline.spec.terrain import MeshTerrain
from pipeline.spec.values import FAR

MOST_BYTES = 2**30
MOST, FEWEST = 4001, 3
"""Vertices along one side."""

SAME = 1e-5
"""Coordinates nearer than this, in the extent of the mesh, belong to one line of the grid."""

EVEN = 0.01
"""Lines of the grid are this near to even spacing, in their spacing."""

READERS = {".obj": obj_vertices, ".ply": ply_vertices}


def mesh(words: MeshTerrain, chance: np.random.Generator) -> HeightField:
    """Return the heights of a mesh, at its own places in x and z.

    Raises:
        SceneError: the file is no mesh that can be read, or no regular grid.
    """
    del chance
    vertices = words.scale * read_vertices(Path(words.file))
    if words.up == "z":
        vertices = np.stack([vertices[:, 0], vertices[:, 2], -vertices[:, 1]], axis=-1)
    name = f"'{Path(words.file).name}'"
    if np.abs(vertices).max() > FAR:
        raise refused(f"{name} reaches farther than {FAR:g} m; is its scale right?")
    try:
        return grid_of(vertices)
    except NotRead as error:
        raise refused(f"{name} is no regular grid in x and z: {error}") from None


def read_vertices(path: Path) -> Array:
    """Return the vertices (V, 3) of a mesh file, in its own units.

    Raises:
        SceneError: it cannot be read.
    """
    name = f"'{path.name}'"
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise refused(f"{name} should end in .obj or .ply")
    try:
        if path.stat().st_size > MOST_BYTES:
            raise refused(f"{name} is larger than {MOST_BYTES // 2**20} MiB")
        vertices = reader(path.read_bytes())
    except OSError as error:
        raise refused(f"{name} cannot be read: {error.strerror}") from None
    except NotRead as error:
        raise refused(f"{name} cannot be read: {error}") from None
    if len(vertices) < FEWEST**2:
        raise refused(f"{name} has {len(vertices)} vertices, fewer than {FEWEST**2}")
    if not np.isfinite(vertices).all():
        raise refused(f"{name} has a vertex that is not finite")
    return vertices


def grid_of(vertices: Array) -> HeightField:
    """Return the height field whose grid vertices (V, 3) are, in any order.

    Raises:
        NotRead: they form no regular grid.
    """
    lines, places = [], []
    for axis in (0, 2):
        values, place = _lines(vertices[:, axis])
        if not FEWEST <= len(values) <= MOST:
            told = f"{len(values)} different values of {'x z'[axis]}"
            raise NotRead(f"{told}, where {FEWEST} to {MOST} are needed")
        even = np.linspace(values[0], values[-1], len(values))
        if np.abs(values - even).max() > EVEN * (even[1] - even[0]):
            raise NotRead(f"its values of {'x z'[axis]} are not evenly spaced")
        lines.append(values)
        places.append(place)
    (x, z), (i, j) = lines, places
    if len(vertices) != len(x) * len(z):
        raise NotRead(f"it has {len(vertices)} vertices, and {len(x)} x {len(z)} places for them")
    heights = np.full((len(z), len(x)), np.nan)
    heights[j, i] = vertices[:, 1]
    if np.isnan(heights).any():
        raise NotRead("two of its vertices lie above one another")
    size = float(x[-1] - x[0]), float(z[-1] - z[0])
    return HeightField(heights, size, (float(x[0] + x[-1]) / 2.0, float(z[0] + z[-1]) / 2.0))


def _lines(values: Array) -> tuple[Array, np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """Return the different values in order, and the number of that which each is."""
    order = np.argsort(values, kind="stable")
    ordered = values[order]
    apart = np.diff(ordered) > SAME * max(float(ordered[-1] - ordered[0]), 1e-12)
    number = np.concatenate([[0], np.cumsum(apart)])
    place = np.empty(len(values), dtype=np.int64)
    place[order] = number
    counts = np.bincount(number)
    return np.bincount(number, ordered) / counts, place
