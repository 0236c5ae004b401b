"""Compiled code: loops over bodies as machine code, compiled when first run and cached.

The cache lies in the user's cache folder, never beside the package, in a folder named by a digest
of the sources of all rooms that compile: numba alone does not notice changes in called functions.
Where no folder is writable the code is compiled anew each time.

Compiled functions take numbers, tuples of them, and records, which are passed as one address:
tuples of many arrays cost as much as the work. Vectors are triples and rotations three rows, so
that they stay in registers. No `fastmath`: sums are added in the order written, so a body moves
alike beside any others, and with NUMBA_DISABLE_JIT=1 in plain Python as well.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba

Record = Any
"""A row of a structured array: numbers and small arrays by name."""

Records = Any
"""A structured array."""

P = ParamSpec("P")
T = TypeVar("T")


def _set_cache_folder() -> bool:
    """Sets numba's cache folder unless the user has; returns whether it is writable."""
    if numba.config.CACHE_DIR:
        return True
    here = Path(__file__).parent
    rooms = (here, here.parent / "characters")
    sources = b"".join(path.read_bytes() for room in rooms for path in sorted(room.rglob("*.py")))
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    name = hashlib.blake2b(sources, digest_size=8).hexdigest()
    folder = Path(base, "pronk", "compiled", name)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    numba.config.CACHE_DIR = str(folder)
    return os.access(folder, os.W_OK)


CACHE_WRITABLE = _set_cache_folder()
"""Whether machine code can be cached."""


def is_cached(room: str) -> bool:
    """Returns whether machine code of a room is in the cache."""
    return CACHE_WRITABLE and any(Path(numba.config.CACHE_DIR).glob(f"{room}_*/*.nbi"))


def compiled(function: Callable[P, T]) -> Callable[P, T]:
    """Compiles a function that other compiled functions call; plain Python cannot call it."""
    return numba.njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)(function)


def inlined(function: Callable[P, T]) -> Callable[P, T]:
    """Compiles a function that is inlined into its compiled callers.

    A tuple of many arrays is passed array by array, which costs more than short work on it.
    """
    return numba.njit(
        error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True
    )(function)


def entry(function: Callable[P, T]) -> Callable[P, T]:
    """Compiles a function that Python calls; its machine code is cached."""
    return numba.njit(cache=CACHE_WRITABLE, error_model="numpy")(function)
