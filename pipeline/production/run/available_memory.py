"""Available memory: how much this process and its children may take, and what they take.

The least of what the machine has free, the limits of the control groups that the process is in,
and the limit of its address space. Only Linux tells all of it; elsewhere the limit of the address
space counts alone.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from pipeline.unexpected_error import memory_limit

_PROC = Path("/proc")
_GROUPS = Path("/sys/fs/cgroup")


@dataclass(frozen=True, slots=True)
class Memory:
    """An amount of memory and where it comes from.

    Attributes:
        size: that a run may take, what it has taken already included [bytes].
        source: what has that much free, for messages.
    """

    size: int
    source: str


def available_memory() -> Memory | None:
    """Return the memory that this process and its children may take, None if nothing tells."""
    own = resident_memory(os.getpid()) or 0
    found = [*_free_memory(own), *_group_limits(own), *_address_space(own)]
    return min(found, key=lambda memory: memory.size, default=None)


def _free_memory(own: int) -> Iterator[Memory]:
    for line in _lines(_PROC / "meminfo"):
        name, _, value = line.partition(":")
        if name == "MemAvailable":
            yield Memory(1024 * int(value.split()[0]) + own, "this machine")


def _group_limits(own: int) -> Iterator[Memory]:
    """Yield the limits of the control groups of this process and of those above them."""
    for line in _lines(_PROC / "self" / "cgroup"):
        _, kinds, path = line.split(":", 2)
        if kinds == "":
            root, limit_file, used_file = _GROUPS, "memory.max", "memory.current"
        elif "memory" in kinds.split(","):
            root = _GROUPS / "memory"
            limit_file, used_file = "memory.limit_in_bytes", "memory.usage_in_bytes"
        else:
            continue
        group = root / path.lstrip("/")
        for folder in (group, *group.parents):
            limit, used = _number(folder / limit_file), _number(folder / used_file)
            if limit is not None:
                # Pages of files can be given back.
                left = limit - max((used or 0) - _reclaimable(folder), 0)
                yield Memory(min(max(left, 0) + own, limit), "this control group (container)")
            if folder == root:
                break


def _reclaimable(folder: Path) -> int:
    """Return the size of file pages in a control group that the system may drop [bytes]."""
    counts = dict(line.split(maxsplit=1) for line in _lines(folder / "memory.stat"))
    names = ("inactive_file", "active_file", "total_inactive_file", "total_active_file")
    found = [int(counts[name]) for name in names if counts.get(name, "").isdigit()]
    return sum(found[-2:])


def _address_space(own: int) -> Iterator[Memory]:
    limit = memory_limit()
    if limit is None:
        return
    taken = 0
    for line in _lines(_PROC / "self" / "statm"):
        taken = int(line.split()[0]) * os.sysconf("SC_PAGE_SIZE")
    yield Memory(max(limit - taken, 0) + own, "the address space of this process (ulimit -v)")


def _number(file: Path) -> int | None:
    for text in _lines(file):
        # A group without a limit says "max", or a number beyond all memory.
        return int(text) if text.isdigit() and int(text) < 2**60 else None
    return None


def _lines(file: Path) -> list[str]:
    with suppress(OSError, ValueError):
        return file.read_text(encoding="ascii").splitlines()
    return []


def resident_memory(process: int) -> int | None:
    """Return the memory of a process without pages that it shares [bytes], None if unknown."""
    for line in _lines(_PROC / str(process) / "statm"):
        _, resident, shared, *_ = map(int, line.split())
        return (resident - shared) * os.sysconf("SC_PAGE_SIZE")
    return None


def descendants(process: int) -> list[int]:
    """Return the processes that a process has started, and those that these have started."""
    children: dict[int, list[int]] = {}
    with suppress(OSError):
        for folder in _PROC.iterdir():
            if not folder.name.isdigit():
                continue
            for line in _lines(folder / "stat"):
                # The name before, in brackets, may hold anything.
                parent = line.rpartition(")")[2].split()[1:2]
                if parent:
                    children.setdefault(int(parent[0]), []).append(int(folder.name))
    found, todo = list[int](), [process]
    while todo:
        own = children.get(todo.pop(), [])
        found += own
        todo += own
    return found


def tree_memory() -> int:
    """Return the memory of this process and of all that it has started [bytes]."""
    own = os.getpid()
    return sum(resident_memory(process) or 0 for process in (own, *descendants(own)))
