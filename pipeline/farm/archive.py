"""Archive: members of one object that can be read one by one, by their ranges of bytes.

It is a tar file whose first member lists the others with place, size and digest. The same members
give the same bytes.
"""

from __future__ import annotations

import io
import tarfile
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import StoreError
from pipeline.farm.seals import digest_of, sealed, unsealed
from pipeline.farm.store import ObjectDamaged, Store

INDEX = "index.json"
"""Name of the first member."""

HEAD_BYTES = 1 << 16
"""Read at once of the beginning of an archive; more if its index is longer [bytes]."""

MAX_GAP = 1 << 17
"""Bytes that are read for nothing rather than by two requests."""

_BLOCK = tarfile.BLOCKSIZE


def write_archive(place: Path, members: Mapping[str, Path | bytes]) -> None:
    """Write an archive.

    Args:
        place: new file.
        members: files or contents by their names, at most 100 characters of ASCII each.

    Raises:
        OSError: a file cannot be read or written.
    """
    index: dict[str, list[Any]] = {}
    offset = 0
    for name in sorted(members):
        data = _content(members[name])
        index[name] = [offset + _BLOCK, len(data), digest_of(data)]
        offset += _BLOCK + -(-len(data) // _BLOCK) * _BLOCK
    with (
        place.open("wb") as file,
        tarfile.open(fileobj=file, mode="w", format=tarfile.USTAR_FORMAT) as tar,
    ):
        _add(tar, INDEX, sealed(index))
        for name in index:
            _add(tar, name, _content(members[name]))


def _add(tar: tarfile.TarFile, name: str, data: bytes) -> None:
    # Without times, owners and modes of the machine that writes it.
    member = tarfile.TarInfo(name)
    member.size = len(data)
    tar.addfile(member, io.BytesIO(data))


def _content(member: Path | bytes) -> bytes:
    return member.read_bytes() if isinstance(member, Path) else member


def folder_members(folder: Path) -> dict[str, Path | bytes]:
    """Return the files of a folder as members, by their paths from there."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path for path in files}


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a member stands: first byte in the archive, size [bytes] and digest."""

    start: int
    size: int
    digest: str


class Archive:
    """An archive in a store, of which only the index is read at first.

    Args:
        store: that has it.
        name: of the object.

    Raises:
        ObjectMissing: there is none.
        StoreError: it cannot be read, or its index is not as it was written.
    """

    def __init__(self, store: Store, name: str) -> None:
        self._store, self._name = store, name
        self._places = self._read_index()

    @property
    def names(self) -> Collection[str]:
        """Names of the members."""
        return self._places.keys()

    def read(self, names: Collection[str]) -> dict[str, bytes]:
        """Return some members by their names; neighbours are read by one request.

        Raises:
            StoreError: there is no such member, or one is not as it was written.
        """
        try:
            wanted = sorted((self._places[name].start, name) for name in names)
        except KeyError as error:
            raise self._damaged(f"has no {error.args[0]}") from None
        found: dict[str, bytes] = {}
        for run in self._runs([name for _, name in wanted]):
            start = self._places[run[0]].start
            last = self._places[run[-1]]
            data = self._store.get(self._name, start, last.start + last.size)
            for name in run:
                place = self._places[name]
                member = data[place.start - start : place.start - start + place.size]
                if digest_of(member) != place.digest:
                    raise self._damaged(f"{name} is not as it was written")
                found[name] = member
        return found

    def _runs(self, names: list[str]) -> list[list[str]]:
        """Return members in the order of their places, those that are read at once together."""
        runs: list[list[str]] = []
        end = -1
        for name in names:
            place = self._places[name]
            if runs and place.start - end <= MAX_GAP:
                runs[-1].append(name)
            else:
                runs.append([name])
            end = place.start + place.size
        return runs

    def _read_index(self) -> dict[str, _Place]:
        head = self._store.get(self._name, 0, HEAD_BYTES)
        try:
            size = tarfile.TarInfo.frombuf(head[:_BLOCK], "ascii", "strict").size
        except (tarfile.HeaderError, UnicodeError) as error:
            raise self._damaged(f"is no archive ({error})") from None
        end = _BLOCK + size
        if end > len(head):
            head += self._store.get(self._name, len(head), end)
        members = unsealed(head[_BLOCK:end])
        if members is None:
            raise self._damaged("its index is not as it was written")
        first = _BLOCK + -(-size // _BLOCK) * _BLOCK
        return {name: _Place(first + at, n, digest) for name, (at, n, digest) in members.items()}

    def _damaged(self, reason: str) -> ObjectDamaged:
        text = f"{self._store.address}: {self._name} is damaged: {reason}"
        return ObjectDamaged(text, self._name)


def write_arrays(place: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays as an archive of .npy files."""
    members: dict[str, Path | bytes] = {}
    for name, values in arrays.items():
        file = io.BytesIO()
        np.lib.format.write_array(file, np.ascontiguousarray(values), allow_pickle=False)
        members[f"{name}.npy"] = file.getvalue()
    write_archive(place, members)


def read_arrays(store: Store, name: str) -> dict[str, NDArray[Any]]:
    """Return the arrays of an archive that `write_arrays` wrote.

    Raises:
        StoreError: one cannot be read.
    """
    archive = Archive(store, name)
    try:
        return {
            member.removesuffix(".npy"): np.lib.format.read_array(
                io.BytesIO(data), allow_pickle=False
            )
            for member, data in archive.read(archive.names).items()
        }
    except ValueError as error:
        raise StoreError(f"{store.address}: {name} cannot be read ({error})") from error
