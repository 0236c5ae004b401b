"""Reels: arrays of many rows, on disk where they are long.

What a simulation writes row by row, and what walks through a take, needs a few rows at a
time. A reel up to `SHORT` is an array like any other. A longer one is mapped from a file
without a name, which the system takes away with the last who uses it, however that ends;
the rows that are done with are given back to it (`rows_of`, `put_down`). So the memory that
a film takes does not grow with its length.

The file stands in the folder that `TMPDIR` names, otherwise in /var/tmp, which is on disk
where /tmp may be memory.
"""

from __future__ import annotations

import math
import mmap
import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from pipeline.errors import StoreError

SHORT = 4 * 2**20
"""Longest reel that is kept in memory [bytes]."""

AT_ONCE = 4 * 2**20
"""About so much of a reel is looked at at once [bytes]."""


def reel(shape: Sequence[int], dtype: DTypeLike) -> NDArray[Any]:
    """Return an array of zeros, (rows, ...).

    Raises:
        StoreError: if there is no room for it.
    """
    size = math.prod(shape) * np.dtype(dtype).itemsize
    if size <= SHORT:
        return np.zeros(shape, dtype)
    folder = _folder()
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            # A disk that is full is noticed now; within the mapping it would end the process.
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, size)
            else:
                file.truncate(size)
            return np.ndarray(shape, dtype, buffer=mmap.mmap(file.fileno(), size))
    except OSError as error:
        raise StoreError(
            f"{folder}: {size / 2**20:.0f} MB for the rows of the take cannot be had there "
            f"({error.strerror}); name a folder with more room in TMPDIR"
        ) from error


def rows_of(array: NDArray[Any], multiple: int = 1) -> Iterator[slice]:
    """Yield rows of a reel from the first to the last, so many as may be in memory at once.

    Args:
        array: any array.
        multiple: of how many rows each but the last is.
    """
    row = max(array[:1].nbytes, 1)
    count = max(AT_ONCE // (row * multiple), 1) * multiple
    for first in range(0, len(array), count):
        yield slice(first, min(first + count, len(array)))
        put_down(array)


def put_down(array: NDArray[Any]) -> None:
    """Give back the memory of a reel's rows; its file has them."""
    if isinstance(array.base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
        # Of a shared mapping nothing is lost by this: the file's pages stay as they are.
        array.base.madvise(mmap.MADV_DONTNEED)


def _folder() -> Path:
    named, usual = os.environ.get("TMPDIR"), Path("/var/tmp")
    if named or not usual.is_dir():
        return Path(tempfile.gettempdir())
    return usual
