"""The scene that `pronk new` writes."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipeline.errors import PronkError, UsageError
from pipeline.production.run.scene_check import check_scene
from pipeline.production.run.starter_scene import write_starter
from pipeline.spec import load_scene


def test_a_starter_passes_check(tmp_path: Path) -> None:
    scene = load_scene(write_starter("my_first", tmp_path))
    assert scene.title == "My first"
    assert check_scene(scene).startswith("right: 96 frames at 24 a second")


@pytest.mark.parametrize(
    "name",
    [
        "yes",
        "null",
        "12",
        "1e3",
        "~",
        "2024-01-01",
        "a b",
        "Käfer",
        "虫",
        "it's",
        "'q",
        "&a",
        "a, b",
    ],
)
def test_valid_names_make_a_scene(tmp_path: Path, name: str) -> None:
    path = write_starter(name, tmp_path)
    assert path == tmp_path / f"{name}.yaml"
    assert load_scene(path).title.casefold() == name.casefold()


@pytest.mark.parametrize(
    "name",
    [
        "",
        ".",
        "..",
        ".hidden",
        ".yaml",
        "-x",
        "a/b",
        "a\\b",
        "a\nb",
        "a\0b",
        " a",
        "a:b",
        "#a",
        "\ud800",
    ],
)
def test_invalid_names_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(UsageError, match="is no name for a scene"):
        write_starter(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.text(max_size=20))
def test_every_name_makes_a_scene_or_a_message(tmp_path: Path, name: str) -> None:
    try:
        path = write_starter(name, tmp_path)
    except PronkError:
        return
    assert load_scene(path).title
    path.unlink()


def test_a_name_that_is_too_long_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="is no name for a scene"):
        write_starter("x" * 201, tmp_path)
    assert write_starter("x" * 200, tmp_path).is_file()
