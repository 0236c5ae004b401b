"""Benchmarks import names that exist: no other test runs them."""

from __future__ import annotations

import ast
from importlib import import_module
from pathlib import Path

import pytest

from render.backend import choose

SCRIPTS = sorted((Path(__file__).parents[1] / "benchmarks").glob("*.py"))
PACKAGES = ("pipeline", "render", "audio")


@pytest.fixture(scope="module", autouse=True)
def backend() -> None:
    """Activate the backend: importing the tracer, some benchmarks import Dr.Jit."""
    choose().activate()


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_names_that_a_benchmark_imports_exist(script: Path) -> None:
    tree = ast.parse(script.read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    for node in imports:
        if node.module is not None and node.module.split(".")[0] in PACKAGES:
            module = import_module(node.module)
            missing = [alias.name for alias in node.names if not hasattr(module, alias.name)]
            assert not missing, f"{node.module} has no {', '.join(missing)}"
