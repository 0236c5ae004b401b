"""Panorama files and lamp parents of a scene's light: found, or refused with their path."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from pipeline.errors import SceneError
from pipeline.spec import load_scene, simulation_key

SCENE = "pronk: 1\nduration: 1\ncast: [{figure: beetle, name: bug}]\nlight:\n  {light}\n"


def write_scene(folder: Path, light: str) -> Path:
    path = folder / "play.yaml"
    path.write_text(SCENE.replace("{light}", light), encoding="utf-8")
    return path


def write_panorama(path: Path, width: int = 8, height: int = 4) -> None:
    pixels = np.ones((height, width, 3), np.float16)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": pixels}) as file:
        file.write(str(path))


def test_a_panorama_beside_the_scene_is_found_and_does_not_change_the_simulation_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_panorama(tmp_path / "place.exr")
    path = write_scene(tmp_path, "hdr: {file: place.exr}")
    monkeypatch.chdir("/")
    scene = load_scene(path)
    assert scene.light.hdr is not None
    assert scene.light.hdr.file == str(tmp_path / "place.exr")
    assert simulation_key(scene) == simulation_key(load_scene(write_scene(tmp_path, "preset: day")))


@pytest.mark.parametrize(
    ("file", "message"),
    [
        ("none.exr", "is no file in"),
        (".", "is no .exr or .hdr file"),
        ('"a\\0b.exr"', "it holds a zero byte"),
        ("square.exr", "8 by 8 pixels"),
        ("torn.exr", "cannot be read as an image"),
        ("torn.hdr", "cannot be read as an image"),
        ("a.png", "is no .exr or .hdr file"),
    ],
)
def test_an_unusable_panorama_is_one_problem_with_its_path(
    tmp_path: Path, file: str, message: str
) -> None:
    write_panorama(tmp_path / "square.exr", 8, 8)
    for name in ("torn.exr", "torn.hdr", "a.png"):
        (tmp_path / name).write_bytes(b"nothing")
    with pytest.raises(SceneError) as refused:
        load_scene(write_scene(tmp_path, f"hdr: {{file: {file}}}"))
    (problem,) = refused.value.problems
    assert (problem.line, problem.path) == (5, "light.hdr.file")
    assert message in str(problem)


def test_a_panorama_is_watched(tmp_path: Path) -> None:
    from pipeline.production.run.watch import files_of

    write_panorama(tmp_path / "place.exr")
    scene = load_scene(write_scene(tmp_path, "hdr: {file: place.exr}"))
    assert files_of(scene) >= {tmp_path / "place.exr"}


def test_an_unknown_lamp_parent_is_refused_with_its_path(tmp_path: Path) -> None:
    with pytest.raises(SceneError) as refused:
        load_scene(write_scene(tmp_path, "lamps: [{}, {parent: bog.head}]"))
    (problem,) = refused.value.problems
    assert problem.path == "light.lamps[1].parent"
    assert "did you mean 'bug'" in str(problem)
