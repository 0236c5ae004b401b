"""Store: objects of a farm under their names, in a shared folder or at an address of fsspec.

An object is there whole or not at all: in folders it is written under a temporary name and
renamed, elsewhere one request puts it. Every object depends on nothing but its name, or is
created once, so that work that is done twice leaves the same objects.
"""

from __future__ import annotations

import os
import random
import threading
import time
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, TypeVar

from pipeline.errors import StoreError
from pipeline.farm.seals import digest_of, sealed, unsealed
from pipeline.farm.store_address import SSH, opened_address, reason_of

MAX_TRIES = 6
"""Calls of the store before an error counts: one call of ten may fail without harm."""

FIRST_PAUSE = 0.2
"""Pause after the first failed call, doubled after each further one [s]."""

TEMPORARY = ".unfinished"
"""Folder of the objects that are being written, in stores that rename."""

STALE_AGE = 86400.0
"""Age from which an unfinished object is taken to be left behind [s]."""

_RENAMING = ("file", "local", "sftp", "ssh", "smb", "hdfs")
"""Protocols whose files appear before they are complete, and can be renamed."""

_PERMANENT = (
    FileNotFoundError,
    FileExistsError,
    IsADirectoryError,
    NotADirectoryError,
    PermissionError,
    NotImplementedError,
    TypeError,
)
"""Errors that another call would meet again."""

T = TypeVar("T")


class ObjectFault(StoreError):
    """An object of a store is of no use.

    Attributes:
        name: of the object.
    """

    def __init__(self, message: str, name: str) -> None:
        super().__init__(message)
        self.name = name


class ObjectMissing(ObjectFault):
    """The store has no object of this name."""


class ObjectDamaged(ObjectFault):
    """An object is not as it was written."""


@dataclass(frozen=True, slots=True)
class Entry:
    """An object of a listing.

    Attributes:
        size: of its content [bytes].
        time: at which it was written, since the epoch [s]; 0.0 where the store does not tell.
    """

    size: int
    time: float


class Store:
    """Objects under names such as `takes/KEY.tar`.

    Args:
        address: a folder, or an URL of fsspec. What it needs to be let in is in the environment.

    Attributes:
        address: complete, so that other processes find the same store.

    Raises:
        UsageError: the address holds a password, or a package for it is missing.
        StoreError: the store cannot be reached.
    """

    def __init__(self, address: str) -> None:
        self._files, self._root = opened_address(address)
        names = self._files.protocol
        self._protocols = (names,) if isinstance(names, str) else tuple(names)
        self._renames = any(name in _RENAMING for name in self._protocols)
        self._has_one_connection = any(name in SSH for name in self._protocols)
        # paramiko may wait for ever when several threads read.
        self._turn = threading.Lock() if self._has_one_connection else nullcontext()
        # Some protocols leave the host out of names.
        self.address: str = (
            self._files.unstrip_protocol(self._root) if self.is_local else address.rstrip("/")
        )

    @property
    def is_local(self) -> bool:
        """Whether it is a folder of this machine."""
        return "file" in self._protocols

    @property
    def is_memory(self) -> bool:
        """Whether no other process can reach it."""
        return "memory" in self._protocols

    def has(self, name: str) -> bool:
        """Return whether there is an object of this name."""
        return bool(self._try("is asked for", name, lambda: self._files.exists(self._path(name))))

    def get(self, name: str, start: int | None = None, end: int | None = None) -> bytes:
        """Return an object, or its bytes from `start` to before `end`.

        Raises:
            ObjectMissing: there is none.
            StoreError: it cannot be read.
        """
        path = self._path(name)
        try:
            return bytes(
                self._try("is read", name, lambda: self._files.cat_file(path, start=start, end=end))
            )
        except FileNotFoundError:
            raise ObjectMissing(f"{self.address}: has no {name}", name) from None

    def get_checked(self, name: str, digest: str) -> bytes:
        """Return an object whose digest is known.

        Raises:
            ObjectMissing: there is none.
            ObjectDamaged: it is not as it was written.
            StoreError: it cannot be read.
        """
        for _ in range(2):
            data = self.get(name)
            if digest_of(data) == digest:
                return data
        raise self._damaged(name)

    def put(self, name: str, content: bytes | Path) -> None:
        """Write an object, whether there is one or not.

        Args:
            name: of the object.
            content: its bytes, or the file that holds them.

        Raises:
            StoreError: it cannot be written.
        """
        with self._missing_told():
            if self._renames:
                with self._unfinished(name, content) as temporary:
                    self._try("is renamed", name, lambda: self._move(temporary, name))
            else:
                self._try("is written", name, lambda: self._write(self._path(name), content))

    def create(self, name: str, data: bytes) -> bool:
        """Write a small object unless there is one; return whether it was written.

        Of two that do so at one moment one succeeds; at servers that know renaming alone, such as
        SFTP, both may, and the object of the last one stays.

        Raises:
            StoreError: it cannot be written.
        """
        if self.has(name):
            return False
        with self._missing_told():
            if not self._renames:
                path = self._path(name)
                return self._created(name, lambda: self._files.pipe_file(path, data, mode="create"))
            with self._unfinished(name, data) as temporary:
                return self._created(name, lambda: self._link(temporary, name))

    def put_json(self, name: str, members: Mapping[str, Any]) -> None:
        """Write members as JSON with a seal."""
        self.put(name, sealed(members))

    def get_json(self, name: str) -> dict[str, Any]:
        """Return the members of a JSON object.

        Raises:
            ObjectMissing: there is none.
            ObjectDamaged: it is not as it was written.
            StoreError: it cannot be read.
        """
        for _ in range(2):
            members = unsealed(self.get(name))
            if members is not None:
                return members
        raise self._damaged(name)

    def names(self, folder: str) -> dict[str, Entry]:
        """Return the objects directly in a folder, by their names in it; none if it is missing."""
        return {
            _last_part(info): Entry(int(info.get("size") or 0), _time_of(info))
            for info in self._listed(folder)
            if info.get("type") == "file" and not str(info["name"]).endswith("/")
        }

    def folders(self, folder: str) -> list[str]:
        """Return the names of the folders directly in a folder, sorted."""
        found = self._listed(folder)
        return sorted(_last_part(info) for info in found if info.get("type") == "directory")

    def _listed(self, folder: str) -> list[dict[str, Any]]:
        def listed() -> list[dict[str, Any]]:
            self._files.invalidate_cache()
            try:
                return list(self._files.ls(self._path(folder), detail=True))
            except FileNotFoundError:
                return []

        return self._try("is listed", folder, listed)

    def remove(self, name: str) -> None:
        """Remove an object, if there is one."""
        with suppress(FileNotFoundError):
            self._try("is removed", name, lambda: self._files.rm_file(self._path(name)))

    def remove_stale(self) -> None:
        """Remove unfinished objects that a writer left behind long ago."""
        if self._renames:
            now = time.time()
            for name, entry in self.names(TEMPORARY).items():
                if entry.time and now - entry.time > STALE_AGE:
                    self.remove(f"{TEMPORARY}/{name}")

    def _damaged(self, name: str) -> ObjectDamaged:
        text = f"{self.address}: {name} is damaged: it is not as it was written"
        return ObjectDamaged(text, name)

    def _path(self, name: str) -> str:
        return f"{self._root.rstrip('/')}/{name}"

    def _try(self, verb: str, name: str, call: Callable[[], T]) -> T:
        """Return the result of a call, which is made again after errors that may pass."""
        pause = FIRST_PAUSE
        for tries in range(1, MAX_TRIES + 1):
            try:
                with self._turn:
                    return call()
            except (FileNotFoundError, FileExistsError):
                raise
            except Exception as error:
                if tries == MAX_TRIES or isinstance(error, _PERMANENT):
                    times = f" {tries} times" if tries > 1 else ""
                    raise StoreError(
                        f"{self.address}: {name} {verb}, and that failed{times}: {reason_of(error)}"
                    ) from error
            # Many workers that failed at once should not all come back at once.
            time.sleep(pause * (0.5 + random.SystemRandom().random()))
            pause *= 2.0
            self._connect_again()
        raise AssertionError("the last try returns or raises")

    def _connect_again(self) -> None:
        """Open another connection where a broken one would stay broken."""
        if self._has_one_connection:
            with suppress(StoreError):
                self._files, self._root = opened_address(self.address)

    @contextmanager
    def _missing_told(self) -> Iterator[None]:
        """Tell what is missing above an object that is written, such as a bucket."""
        try:
            yield
        except FileNotFoundError as error:
            raise StoreError(
                f"{self.address}: cannot be written to ({reason_of(error)}); make it first"
            ) from error

    @contextmanager
    def _unfinished(self, name: str, content: bytes | Path) -> Iterator[str]:
        """Write an object under a temporary name, which is free again at the end."""
        # Machines that share a folder may have processes of one number.
        temporary = self._path(f"{TEMPORARY}/{uuid.uuid4().hex}")
        try:
            self._try("is written", name, lambda: self._write(temporary, content, durable=True))
            yield temporary
        finally:
            with suppress(Exception):
                self._files.rm_file(temporary)

    def _write(self, path: str, content: bytes | Path, durable: bool = False) -> None:
        if self._renames:
            self._files.makedirs(path.rpartition("/")[0], exist_ok=True)
        if isinstance(content, Path):
            self._files.put_file(str(content), path)
        else:
            self._files.pipe_file(path, content)
        if durable and self.is_local:
            with open(path, "r+b") as file:
                os.fsync(file.fileno())

    def _move(self, temporary: str, name: str) -> None:
        path = self._path(name)
        self._files.makedirs(path.rpartition("/")[0], exist_ok=True)
        if self.is_local:
            os.replace(temporary, path)
        else:
            self._files.mv(temporary, path)

    def _created(self, name: str, call: Callable[[], None]) -> bool:
        try:
            self._try("is created", name, call)
        except FileExistsError:
            return False
        return True

    def _link(self, temporary: str, name: str) -> None:
        """Give a finished object its name unless another has it.

        Raises:
            FileExistsError: another has it.
        """
        path = self._path(name)
        self._files.makedirs(path.rpartition("/")[0], exist_ok=True)
        if self.is_local:
            try:
                os.link(temporary, path)
                return
            except FileExistsError:
                raise
            except OSError:
                pass  # a file system without links
        if self._files.exists(path):
            raise FileExistsError(path)
        self._move(temporary, name)


def _time_of(info: Mapping[str, Any]) -> float:
    """Return when an object was written, since the epoch [s]; protocols name it differently."""
    for name in ("mtime", "LastModified", "last_modified", "created"):
        value = info.get(name)
        if isinstance(value, datetime):
            return value.timestamp()
        if isinstance(value, int | float):
            return float(value)
    return 0.0


def _last_part(info: Mapping[str, Any]) -> str:
    """Return the name of an entry in its folder."""
    return str(info["name"]).rstrip("/").rpartition("/")[2]
