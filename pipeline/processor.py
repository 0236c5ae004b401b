"""The processor: the same arithmetic on all that have AVX2, so that takes are the same bytes.

Numpy and its OpenBLAS choose their code by the vector units that they find, and what they choose
rounds otherwise in the last bit: enough for dominoes to fall otherwise five seconds later. On
x86-64 under Linux both are held to AVX2, which processors have since 2013; what newer ones would
gain is nothing to arrays as small as a simulation's.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path

UNITS = frozenset({"avx2", "fma", "f16c", "bmi1", "bmi2", "abm", "movbe"})
"""What Linux calls the units of the third level of x86-64, in which numpy and OpenBLAS agree."""

HELD = {"NPY_ENABLE_CPU_FEATURES": "X86_V3", "OPENBLAS_CORETYPE": "Haswell"}
"""Said to numpy and OpenBLAS, which listen as they are loaded."""


def hold() -> bool:
    """Hold numpy to the common arithmetic; return whether it is, in this process.

    It is not where numpy was loaded before, where the user has said otherwise in the same
    variables, and on other kinds of processors. Processes that are started later are held, too.
    """
    said = {
        name: os.environ[name] for name in (*HELD, "NPY_DISABLE_CPU_FEATURES") if name in os.environ
    }
    if said:
        return said == HELD
    if "numpy" in sys.modules or not UNITS <= units():
        return False
    os.environ.update(HELD)
    return True


@cache
def units() -> frozenset[str]:
    """Return the units of the processor as Linux names them; none elsewhere."""
    if platform.machine() != "x86_64":
        return frozenset()
    try:
        with Path("/proc/cpuinfo").open(encoding="ascii", errors="replace") as lines:
            flags = next((line for line in lines if line.startswith("flags")), "")
    except OSError:
        return frozenset()
    return frozenset(flags.partition(":")[2].split())


def class_of(found: Iterable[str], held: bool) -> str:
    """Return the class of processor: within it, equal scenes give equal bytes.

    Args:
        found: the vector units that numpy uses beside those that all have.
        held: whether numpy and OpenBLAS are held to the common arithmetic.
    """
    if held:
        return f"{platform.machine()}-X86_V3"
    own = ["own"] if platform.machine() == "x86_64" else []
    return "-".join([platform.machine(), *found, *own])
