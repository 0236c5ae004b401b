"""The SoundFont of a scene: found beside it, or refused with its path."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.errors import SceneError
from pipeline.spec import load_scene

SCENE = "pronk: 1\nduration: 1\ncast: [{figure: beetle}]\nsound:\n  soundfont: {font}\n"


def write_scene(folder: Path, font: str) -> Path:
    path = folder / "play.yaml"
    path.write_text(SCENE.replace("{font}", font), encoding="utf-8")
    return path


def test_a_soundfont_beside_the_scene_is_found_from_any_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "fonts").mkdir()
    (tmp_path / "fonts" / "größer.sf2").write_bytes(b"RIFF")
    path = write_scene(tmp_path, "fonts/größer.sf2")
    monkeypatch.chdir("/")
    assert load_scene(path).sound.soundfont == str(tmp_path / "fonts" / "größer.sf2")


@pytest.mark.parametrize("font", ["none.sf2", ".", "a\\0b.sf2"])
def test_a_missing_soundfont_is_one_problem_with_its_path(tmp_path: Path, font: str) -> None:
    path = write_scene(tmp_path, f'"{font}"')
    with pytest.raises(SceneError) as refused:
        load_scene(path)
    (problem,) = refused.value.problems
    assert (problem.line, problem.path) == (5, "sound.soundfont")
    assert "is no file in" in str(problem)


def test_the_soundfont_does_not_change_the_simulation_key(tmp_path: Path) -> None:
    from pipeline.spec import simulation_key

    (tmp_path / "a.sf2").write_bytes(b"")
    with_font = load_scene(write_scene(tmp_path, "a.sf2"))
    path = tmp_path / "plain.yaml"
    path.write_text(SCENE.partition("sound:")[0], encoding="utf-8")
    assert simulation_key(with_font) == simulation_key(load_scene(path))
