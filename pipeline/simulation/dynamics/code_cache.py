"""Code cache: compiled functions as files of the user, found by all that they depend on.

The files lie in one folder for each state of the sources, Python, numba and llvmlite, in the user's
cache folder and never beside the package. A file is named by its function, argument types and
processor, as numba tells processors apart, and begins with a digest of its content: a damaged or
incomplete file counts as absent. Places and times of source files do not matter, so that every
installation of the same version shares the files.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core import caching

from pipeline.atomic_file import make_folder, write_if_changed
from pipeline.simulation.compilation import observer

DIGEST_BYTES = 16
"""Bytes of the digest that a file begins with."""

ROOMS = {"characters": "people", "dynamics": "bodies"}
"""Folders that hold functions to compile, and what they simulate."""

SOURCES = (*ROOMS, "people")
"""Folders of these functions and of the constants compiled into them."""


@cache
def code_folder() -> Path:
    """Returns the folder of the present sources and compiler."""
    simulation = Path(__file__).parent.parent
    versions = (sys.version_info[:2], numba.__version__, llvmlite.__version__)
    state = hashlib.blake2b(repr(versions).encode(), digest_size=8)
    for folder in SOURCES:
        for path in sorted((simulation / folder).rglob("*.py")):
            state.update(path.read_bytes())
    return _base_folder() / state.hexdigest()


def _base_folder() -> Path:
    if numba.config.CACHE_DIR:
        return Path(numba.config.CACHE_DIR)
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base, "pronk", "compiled")


class StoredCode(caching.FunctionCache):  # type: ignore[misc]
    """Compiled code of one function, in the code folder."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._name = repr(function)
        self._py_func = function
        self._impl = _Reduction()
        self._cache_path = str(code_folder())
        self.enable()

    def flush(self) -> None:
        """Deletes the code of the function."""
        for path in code_folder().glob(f"{self._stem()}-*"):
            path.unlink(missing_ok=True)

    def _load_overload(self, signature: Any, target: Any) -> Any:
        path = self._path(signature, target.codegen())
        try:
            content = path.read_bytes()
        except OSError:
            return None
        digest, data = content[:DIGEST_BYTES], content[DIGEST_BYTES:]
        if digest != _digest(data):
            return None
        return self._impl.rebuild(target, pickle.loads(data))

    def _save_overload(self, signature: Any, compiled: Any) -> None:
        data = caching.dumps(self._impl.reduce(compiled))
        path = self._path(signature, compiled.codegen)
        try:
            make_folder(path.parent)
            write_if_changed(path, _digest(data) + data)
        except OSError as error:
            observer().warn(
                f"{path.parent}: {error.strerror}; compiled code is not stored and will be "
                "compiled again by the next run; set XDG_CACHE_HOME to a folder that is writable"
            )

    def _path(self, signature: Any, codegen: Any) -> Path:
        key = repr(self._index_key(signature, codegen)).encode()
        return code_folder() / f"{self._stem()}-{hashlib.blake2b(key, digest_size=8).hexdigest()}"

    def _stem(self) -> str:
        function = self._py_func
        return f"{function.__module__.rpartition('.')[2]}.{function.__name__}"


class _Reduction(caching.CompileResultCacheImpl):  # type: ignore[misc]
    """Compiled code as data and back; without the search for a folder."""

    def __init__(self) -> None:
        pass


def _digest(data: bytes) -> bytes:
    return hashlib.blake2b(data, digest_size=DIGEST_BYTES).digest()
