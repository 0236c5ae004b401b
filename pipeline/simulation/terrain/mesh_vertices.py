"""Vertices of mesh files: Wavefront OBJ, and PLY as text or binary."""

from __future__ import annotations

from typing import Any

import numpy as np

from pipeline.simulation.spatial import Array

TYPES = {
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
"""Numpy's name of each type of PLY."""

ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


class NotRead(Exception):
    """Why a mesh is none, in words."""


def obj_vertices(content: bytes) -> Array:
    """Return the vertices (V, 3) of an OBJ file.

    Raises:
        NotRead: it has none, or one that is no vertex.
    """
    rows = [line.split()[1:4] for line in content.splitlines() if line.startswith((b"v ", b"v\t"))]
    if not rows:
        raise NotRead("it has no vertices (lines that begin with v)")
    return _numbers(rows)


def ply_vertices(content: bytes) -> Array:
    """Return the vertices (V, 3) of a PLY file.

    Raises:
        NotRead: it is none, or its vertices are not its first element.
    """
    head, end, body = content.partition(b"end_header")
    lines = [line.split() for line in head.decode("latin-1").splitlines()]
    if not lines or lines[0] != ["ply"] or not end:
        raise NotRead("it does not begin with the header of a PLY file")
    order, count, columns = _header(lines)
    # The header ends with its line; what follows is data.
    body = body[1:] if body.startswith(b"\n") else body.partition(b"\n")[2]
    if order == "":
        return _text_vertices(body, count, list(columns))
    row = np.dtype([(name, order + kind) for name, kind in columns.items()])
    if len(body) < count * row.itemsize:
        raise NotRead("it ends before its last vertex")
    table = np.frombuffer(body, row, count)
    return np.stack([table[axis].astype(float) for axis in "xyz"], axis=-1)


def _header(lines: list[list[str]]) -> tuple[str, int, dict[str, str]]:
    """Return byte order, number of vertices, and the type of each of their columns."""
    order: str | None = None
    count = -1
    elements = 0
    columns: dict[str, str] = {}
    for words in lines:
        match words:
            case ["format", kind, *_]:
                order = ORDERS.get(kind)
            case ["element", name, number]:
                elements += 1
                if elements == 1 and name != "vertex":
                    raise NotRead(f"its first element is '{name}'; should be 'vertex'")
                if elements == 1 and number.isdigit():
                    count = int(number)
            case ["property", kind, name] if elements == 1:
                columns[name] = TYPES.get(kind, "")
            case ["property", "list", *_] if elements == 1:
                raise NotRead("its vertices have lists")
    if order is None:
        raise NotRead(f"its format is none of {', '.join(ORDERS)}")
    if count < 0 or not {"x", "y", "z"} <= columns.keys() or not all(columns.values()):
        raise NotRead("its header says no number of vertices with x, y and z")
    return order, count, columns


def _text_vertices(body: bytes, count: int, columns: list[str]) -> Array:
    rows = [line.split() for line in body.splitlines() if line.strip()][:count]
    if len(rows) < count or any(len(row) < len(columns) for row in rows):
        raise NotRead("it ends before its last vertex")
    places = [columns.index(axis) for axis in "xyz"]
    return _numbers([[row[k] for k in places] for row in rows])


def _numbers(rows: list[list[Any]]) -> Array:
    try:
        found = np.array(rows, dtype=float)
    except ValueError:
        found = np.zeros(0)
    if found.ndim != 2 or found.shape[1] != 3:
        raise NotRead("a vertex is not three numbers")
    return found
