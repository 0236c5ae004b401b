"""Terrains from files: grayscale PNG pictures, and OBJ or PLY meshes that form a regular grid.

The faces of a mesh are not read: every cell is cut as those of all terrains are.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, UnidentifiedImageError

from pipeline.errors import Problem, SceneError
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.generators import generates
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.model_base import WORLD_LIMIT
from pipeline.spec.terrain.kinds import ImageTerrain, MeshTerrain


def refused(message: str) -> SceneError:
    """Return the error of a file that a terrain names."""
    return SceneError([Problem("file", message)])


MAX_PIXELS, MIN_PIXELS = 4000, 3
"""Pixels along one side."""

WHITE_VALUES = {"1": 1.0, "L": 255.0, "I;16": 65535.0, "I;16B": 65535.0, "I": 65535.0}
"""Value of white by Pillow's mode of the picture."""


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
    """
    name = f"'{Path(file).name}'"
    try:
        with warnings.catch_warnings():
            # Of pictures beyond 89 million pixels Pillow warns before it tells their size.
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            picture = Image.open(file, formats=("PNG",))
        with picture:
            _check(picture, name)
            values = np.asarray(picture, dtype=float)
            return values / WHITE_VALUES[picture.mode]
    except UnidentifiedImageError:
        raise refused(f"{name} is no PNG picture") from None
    except Image.DecompressionBombError:
        raise refused(f"{name} is larger than {MAX_PIXELS} x {MAX_PIXELS} pixels") from None
    except (OSError, SyntaxError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise refused(f"{name} cannot be read: {reason}") from None


def _check(picture: Image.Image, name: str) -> None:
    width, height = picture.size
    if max(width, height) > MAX_PIXELS:
        size = f"{width} x {height} pixels, more than {MAX_PIXELS} x {MAX_PIXELS}"
        raise refused(f"{name} has {size}; make it smaller")
    if min(width, height) < MIN_PIXELS:
        raise refused(
            f"{name} has {width} x {height} pixels, fewer than {MIN_PIXELS} x {MIN_PIXELS}"
        )
    if picture.mode not in WHITE_VALUES:
        raise refused(
            f"{name} is a picture of kind {picture.mode}; should be grayscale of 8 or 16 bits"
        )


MAX_FILE_BYTES = 2**30
MAX_VERTICES, MIN_VERTICES = 4001, 3
"""Vertices of a mesh along one side."""

LINE_TOLERANCE = 1e-5
"""Coordinates nearer than this fraction of the mesh's extent belong to one line of the grid."""

SPACING_TOLERANCE = 0.01
"""Largest deviation from even spacing, as a fraction of the spacing."""


PLY_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float": "f4",
    "double": "f8",
    "float32": "f4",
    "float64": "f8",
}
"""NumPy types by their names in PLY files."""

BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


class MeshError(Exception):
    """Why a mesh is none, in terrain."""


def obj_vertices(content: bytes) -> Array:
    """Return the vertices (V, 3) of an OBJ file.

    Raises:
        MeshError: it has none, or one that is no vertex.
    """
    rows = [line.split()[1:4] for line in content.splitlines() if line.startswith((b"v ", b"v\t"))]
    if not rows:
        raise MeshError("it has no vertices (lines that begin with v)")
    return _numbers(rows)


def ply_vertices(content: bytes) -> Array:
    """Return the vertices (V, 3) of a PLY file.

    Raises:
        MeshError: it is none, or its vertices are not its first element.
    """
    head, end, body = content.partition(b"end_header")
    lines = [line.split() for line in head.decode("latin-1").splitlines()]
    if not lines or lines[0] != ["ply"] or not end:
        raise MeshError("it does not begin with the header of a PLY file")
    order, count, columns = _header(lines)
    # The header ends with its line; what follows is data.
    body = body[1:] if body.startswith(b"\n") else body.partition(b"\n")[2]
    if order == "":
        return _text_vertices(body, count, list(columns))
    row = np.dtype([(name, order + kind) for name, kind in columns.items()])
    if len(body) < count * row.itemsize:
        raise MeshError("it ends before its last vertex")
    table = np.frombuffer(body, row, count)
    return np.stack([table[axis].astype(float) for axis in "xyz"], axis=-1)


def _header(lines: list[list[str]]) -> tuple[str, int, dict[str, str]]:
    """Return byte order, number of vertices, and the type of each of their columns."""
    order: str | None = None
    count = -1
    elements = 0
    columns: dict[str, str] = {}
    for line in lines:
        match line:
            case ["format", kind, *_]:
                order = BYTE_ORDERS.get(kind)
            case ["element", name, number]:
                elements += 1
                if elements == 1 and name != "vertex":
                    raise MeshError(f"its first element is '{name}'; should be 'vertex'")
                if elements == 1 and number.isdigit():
                    count = int(number)
            case ["property", kind, name] if elements == 1:
                columns[name] = PLY_TYPES.get(kind, "")
            case ["property", "list", *_] if elements == 1:
                raise MeshError("its vertices have lists")
    if order is None:
        raise MeshError(f"its format is none of {', '.join(BYTE_ORDERS)}")
    if count < 0 or not {"x", "y", "z"} <= columns.keys() or not all(columns.values()):
        raise MeshError("its header says no number of vertices with x, y and z")
    return order, count, columns


def _text_vertices(body: bytes, count: int, columns: list[str]) -> Array:
    rows = [line.split() for line in body.splitlines() if line.strip()][:count]
    if len(rows) < count or any(len(row) < len(columns) for row in rows):
        raise MeshError("it ends before its last vertex")
    places = [columns.index(axis) for axis in "xyz"]
    return _numbers([[row[k] for k in places] for row in rows])


def _numbers(rows: list[list[Any]]) -> Array:
    try:
        found = np.array(rows, dtype=float)
    except ValueError:
        found = np.zeros(0)
    if found.ndim != 2 or found.shape[1] != 3:
        raise MeshError("a vertex is not three numbers")
    return found


READERS = {".obj": obj_vertices, ".ply": ply_vertices}


@generates(MeshTerrain)
def mesh(terrain: MeshTerrain, rng: np.random.Generator) -> HeightField:
    """Return the heights of a mesh, at its own places in x and z.

    Raises:
        SceneError: the file is no mesh that can be read, or no regular grid.
    """
    del rng
    vertices = terrain.scale * read_vertices(Path(terrain.file))
    if terrain.up == "z":
        vertices = np.stack([vertices[:, 0], vertices[:, 2], -vertices[:, 1]], axis=-1)
    name = f"'{Path(terrain.file).name}'"
    if np.abs(vertices).max() > WORLD_LIMIT:
        raise refused(f"{name} reaches farther than {WORLD_LIMIT:g} m; is its scale right?")
    try:
        return grid_of(vertices)
    except MeshError as error:
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
        if path.stat().st_size > MAX_FILE_BYTES:
            raise refused(f"{name} is larger than {MAX_FILE_BYTES // 2**20} MiB")
        vertices = reader(path.read_bytes())
    except OSError as error:
        raise refused(f"{name} cannot be read: {error.strerror}") from None
    except MeshError as error:
        raise refused(f"{name} cannot be read: {error}") from None
    if len(vertices) < MIN_VERTICES**2:
        raise refused(f"{name} has {len(vertices)} vertices, fewer than {MIN_VERTICES**2}")
    if not np.isfinite(vertices).all():
        raise refused(f"{name} has a vertex that is not finite")
    return vertices


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
