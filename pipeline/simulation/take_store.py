"""Take store: a take as a zarr group, in chunks of 32 frames.

Zarr stays readable up to its last whole chunk if its writer is killed, and other programs read
it. Everything but arrays stands in the group's attributes. Rows are written and read in chunks,
so that a long take needs no more memory than a short one.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import zarr
from numpy.typing import NDArray
from zarr.core.sync import sync
from zarr.storage import StoreLike

from pipeline.errors import StoreError
from pipeline.simulation.mechanism import Leg, Mechanism, NodeAlias
from pipeline.simulation.row_storage import allocate_rows, row_chunks
from pipeline.simulation.take import (
    FORMAT,
    OPTIONAL_ARRAYS,
    OPTIONAL_TABLES,
    BeatRecord,
    Channel,
    Contact,
    Face,
    Header,
    Mesh,
    Node,
    OrderRecord,
    Part,
    SoundEvent,
    Take,
    TakeNote,
    TerrainRecord,
)

FRAMES_PER_CHUNK = 32

RECORD_TYPES: dict[str, Any] = {
    "nodes": Node,
    "channels": Channel,
    "parts": Part,
    "contacts": Contact,
    "events": SoundEvent,
    "notes": TakeNote,
    "mechanisms": Mechanism,
    "legs": Leg,
    "aliases": NodeAlias,
    "orders": OrderRecord,
    "faces": Face,
    "beats": BeatRecord,
}

UNREADABLE = (OSError, KeyError, TypeError, ValueError, AttributeError, RuntimeError)
"""Exceptions of zarr for a damaged group; RuntimeError for a truncated chunk."""

ROW_ARRAYS = ("positions", "rotations", "alive", "scales", "values", "expressions")

OPTIONAL_ROWS = ("expressions",)
"""Arrays of rows that are left out where they are empty."""


def write_take(take: Take, path: Path) -> None:
    """Writes `take` into the new folder `path`.

    Raises:
        StoreError: if it cannot be written.
    """
    try:
        group = zarr.open_group(path, mode="w", zarr_format=3)
        for name, values in take.arrays():
            _write_array(group, name, values, take.header.samples)
        attributes: dict[str, Any] = {
            "header": take.header.as_dict(),
            "tables": take.tables(),
            "columns": {name: list(row.__dataclass_fields__) for name, row in RECORD_TYPES.items()},
            "scaled": list(take.scaled),
            "terrain": {"cells": list(take.terrain.cells), "material": take.terrain.material},
            "meshes": take.mesh_sizes,
            "digest": take.digest,
        }
        group.attrs.update(attributes)
    except OSError as error:
        sync(_end_of_writes())
        raise StoreError(f"{path}: the take could not be written: {error.strerror}") from error


async def _end_of_writes() -> None:
    """Wait for what zarr still writes in threads of its own after one of several writes failed.

    The caller may remove the folder then, or write it again.
    """
    others = asyncio.all_tasks() - {asyncio.current_task()}
    if others:
        await asyncio.wait(others)


def _write_array(group: zarr.Group, name: str, values: NDArray[Any], samples: int) -> None:
    rows = FRAMES_PER_CHUNK * samples if name in ROW_ARRAYS else max(len(values), 1)
    shape = tuple(max(n, 1) for n in values.shape)
    rows = min(rows, shape[0])
    array = group.create_array(
        name, shape=values.shape, dtype=values.dtype, chunks=(rows, *shape[1:])
    )
    if values.size:
        for chunk in row_chunks(values, rows):
            array[chunk] = values[chunk]


def read_key(path: Path) -> str | None:
    """Returns the key of the take in `path`, None without a complete take."""
    try:
        attributes: dict[str, Any] = zarr.open_group(path, mode="r").attrs.asdict()
        header = Header.from_dict(attributes["header"])
        # The digest is written last.
        return header.key if header.format == FORMAT and "digest" in attributes else None
    except UNREADABLE:
        return None


def read_take(path: Path) -> Take:
    """Reads the take in `path`.

    Raises:
        StoreError: if there is none, or it is incomplete.
    """
    try:
        group = zarr.open_group(path, mode="r")
        plain: dict[str, Any] = group.attrs.asdict()
        take = _assemble(group, plain)
    except UNREADABLE as error:
        raise StoreError(f"{path}: not a readable take ({error})") from error
    if take.digest != plain["digest"]:
        raise StoreError(
            f"{path}: the take is damaged: its digest does not match; simulate it again"
        )
    return take


def read_without_rows(source: StoreLike) -> Take:
    """Reads all of a take but its rows, which are zeros until `read_rows` reads some.

    Args:
        source: of the take; chunks of rows need not be there.

    Raises:
        StoreError: it cannot be read.
    """
    try:
        group = zarr.open_group(source, mode="r")
        return _assemble(group, group.attrs.asdict(), with_rows=False)
    except UNREADABLE as error:
        raise StoreError(f"not a readable take ({error})") from error


def read_rows(source: StoreLike, take: Take, rows: slice) -> None:
    """Reads rows of a take into one of `read_without_rows`.

    Args:
        source: of the take, with the chunks of these rows; what is missing is read as zeros.
        take: that is changed.
        rows: first and last.

    Raises:
        StoreError: they cannot be read.
    """
    try:
        group = zarr.open_group(source, mode="r")
        for name in ROW_ARRAYS:
            values = getattr(take, name)
            if name in OPTIONAL_ROWS and not values.size:
                continue
            found = group[name]
            assert isinstance(found, zarr.Array)
            if values.size:
                values[rows] = found[rows]
    except UNREADABLE as error:
        raise StoreError(f"not a readable take ({error})") from error


def _assemble(group: zarr.Group, plain: dict[str, Any], with_rows: bool = True) -> Take:
    def array(name: str) -> NDArray[Any]:
        found = group[name]
        assert isinstance(found, zarr.Array)
        if name in ROW_ARRAYS and not with_rows:
            # Takes no memory before it is written to.
            return np.zeros(found.shape, found.dtype)
        values = allocate_rows(found.shape, found.dtype)
        if values.size:
            for chunk in row_chunks(values, found.chunks[0]):
                values[chunk] = found[chunk]
        return values

    tables: dict[str, Any] = {
        name: tuple(_records(row, plain["tables"][name]))
        for name, row in RECORD_TYPES.items()
        if name not in OPTIONAL_TABLES or name in plain["tables"]
    }
    rows: dict[str, Any] = {
        name: array(name) for name in ROW_ARRAYS if name not in OPTIONAL_ROWS or name in group
    }
    terrain = plain["terrain"]
    return Take(
        header=Header.from_dict(plain["header"]),
        scaled=tuple(plain["scaled"]),
        meshes=_meshes(
            {name: array(f"meshes/{name}") for name in _mesh_names(plain["meshes"])},
            plain["meshes"],
        ),
        terrain=TerrainRecord(
            array("terrain/vertices"),
            array("terrain/faces"),
            tuple(terrain["cells"]),
            array("terrain/forbidden"),
            terrain["material"],
        ),
        **rows,
        **tables,
    )


def _mesh_names(sizes: list[list[int]]) -> list[str]:
    """Returns the names of the arrays of meshes, of the optional ones those that are stored."""
    names = list(Mesh.__dataclass_fields__)
    return names[: len(sizes[0])] if sizes else names[: -len(OPTIONAL_ARRAYS)]


def _meshes(joined: dict[str, NDArray[Any]], sizes: list[list[int]]) -> tuple[Mesh, ...]:
    """Splits concatenated arrays into meshes."""
    ends = np.cumsum(np.array(sizes, dtype=np.int64).reshape(len(sizes), len(joined)), axis=0)
    pieces = [
        np.split(values, ends[:-1, k]) if len(sizes) else []
        for k, values in enumerate(joined.values())
    ]
    return tuple(
        Mesh(**dict(zip(joined, arrays, strict=True))) for arrays in zip(*pieces, strict=True)
    )


def _records(row: Any, table: list[list[Any]]) -> Iterator[Any]:
    for values in table:
        yield row(*(_frozen(value) for value in values))


def _frozen(value: Any) -> Any:
    """Returns a value with tuples for lists, also within lists."""
    return tuple(_frozen(one) for one in value) if isinstance(value, list) else value
