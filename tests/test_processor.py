"""Arithmetic is the same on all processors that have what it is held to."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from pipeline.processor import HELD, UNITS, class_of, units

TELL = "import pipeline; from pipeline.simulation.versions import processor_class as c; print(c())"
NAMES = (*HELD, "NPY_DISABLE_CPU_FEATURES")

able = pytest.mark.skipif(not units() >= UNITS, reason="this processor has no AVX2, or is no x86")


def told(code: str, **variables: str) -> str:
    clean = {name: value for name, value in os.environ.items() if name not in NAMES}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env={**clean, **variables},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=True,
    )
    return done.stdout.strip()


@pytest.mark.slow
@able
def test_a_process_of_ours_is_held_and_those_it_starts() -> None:
    assert told(TELL) == "x86_64-X86_V3"
    below = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {TELL!r}], check=True)"
    assert told("import pipeline; " + below) == "x86_64-X86_V3"


@able
def test_numpy_and_its_blas_obey() -> None:
    found = "n.show_config(mode='dicts')['SIMD Extensions']['found']"
    assert told(f"import pipeline, numpy as n; print(*{found})") == "X86_V3"
    assert "Haswell" in told("import pipeline, numpy", OPENBLAS_VERBOSE="2")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("before", "variables"),
    [
        ("import numpy; ", {}),
        ("", {"OPENBLAS_CORETYPE": "Nehalem"}),
        ("", {"NPY_DISABLE_CPU_FEATURES": "X86_V3"}),
    ],
    ids=["numpy was loaded", "another kernel", "fewer units"],
)
@able
def test_who_is_not_held_is_of_another_class(before: str, variables: dict[str, str]) -> None:
    assert told(before + TELL, **variables).endswith("-own")


def test_other_processors_keep_what_they_have() -> None:
    assert class_of(["X86_V3"], held=True) != class_of(["X86_V3"], held=False)
