"""The picture that lights a scene, and who carries its lamps: refused with their places."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from pipeline.errors import SceneError
from pipeline.spec import load_scene, simulation_key

SCENE = "pronk: 1\nduration: 1\ncast: [{figure: beetle, name: bug}]\nlight:\n  {light}\n"


def written(folder: Path, light: str) -> Path:
    path = folder / "play.yaml"
    path.write_text(SCENE.replace("{light}", light), encoding="utf-8")
    return path


def picture(path: Path, width: int = 8, height: int = 4) -> None:
    pixels = np.ones((height, width, 3), np.float16)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": pixels}) as file:
        file.write(str(path))


def test_a_picture_is_found_beside_the_scene_and_is_none_of_what_is_simulated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture(tmp_path / "place.exr")
    path = written(tmp_path, "hdr: {file: place.exr}")
    monkeypatch.chdir("/")
    scene = load_scene(path)
    assert scene.light.hdr is not None
    assert scene.light.hdr.file == str(tmp_path / "place.exr")
    assert simulation_key(scene) == simulation_key(load_scene(written(tmp_path, "preset: day")))


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("none.exr", "is no file in"),
        (".", "is no file in"),
        ('"a\\0b.exr"', "is no file in"),
        ("square.exr", "8 by 8 pixels"),
        ("torn.exr", "cannot be read as an image"),
        ("torn.hdr", "cannot be read as an image"),
        ("a.png", "is no .exr or .hdr file"),
    ],
)
def test_a_picture_that_is_of_no_use_is_one_problem_with_its_place(
    tmp_path: Path, file: str, said: str
) -> None:
    picture(tmp_path / "square.exr", 8, 8)
    for name in ("torn.exr", "torn.hdr", "a.png"):
        (tmp_path / name).write_bytes(b"nothing")
    with pytest.raises(SceneError) as refused:
        load_scene(written(tmp_path, f"hdr: {{file: {file}}}"))
    (problem,) = refused.value.problems
    assert (problem.line, problem.path) == (5, "light.hdr.file")
    assert said in str(problem)


def test_a_picture_is_watched(tmp_path: Path) -> None:
    from pipeline.production.run.watch import files_of

    picture(tmp_path / "place.exr")
    scene = load_scene(written(tmp_path, "hdr: {file: place.exr}"))
    assert files_of(scene) >= {tmp_path / "place.exr"}


def test_a_lamp_that_nobody_carries_is_refused_with_its_place(tmp_path: Path) -> None:
    with pytest.raises(SceneError) as refused:
        load_scene(written(tmp_path, "lamps: [{}, {parent: bog.head}]"))
    (problem,) = refused.value.problems
    assert problem.path == "light.lamps[1].parent"
    assert "did you mean 'bug'" in str(problem)
