"""Wing beats: birds flap and insects hum at the rate of their wings; cloth follows its speed."""

from __future__ import annotations

import numpy as np
import pytest

from audio.cause_voices import CAUSE_VOICES
from audio.synthesis import SoundParameters, synthesize

RATE = 48_000


def sound(cause: str, size: float, speed: float = 4.0, **more: object) -> np.ndarray:
    values = {"distance": 2.0, "pitch": 0.0, "decay": 0.0, "duration": 4.0, "variant": 3, **more}
    return synthesize(SoundParameters(cause, "", "", size, speed, **values), 1)


@pytest.mark.parametrize(("length", "beats"), [(0.25, 6.2), (0.1, 17.7)])
def test_a_bird_flaps_as_often_as_its_wings_allow(length: float, beats: float) -> None:
    level = np.abs(sound("wings", length)).reshape(-1, 240).mean(axis=1)
    spectrum = np.abs(np.fft.rfft(level - level.mean(), 1 << 13))
    frequency = np.fft.rfftfreq(1 << 13, 240 / RATE)
    band = (frequency > 3.0) & (frequency < 60.0)
    found = frequency[band][spectrum[band].argmax()]
    assert found == pytest.approx(beats, rel=0.15)


@pytest.mark.parametrize(("length", "beats"), [(0.01, 250.7), (0.005, 556.0)])
def test_an_insect_hums_at_the_rate_of_its_wings(length: float, beats: float) -> None:
    assert CAUSE_VOICES["wings"].pitch_of(length) == pytest.approx(beats, rel=0.01)
    hum = sound("wings", length)
    spectrum = np.abs(np.fft.rfft(hum))
    frequency = np.fft.rfftfreq(hum.size, 1 / RATE)
    assert frequency[spectrum.argmax()] == pytest.approx(beats, rel=0.15)
    # A tone, not a noise.
    near = np.abs(frequency[:, None] / beats - np.arange(1, 13)).min(axis=1) < 0.2
    assert (spectrum[near] ** 2).sum() > 0.3 * (spectrum**2).sum()


def test_cloth_is_louder_and_brighter_the_faster_it_moves() -> None:
    speeds = tuple(np.linspace(0.5, 2.0, 33).tolist())
    rustle = sound("rustle", 1.0, 2.0, speeds=speeds, full_duration=4.0)
    slow, fast = rustle[RATE // 4 : RATE], rustle[3 * RATE : 3 * RATE + RATE // 2]
    assert np.sqrt(np.mean(fast**2)) > 2 * np.sqrt(np.mean(slow**2))

    def centroid(part: np.ndarray) -> float:
        power = np.abs(np.fft.rfft(part)) ** 2
        return float((power * np.fft.rfftfreq(part.size, 1 / RATE)).sum() / power.sum())

    assert centroid(fast) > 1.2 * centroid(slow)
