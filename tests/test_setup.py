"""Set-up: what make installs, quietly, and again after an interruption."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

# Makes a folder with a python that notes what it is asked to install.
PYTHON = """#!/bin/sh
case "$*" in
    "-m venv .venv")
        mkdir -p .venv/bin && cp "$0" .venv/bin/python
        printf '#!/bin/sh\\necho made "$@"\\n' > .venv/bin/pronk && chmod +x .venv/bin/pronk;;
    "-m pip"*)
        echo "$*" >> calls
        echo "Collecting everything"
        if [ -e fails ]; then echo "ERROR: no such package" >&2; exit 1; fi
        if [ -e dies ]; then kill -9 $PPID; fi
        touch .venv/half;;
esac
"""

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="no make")


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, tmp_path)
    python = tmp_path / "python"
    python.write_text(PYTHON)
    python.chmod(0o755)
    return tmp_path


OUTER_MAKE = ("MAKEFLAGS", "MAKELEVEL", "MFLAGS")
"""Settings by which make knows that another make runs it, and says more."""


def make(clone: Path, target: str = "demo") -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["make", f"PYTHON={clone / 'python'}", target],
        cwd=clone,
        env={key: value for key, value in os.environ.items() if key not in OUTER_MAKE},
        capture_output=True,
        text=True,
        check=False,
    )


def calls(clone: Path) -> list[str]:
    return (clone / "calls").read_text().splitlines()


def test_demo_installs_what_rendering_needs_and_says_little(clone: Path) -> None:
    done = make(clone)
    assert (done.returncode, done.stderr) == (0, "")
    first, last = done.stdout.splitlines()
    assert first.startswith("setting up .venv")
    assert last == "made render first_steps"
    (call,) = calls(clone)
    assert call.endswith("-c constraints.txt -e .")
    assert make(clone).stdout == "made render first_steps\n"
    assert len(calls(clone)) == 1


def test_the_tools_of_the_tests_are_added(clone: Path) -> None:
    make(clone)
    assert make(clone, ".venv/.tools").returncode == 0
    assert [call.split()[-1] for call in calls(clone)] == [".", ".[dev]", "tinysoundfont"]
    make(clone)
    make(clone, ".venv/.tools")
    assert len(calls(clone)) == 3


def test_a_failure_shows_what_pip_said(clone: Path) -> None:
    (clone / "fails").touch()
    done = make(clone)
    assert done.returncode != 0
    assert "Collecting everything\nERROR: no such package\n" in done.stdout
    assert "made" not in done.stdout


@pytest.mark.parametrize("target", [".venv/.ready", ".venv/.tools"])
def test_an_interrupted_set_up_starts_again(clone: Path, target: str) -> None:
    if target == ".venv/.tools":
        make(clone)
    (clone / "dies").touch()
    assert make(clone, target).returncode != 0
    (clone / "dies").unlink()
    (clone / ".venv" / "left").touch()
    assert make(clone).stdout.splitlines()[-1] == "made render first_steps"
    assert not (clone / ".venv" / "left").exists()


def test_an_environment_of_ones_own_is_installed_into(clone: Path) -> None:
    (clone / ".venv").mkdir()
    (clone / ".venv" / "own").touch()
    assert make(clone).returncode == 0
    assert (clone / ".venv" / "own").exists()
