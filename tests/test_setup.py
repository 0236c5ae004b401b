"""Set-up: what make installs, quietly, and again after an interruption."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from hashlib import sha256
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

# Makes a folder with a python that notes what it is asked to install; pinned files go through the
# real pip where the folder has links.
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
        case "$*" in *--require-hashes*) if [ -e links ]; then
            exec "$REAL_PYTHON" "$@" --target .venv/packages
        fi;; esac
        touch .venv/half;;
esac
"""

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="no make")


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    for name in ("Makefile", "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path)
    shutil.copytree(ROOT / "requirements", tmp_path / "requirements")
    python = tmp_path / "python"
    python.write_text(PYTHON)
    python.chmod(0o755)
    return tmp_path


OUTER_MAKE = ("MAKEFLAGS", "MAKELEVEL", "MFLAGS")
"""Settings by which make knows that another make runs it, and says more."""


def make(clone: Path, target: str = "demo", **settings: str) -> subprocess.CompletedProcess[str]:
    outer = {key: value for key, value in os.environ.items() if key not in OUTER_MAKE}
    return subprocess.run(
        ["make", f"PYTHON={clone / 'python'}", target],
        cwd=clone,
        env={**outer, "REAL_PYTHON": sys.executable, **settings},
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
    pinned, project = calls(clone)
    assert pinned.endswith("-r requirements/runtime.txt -r requirements/build.txt")
    assert project.endswith("-e .")
    assert make(clone).stdout == "made render first_steps\n"
    assert len(calls(clone)) == 2


def test_packages_come_by_their_hashes_and_the_project_brings_none(clone: Path) -> None:
    make(clone, ".venv/.tools")
    *others, tools = calls(clone)
    pinned, project = others
    for call in (pinned, tools):
        assert {"--require-hashes", "--no-deps"} <= set(call.split())
        # What a source distribution is built with has no hashes.
        assert "--only-binary :all:" in call
    assert {"--no-build-isolation", "--no-deps"} <= set(project.split())


def test_the_tools_of_the_tests_are_added(clone: Path) -> None:
    make(clone)
    assert make(clone, ".venv/.tools").returncode == 0
    last = [call.split()[-1] for call in calls(clone)]
    assert last == ["requirements/build.txt", ".", "requirements/dev.txt"]
    make(clone)
    make(clone, ".venv/.tools")
    assert len(calls(clone)) == 3


def test_what_the_tests_of_farms_need_is_added_apart(clone: Path) -> None:
    assert make(clone, ".venv/.farm").returncode == 0
    farm = calls(clone)[-1]
    assert farm.endswith("-r requirements/farm.txt -r requirements/browser.txt")
    assert {"--require-hashes", "--no-deps"} <= set(farm.split())
    make(clone, ".venv/.tools")
    make(clone, ".venv/.farm")
    assert len(calls(clone)) == 4


def write_wheel(folder: Path) -> str:
    """Write a package and return its pin."""
    folder.mkdir()
    path = folder / "tiny-1.0-py3-none-any.whl"
    info = "tiny-1.0.dist-info"
    with zipfile.ZipFile(path, "w") as wheel:
        wheel.writestr("tiny.py", "")
        wheel.writestr(f"{info}/METADATA", "Metadata-Version: 2.1\nName: tiny\nVersion: 1.0\n")
        wheel.writestr(
            f"{info}/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
        )
        wheel.writestr(f"{info}/RECORD", "")
    return f"tiny==1.0 --hash=sha256:{sha256(path.read_bytes()).hexdigest()}\n"


@pytest.mark.slow
def test_a_wrong_hash_is_one_message_and_the_right_one_is_found_where_the_environment_says(
    clone: Path,
) -> None:
    pin = write_wheel(clone / "links")
    place = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(clone / "links")}
    (clone / "requirements" / "build.txt").write_text("")
    runtime = clone / "requirements" / "runtime.txt"
    name, _, right = pin.partition("sha256:")
    runtime.write_text(f"{name}sha256:{'0' * 64}\n")
    done = make(clone, **place)
    assert done.returncode != 0
    heard = done.stdout.partition("\n")[2]
    assert heard.startswith("ERROR: THESE PACKAGES DO NOT MATCH THE HASHES")
    assert "tiny==1.0" in heard
    assert "(from -r requirements/runtime.txt (line 1))" in heard
    assert right.strip() in heard
    assert "0" * 64 not in heard
    assert heard.endswith('see "Pinned packages" in CONTRIBUTING.md\n')
    assert not (clone / ".venv" / "packages").exists()
    runtime.write_text(pin)
    assert make(clone, **place).returncode == 0
    assert (clone / ".venv" / "packages" / "tiny.py").is_file()


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
