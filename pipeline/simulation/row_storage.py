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
"""Longest reel that is kept in memory [bytes]."""

CHUNK_BYTES = 4 * 2**20
"""About so much of a reel is looked at at once [bytes]."""


def allocate_rows(shape: Sequence[int], dtype: DTypeLike) -> NDArray[Any]:
    """Return an array of zeros, (rows, ...).

    Raises:
        StoreError: if there is no room for it.
    """
    size = math.prod(shape) * np.dtype(dtype).itemsize
    if size <= MAX_IN_MEMORY:
        return np.zeros(shape, dtype)
    folder = _temporary_folder()
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


def row_chunks(array: NDArray[Any], multiple: int = 1) -> Iterator[slice]:
    """Yield rows of a reel from the first to the last, so many as may be in memory at once.

    Args:
        array: any array.
        multiple: of how many rows each but the last is.
    """
    row = max(array[:1].nbytes, 1)
    count = max(CHUNK_BYTES // (row * multiple), 1) * multiple
    for first in range(0, len(array), count):
        yield slice(first, min(first + count, len(array)))
        release_rows(array)


def release_rows(array: NDArray[Any]) -> None:
    """Give back the memory of a reel's rows; its file has them."""
    if isinstance(array.base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
        # Of a shared mapping nothing is lost by this: the file's pages stay as they are.
        array.base.madvise(mmap.MADV_DONTNEED)


def _temporary_folder() -> Path:
    named, usual = os.environ.get("TMPDIR"), Path("/var/tmp")
    if named or not usual.is_dir():
        return Path(tempfile.gettempdir())
    return usual
