"""The SoundFont of a scene: found beside it, and refused with its place when it is not there."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.errors import SceneError
from pipeline.spec import load_scene

SCENE = "pronk: 1\nduration: 1\ncast: [{figure: beetle}]\nsound:\n  soundfont: {font}\n"


def written(folder: Path, font: str) -> Path:
    path = folder / "play.yaml"
    path.write_text(SCENE.replace("{font}", font), encoding="utf-8")
    return path


def test_a_font_is_found_beside_the_scene_from_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "fonts").mkdir()
    (tmp_path / "fonts" / "größer.sf2").write_bytes(b"RIFF")
    path = written(tmp_path, "fonts/größer.sf2")
    monkeypatch.chdir("/")
    assert load_scene(path).sound.soundfont == str(tmp_path / "fonts" / "größer.sf2")


@pytest.mark.parametrize("font", ["none.sf2", ".", "a\\0b.sf2"])
def test_a_font_that_is_not_there_is_one_problem_with_its_place(tmp_path: Path, font: str) -> None:
    path = written(tmp_path, f'"{font}"')
    with pytest.raises(SceneError) as refused:
        load_scene(path)
    (problem,) = refused.value.problems
    assert (problem.line, problem.path) == (5, "sound.soundfont")
    assert "is no file in" in str(problem)


def test_the_font_is_none_of_what_is_simulated(tmp_path: Path) -> None:
    from pipeline.spec import simulation_key

    (tmp_path / "a.sf2").write_bytes(b"")
    with_font = load_scene(written(tmp_path, "a.sf2"))
    path = tmp_path / "plain.yaml"
    path.write_text(SCENE.partition("sound:")[0], encoding="utf-8")
    assert simulation_key(with_font) == simulation_key(load_scene(path))
