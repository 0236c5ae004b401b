"""Loudness and true peak against closed forms and standard test signals."""

import numpy as np
import pytest

from audio.loudness_meter import integrated_loudness, true_peak, true_peaks

RATE = 48_000


def sine(hertz, seconds, amplitude=1.0, phase=0.3):
    t = np.arange(int(seconds * RATE)) / RATE
    return amplitude * np.sin(2 * np.pi * hertz * t + phase)[:, None] * np.ones(2)


@pytest.mark.parametrize("level", [-18.0, -23.0, -33.0])
def test_the_loudness_of_a_1_khz_stereo_tone_is_its_level(level):
    # Source: EBU Tech 3341, test signals 1 and 2.
    assert integrated_loudness(sine(1000, 20, 10 ** (level / 20))) == pytest.approx(level, abs=0.1)


@pytest.mark.slow
def test_silence_has_no_loudness_and_pauses_are_gated():
    assert integrated_loudness(np.zeros((RATE, 2))) == -np.inf
    assert integrated_loudness(np.zeros((1, 2))) == -np.inf
    tone = sine(1000, 10, 0.1)
    paused = np.concatenate((tone, np.zeros((RATE * 30, 2))))
    assert integrated_loudness(paused) == pytest.approx(integrated_loudness(tone), abs=0.15)


def test_very_short_tracks_and_clicks_at_the_end_have_a_loudness():
    for samples, at in ((400, 10), (2 * RATE + 3000, 2 * RATE + 2900)):
        click = np.zeros((samples, 2))
        click[at : at + 60] = 0.5
        assert -60 < integrated_loudness(click) < -20


def test_twice_the_amplitude_is_six_decibels():
    heard = sine(500, 3, 0.1)
    assert integrated_loudness(2 * heard) - integrated_loudness(heard) == pytest.approx(
        6.02, abs=0.01
    )


@pytest.mark.parametrize("hertz", [997, 6000, 12_000, 17_000, 20_000])
@pytest.mark.parametrize("phase", [0.0, np.pi / 4, 1.0])
def test_the_true_peak_of_a_tone_is_its_amplitude(hertz, phase):
    tone = sine(hertz, 0.5, 0.5, phase) * np.hanning(RATE // 2)[:, None]
    # Four times oversampled, 20 kHz is sampled a tenth of a cycle from its top at the worst.
    worst = np.cos(np.pi * hertz / (4 * RATE))
    assert 0.5 * worst - 1e-3 < true_peak(tone) < 0.5005


def test_the_true_peak_exceeds_the_samples():
    tone = sine(12_000, 0.1, 1.0, np.pi / 4) * np.hanning(RATE // 10)[:, None]
    assert np.abs(tone).max() == pytest.approx(np.sqrt(0.5), abs=1e-3)
    assert true_peak(tone) == pytest.approx(1.0, abs=2e-3)


def test_the_true_peak_bounds_the_samples_and_scales():
    heard = np.random.default_rng(0).standard_normal((RATE, 2)) * 0.1
    assert (true_peaks(heard, 0.0) >= np.abs(heard).max(axis=1)).all()
    assert true_peak(heard) == true_peaks(heard, 0.0).max()
    assert true_peak(3 * heard) == pytest.approx(3 * true_peak(heard))
    assert true_peak(np.zeros((9, 2))) == 0
