"""Take object: a take in the store, of which workers read the rows of their frames alone."""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from zarr.core.buffer import default_buffer_prototype
from zarr.storage import MemoryStore

from pipeline.errors import StoreError
from pipeline.farm.archive import Archive, folder_members, write_archive
from pipeline.farm.store import ObjectDamaged, ObjectFault, Store
from pipeline.simulation.take import Take
from pipeline.simulation.take_store import (
    FRAMES_PER_CHUNK,
    ROW_ARRAYS,
    read_rows,
    read_without_rows,
    write_take,
)


class TakeLost(StoreError):
    """The take or the tracks of a film are gone or damaged, and have to be made again."""


@contextmanager
def take_required(store: Store) -> Iterator[None]:
    """Read a take or tracks inside; one that is damaged is removed, so that it is made again.

    Raises:
        TakeLost: it is gone or damaged.
    """
    try:
        yield
    except ObjectFault as error:
        if isinstance(error, ObjectDamaged):
            store.remove(error.name)
        raise TakeLost(f"{error}; 'pronk farm simulate' makes it again") from error


def take_name(key: str) -> str:
    """Return the name of the take of a key."""
    return f"takes/{key}.tar"


def store_take(store: Store, take: Take) -> None:
    """Store a take under its key.

    Raises:
        StoreError: it cannot be written.
    """
    with tempfile.TemporaryDirectory(prefix="pronk_take_") as made:
        folder, packed = Path(made, "take.zarr"), Path(made, "take.tar")
        write_take(take, folder)
        write_archive(packed, folder_members(folder))
        store.put(take_name(take.header.key), packed)


def fetch_take(store: Store, key: str, folder: Path) -> None:
    """Write the take of a key into a new folder, as `read_take` reads it.

    Raises:
        ObjectMissing: the store has no such take.
        StoreError: it cannot be read.
    """
    archive = Archive(store, take_name(key))
    # A batch at a time, because a long take need not fit into memory.
    names = sorted(archive.names)
    for first in range(0, len(names), BATCH):
        for name, data in archive.read(names[first : first + BATCH]).items():
            path = folder / name
            if not path.resolve().is_relative_to(folder.resolve()):
                raise StoreError(f"{store.address}: {take_name(key)} is no take: has {name}")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)


BATCH = 64
"""Members of a take that are fetched at once."""


class TakeRows:
    """A take whose rows are read when their frames are due.

    Rows that were not read are zeros. A frame that is shot from such rows has another key than
    the same frame of the whole take, so it never passes for it.

    Args:
        store: that has the take.
        key: of the take.

    Attributes:
        take: all tables and meshes, and the rows read so far.
        bytes_read: of the take so far.

    Raises:
        ObjectMissing: the store has no such take.
        StoreError: it cannot be read.
    """

    def __init__(self, store: Store, key: str) -> None:
        self._archive = Archive(store, take_name(key))
        self._rows = frozenset(n for n in self._archive.names if n.split("/c/")[0] in ROW_ARRAYS)
        self._chunks = set[int]()
        self.bytes_read = 0
        # The descriptions of the arrays of rows, but none of their chunks.
        self._base = self._fetched(
            [n for n in self._archive.names if n not in self._rows or n.endswith("zarr.json")]
        )
        self.take = read_without_rows(MemoryStore(dict(self._base)))

    def require(self, first: int, last: int) -> None:
        """Read the rows of frames that were not read before.

        Args:
            first: the first frame.
            last: the last frame.

        Raises:
            StoreError: they cannot be read.
        """
        header = self.take.header
        per_chunk = FRAMES_PER_CHUNK * header.samples
        rows = len(self.take.positions)
        # An open shutter looks into the rows of the next frame.
        begin, end = (first - 1) * header.samples, min((last + 1) * header.samples, rows)
        for chunk in range(begin // per_chunk, (max(end - 1, begin)) // per_chunk + 1):
            if chunk not in self._chunks:
                self._read_chunk(chunk, per_chunk, rows)
                self._chunks.add(chunk)

    def _read_chunk(self, chunk: int, per_chunk: int, rows: int) -> None:
        names = [name for name in self._rows if name.split("/c/")[-1].split("/")[0] == str(chunk)]
        there = MemoryStore({**self._base, **self._fetched(names)})
        read_rows(there, self.take, slice(chunk * per_chunk, min((chunk + 1) * per_chunk, rows)))

    def _fetched(self, names: Collection[str]) -> dict[str, Any]:
        buffer = default_buffer_prototype().buffer
        found = self._archive.read(names)
        self.bytes_read += sum(map(len, found.values()))
        return {name: buffer.from_bytes(data) for name, data in found.items()}
