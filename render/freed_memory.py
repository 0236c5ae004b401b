"""Freed memory: what was freed goes back to the system."""

from __future__ import annotations

import ctypes
import sys

import drjit as dr


def return_freed_memory() -> None:
    """Return to the system what was freed, as far as Dr.Jit and the C library can.

    Dr.Jit keeps all buffers for later, and the C library of GNU blocks below 32 MiB. Making
    scenery and building a scene free hundreds of MiB that nothing asks for again.

    Source: malloc_trim(3) and M_TRIM_THRESHOLD in mallopt(3), Linux man-pages.
    """
    dr.flush_malloc_cache()
    if not sys.platform.startswith("linux"):
        return
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # musl has none.
    if trim is not None:
        trim(ctypes.c_size_t(0))
