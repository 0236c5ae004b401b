"""Wheel: pronk installed alone in an empty environment."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import pipeline

ROOT = Path(pipeline.__file__).parents[1]


def run(*arguments: str | Path, cwd: Path) -> str:
    """Run a command that must succeed; return its output."""
    # The variables of this process are not set on a user's machine.
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    end = subprocess.run([*map(str, arguments)], cwd=cwd, env=clean, capture_output=True, text=True)
    assert end.returncode == 0, end.stdout + end.stderr
    return end.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "pip", "wheel", "--no-deps", "-q", "-w", place, ROOT, cwd=place)
    (built,) = place.glob("pronk-*.whl")
    return built


@pytest.mark.slow
def test_a_wheel_holds_the_packages_and_the_library_and_nothing_else(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    library = {
        f"pipeline/scenes/{path.relative_to(ROOT / 'scenes').as_posix()}"
        for path in (ROOT / "scenes").rglob("*.yaml")
    }
    modules = {
        path.relative_to(ROOT).as_posix()
        for package in ("pipeline", "render", "audio")
        for path in (ROOT / package).rglob("*.py")
    }
    assert "pipeline/scenes/first_steps.yaml" in library
    page = {f"pipeline/production/goldens/report.{end}" for end in ("css", "js")}
    assert library | modules | page <= names
    rest = {name for name in names - library - modules - page if ".dist-info/" not in name}
    assert rest == set()


@pytest.mark.nightly
def test_an_installed_pronk_makes_a_film_in_an_empty_folder(wheel: Path, tmp_path: Path) -> None:
    run(sys.executable, "-m", "venv", tmp_path / "venv", cwd=tmp_path)
    scripts = tmp_path / "venv" / ("Scripts" if os.name == "nt" else "bin")
    pip = (scripts / "python", "-m", "pip", "install", "-q", "-c", ROOT / "constraints.txt")
    run(*pip, wheel, cwd=tmp_path)
    folder = tmp_path / "empty"
    folder.mkdir()
    run(scripts / "pronk", "new", "hello", cwd=folder)
    assert "right: " in run(scripts / "pronk", "check", "hello.yaml", cwd=folder)
    arguments = ("render", "hello.yaml", "--preset", "draft", "--frames", "1-3")
    assert run(scripts / "pronk", *arguments, cwd=folder) == f"out{os.sep}hello\n"
    made = folder / "out" / "hello"
    frames = [path.name for path in sorted((made / "frames").iterdir())]
    assert frames == ["0001.png", "0002.png", "0003.png"]
    assert (made / "hello_1-3.mp4").is_file()
    assert "first_steps: right" in run(scripts / "pronk", "check", "first_steps", cwd=folder)
