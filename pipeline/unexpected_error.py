"""Unexpected errors: what is told of exceptions that are not raised on purpose.

Where memory is short, anything can fail. Python says so by itself; compiled libraries say it in
words of their own, or end the process while they are loaded. So a limit of memory too low for
loading them is refused at the start.
"""

from __future__ import annotations

import errno
import os
import traceback
from collections.abc import Iterator

from pipeline.errors import ProductionError, PronkError

try:
    import resource
except ImportError:  # Windows has no such limits.
    resource = None  # type: ignore[assignment]

LOADING_MEMORY, THREAD_MEMORY = 512 * 2**20, 64 * 2**20
"""Address space that the libraries take, and that each of their threads takes besides [bytes]."""

_LOADER_MESSAGES = ("failed to map segment", "cannot allocate memory", "libllvmlite", "bad_alloc")
"""Parts of messages of the loader and of libraries without memory, in lower case."""


class Defect(PronkError):
    """Pronk failed in a way that it does not know."""

    exit_code = 4

    def __init__(self, error: Exception) -> None:
        lines = "".join(traceback.format_exception(error)).rstrip()
        super().__init__(f"a defect of pronk, please report it: {error!r}\n{lines}")


class MemoryShort(ProductionError):
    """This process may not take the memory that it needs."""


def told_error(error: Exception) -> PronkError:
    """Return the error to tell of an exception."""
    if isinstance(error, PronkError):
        return error
    if not any(map(_says_memory_short, _chain(error))):
        return Defect(error)
    first = (str(error).splitlines() or [""])[0]
    reason = f"memory ran out: {first}" if first else "memory ran out"
    limit = memory_limit()
    if limit is None:
        return MemoryShort(f"{reason}; try a smaller scene, or fewer processes")
    return MemoryShort(f"{reason}; this process is limited to {_size(limit)} (ulimit -v), raise it")


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _says_memory_short(error: BaseException) -> bool:
    if isinstance(error, MemoryError):
        return True
    if isinstance(error, OSError) and error.errno == errno.ENOMEM:
        return True
    # Also what is wrong with an installation is told in such words, where no limit is set.
    loads = isinstance(error, ImportError | OSError | RuntimeError) and memory_limit() is not None
    return loads and any(part in str(error).lower() for part in _LOADER_MESSAGES)


def memory_limit() -> int | None:
    """Return the limit of this process's address space [bytes], None without one."""
    if resource is None:
        return None
    soft, _ = resource.getrlimit(resource.RLIMIT_AS)
    return None if soft == resource.RLIM_INFINITY else soft


def require_memory() -> None:
    """Refuse a limit of memory below what loading the libraries takes.

    Raises:
        MemoryShort: it is lower.
    """
    limit = memory_limit()
    needed = LOADING_MEMORY + THREAD_MEMORY * (os.cpu_count() or 1)
    if limit is not None and limit < needed:
        message = f"this process is limited to {_size(limit)} of memory (ulimit -v)"
        raise MemoryShort(f"{message}; raise the limit to {_size(needed)} or more")


def _size(memory: int) -> str:
    return f"{memory // 2**20} MiB"
