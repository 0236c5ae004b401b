"""Freed memory goes back to the system."""

from __future__ import annotations

import platform
import resource
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

BLOCKS, SIZE = 2000, 100_000


@pytest.fixture
def return_freed_memory() -> Callable[[], None]:
    # Dr.Jit must not be imported before the backend is chosen.
    from render.freed_memory import return_freed_memory

    return return_freed_memory


def _resident() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only the C library of GNU keeps it")
def test_freed_blocks_between_kept_ones_are_returned(
    return_freed_memory: Callable[[], None],
) -> None:
    return_freed_memory()
    blocks = [np.ones(SIZE, np.uint8) for _ in range(BLOCKS)]
    # One that is kept above them: nothing can be cut off at the end of the heap.
    kept = np.ones(SIZE, np.uint8)
    blocks.clear()
    before = _resident()
    return_freed_memory()
    assert before - _resident() > 0.8 * BLOCKS * SIZE
    assert kept.all()
