"""Mastering: the target loudness if feasible, and peaks below the ceiling."""

import numpy as np
import pytest

from audio.config.sound import Master
from audio.loudness_meter import integrated_loudness, true_peak
from audio.mastering import FULL_SCALE, limiting_gain, master_mix
from audio.wav_file import write_wav


def walk(level, steps=12, decay=3000):
    """Return steps of decaying noise at a peak level [dB]."""
    rng = np.random.default_rng(4)
    one = rng.standard_normal((24_000, 2)) * np.exp(-np.arange(24_000) / decay)[:, None]
    mix = np.tile(one, (steps, 1))
    return mix * 10 ** (level / 20) / np.abs(mix).max()


@pytest.mark.sample(6)
@pytest.mark.slow
@pytest.mark.parametrize("level", [-36, -20, 0, 20, 60])
@pytest.mark.parametrize("lufs", [-16.0, -23.0])
@pytest.mark.parametrize("decay", [300, 3000, 20_000])
def test_a_walk_of_any_level_reaches_the_target_loudness(level, lufs, decay):
    config = Master(lufs=lufs)
    done = master_mix(walk(level, decay=decay), config)
    assert done.true_peak_db < -1
    written = done.samples / FULL_SCALE
    assert done.true_peak_db == pytest.approx(20 * np.log10(true_peak(written)), abs=1e-9)
    assert done.lufs == pytest.approx(integrated_loudness(written), abs=1e-6)
    # Every step is an attack: none is limited by much, and the target falls.
    assert done.limited_db <= 1.0
    assert done.lufs == pytest.approx(done.target, abs=0.3)
    assert done.target <= lufs
    if done.gain_db < config.most_gain_db and done.limited_db < 0.5:
        assert done.target == pytest.approx(lufs, abs=0.1)


def test_a_nearly_silent_mix_gets_at_most_the_greatest_gain():
    mix = walk(-45)
    done = master_mix(mix, Master(most_gain_db=20))
    assert done.gain_db == 20
    assert done.lufs == pytest.approx(integrated_loudness(mix) + 20, abs=0.1)


def test_without_limiting_the_balance_of_soft_and_loud_stays():
    mix = walk(-30, decay=20_000)
    mix[: len(mix) // 2] *= 0.1
    done = master_mix(mix, Master(lufs=-30))
    assert done.limited_db == 0
    ratio = done.samples / FULL_SCALE / np.where(mix == 0, 1, mix)
    big = np.abs(mix) > 1e-3
    assert np.allclose(ratio[big], 10 ** (done.gain_db / 20), rtol=1e-3)


def test_blows_keep_what_sets_them_apart():
    """A drummer's blows differ after the master by what they differed before, within 1 dB."""
    levels = np.random.default_rng(7).uniform(-6.6, 0.0, 40)
    one = walk(0, steps=1, decay=900)
    mix = np.concatenate([one * 10 ** (level / 20) for level in levels])
    done = master_mix(mix, Master())
    peaks = np.abs(done.samples).reshape(40, -1).max(axis=1)
    after = 20 * np.log10(peaks / peaks[0])
    assert np.abs(after - (levels - levels[0])).max() < 1.0
    assert 0 < done.limited_db < 1.0


def test_one_rare_peak_is_lowered_by_6_db_at_most():
    mix = walk(-12, steps=60)
    mix[24_000 * 20 : 24_000 * 21] *= 8.0
    done = master_mix(mix, Master())
    assert 4.0 < done.limited_db <= 6.0
    assert done.curve is not None
    assert 20 * np.log10(done.curve.min()) > -6.5
    assert (done.curve[: 24_000 * 19] > 0.9).all()


@pytest.mark.parametrize("level", [-30, 0, 30])
def test_master_off_keeps_the_level_and_the_ceiling(level):
    mix = walk(level)
    done = master_mix(mix, None)
    assert done.gain_db == 0
    assert done.true_peak_db < -1
    if level < -1.2:
        assert np.array_equal(done.samples, np.rint(mix * FULL_SCALE))


def test_silence_stays_silence():
    done = master_mix(np.zeros((5000, 2)), Master())
    assert not done.samples.any()
    assert (done.lufs, done.true_peak_db, done.gain_db) == (-np.inf, -np.inf, 0.0)


@pytest.mark.parametrize("frames", [1, 2, 5, 9, 10, 240])
def test_a_film_of_any_length_keeps_its_onset_on_its_sample(
    step, score_of, read_wav, tmp_path, frames
):
    report = write_wav(score_of([step(frames)], frames), tmp_path / "a.wav")
    sound = read_wav(tmp_path / "a.wav")
    assert not sound[: 2000 * (frames - 1)].any()
    assert np.abs(sound[2000 * (frames - 1)]).min() > 1e-4
    assert np.isfinite(report.lufs)
    assert report.true_peak_db < -1
    assert report.gain_db <= Master().most_gain_db


def test_the_volume_shifts_the_target(step, score_of, tmp_path):
    def loudness(volume):
        happened = [step(1 + 4 * i) for i in range(12)]
        config = {"volume_db": volume, "master": {"lufs": -24}}
        return write_wav(score_of(happened, 48, sound=config), tmp_path / "v.wav").lufs

    assert loudness(0) == pytest.approx(-24, abs=0.1)
    assert loudness(-6) == pytest.approx(-30, abs=0.1)
    assert loudness(3) == pytest.approx(-21, abs=0.1)


@pytest.mark.parametrize(
    ("config", "gain"), [("off", 0.0), (False, 0.0), ({"most_gain_db": 0}, 0.0)]
)
def test_the_configuration_turns_the_master_off(step, score_of, tmp_path, config, gain):
    score = score_of([step(1, distance=20)], sound={"master": config})
    assert write_wav(score, tmp_path / "o.wav").gain_db == gain


# --- limiter ---

CEILING = 10 ** (-1.1 / 20)


def limit(mix, ceiling):
    """Return a limited mix, and the greatest reduction [dB]."""
    gain = limiting_gain(mix, ceiling)
    return (mix, 0.0) if gain is None else (mix * gain[:, None], -20 * np.log10(gain.min()))


@pytest.mark.parametrize("loudness", [0.5, 0.8, 1.5, 5.0, 1e6, 1e200])
@pytest.mark.parametrize("kind", ["noise", "tone", "clicks"])
def test_no_mix_exceeds_the_ceiling(loudness, kind):
    rng = np.random.default_rng(1)
    t = np.arange(20_000)[:, None]
    mix = {
        "noise": rng.uniform(-1, 1, (20_000, 2)) * np.exp(-t / 3000),
        # Its samples reach 0.71 of the peak between them.
        "tone": 1.2 * np.sin(np.pi * t / 2 + np.pi / 4) * [1.0, 0.3],
        "clicks": (rng.random((20_000, 2)) < 1e-3) * rng.uniform(-1, 1, (20_000, 2)),
    }[kind] * loudness
    out, lowered = limit(mix, CEILING)
    assert true_peak(out) < 10 ** (-1 / 20)
    assert np.abs(out).max() <= CEILING * (1 + 1e-12)
    assert np.array_equal(np.sign(out), np.sign(mix))
    assert (lowered > 0) == (true_peak(mix) > CEILING)


def test_single_spikes_are_limited():
    mix = np.zeros((99_999, 2))
    mix[[0, 47, 48, 50_000, 99_998], [0, 1, 0, 1, 0]] = [3, -40, 2, -1.1, 700]
    out, _ = limit(mix, CEILING)
    assert true_peak(out) < 10 ** (-1 / 20)
    assert np.abs(out[50_000, 1]) > 0.6


def test_parts_far_from_a_peak_are_unchanged():
    mix = np.full((48_000, 2), 0.1)
    mix[24_000:24_100] = 8.0
    out, lowered = limit(mix, CEILING)
    assert lowered == pytest.approx(20 * np.log10(true_peak(mix) / CEILING), abs=0.01)
    assert np.array_equal(out[:23_000], mix[:23_000])
    # A hold of 4 ms, then 300 dB a second.
    back = 24_100 + int(48_000 * (0.012 + lowered / 300))
    assert np.array_equal(out[back:], mix[back:])
    assert (out[24_200] < 0.05).all()


def test_both_sides_share_one_smooth_gain():
    rng = np.random.default_rng(3)
    mix = rng.uniform(-2, 2, (30_000, 2))
    out, _ = limit(mix, CEILING)
    gain = out / mix
    assert np.allclose(gain[:, 0], gain[:, 1], rtol=1e-12)
    assert np.abs(np.diff(gain[:, 0])).max() < 1 / 200


def test_a_mix_below_the_ceiling_is_unchanged():
    mix = np.random.default_rng(2).uniform(-0.4, 0.4, (5000, 2))
    out, lowered = limit(mix, CEILING)
    assert out is mix
    assert lowered == 0
