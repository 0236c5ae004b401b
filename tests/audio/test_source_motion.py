"""Source motion: Doppler shift, distance, direction and speed of sustained sounds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from audio.dsp import pan_gains, resample
from audio.score import Bearing
from audio.source_motion import SPEED_OF_SOUND, moving_gains, speed_profile
from audio.wav_file import write_wav

RATE = 48_000


def pass_by(speed, aside=2.0, reach=10.0, count=65):
    """Return a course past the listener from left to right, and its duration [s]."""
    x = np.linspace(-reach, reach, count)
    d = np.hypot(x, aside)
    bearings = [
        Bearing(float(r), float(np.arctan2(at, aside)), float(-speed * at / r))
        for at, r in zip(x, d, strict=True)
    ]
    return tuple(bearings), 2 * reach / speed


@pytest.fixture
def render_event(step, render):
    """Return a function that renders one event of three seconds: (N, 2)."""
    return lambda **fields: render([step(1, **fields)], 72)


def strongest(sound, first, last):
    """Return the strongest frequency between two times [Hz]."""
    part = sound[int(first * RATE) : int(last * RATE)].sum(axis=1)
    spectrum = np.abs(np.fft.rfft(part * np.hanning(part.size), 4 * RATE))
    return float(spectrum.argmax() / 4)


def centroid(sound, first, last):
    power = np.abs(np.fft.rfft(sound[int(first * RATE) : int(last * RATE)].sum(axis=1))) ** 2
    f = np.fft.rfftfreq(int(last * RATE) - int(first * RATE), 1 / RATE)
    return float((f * power).sum() / power.sum())


@pytest.mark.parametrize("speed", [10.0, 20.0, 40.0])
def test_a_passing_whistle_falls_by_the_doppler_ratio(render_event, speed):
    course, seconds = pass_by(speed)
    sound = render_event(
        cause="whistle", strength=speed, duration=seconds, distance=2.0, size=0.1,
        speeds=(speed,) * len(course), course=course,
    )  # fmt: skip
    coming = strongest(sound, 0.02 * seconds, 0.2 * seconds)
    going = strongest(sound, 0.8 * seconds, 0.98 * seconds)
    v = speed * 8 / np.hypot(8, 2)
    # The tone itself drifts by two per cent.
    assert coming / going == pytest.approx((SPEED_OF_SOUND + v) / (SPEED_OF_SOUND - v), rel=0.04)


def test_a_passing_sound_moves_from_left_to_right_and_is_loudest_near(render_event):
    course, seconds = pass_by(20.0)
    sound = render_event(
        cause="swoosh", strength=20.0, duration=seconds, distance=2.0,
        speeds=(20.0,) * len(course), course=course,
    )  # fmt: skip
    third = int(seconds * RATE / 5)
    power = np.array([(sound[i * third : (i + 1) * third] ** 2).sum(axis=0) for i in range(5)])
    assert power[0, 0] > 5 * power[0, 1]
    assert power[4, 1] > 5 * power[4, 0]
    whole = power.sum(axis=1)
    assert whole.argmax() == 2
    assert whole[2] > 5 * max(whole[0], whole[4])


def test_moving_gains_are_inverse_to_distance_and_keep_power():
    course, seconds = pass_by(20.0)
    left, right = moving_gains(course, 2.0, seconds, int(seconds * RATE))
    at = np.linspace(0, left.size - 1, len(course)).astype(int)
    distance = np.array([bearing.distance for bearing in course])
    assert np.hypot(left, right)[at] == pytest.approx(2.0 / distance, rel=0.01)
    left, right = moving_gains(course, 2.0, seconds, 1000, pan=1.0)
    assert np.abs(left).max() < 1e-12
    assert (right > 0).all()


@pytest.mark.parametrize("cause", ["roll", "slide", "scuff", "swoosh", "squeak", "squawk"])
def test_a_slowing_source_gets_softer_and_lower(render_event, cause):
    speeds = tuple(np.linspace(1.0, 0.1, 33))
    sound = render_event(
        cause=cause, strength=10.0 if cause == "swoosh" else 1.0, duration=2.0, speeds=speeds,
        material="wood", surface="gravel", size=0.3,
    )  # fmt: skip
    loud = [
        np.sqrt((sound[int(a * RATE) : int(b * RATE)] ** 2).mean())
        for a, b in ((0.1, 0.5), (1.5, 1.9))
    ]
    assert loud[0] > 1.5 * loud[1]
    # A squeak keeps its modes; its slip rate has tests of its own.
    if cause not in ("squeak", "squawk"):
        assert centroid(sound, 0.1, 0.5) > 1.1 * centroid(sound, 1.5, 1.9)


def test_resampling_at_half_rate_halves_the_spectrum():
    rng = np.random.default_rng(0)
    profile = np.convolve(rng.standard_normal(96_000), np.hanning(24), "same")
    whole = np.stack([resample(profile, np.full(48_000, pace)) for pace in (1.0, 0.5)])
    spread = [centroid(np.stack([w, w], axis=1), 0, 1) for w in whole]
    assert spread[1] == pytest.approx(spread[0] / 2, rel=0.05)


@pytest.mark.parametrize("cause", ["roll", "slide", "swoosh", "whistle", "squeak", "squawk"])
@pytest.mark.parametrize("speeds", [(), (0.0, 1.0), (1.0, 0.0), (0.0, 0.0), (1.0, 0.0, 1.0)])
def test_every_course_starts_on_its_sample_and_ends_in_time(
    step, score_of, read_wav, tmp_path, cause, speeds
):
    course = tuple(Bearing(3.0 + i, 0.5 * i, 400.0 * (1 - i)) for i in range(len(speeds)))
    event = step(
        3, cause=cause, strength=max(speeds, default=0.0) or 1.0, duration=0.4, speeds=speeds,
        course=course, distance=3.0,
    )  # fmt: skip
    write_wav(score_of([event], 24, sound={"room": "dry"}), tmp_path / "e.wav")
    sound = read_wav(tmp_path / "e.wav")
    assert not sound[:4000].any()
    assert sound[4000].any()
    assert not sound[4000 + 19_201 :].any()


def test_a_speed_profile_interpolates_and_holds_the_last_speed():
    drive = speed_profile(RATE, 0.5, (1.0, 4.0, 2.0), ())
    assert drive.relative_speed[[0, 12_000, 24_000, 47_999]] == pytest.approx([0.25, 1.0, 0.5, 0.5])
    assert (drive.doppler == 1).all()
    near = speed_profile(RATE, 1.0, (), (SPEED_OF_SOUND / 2, SPEED_OF_SOUND / 2))
    assert near.doppler == pytest.approx(2.0)
    assert near.is_steady


def test_resampling_at_rate_one_is_the_identity_and_at_half_interpolates():
    profile = np.random.default_rng(1).standard_normal(500)
    assert np.array_equal(resample(profile, np.ones(500)), profile)
    t = np.arange(2000)
    curve = np.sin(2 * np.pi * t / 97)
    half = resample(curve, np.full(1900, 0.5))
    # At its first sample the input wraps around.
    assert half[2:] == pytest.approx(np.sin(np.pi * t[2:1900] / 97), abs=2e-3)


@given(st.floats(-1, 1))
def test_pan_gains_keep_power(pan):
    left, right = pan_gains(pan)
    assert left**2 + right**2 == pytest.approx(1)
    assert (right > left) == (pan > 1e-16) or abs(pan) < 1e-15


def test_a_full_pan_silences_the_other_side():
    assert pan_gains(-1)[1] == 0
    assert pan_gains(1)[0] == 0
