"""Mode store: modes of bodies as files in the user's cache, so that each body is solved once.

A file is named by the body, and lies in a folder for each state of the sources and libraries that
solve it. It is sealed: a damaged or incomplete file counts as absent.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np

from audio.dsp import Signal
from pipeline.atomic_file import make_folder, read_sealed, write_sealed
from pipeline.user_cache import user_cache_folder

FOLDER = "modes"

# Modules on which the modes depend.
_SOURCES = ("body_shape.py", "elastic_modes.py", "symmetric_eigen.py", "thin_walls.py")


def stored(body: tuple[object, ...], shape: tuple[int, ...], solve: Callable[[], Signal]) -> Signal:
    """Return a table of a body, from its file if there is one.

    Args:
        body: all that the table depends on.
        shape: of a row of the table.
        solve: returns the table (M, *shape).
    """
    name = hashlib.blake2b(repr(body).encode(), digest_size=16).hexdigest()
    path = user_cache_folder() / FOLDER / _state() / name
    data = read_sealed(path)
    if data is not None:
        return np.frombuffer(data, "<f8").reshape(-1, *shape)
    table = solve()
    # The store only saves time.
    with suppress(OSError):
        make_folder(path.parent)
        write_sealed(path, table.astype("<f8").tobytes())
    return table


@cache
def _state() -> str:
    """Return the name of the present sources and libraries."""
    state = hashlib.blake2b(repr([version(name) for name in ("numpy", "scipy")]).encode())
    for source in _SOURCES:
        state.update((Path(__file__).parent / source).read_bytes())
    return state.hexdigest()[:16]
