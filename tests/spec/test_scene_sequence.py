"""Sequences: clips at their places, and what is refused, with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.errors import SceneError
from pipeline.spec import find_scene, load_scene, load_sequence
from pipeline.spec.scene_sequence import is_sequence

SCENE = """\
pronk: 1
title: {title}
fps: {fps}
duration: 4
cast:
  - {{figure: beetle}}
film: {{size: {size}}}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, fps, size in (("a", 24, "[64, 36]"), ("b", 24, "[64, 36]"), ("c", 25, "[32, 36]")):
        text = SCENE.format(title=name.upper(), fps=fps, size=size)
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    return tmp_path


def written(folder: Path, clips: str, more: str = "") -> Path:
    path = folder / "film.yaml"
    path.write_text(f"pronk: 1\n{more}sequence:\n{clips}", encoding="utf-8")
    return path


def test_clips_overlap_where_they_dissolve(folder: Path) -> None:
    clips = "  - a\n  - {scene: b.yaml, start: 1, end: 3, dissolve: 0.5}\n"
    clips += "  - {scene: a, start: 3.5, fade_in: 0.25}\n"
    path = written(folder, clips)
    assert is_sequence(path)
    assert not is_sequence(folder / "a.yaml")
    sequence = load_sequence(path)
    stretches = [(clip.name, clip.first, clip.last, clip.at) for clip in sequence.clips]
    assert stretches == [("01_a", 1, 96, 0), ("02_b", 25, 72, 84), ("03_a", 85, 96, 132)]
    assert [(clip.rise, clip.fall) for clip in sequence.clips] == [(0, 12), (12, 0), (6, 0)]
    assert sequence.n_frames == 144


def test_the_sequence_changes_its_scenes_and_the_command_line_comes_last(folder: Path) -> None:
    clips = "  - {scene: a, set: [film.samples=3]}\n  - {scene: c, set: [fps=24]}\n"
    path = written(folder, clips, "film: {size: [48, 32], samples: 5}\n")
    one, two = (clip.scene for clip in load_sequence(path).clips)
    assert (one.film.resolved().size, one.film.samples, two.film.samples) == ((48, 32), 3, 5)
    (three, _) = (clip.scene for clip in load_sequence(path, (), ["film.samples=7"]).clips)
    assert three.film.samples == 7


@pytest.mark.parametrize(
    ("clips", "message"),
    [
        ("  - {scene: a, disolve: 1}", r"film.yaml:3:\d+: sequence\[0\].disolve: .*dissolve"),
        ("  - {scene: a, dissolve: 1}", r"sequence\[0\].dissolve: no clip is before the first"),
        ("  - zz_none", r"film.yaml:3:5: sequence\[0\].scene: .*zz_none"),
        ("  - a\n  - c", r"film.yaml:4:5: sequence\[1\].scene: has 25 frames a second"),
        ("  - a\n  - {scene: c, set: [fps=24]}", r"sequence\[1\].scene: has size \(32, 36\)"),
        ("  - {scene: a, start: 2, end: 1}", r"sequence\[0\].end: must be after start, 2 s"),
        ("  - {scene: a, end: 5}", r"sequence\[0\].end: the scene ends at 4 s"),
        ("  - {scene: a, start: 4}", r"sequence\[0\].start: the scene ends at 4 s"),
        ("  - a\n  - {scene: b, dissolve: 1, fade_in: 1}", r"\[1\].fade_in: .*not both"),
        ("  - {scene: a, fade_out: 1}\n  - {scene: b, dissolve: 1}", r"\[0\].fade_out: .*leave"),
        ("  - {scene: a, end: 1, fade_in: 0.6, fade_out: 0.6}", r"\[0\]: lasts 1 s, less than"),
        ("  - {scene: a, set: [film.sise=3]}", r"sequence\[0\]: --set film.sise=3: .*size"),
        ("  - film", r"is a sequence of scenes"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(folder: Path, clips: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        load_sequence(written(folder, clips + "\n"))


def test_commands_of_one_scene_refuse_a_sequence(folder: Path) -> None:
    path = written(folder, "  - a\n")
    with pytest.raises(SceneError, match=r"film.yaml:2:1: sequence: is a sequence of scenes"):
        load_scene(path)


def test_a_strangers_sequence_keeps_to_its_folder(folder: Path) -> None:
    (folder / "inner").mkdir()
    path = folder / "inner" / "film.yaml"
    path.write_text("pronk: 1\nsequence: [../a]\n", encoding="utf-8")
    assert load_sequence(path).n_frames == 96
    with pytest.raises(SceneError, match=r"film.yaml:2:.*sequence\[0\].scene: .*out of the folder"):
        load_sequence(path, untrusted=True)


def test_a_strangers_sequence_may_use_shipped_scenes_and_those_beside_it(folder: Path) -> None:
    path = written(folder, "  - a\n  - {scene: dice, set: [fps=24, 'film.size=[64,36]']}\n")
    assert [clip.name for clip in load_sequence(path, untrusted=True).clips] == ["01_a", "02_dice"]


def test_a_strangers_sequence_that_is_a_link_is_refused_unread(folder: Path) -> None:
    inner = folder / "inner"
    inner.mkdir()
    written(folder, "  - a\n")
    (inner / "film.yaml").symlink_to(folder / "film.yaml")
    with pytest.raises(SceneError, match="out of the folder"):
        is_sequence(inner / "film.yaml", untrusted=True)
    with pytest.raises(SceneError, match="out of the folder"):
        load_sequence(inner / "film.yaml", untrusted=True)


def test_the_shipped_reel_has_eight_shots_of_a_minute() -> None:
    reel = load_sequence(find_scene("reel"))
    assert len(reel.clips) == 8
    assert 59 < reel.n_frames / reel.rate < 61
