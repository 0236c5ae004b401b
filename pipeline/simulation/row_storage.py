"""Row storage: arrays of many rows, on disk where they are long.

A simulation writes row by row, and readers of a take walk through it; both need a few rows at a
time. Short arrays are ordinary ones. A longer one is mapped from an unlinked temporary file, which
the system removes with its last user, however that ends; processed rows are given back
(`row_chunks`, `release_rows`). So memory use does not grow with the length of the film.

The file stands in the folder that `TMPDIR` names, otherwise in /var/tmp, which is on disk where
/tmp may be memory.
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

MAX_IN_MEMORY = 4 * 2**20
"""Longest array that stays in memory [bytes]."""

CHUNK_BYTES = 4 * 2**20
"""Size of a chunk of rows, about [bytes]."""


def allocate_rows(shape: Sequence[int], dtype: DTypeLike) -> NDArray[Any]:
    """Returns an array of zeros, (rows, ...).

    Raises:
        StoreError: if there is no room for it.
    """
    size = math.prod(shape) * np.dtype(dtype).itemsize
    if size <= MAX_IN_MEMORY:
        return np.zeros(shape, dtype)
    folder = _temporary_folder()
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            # A full disk raises here; a write to the mapping would kill the process.
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, size)
            else:
                file.truncate(size)
            return np.ndarray(shape, dtype, buffer=mmap.mmap(file.fileno(), size))
    except OSError as error:
        raise StoreError(
            f"{folder}: no room for {size / 2**20:.0f} MB of rows of the take "
            f"({error.strerror}); set TMPDIR to a folder with more room"
        ) from error


def row_chunks(array: NDArray[Any], multiple: int = 1) -> Iterator[slice]:
    """Yields slices of rows from first to last, small enough to be in memory at once.

    Args:
        array: any array.
        multiple: the length of each slice but the last is a multiple of this.
    """
    row = max(array[:1].nbytes, 1)
    count = max(CHUNK_BYTES // (row * multiple), 1) * multiple
    for first in range(0, len(array), count):
        yield slice(first, min(first + count, len(array)))
        release_rows(array)


def release_rows(array: NDArray[Any]) -> None:
    """Releases the memory of a mapped array; its file keeps the values."""
    if isinstance(array.base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
        # A shared mapping loses nothing: the file's pages stay.
        array.base.madvise(mmap.MADV_DONTNEED)


def _temporary_folder() -> Path:
    named, usual = os.environ.get("TMPDIR"), Path("/var/tmp")
    if named or not usual.is_dir():
        return Path(tempfile.gettempdir())
    return usual
