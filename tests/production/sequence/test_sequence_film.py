"""The film of a sequence: its pictures, its sound, its repair and its verification."""

from __future__ import annotations

import json
import wave
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from audio.joined_sound import SoundPiece, write_joined_sound
from audio.mastering import FULL_SCALE
from audio.wav_file import read_samples, wav_bytes
from pipeline.production.run.film_source import FilmSource
from pipeline.production.run.outputs import Outputs
from pipeline.production.sequence.sequence_source import ClipSource, SequenceSource
from pipeline.spec import load_sequence
from render.image_files import read_png

if TYPE_CHECKING:
    from tests.production.conftest import Studio

Pronk = Callable[..., tuple[int, str, str]]

SEQUENCE = """\
pronk: 1
title: Two
titles: [{preset: caption, text: and now, start: 0.3, duration: 0.1, size: 0.2}]
sequence:
  - {scene: tiny, end: 0.25, fade_in: 0.0834}
  - {scene: tiny, start: 0.125, dissolve: 0.0834}
"""


def test_weights_of_a_dissolve_add_up_to_one() -> None:
    def clip(at: int, rise: int, fall: int) -> ClipSource:
        source = FilmSource(tuple(range(1, 9)), Fraction(24), "png", False, "h264")
        return ClipSource("x", source, at, rise, fall)

    before, after = clip(0, 0, 3), clip(5, 3, 0)
    sums = [before.weight(5 + k) + after.weight(k) for k in range(3)]
    assert sums == pytest.approx([1.0, 1.0, 1.0])
    assert [after.weight(k) for k in range(3, 8)] == [1.0] * 5
    assert 0.0 < clip(0, 3, 0).weight(0) < clip(0, 3, 0).weight(1) < 1.0


def test_joined_sounds_meet_at_full_level(tmp_path: Path) -> None:
    one = np.full((4800, 2), FULL_SCALE // 2, np.int32)
    (tmp_path / "a.wav").write_bytes(wav_bytes(one))
    pieces = [
        SoundPiece(tmp_path / "a.wav", 0, 4800, 0, fall=480),
        SoundPiece(tmp_path / "a.wav", 1200, 3600, 4320, rise=480, fall=100),
    ]
    write_joined_sound(tmp_path / "b.wav", pieces, 7920)
    sound = read_samples(tmp_path / "b.wav", 0, 10_000)
    assert sound.shape == (7920, 2)
    assert sound[:7800] == pytest.approx(0.5, abs=1e-5)
    assert sound[-1, 0] < 0.01
    with wave.open(str(tmp_path / "b.wav")) as file:
        assert (file.getframerate(), file.getnframes()) == (48_000, 7920)


@pytest.mark.nightly
def test_a_sequence_renders_resumes_repairs_and_verifies(studio: Studio, pronk: Pronk) -> None:
    folder = studio.folder
    (folder / "two.yaml").write_text(SEQUENCE, encoding="utf-8")
    code, out, err = pronk("render", "two", cwd=folder)
    assert (code, out) == (0, "out/two\n"), err
    outputs = Outputs(folder / "out" / "two", "two")
    source = SequenceSource.of(load_sequence(folder / "two.yaml"), has_sound=True)
    assert source.n_frames == 9
    assert SequenceSource.read(json.loads(json.dumps(source.facts))) == source
    pictures = list(source.pictures(outputs))
    first, second = (outputs.folder / "clips" / name / "frames" for name in ("01_tiny", "02_tiny"))
    assert np.array_equal(pictures[2], read_png(first / "0003.png"))
    assert pictures[0].mean() < 0.5 * pictures[2].mean()
    blend = 2 / 3 * read_png(first / "0005.png") + 1 / 3 * read_png(second / "0004.png")
    assert pictures[4] == pytest.approx(blend, abs=0.51)
    assert not np.array_equal(pictures[-1], read_png(second / "0008.png"))  # words are over it

    film = outputs.film().read_bytes()
    code, _, err = pronk("render", "two", cwd=folder)
    assert "two.mp4 is up to date" in err
    code, out, err = pronk("verify", "two", cwd=folder)
    assert code == 0, err
    assert "two.mp4 as its frames and its sound" in out

    (second / "0006.png").unlink()
    code, out, err = pronk("verify", "two", cwd=folder)
    assert code == 1
    assert "clips/02_tiny/frames/0006.png: is missing" in err
    assert "pronk render two makes them again" in err
    assert pronk("render", "two", cwd=folder)[0] == 0
    assert pronk("verify", "two", cwd=folder)[0] == 0
    assert outputs.film().read_bytes() == film


def test_a_sequence_has_no_ranges_of_frames(studio: Studio, pronk: Pronk) -> None:
    (studio.folder / "two.yaml").write_text(SEQUENCE, encoding="utf-8")
    code, _, err = pronk("render", "two", "--frames", "1-3", cwd=studio.folder)
    assert code == 2
    assert "--frames: a sequence is rendered whole" in err
    assert pronk("check", "two", cwd=studio.folder)[0] == 0
    code, _, err = pronk("midi", "two", cwd=studio.folder)
    assert (code, "is a sequence of scenes" in err) == (3, True)
