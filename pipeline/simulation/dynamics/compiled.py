"""Compiled: loops over bodies as machine code, made when they are first run and kept.

What is made is kept in the user's cache, never beside the package, in a folder named by a
digest of the sources of all rooms that compile: numba alone would not see that a function which another one
calls has changed. Where nothing can be written it is made anew each time.

Compiled functions take numbers, tuples of them, and records, which are passed as one address:
tuples of many arrays cost as much as the work. Vectors are triples and rotations three rows:
such values live in registers. No `fastmath`: sums are added up as they
are written, so the same body moves the same way beside any others, and with
NUMBA_DISABLE_JIT=1 in plain Python as well.
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


def _kept() -> bool:
    """Choose where machine code is kept, unless the user has; say whether it can be."""
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


KEPT = _kept()
"""Whether machine code can be kept."""


def is_made(room: str) -> bool:
    """Tell whether machine code of a room was made before."""
    return KEPT and any(Path(numba.config.CACHE_DIR).glob(f"{room}_*/*.nbi"))


def compiled(function: Callable[P, T]) -> Callable[P, T]:
    """Return a function that others which are compiled call; it becomes part of them."""
    made: Callable[P, T] = numba.njit(
        error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True
    )(function)
    return made


def inlined(function: Callable[P, T]) -> Callable[P, T]:
    """Return a function that is copied to where others which are compiled call it.

    A tuple of many arrays is handed over array by array, which costs more than short work on
    it does.
    """
    made: Callable[P, T] = numba.njit(
        error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True
    )(function)
    return made


def entry(function: Callable[P, T]) -> Callable[P, T]:
    """Return a function that Python calls, as machine code which is kept."""
    made: Callable[P, T] = numba.njit(cache=KEPT, error_model="numpy")(function)
    return made
