"""Processor class: hold numpy to the arithmetic that all processors with AVX2 share.

Numpy and its OpenBLAS choose their kernels by the vector units they find, and the kernels round
differently in the last bit. That is enough for a chaotic scene to end differently five seconds
later. On x86-64 under Linux both are held to AVX2, which processors have had since 2013; arrays as
small as a simulation's gain nothing from wider units.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

REQUIRED_FLAGS = frozenset({"avx2", "fma", "f16c", "bmi1", "bmi2", "abm", "movbe"})
"""Flags of the x86-64-v3 level as Linux names them; numpy and OpenBLAS agree on this level."""

HELD = {"NPY_ENABLE_CPU_FEATURES": "X86_V3", "OPENBLAS_CORETYPE": "Haswell"}
"""Environment variables that numpy and OpenBLAS read when they are loaded, and the held values."""

RELATED = (*HELD, "NPY_DISABLE_CPU_FEATURES")
"""Environment variables that select the kernels of numpy and OpenBLAS."""


def hold() -> bool:
    """Hold numpy to the common arithmetic; return whether this process uses it.

    Settings of the user that agree with the hold are completed. The hold fails where the user
    chose other kernels, where numpy is already loaded without it, and on other processors. Child
    processes inherit the hold.
    """
    chosen = {name: os.environ[name] for name in RELATED if os.environ.get(name)}
    if chosen == HELD:
        return True
    if not agrees(chosen) or "numpy" in sys.modules or not REQUIRED_FLAGS <= processor_flags():
        return False
    os.environ.update(HELD)
    return True


def agrees(chosen: Mapping[str, str]) -> bool:
    """Return whether the user's settings leave the held kernels possible.

    Args:
        chosen: the variables of `RELATED` that the environment sets.
    """
    return all(
        name in HELD and value.strip().lower() == HELD[name].lower()
        for name, value in chosen.items()
    )


@cache
def processor_flags() -> frozenset[str]:
    """Return the flags of the processor as Linux names them; empty on other systems."""
    if platform.machine() != "x86_64":
        return frozenset()
    try:
        with Path("/proc/cpuinfo").open(encoding="ascii", errors="replace") as lines:
            flags = next((line for line in lines if line.startswith("flags")), "")
    except OSError:
        return frozenset()
    return frozenset(flags.partition(":")[2].split())


def class_name(simd: Iterable[str], held: bool) -> str:
    """Return the processor class; equal scenes give equal bytes within one class.

    Args:
        simd: the vector units that numpy dispatches to beyond its baseline.
        held: whether numpy and OpenBLAS are held to the common arithmetic.
    """
    if held:
        return f"{platform.machine()}-X86_V3"
    suffix = ["own"] if platform.machine() == "x86_64" else []
    return "-".join([platform.machine(), *simd, *suffix])
