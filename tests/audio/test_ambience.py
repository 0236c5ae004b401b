"""Ambience: every place sounds, at its loudness, without an onset, and the same again."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from audio.ambience import AMBIENCES, Ambience, ambient_sound
from audio.config.sound import AmbienceName
from audio.loudness_meter import integrated_loudness
from audio.wav_file import read_samples, write_wav
from pipeline.production.sound.ambience_choice import ambience_of
from pipeline.spec import read_scene

RATE = 48_000
LENGTH = 6 * RATE


@pytest.mark.parametrize("name", AMBIENCES)
def test_a_place_is_never_silent_and_has_no_onset(name: str) -> None:
    bed = ambient_sound(AMBIENCES[name], LENGTH, 3)
    assert bed.shape == (LENGTH, 2)
    assert -50.0 < integrated_loudness(bed) < -26.0
    level = 10 * np.log10((bed**2).mean(axis=1).reshape(-1, 2400).mean(axis=1) + 1e-12)
    assert np.mean(level[2:-2] > -62.0) > 0.7
    assert np.abs(bed).max() < 0.25
    # The sides are neither the same nor strangers.
    assert 0.2 < np.corrcoef(bed.T)[0, 1] < 0.95


def test_a_bed_is_the_same_again_and_another_by_its_seed() -> None:
    first, again, other = (ambient_sound(AMBIENCES["forest"], RATE, seed) for seed in (3, 3, 4))
    assert np.array_equal(first, again)
    assert np.abs(first - other).max() > 1e-4


def test_more_rain_is_louder() -> None:
    soft, hard = (ambient_sound(Ambience(rain=amount), LENGTH, 3) for amount in (0.25, 1.0))
    assert integrated_loudness(hard) - integrated_loudness(soft) == pytest.approx(12.0, abs=0.1)


def test_the_bed_follows_the_target_and_no_gain_raises_it(step, score_of, tmp_path: Path) -> None:
    def quiet_part(lufs: float) -> float:
        sound = {"master": {"lufs": lufs}}
        score = score_of([step(1, distance=40)], 240, sound=sound, ambience=AMBIENCES["room"])
        report = write_wav(score, tmp_path / "a.wav")
        return integrated_loudness(read_samples(report.path, 5 * RATE, 5 * RATE))

    assert quiet_part(-16.0) == pytest.approx(-47.0, abs=0.7)
    assert quiet_part(-24.0) == pytest.approx(-55.0, abs=0.7)


SCENE = "pronk: 1\nframes: 1\ncast: [{figure: beetle}]\n"


@pytest.mark.parametrize(
    ("words", "heard", "silent"),
    [
        ("terrain: {kind: flat, material: grass, surroundings: forest}", "birds leaves", "rain"),
        ("terrain: {kind: flat, material: wood, edging: room}", "room", "birds wind"),
        ("terrain: {preset: dunes}", "wind", "surf leaves"),
        ("terrain: {kind: flat, material: wood, surroundings: sea}", "surf", "stream"),
        ("light: {sun: {hour: 1}}", "crickets", "birds"),
        ("light: {sun: {hour: 14, clouds: overcast}, weather: rain}", "rain", "crickets"),
        ("light: {sun: {hour: 12}, weather: snow}", "wind", "birds crickets"),
        ("sound: {ambience: night}", "crickets", "surf"),
        ("light: {sun: {hour: 12}}", "wind", "fire"),
    ],
)
def test_a_scene_sounds_like_what_it_shows(words: str, heard: str, silent: str) -> None:
    found = ambience_of(read_scene(SCENE + words))
    assert found is not None
    assert set(heard.split()) <= found.layers.keys()
    assert not set(silent.split()) & found.layers.keys()


def test_a_fire_is_heard_and_smoke_is_not() -> None:
    def layers(material: str) -> set[str]:
        group = f"{{group: {{rule: fire}}, material: {material}}}"
        scene = read_scene(f"pronk: 1\nframes: 1\ncast: [{group}]\n")
        found = ambience_of(scene)
        assert found is not None
        return set(found.layers)

    assert "fire" in layers("flame")
    assert "fire" not in layers("smoke")


def test_every_ambience_has_a_word() -> None:
    assert set(get_args(AmbienceName)) == {*AMBIENCES, "auto", "none"}


def test_no_ambience_where_none_is_asked_for() -> None:
    assert ambience_of(read_scene(SCENE + "sound: {ambience: none}")) is None
    with pytest.raises(Exception, match=r"sound.ambience: .*forest"):
        read_scene(SCENE + "sound: {ambience: forrest}")
