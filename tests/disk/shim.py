"""Shim: control of the disk shim from within a process that runs with it."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

SOURCE = Path(__file__).with_name("disk_shim.c")


def built(folder: Path) -> Path:
    """Build the shim into a folder and return its file; skip the test where nothing builds it."""
    compiler = shutil.which("cc")
    if compiler is None or not Path("/proc/self/fd").is_dir():
        pytest.skip("the disk shim needs Linux and a C compiler")
    file = folder / "disk_shim.so"
    options = ["-shared", "-fPIC", "-O1", "-o", str(file), str(SOURCE), "-ldl", "-lpthread"]
    subprocess.run([compiler, *options], check=True, capture_output=True)
    return file


def environment(shim: Path) -> dict[str, str]:
    """Return the environment of a process with the shim that can import the tests."""
    paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "LD_PRELOAD": str(shim), "PYTHONPATH": os.pathsep.join(paths)}


def run_with(shim: Path, code: str, *arguments: object) -> str:
    """Run Python code in a process of its own with the shim; return what it prints."""
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        env=environment(shim),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


class Shim:
    """The shim of this process."""

    def __init__(self) -> None:
        self._library = ctypes.CDLL(os.environ["LD_PRELOAD"])
        self._library.shim_failed.restype = ctypes.c_char_p
        self._library.shim_stop.restype = ctypes.c_long
        self._library.shim_start.argtypes = [
            *(ctypes.c_char_p, ctypes.c_char_p),
            *(ctypes.c_long, ctypes.c_int),
        ]

    def start(self, folder: Path, log: Path | None = None, failing: int = 0, code: int = 0) -> None:
        """Observe a folder.

        Args:
            folder: with its real path.
            log: file of the log, None for none.
            failing: number of the call that fails, from 1; 0 for none.
            code: number of its error.
        """
        named = os.fsencode(log) if log else b""
        self._library.shim_start(os.fsencode(folder), named, failing, code)

    def stop(self) -> int:
        """Observe no more; return the number of calls."""
        return int(self._library.shim_stop())

    @property
    def failed(self) -> str:
        """The call that failed, "" if none did."""
        return os.fsdecode(self._library.shim_failed())
