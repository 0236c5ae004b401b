"""The SoundFont of a scene: found beside it, or refused with its path."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.foreign_files import verdict_store
from pipeline.foreign_files.reader_process import Reading, read_confined
from pipeline.spec import load_scene
from tests.audio.soundfont_writer import sf2

SCENE = "pronk: 1\nduration: 1\ncast: [{figure: beetle}]\nsound:\n  soundfont: {font}\n"
PLAYS = pytest.mark.skipif(
    importlib.util.find_spec("tinysoundfont") is None, reason="tinysoundfont is not installed"
)
FONT = sf2(np.sin(np.arange(400)))


def write_scene(folder: Path, font: str) -> Path:
    path = folder / "play.yaml"
    path.write_text(SCENE.replace("{font}", font), encoding="utf-8")
    return path


def test_a_soundfont_beside_the_scene_is_found_from_any_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "fonts").mkdir()
    (tmp_path / "fonts" / "größer.sf2").write_bytes(FONT)
    path = write_scene(tmp_path, "fonts/größer.sf2")
    monkeypatch.chdir("/")
    assert load_scene(path).sound.soundfont == str(tmp_path / "fonts" / "größer.sf2")


@pytest.mark.parametrize(
    ("font", "said"),
    [
        ("none.sf2", "is no file in"),
        (".", "is a folder, not a file"),
        ("a\\0b.sf2", "cannot be the name of a file: it holds a zero byte"),
        ("x" * 300, "File name too long"),
    ],
)
def test_a_missing_soundfont_is_one_problem_with_its_path(
    tmp_path: Path, font: str, said: str
) -> None:
    path = write_scene(tmp_path, f'"{font}"')
    with pytest.raises(SceneError) as refused:
        load_scene(path)
    (problem,) = refused.value.problems
    assert (problem.line, problem.path) == (5, "sound.soundfont")
    assert said in str(problem)


def test_the_soundfont_does_not_change_the_simulation_key(tmp_path: Path) -> None:
    from pipeline.spec import simulation_key

    (tmp_path / "a.sf2").write_bytes(FONT)
    with_font = load_scene(write_scene(tmp_path, "a.sf2"))
    path = tmp_path / "plain.yaml"
    path.write_text(SCENE.partition("sound:")[0], encoding="utf-8")
    assert simulation_key(with_font) == simulation_key(load_scene(path))


def crashing_font() -> bytes:
    """Return a SoundFont whose first preset begins far behind its last zone."""
    font = bytearray(FONT)
    at = font.index(b"phdr") + 8 + 24
    font[at : at + 2] = (40_000).to_bytes(2, "little")
    return bytes(font)


@PLAYS
@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"RIFF", "is no SoundFont 2"),
        (FONT[:-40], "is cut short"),
        (FONT.replace(b"phdr", b"xxxx"), "is a damaged SoundFont"),
        (crashing_font(), "crashes its reader (SIG"),
    ],
    ids=["no font", "short", "lacks presets", "crashes"],
)
def test_a_malformed_soundfont_is_one_problem_with_its_path(
    tmp_path: Path, content: bytes, said: str
) -> None:
    (tmp_path / "a.sf2").write_bytes(content)
    with pytest.raises(SceneError) as refused:
        load_scene(write_scene(tmp_path, "a.sf2"))
    (problem,) = refused.value.problems
    assert (problem.line, problem.path) == (5, "sound.soundfont")
    assert problem.message.startswith(f"'a.sf2' {said}")


@PLAYS
def test_a_right_soundfont_is_read_once_by_its_content(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = []

    def confined(reading: Reading) -> Any:
        read.append(reading.file.name)
        return read_confined(reading)

    monkeypatch.setattr(verdict_store, "read_confined", confined)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "a.sf2").write_bytes(FONT)
    (tmp_path / "b.sf2").write_bytes(FONT)
    (tmp_path / "c.sf2").write_bytes(FONT + b"\0\0")
    for name in ("a", "a", "b", "c", "c"):
        load_scene(write_scene(tmp_path, f"{name}.sf2"))
    assert read == ["a.sf2", "c.sf2"]
    # A damaged one is read each time, because its reader may have failed for other reasons.
    (tmp_path / "d.sf2").write_bytes(crashing_font())
    for _ in range(2):
        with pytest.raises(SceneError):
            load_scene(write_scene(tmp_path, "d.sf2"))
    assert read[2:] == ["d.sf2", "d.sf2"]
    # Without a folder for verdicts the check is the same.
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "a.sf2"))
    load_scene(write_scene(tmp_path, "a.sf2"))
    assert read[4:] == ["a.sf2"]


def test_without_its_player_a_soundfont_is_not_checked_and_that_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    # What this process needs is loaded; its children have their own.
    import audio.soundfont  # noqa: F401

    elsewhere = [entry for entry in sys.path if not entry.endswith("site-packages")]
    monkeypatch.setattr(sys, "path", elsewhere)
    (tmp_path / "a.sf2").write_bytes(FONT)
    load_scene(write_scene(tmp_path, "a.sf2"))
    assert "'a.sf2' is not checked" in caplog.text
    assert "pip install --no-deps tinysoundfont" in caplog.text
