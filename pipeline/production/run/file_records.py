"""File records: what every file was when it was written, by which a damaged one is known.

A file whose size and time are those of its record is taken to be as it was, without reading it.
Where they differ, the digest of its content decides. Files with a key count only while the key of
their record is the one that is asked for.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

UNKNOWN_TIME = -1
"""Time of a record that is not trusted without reading the file."""


@dataclass(frozen=True, slots=True)
class FileRecord:
    """A file, or a folder that is written as one, when it was written.

    Attributes:
        digest: of its content.
        size: of its content [bytes].
        mtime_ns: time of its last change [ns]; of a folder, the latest of its files.
        key: digest of all that it was made of, "" for files without.
    """

    digest: str
    size: int
    mtime_ns: int
    key: str = ""

    @staticmethod
    def of(path: Path, key: str = "") -> FileRecord:
        """Return the record of a file or folder as it is.

        Raises:
            OSError: it cannot be read.
        """
        size, mtime_ns = _stamp(path)
        return FileRecord(content_digest(path), size, mtime_ns, key)

    @staticmethod
    def read(members: object) -> FileRecord | None:
        """Return the record that `facts` wrote, None for anything else."""
        match members:
            case {"digest": str(digest), "size": int(size), "mtime_ns": int(time), **rest}:
                return FileRecord(digest, size, time, str(rest.get("key", "")))
        return None

    @property
    def facts(self) -> dict[str, Any]:
        """Its members as JSON has them."""
        plain = {"digest": self.digest, "size": self.size, "mtime_ns": self.mtime_ns}
        return {**plain, "key": self.key} if self.key else plain


class FileRecords(Mapping[str, FileRecord]):
    """The records of the files in a folder, by their paths from there.

    Args:
        folder: of the files.
        records: of earlier runs.
    """

    def __init__(self, folder: Path, records: Mapping[str, FileRecord]) -> None:
        self._folder = folder
        self._records = dict(records)

    def __getitem__(self, name: str) -> FileRecord:
        return self._records[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._records)

    def __len__(self) -> int:
        return len(self._records)

    def name(self, path: Path) -> str:
        """Return the name under which a file is recorded."""
        return path.relative_to(self._folder).as_posix()

    def of(self, path: Path, key: str = "") -> FileRecord | None:
        """Return the record of a file under a key, None if there is none."""
        record = self._records.get(self.name(path))
        return record if record is not None and record.key == key else None

    def put(self, path: Path, record: FileRecord) -> None:
        """Keep the record of a file that has been written."""
        self._records[self.name(path)] = record

    def add(self, path: Path, key: str = "") -> None:
        """Record a file that has been written.

        Raises:
            OSError: it cannot be read.
        """
        self.put(path, FileRecord.of(path, key))

    def update(self, *paths: Path) -> None:
        """Record files that may have been written, or deleted.

        Raises:
            OSError: one cannot be read.
        """
        for path in paths:
            record = self.of(path)
            if not path.exists():
                self._records.pop(self.name(path), None)
            elif record is None or _stamp(path) != (record.size, record.mtime_ns):
                self.add(path)

    def is_intact(self, path: Path, key: str = "") -> bool:
        """Return whether a file is recorded under a key and is as it was.

        A file that is equal but was copied or touched is read once and has its new time recorded.
        """
        record = self.of(path, key)
        if record is None:
            return False
        try:
            size, mtime_ns = _stamp(path)
            if size != record.size:
                return False
            if mtime_ns != record.mtime_ns:
                if content_digest(path) != record.digest:
                    return False
                self.put(path, replace(record, mtime_ns=mtime_ns))
        except OSError:
            return False
        return True

    def distrust(self, path: Path) -> None:
        """Have a file read before it counts again, because its size and time tell nothing."""
        record = self._records.get(self.name(path))
        if record is not None:
            self.put(path, replace(record, mtime_ns=UNKNOWN_TIME))

    def forget_intact(self, path: Path) -> None:
        """Drop the record of a file that is as it was, so that it is made again."""
        record = self._records.get(self.name(path))
        if record is not None and self.is_intact(path, record.key):
            del self._records[self.name(path)]

    def forget_missing(self) -> None:
        """Drop the records of files that are not there."""
        self._records = {n: r for n, r in self._records.items() if (self._folder / n).exists()}


def content_digest(path: Path) -> str:
    """Return the digest of a file, or of the names and contents of the files in a folder.

    Raises:
        OSError: it cannot be read.
    """
    state = hashlib.blake2b(digest_size=20)
    if path.is_dir():
        for file in _files(path):
            state.update(f"{file.relative_to(path).as_posix()}|{content_digest(file)}\n".encode())
        return state.hexdigest()
    with path.open("rb") as opened:
        return hashlib.file_digest(opened, lambda: state).hexdigest()


def _stamp(path: Path) -> tuple[int, int]:
    """Return size and time of a file; of a folder, the sum of sizes and the latest time."""
    stats = [file.stat() for file in (_files(path) if path.is_dir() else [path])]
    times = [stat.st_mtime_ns for stat in stats]
    return sum(stat.st_size for stat in stats), max(times, default=0)


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())
