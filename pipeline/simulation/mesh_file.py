"""Mesh files: the vertices of OBJ and PLY files. Their faces are not read.

The parsers are written for files from anywhere: every count is checked before it is used, and text
is read block by block, so that it takes little more memory than its vertices.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from pipeline.foreign_files.safe_file import FileKind, ForeignFileError, read_file
from pipeline.simulation.spatial import Array

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

MAX_HEADER_BYTES = 65_536

BLOCK_BYTES = 2**22
"""Text that is split into numbers at once."""


class MeshError(Exception):
    """Why a file is no mesh, to continue its name."""


def mesh_vertices(path: Path, kind: FileKind, most: int) -> Array:
    """Return the vertices (V, 3) of a mesh file, in its own units.

    Args:
        path: of the file; its suffix tells the format.
        kind: of the file, with the limit of its size.
        most: number of vertices that are read.

    Raises:
        MeshError: it cannot be read, or has more vertices.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise MeshError(f"should end in {' or '.join(READERS)}")
    try:
        content = read_file(path, kind)
    except ForeignFileError as error:
        raise MeshError(str(error)) from None
    vertices = reader(content, most)
    if not np.isfinite(vertices).all():
        raise MeshError("has a vertex that is not finite")
    return vertices


def obj_vertices(content: bytes, most: int) -> Array:
    """Return the vertices (V, 3) of an OBJ file.

    Raises:
        MeshError: it has none or more than `most`, or one that is no vertex.
    """
    found = _numbers(_obj_rows(block) for block in _blocks(content, 0))
    vertices = _joined(found, most)
    if not len(vertices):
        raise _unreadable("it has no vertices (lines that begin with v)")
    return vertices


def _obj_rows(block: bytes) -> list[list[bytes]]:
    lines = block.splitlines()
    return [line.split(None, 4)[1:4] for line in lines if line.startswith((b"v ", b"v\t"))]


def ply_vertices(content: bytes, most: int) -> Array:
    """Return the vertices (V, 3) of a PLY file.

    Raises:
        MeshError: it is none, its vertices are not its first element or more than `most`.
    """
    head, end, _ = content[:MAX_HEADER_BYTES].partition(b"end_header")
    lines = [line.split() for line in head.decode("latin-1").splitlines()]
    if not lines or lines[0] != ["ply"] or not end:
        raise _unreadable("it does not begin with the header of a PLY file")
    order, count, columns = _header(lines)
    if count > most:
        raise _too_many(most)
    # The header ends with its line; what follows is data.
    start = content.find(b"\n", len(head)) + 1 or len(content)
    if order == "":
        return _text_vertices(content, start, count, list(columns))
    row = np.dtype([(name, order + kind) for name, kind in columns.items()])
    if len(content) - start < count * row.itemsize:
        raise _unreadable("it ends before its last vertex")
    table = np.frombuffer(content, row, count, start)
    with np.errstate(invalid="ignore"):
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
                if elements == 1:
                    count = _vertex_count(name, number)
            case ["property", "list", *_] if elements == 1:
                raise _unreadable("its vertices have lists")
            case ["property", _, name] if elements == 1 and name in columns:
                raise _unreadable(f"its vertices have two properties '{name}'")
            case ["property", kind, name] if elements == 1:
                columns[name] = PLY_TYPES.get(kind, "")
    if order is None:
        raise _unreadable(f"its format is none of {', '.join(BYTE_ORDERS)}")
    if count < 0 or not {"x", "y", "z"} <= columns.keys() or not all(columns.values()):
        raise _unreadable("its header says no number of vertices with x, y and z")
    return order, count, columns


def _vertex_count(name: str, number: str) -> int:
    """Return the number of the first element of a PLY file, -1 where it is none."""
    if name != "vertex":
        raise _unreadable(f"its first element is '{name}'; should be 'vertex'")
    return int(number) if re.fullmatch("[0-9]{1,18}", number) else -1


def _text_vertices(content: bytes, start: int, count: int, columns: list[str]) -> Array:
    """Return the vertices of a PLY file of text whose data begins at `start`."""
    places = [columns.index(axis) for axis in "xyz"]

    def rows() -> Iterator[list[list[bytes]]]:
        left = count
        for block in _blocks(content, start):
            lines = [line.split() for line in block.splitlines() if line.strip()][:left]
            if any(len(line) < len(columns) for line in lines):
                break
            yield [[line[k] for k in places] for line in lines]
            left -= len(lines)
            if not left:
                return
        raise _unreadable("it ends before its last vertex")

    return _joined(_numbers(rows()), count) if count else np.zeros((0, 3))


def _blocks(content: bytes, start: int) -> Iterator[bytes]:
    """Yield the lines of a text in blocks, a line that is longer than a block as a whole."""
    while start < len(content):
        end = content.find(b"\n", start + BLOCK_BYTES) + 1 or len(content)
        yield content[start:end]
        start = end


def _numbers(blocks: Iterable[list[list[bytes]]]) -> Iterator[Array]:
    """Yield the numbers of each block of rows: (N, 3)."""
    for rows in blocks:
        if not rows:
            continue
        try:
            found = np.array(rows, dtype=float)
        except ValueError:
            found = np.zeros(0)
        if found.ndim != 2 or found.shape[1] != 3:
            raise _unreadable("a vertex is not three numbers")
        yield found


def _joined(blocks: Iterable[Array], most: int) -> Array:
    """Return the vertices of all blocks together.

    Raises:
        MeshError: they are more than `most`.
    """
    kept, count = [np.zeros((0, 3))], 0
    for block in blocks:
        count += len(block)
        if count > most:
            raise _too_many(most)
        kept.append(block)
    return np.concatenate(kept)


def _unreadable(reason: str) -> MeshError:
    return MeshError(f"cannot be read: {reason}")


def _too_many(most: int) -> MeshError:
    return MeshError(f"has more than {most} vertices; make it simpler")


READERS: dict[str, Callable[[bytes, int], Array]] = {".obj": obj_vertices, ".ply": ply_vertices}
"""Readers by the suffix of their files."""
