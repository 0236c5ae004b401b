"""Distributions: the wheel installed alone in an empty environment, and the sources as a whole."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import pipeline

ROOT = Path(pipeline.__file__).parents[1]

pytestmark = pytest.mark.skipif(
    find_spec("hatchling") is None, reason="no build backend here; make test installs it"
)


def run(*arguments: str | Path, cwd: Path, **settings: str) -> str:
    """Run a command that must succeed; return its output."""
    # The variables of this process are not set on a user's machine.
    unset = ("PYTHON", "SOURCE_DATE_EPOCH")
    clean = {name: value for name, value in os.environ.items() if not name.startswith(unset)}
    end = subprocess.run(
        [*map(str, arguments)], cwd=cwd, env=clean | settings, capture_output=True, text=True
    )
    assert end.returncode == 0, end.stdout + end.stderr
    return end.stdout


def build(sources: Path, place: Path, *kinds: str, **settings: str) -> list[Path]:
    """Build distributions of kinds `sdist` and `wheel` and return them in this order."""
    targets = [part for kind in kinds for part in ("-t", kind)]
    command = (sys.executable, "-m", "hatchling", "build", *targets, "-d", place)
    run(*command, cwd=sources, **settings)
    return sorted(place.iterdir(), key=lambda path: path.suffix)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return build(ROOT, tmp_path_factory.mktemp("built"), "sdist", "wheel")


@pytest.fixture(scope="module")
def sdist(built: list[Path]) -> Path:
    return built[0]


@pytest.fixture(scope="module")
def wheel(built: list[Path]) -> Path:
    return built[1]


@pytest.fixture
def unpacked(sdist: Path, tmp_path: Path) -> Path:
    with tarfile.open(sdist) as archive:
        # Python 3.11 has filters from 3.11.4 on.
        checked: Any = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}
        archive.extractall(tmp_path, **checked)
    (folder,) = tmp_path.iterdir()
    return folder


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
    page |= {
        f"pipeline/studio/page/{name}"
        for name in ("index.html", "studio.css", "studio.js", "licences.txt")
    }
    fonts = {f"render/fonts/{name}" for name in ("DejaVuSans.ttf", "DejaVuSerif.ttf", "LICENSE")}
    assert library | modules | page | fonts <= names
    rest = {name for name in names - library - modules - page - fonts if ".dist-info/" not in name}
    assert rest == set()


@pytest.mark.slow
@pytest.mark.skipif(
    not (ROOT / ".git").exists() or shutil.which("git") is None, reason="no clone of the repository"
)
def test_a_source_distribution_holds_the_whole_repository(unpacked: Path) -> None:
    tracked = set(run("git", "ls-files", cwd=ROOT).splitlines())
    files = {p.relative_to(unpacked).as_posix() for p in unpacked.rglob("*") if p.is_file()}
    assert tracked - files == set()


@pytest.mark.nightly
def test_distributions_are_the_same_bytes_wherever_and_whenever_they_are_built(
    built: list[Path], unpacked: Path, tmp_path: Path
) -> None:
    for path in unpacked.rglob("*"):
        os.utime(path, (1_700_000_000, 1_700_000_000))
        path.chmod(path.stat().st_mode & 0o700)
    again = build(unpacked, tmp_path / "again", "sdist", "wheel", TZ="Asia/Tokyo")
    assert [path.name for path in again] == [path.name for path in built]
    assert [path.read_bytes() for path in again] == [path.read_bytes() for path in built]


@pytest.mark.nightly
def test_a_date_of_the_sources_is_that_of_their_distributions(
    wheel: Path, unpacked: Path, tmp_path: Path
) -> None:
    dated = [
        build(unpacked, tmp_path / name, "sdist", "wheel", SOURCE_DATE_EPOCH="1700000000")
        for name in "ab"
    ]
    first, second = ([path.read_bytes() for path in paths] for paths in dated)
    assert first == second
    with zipfile.ZipFile(dated[0][1]) as archive:
        assert {entry.date_time for entry in archive.infolist()} == {(2023, 11, 14, 22, 13, 20)}
    assert first[1] != wheel.read_bytes()


@pytest.mark.nightly
def test_tests_run_from_a_source_distribution(unpacked: Path) -> None:
    for folder in ("docs", "benchmarks", "requirements", "tests/goldens/motion"):
        assert list((unpacked / folder).iterdir()), folder
    names = ("test_docs", "test_requirements", "render/test_film_codecs", "audio/test_sound_docs")
    tests = [f"tests/{name}.py" for name in names]
    options = ("-q", "-n0", "-m", "not slow and not nightly", "-p", "no:cacheprovider")
    said = run(sys.executable, "-m", "pytest", *options, *tests, cwd=unpacked)
    assert " passed" in said


@pytest.mark.nightly
def test_an_installed_pronk_makes_a_film_in_an_empty_folder(wheel: Path, tmp_path: Path) -> None:
    run(sys.executable, "-m", "venv", tmp_path / "venv", cwd=tmp_path)
    scripts = tmp_path / "venv" / ("Scripts" if os.name == "nt" else "bin")
    pip = (scripts / "python", "-m", "pip", "install", "-q", "--no-deps")
    pinned = ("--require-hashes", "--only-binary", ":all:", "-r")
    run(*pip, *pinned, ROOT / "requirements" / "runtime.txt", cwd=tmp_path)
    run(*pip, wheel, cwd=tmp_path)
    folder = tmp_path / "empty"
    folder.mkdir()
    scenes = {path.stem for path in (ROOT / "scenes").glob("*.yaml")}
    listed = run(scripts / "pronk", "list", "scenes", "--json", cwd=folder)
    assert all(f'"name": "{name}"' in listed for name in scenes)
    assert "first_steps: right" in run(scripts / "pronk", "check", "first_steps", cwd=folder)
    run(scripts / "pronk", "new", "hello", cwd=folder)
    assert "right: " in run(scripts / "pronk", "check", "hello.yaml", cwd=folder)
    arguments = ("render", "hello.yaml", "--preset", "draft", "--frames", "1-3")
    assert run(scripts / "pronk", *arguments, cwd=folder) == f"out{os.sep}hello\n"
    made = folder / "out" / "hello"
    frames = [path.name for path in sorted((made / "frames").iterdir())]
    assert frames == ["0001.png", "0002.png", "0003.png"]
    assert (made / "hello_1-3.mp4").is_file()
