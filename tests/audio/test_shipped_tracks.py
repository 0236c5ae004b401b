"""Tracks of all shipped scenes: onsets on their samples, peak ceiling, loudness."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyloudnorm
import pytest
from scipy.signal import resample_poly

from audio.notes import notes_of
from audio.time_grid import sample_at
from audio.wav_file import write_wav
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.sound.score_builder import build_score
from pipeline.simulation.simulate import simulate
from pipeline.spec import load_scene
from pipeline.spec.scene_library import SUFFIX, library, shipped_scenes

SLOW = {"squeaky_robot": pytest.mark.slow, "pass_by": pytest.mark.slow, "toy": pytest.mark.slow}
SCENES = [
    pytest.param(name, marks=() if name == "first_steps" else SLOW.get(name, pytest.mark.nightly))
    for name in shipped_scenes()
]


@pytest.mark.nightly
@pytest.mark.parametrize("name", SCENES)
def test_tracks_of_shipped_scenes_have_their_onsets_and_loudness(
    name: str, read_wav: Any, tmp_path: Path
) -> None:
    scene = load_scene(library() / (name + SUFFIX))
    take = simulate(scene)
    score, _ = build_score(scene, take, ShotBuilder(scene, take).poses)
    with_bed = write_wav(score, tmp_path / "track.wav")
    sound = read_wav(tmp_path / "track.wav")
    # Nowhere silent, and the events stand out of it.
    level = np.sqrt((sound[: len(sound) // 2400 * 2400] ** 2).reshape(-1, 4800).mean(axis=1))
    assert np.mean(level > 10 ** (-60 / 20)) > 0.7
    score = replace(score, ambience=None)
    report = write_wav(score, tmp_path / "track.wav")
    # The bed neither drowns the events nor lowers them by much.
    assert with_bed.lufs < max(report.lufs + 3, -20)
    assert with_bed.gain_db > report.gain_db - 2
    sound = read_wav(tmp_path / "track.wav")
    magnitude = np.abs(sound).max(axis=1)
    onsets = sorted({sample_at(note.onset) for note in notes_of(score)})
    assert not magnitude[: min(onsets, default=len(sound))].any()
    assert magnitude[onsets].all()
    if not onsets:
        return
    master = scene.sound.master
    assert master is not None
    # Independent meters: eight times oversampled, and another library's loudness.
    assert np.abs(resample_poly(sound, 8, 1, axis=0)).max() < 10 ** (master.true_peak_db / 20)
    loudness = pyloudnorm.Meter(48_000).integrated_loudness(sound)
    assert loudness == pytest.approx(report.lufs, abs=0.3)
    assert report.lufs == pytest.approx(report.target, abs=0.3)
    assert with_bed.lufs == pytest.approx(with_bed.target, abs=0.3)
    assert report.target <= master.lufs
    assert report.limited_db <= master.most_limiting_db + 0.05
