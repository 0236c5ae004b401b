"""The processor class: numpy and BLAS use the same units on every processor."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from pipeline.processor import HELD, RELATED, REQUIRED_FLAGS, class_name, processor_flags

pytestmark = pytest.mark.nightly

PRINT_CLASS = (
    "import pipeline; from pipeline.simulation.versions import processor_class; "
    "print(processor_class())"
)

needs_avx2 = pytest.mark.skipif(
    not processor_flags() >= REQUIRED_FLAGS, reason="the processor has no AVX2, or is no x86-64"
)


def python_output(code: str, **variables: str) -> str:
    """Return the output of a Python process whose kernels `variables` alone select."""
    clean = {name: value for name, value in os.environ.items() if name not in RELATED}
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
@needs_avx2
def test_child_processes_inherit_the_processor_class() -> None:
    child = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {PRINT_CLASS!r}])"
    assert python_output("import pipeline; " + child) == "x86_64-X86_V3"


@pytest.mark.sample(3)
@pytest.mark.slow
@pytest.mark.parametrize(
    "variables",
    [
        {},
        HELD,
        {"OPENBLAS_CORETYPE": "Haswell"},
        {"OPENBLAS_CORETYPE": "haswell"},
        {"OPENBLAS_CORETYPE": ""},
        {"NPY_ENABLE_CPU_FEATURES": "X86_V3"},
        {"NPY_DISABLE_CPU_FEATURES": ""},
    ],
    ids=lambda variables: " ".join(f"{k}={v}" for k, v in variables.items()) or "nothing set",
)
@needs_avx2
def test_compatible_settings_are_completed(variables: dict[str, str]) -> None:
    assert python_output(PRINT_CLASS, **variables) == "x86_64-X86_V3"


@needs_avx2
def test_numpy_and_its_blas_use_the_common_units() -> None:
    found = "n.show_config(mode='dicts')['SIMD Extensions']['found']"
    assert python_output(f"import pipeline, numpy as n; print(*{found})") == "X86_V3"
    assert "Haswell" in python_output("import pipeline, numpy", OPENBLAS_VERBOSE="2")


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("before", "variables"),
    [
        ("import numpy; ", {}),
        ("import numpy; ", {"OPENBLAS_CORETYPE": "Haswell"}),
        ("", {"OPENBLAS_CORETYPE": "Nehalem"}),
        ("", {"NPY_DISABLE_CPU_FEATURES": "X86_V3"}),
        ("", {"OPENBLAS_CORETYPE": "Haswell", "NPY_DISABLE_CPU_FEATURES": "X86_V3"}),
    ],
    ids=["numpy first", "numpy first, kernel chosen", "other kernel", "fewer units", "mixed"],
)
@needs_avx2
def test_incompatible_settings_give_an_own_class(before: str, variables: dict[str, str]) -> None:
    assert python_output(before + PRINT_CLASS, **variables).endswith("-own")


def test_class_names_of_held_and_other_processes_differ() -> None:
    assert class_name(["X86_V3"], held=True) != class_name(["X86_V3"], held=False)
