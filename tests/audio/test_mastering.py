"""The master: as loud as asked where that is sensible, its peaks below the ceiling."""

import numpy as np
import pytest

from audio.config.sound import Master
from audio.loudness_meter import integrated_loudness, true_peak
from audio.mastering import FULL_SCALE, master_mix
from audio.wav_file import write_wav


def walk(level, steps=12, decay=3000):
    """Return steps in noise that dies away, of some peak level [dB]."""
    rng = np.random.default_rng(4)
    one = rng.standard_normal((24_000, 2)) * np.exp(-np.arange(24_000) / decay)[:, None]
    mix = np.tile(one, (steps, 1))
    return mix * 10 ** (level / 20) / np.abs(mix).max()


@pytest.mark.slow
@pytest.mark.parametrize("level", [-36, -20, 0, 20, 60])
@pytest.mark.parametrize("lufs", [-16.0, -23.0])
@pytest.mark.parametrize("decay", [300, 3000, 20_000])
def test_a_walk_is_as_loud_as_asked_whatever_it_was(level, lufs, decay):
    words = Master(lufs=lufs)
    done = master_mix(walk(level, decay=decay), words)
    assert done.true_peak_db < -1
    written = done.samples / FULL_SCALE
    assert done.true_peak_db == pytest.approx(20 * np.log10(true_peak(written)), abs=1e-9)
    assert done.lufs == pytest.approx(integrated_loudness(written), abs=1e-9)
    assert done.limited_db <= words.most_limiting_db + 1e-9
    if done.gain_db < words.most_gain_db and done.limited_db < words.most_limiting_db - 0.1:
        assert done.lufs == pytest.approx(lufs, abs=0.2)


def test_what_is_nearly_silent_is_raised_by_no_more_than_allowed():
    mix = walk(-45)
    done = master_mix(mix, Master(most_gain_db=20))
    assert done.gain_db == 20
    assert done.lufs == pytest.approx(integrated_loudness(mix) + 20, abs=0.1)


def test_soft_and_loud_keep_their_relation_where_nothing_is_lowered():
    mix = walk(-30, decay=20_000)
    mix[: len(mix) // 2] *= 0.1
    done = master_mix(mix, Master(lufs=-30))
    assert done.limited_db == 0
    ratio = done.samples / FULL_SCALE / np.where(mix == 0, 1, mix)
    big = np.abs(mix) > 1e-3
    assert np.allclose(ratio[big], 10 ** (done.gain_db / 20), rtol=1e-3)


def test_what_is_louder_stays_louder():
    mix = walk(0, steps=2)
    mix[24_000:] *= 0.25
    done = master_mix(mix, Master())
    loud, soft = (np.abs(done.samples[at : at + 24_000]).max() for at in (0, 24_000))
    assert done.limited_db > 0
    assert soft < loud


@pytest.mark.parametrize("level", [-30, 0, 30])
def test_off_leaves_the_loudness_and_keeps_the_ceiling(level):
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
def test_a_film_of_any_length_is_mastered_with_its_onset_on_its_sample(
    step, score_of, read_wav, tmp_path, frames
):
    report = write_wav(score_of([step(frames)], frames), tmp_path / "a.wav")
    sound = read_wav(tmp_path / "a.wav")
    assert not sound[: 2000 * (frames - 1)].any()
    assert np.abs(sound[2000 * (frames - 1)]).min() > 1e-4
    assert np.isfinite(report.lufs)
    assert report.true_peak_db < -1
    assert report.gain_db <= Master().most_gain_db


def test_the_volume_shifts_what_is_aimed_at(step, score_of, tmp_path):
    def loudness(volume):
        happened = [step(1 + 4 * i) for i in range(12)]
        words = {"volume_db": volume, "master": {"lufs": -24}}
        return write_wav(score_of(happened, 48, sound=words), tmp_path / "v.wav").lufs

    assert loudness(0) == pytest.approx(-24, abs=0.1)
    assert loudness(-6) == pytest.approx(-30, abs=0.1)
    assert loudness(3) == pytest.approx(-21, abs=0.1)


@pytest.mark.parametrize(
    ("words", "gain"), [("off", 0.0), (False, 0.0), ({"most_gain_db": 0}, 0.0)]
)
def test_the_master_may_be_off(step, score_of, tmp_path, words, gain):
    score = score_of([step(1, distance=20)], sound={"master": words})
    assert write_wav(score, tmp_path / "o.wav").gain_db == gain
