"""Voices of people and creatures: pitch by size, and spectra by mood."""

from itertools import pairwise

import numpy as np
import pytest

from audio.cause_voices import CAUSE_VOICES, MotionVoice
from audio.synthesis import SoundParameters, synthesize
from audio.time_grid import SAMPLE_RATE

CALLS = ("call", "growl", "whine")


def voice(cause: str, size: float, variant: int = 1, speed: float = 1.5) -> np.ndarray:
    plain = (size, speed, 1.0, 0.0, 0.0, 0.0, variant)
    return synthesize(SoundParameters(cause, "skin", "", *plain), 3)


def spectrum(sound: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    size = 1 << 17
    return np.fft.rfftfreq(size, 1 / SAMPLE_RATE), np.abs(np.fft.rfft(sound, size)) ** 2


def centroid(sound: np.ndarray) -> float:
    frequency, power = spectrum(sound)
    return float((frequency * power).sum() / power.sum())


def noisiness(sound: np.ndarray) -> float:
    """Return the flatness of the spectrum from 100 Hz to 10 kHz: 1 for white noise."""
    frequency, power = spectrum(sound)
    band = power[(frequency > 100) & (frequency < 10_000)]
    return float(np.exp(np.mean(np.log(band + 1e-15))) / band.mean())


def pitch(sound: np.ndarray, low: float, high: float) -> float:
    """Return the pitch in the loudest 0.1 s, by autocorrelation [Hz]."""
    count = 4800
    start = int(np.convolve(sound**2, np.ones(count), "valid").argmax())
    part = sound[start : start + count] * np.hanning(count)
    alike = np.fft.irfft(np.abs(np.fft.rfft(part, 1 << 15)) ** 2)
    lags = np.arange(int(SAMPLE_RATE / high), int(SAMPLE_RATE / low))
    return float(SAMPLE_RATE / lags[np.argmax(alike[lags])])


@pytest.mark.parametrize("cause", ["call", "whine"])
def test_the_pitch_of_creatures_falls_with_their_mass(cause):
    # f = 1000 Hz M^-0.4, and a cube of water of s metres has 1000 s³ kg.
    sizes = np.array([0.05, 0.1, 0.2, 0.4])
    expected = 1000 * (1000 * sizes**3) ** -0.4 * {"call": 1.0, "whine": 1.5}[cause]
    found = [
        np.median([pitch(voice(cause, s, variant), f / 1.5, f * 1.5) for variant in range(5)])
        for s, f in zip(sizes, expected, strict=True)
    ]
    assert found == pytest.approx(expected, rel=0.2)
    slope = np.polyfit(np.log(sizes), np.log(found), 1)[0]
    assert slope == pytest.approx(-1.2, abs=0.1)


def test_laughs_and_cries_of_small_people_are_higher():
    for cause in ("laugh", "cry"):
        heights = (0.9, 1.2, 1.7)
        tones = [pitch(voice(cause, 0.1 * height), 150.0, 900.0) for height in heights]
        assert all(tall < small for small, tall in pairwise(tones))


def test_moods_differ_by_spectrum():
    # Morton 1977: hostile sounds are low and harsh, fearful ones high and pure.
    for size in (0.1, 0.2, 0.4):
        call, growl, whine = ([voice(cause, size, v) for v in range(6)] for cause in CALLS)
        harsh = [float(np.median([noisiness(s) for s in mood])) for mood in (growl, call, whine)]
        assert harsh[0] > 2 * harsh[2]
        assert harsh[1] > 2 * harsh[2]
        strongest = [
            float(np.median([np.argmax(spectrum(s)[1]) for s in mood])) for mood in (growl, whine)
        ]
        assert strongest[0] < 0.9 * strongest[1]
        low = [float(np.median([pitch(s, 20.0, 4000.0) for s in mood])) for mood in (call, whine)]
        assert low[1] > 1.2 * low[0]


def test_growls_are_rough():
    def roughness(sound: np.ndarray) -> float:
        """Return how much of the loudness changes 20 to 45 times a second."""
        window = np.hanning(576)
        loud = np.convolve(sound**2, window / window.sum(), "same")[::120]
        changes = np.abs(np.fft.rfft(loud / loud.mean(), 1 << 12)) ** 2
        rate = np.fft.rfftfreq(1 << 12, 120 / SAMPLE_RATE)
        return float(changes[(rate > 20) & (rate < 45)].sum() / changes[0])

    call, growl = (np.median([roughness(voice(c, 0.2, v)) for v in range(6)]) for c in CALLS[:2])
    assert growl > 5 * call


def test_a_laugh_is_a_row_of_notes_that_fade():
    fading = []
    for variant in range(8):
        sound = voice("laugh", 0.12, variant)
        level = np.sqrt(np.convolve(sound**2, np.ones(960) / 960, "same"))[::96]
        top = level.max()
        peaks = [
            k
            for k in range(10, len(level) - 10)
            if level[k] == level[k - 10 : k + 11].max() and level[k] > 0.15 * top
        ]
        assert 3 <= len(peaks) <= 8
        fading.append(level[peaks[-1]] / level[peaks[0]])
    assert np.median(fading) < 0.7


def test_a_gasp_is_breath_more_than_voice():
    assert noisiness(voice("gasp", 0.12)) > 4 * noisiness(voice("laugh", 0.12))
    # A louder fright has more voice.
    calm, panic = (noisiness(voice("gasp", 0.12, speed=speed)) for speed in (0.5, 5.0))
    assert panic < calm


def test_voices_have_no_offset_and_end_in_silence():
    for cause, kind in CAUSE_VOICES.items():
        if isinstance(kind, MotionVoice) and kind.synthesize.__module__ == "audio.vocal_tract":
            sound = voice(cause, 0.15)
            assert abs(sound.mean()) < 2e-3
            assert np.abs(sound[-10:]).max() < 0.01
            assert len(sound) == int(kind.seconds * SAMPLE_RATE)
            assert centroid(sound) < 6000
