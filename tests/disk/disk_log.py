"""Disk log: what a process did to the files of a folder, and what a loss of power leaves of it.

A file system keeps what was synced: the content of a file, the names of a folder. Of all else it
may have kept everything, nothing, a part, or the length of a file without its content.
"""

from __future__ import annotations

import os
import random
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

Survival = Literal["lost", "kept", "torn", "zeroed", "whole", "random"]

SURVIVALS: tuple[Survival, ...] = ("lost", "kept", "torn", "zeroed", "whole", "random")
"""What becomes of what was not synced.

- lost: neither names nor contents are on the disk
- kept: the names are, and the contents are not
- torn: the names are, and of each file the first half of what was written
- zeroed: the names are, and zeros in place of what was written
- whole: all is, as after a process was killed
- random: some of the names, in the order in which they were given, and any of these contents
"""


@dataclass(frozen=True)
class Call:
    """One call that changed or synced something.

    Attributes:
        op: "create", "write", "truncate", "sync", "mkdir", "unlink", "rename", "exchange", "link".
        path: from the observed folder.
        other: second path, "" if there is none.
        offset: of written data, or the new length.
        data: that were written.
        mtime_ns: time of the file after the call.
    """

    op: str
    path: str
    other: str
    offset: int
    data: bytes
    mtime_ns: int


def read_log(log: Path, folder: Path) -> list[Call]:
    """Return the calls of a log, whose paths are below `folder`."""
    text, at, calls = log.read_bytes(), 0, []
    while at < len(text):
        end = text.index(b"\n", at)
        op, _, offset, length, mtime, first, second = text[at:end].split()
        at = end + 1
        middle, last = at + int(first), at + int(first) + int(second)
        path, other, at = text[at:middle], text[middle:last], last
        data = text[at : at + int(length)] if op == b"write" else b""
        at += len(data)
        names = [os.path.relpath(os.fsdecode(p), folder) if p else "" for p in (path, other)]
        calls.append(Call(op.decode(), *names, int(offset), data, int(mtime)))
    return calls


@dataclass(eq=False)
class File:
    """A file: its content in memory and on the disk."""

    content: bytearray = field(default_factory=bytearray)
    synced: bytes = b""
    unsynced: list[tuple[int, bytes]] = field(default_factory=list)
    mtime_ns: int = 0


@dataclass(eq=False)
class Folder:
    """A folder: its names in memory and on the disk."""

    names: dict[str, Node] = field(default_factory=dict)
    synced: dict[str, Node] = field(default_factory=dict)


Node = File | Folder

Found = dict[str, tuple[bytes, int] | None]
"""Content and time [ns] of files, None of folders, by their paths."""

Assignments = list[tuple[Folder, str, Node | None]]
"""Names that one call gives or takes, all or none of them."""


class Disk:
    """The files of a folder, as calls change them."""

    def __init__(self, folder: Path) -> None:
        self.root = _loaded(folder)
        self._pending: list[Assignments] = []

    def apply(self, call: Call) -> None:
        """Do what a call did."""
        getattr(self, f"_{call.op}")(call)

    def _entry(self, path: str) -> tuple[Folder, str]:
        *folders, name = Path(path).parts
        at = self.root
        for folder in folders:
            inner = at.names[folder]
            assert isinstance(inner, Folder)
            at = inner
        return at, name

    def _node(self, path: str) -> Node:
        if path == ".":
            return self.root
        folder, name = self._entry(path)
        return folder.names[name]

    def _assign(self, *assignments: tuple[tuple[Folder, str], Node | None]) -> None:
        self._pending.append([(folder, name, node) for (folder, name), node in assignments])
        for (folder, name), node in assignments:
            if node is None:
                del folder.names[name]
            else:
                folder.names[name] = node

    def _create(self, call: Call) -> None:
        self._assign((self._entry(call.path), File(mtime_ns=call.mtime_ns)))

    def _mkdir(self, call: Call) -> None:
        self._assign((self._entry(call.path), Folder()))

    def _unlink(self, call: Call) -> None:
        self._assign((self._entry(call.path), None))

    def _rename(self, call: Call) -> None:
        node = self._node(call.path)
        self._assign((self._entry(call.path), None), (self._entry(call.other), node))

    def _link(self, call: Call) -> None:
        self._assign((self._entry(call.other), self._node(call.path)))

    def _exchange(self, call: Call) -> None:
        one, two = self._node(call.path), self._node(call.other)
        self._assign((self._entry(call.path), two), (self._entry(call.other), one))

    def _file(self, call: Call) -> File:
        file = self._node(call.path)
        assert isinstance(file, File)
        file.mtime_ns = call.mtime_ns
        return file

    def _write(self, call: Call) -> None:
        file, end = self._file(call), call.offset + len(call.data)
        file.content.extend(bytes(max(end - len(file.content), 0)))
        file.content[call.offset : end] = call.data
        file.unsynced.append((call.offset, call.data))

    def _truncate(self, call: Call) -> None:
        file = self._file(call)
        del file.content[call.offset :]
        file.content.extend(bytes(call.offset - len(file.content)))
        # A shorter file counts as not written at all, the worst of what it may be.
        file.unsynced.append((0, b""))

    def _sync(self, call: Call) -> None:
        node = self._node(call.path)
        if isinstance(node, File):
            node.synced, node.unsynced = bytes(node.content), []
            return
        for assignments in [a for a in self._pending if any(f is node for f, _, _ in a)]:
            _settle(assignments)
            self._pending.remove(assignments)

    def after_loss(self, survival: Survival, seed: int = 0) -> Found:
        """Return what is found after a loss of power."""
        rng = random.Random(seed)
        given = {id(f): dict(f.synced) for f in _folders(self.root)}
        if survival != "lost":
            for assignments in self._pending:
                if survival == "random" and rng.random() < 0.3:
                    break
                for folder, name, node in assignments:
                    names = given.setdefault(id(folder), dict(folder.synced))
                    names.pop(name, None) if node is None else names.update({name: node})
        kept = _KEPT[survival] if survival != "random" else None
        found: Found = {}
        pending = [("", self.root)]
        while pending:
            prefix, folder = pending.pop()
            for name, node in given.get(id(folder), folder.synced).items():
                if isinstance(node, Folder):
                    found[prefix + name] = None
                    pending.append((f"{prefix}{name}/", node))
                else:
                    keep = kept or rng.choice([_lost, _torn, _zeroed, _whole])
                    content = keep(node) if node.unsynced else node.synced
                    found[prefix + name] = content, node.mtime_ns
        return found


def _settle(assignments: Assignments) -> None:
    for folder, name, node in assignments:
        if node is None:
            folder.synced.pop(name, None)
        else:
            folder.synced[name] = node


def _folders(root: Folder) -> Iterator[Folder]:
    """Yield a folder and all below it, in memory or on the disk."""
    seen, pending = set[int](), [root]
    while pending:
        folder = pending.pop()
        if id(folder) not in seen:
            seen.add(id(folder))
            yield folder
            inner = [*folder.names.values(), *folder.synced.values()]
            pending += [node for node in inner if isinstance(node, Folder)]


def _lost(file: File) -> bytes:
    return file.synced


def _whole(file: File) -> bytes:
    return bytes(file.content)


def _torn(file: File) -> bytes:
    content = bytearray(file.synced)
    total = sum(len(data) for _, data in file.unsynced)
    left = total // 2
    for offset, data in file.unsynced:
        part = data[:left]
        left -= len(part)
        content.extend(bytes(max(offset + len(part) - len(content), 0)))
        content[offset : offset + len(part)] = part
    return bytes(content)


def _zeroed(file: File) -> bytes:
    content = bytearray(file.content)
    for offset, data in file.unsynced:
        content[offset : offset + len(data)] = bytes(len(data))
    return bytes(content)


_KEPT: dict[str, Callable[[File], bytes]] = {
    "lost": _lost,
    "kept": _lost,
    "torn": _torn,
    "zeroed": _zeroed,
    "whole": _whole,
}


def _loaded(folder: Path) -> Folder:
    """Return the files of a folder, all of them synced."""
    loaded = Folder()
    for path in sorted(folder.iterdir()):
        if path.is_dir():
            loaded.names[path.name] = _loaded(path)
        else:
            content, stat = path.read_bytes(), path.stat()
            loaded.names[path.name] = File(bytearray(content), content, [], stat.st_mtime_ns)
    loaded.synced = dict(loaded.names)
    return loaded


def place(found: Found, folder: Path) -> None:
    """Put what was found after a loss of power in place of a folder."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in sorted(found):
        entry, path = found[name], folder / name
        if entry is None:
            path.mkdir(parents=True, exist_ok=True)
            continue
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(entry[0])
        os.utime(path, ns=(entry[1], entry[1]))
