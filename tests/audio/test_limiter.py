"""The limiter: nothing passes its ceiling, between samples neither; nothing quiet is touched."""

import numpy as np
import pytest

from audio.loudness_meter import true_peak
from audio.mastering import limit

CEILING = 10 ** (-1.1 / 20)


@pytest.mark.parametrize("loudness", [0.5, 0.8, 1.5, 5.0, 1e6, 1e200])
@pytest.mark.parametrize("kind", ["noise", "tone", "clicks"])
def test_no_mix_passes_the_ceiling(loudness, kind):
    rng = np.random.default_rng(1)
    t = np.arange(20_000)[:, None]
    mix = {
        "noise": rng.uniform(-1, 1, (20_000, 2)) * np.exp(-t / 3000),
        # Its samples reach 0.71 of what lies between them.
        "tone": 1.2 * np.sin(np.pi * t / 2 + np.pi / 4) * [1.0, 0.3],
        "clicks": (rng.random((20_000, 2)) < 1e-3) * rng.uniform(-1, 1, (20_000, 2)),
    }[kind] * loudness
    out, lowered = limit(mix, CEILING)
    assert true_peak(out) < 10 ** (-1 / 20)
    assert np.abs(out).max() <= CEILING * (1 + 1e-12)
    assert np.array_equal(np.sign(out), np.sign(mix))
    assert (lowered > 0) == (true_peak(mix) > CEILING)


def test_a_single_spike_is_caught():
    mix = np.zeros((99_999, 2))
    mix[[0, 47, 48, 50_000, 99_998], [0, 1, 0, 1, 0]] = [3, -40, 2, -1.1, 700]
    out, _ = limit(mix, CEILING)
    assert true_peak(out) < 10 ** (-1 / 20)
    assert np.abs(out[50_000, 1]) > 0.6


def test_what_is_far_from_a_crash_is_left_as_it_is():
    mix = np.full((48_000, 2), 0.1)
    mix[24_000:24_100] = 8.0
    out, lowered = limit(mix, CEILING)
    assert lowered == pytest.approx(20 * np.log10(true_peak(mix) / CEILING), abs=0.01)
    assert np.array_equal(out[:23_000], mix[:23_000])
    # A hold of 4 ms, then 300 dB a second.
    back = 24_100 + int(48_000 * (0.012 + lowered / 300))
    assert np.array_equal(out[back:], mix[back:])
    assert (out[24_200] < 0.05).all()


def test_the_gain_of_both_sides_is_one_and_bends_no_wave():
    rng = np.random.default_rng(3)
    mix = rng.uniform(-2, 2, (30_000, 2))
    out, _ = limit(mix, CEILING)
    gain = out / mix
    assert np.allclose(gain[:, 0], gain[:, 1], rtol=1e-12)
    assert np.abs(np.diff(gain[:, 0])).max() < 1 / 200


def test_a_mix_below_the_ceiling_is_not_touched():
    mix = np.random.default_rng(2).uniform(-0.4, 0.4, (5000, 2))
    out, lowered = limit(mix, CEILING)
    assert out is mix
    assert lowered == 0
