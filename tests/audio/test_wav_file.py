"""The WAV file: onsets on their samples, length, ceiling, direction and reproducibility."""

import hashlib
import os
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from audio.errors import ScoreError, SoundFileError
from audio.time_grid import sample_of_frame
from audio.wav_file import write_wav

RATES = [10, 12, 15, 16, 18, 24, 25, 30, 48, 50, 60, 72, 90, 100, 120, 144, 240]
RATES = [Fraction(r) for r in RATES] + [Fraction(r * 1000, 1001) for r in (24, 30, 60)]
CEILING = 10 ** (-1 / 20)


def db(level):
    return 20 * np.log10(level)


@pytest.mark.sample(5)
@pytest.mark.parametrize("rate", RATES, ids=str)
def test_an_impact_starts_on_the_sample_of_its_frame(step, render, rate):
    frames = 2 * int(rate) + 3
    for frame in (2, int(rate) + 2, frames):
        sound = render([step(frame)], frames, rate)
        at = sample_of_frame(frame, rate)
        assert len(sound) == sample_of_frame(frames + 1, rate)
        assert not sound[:at].any()
        assert np.abs(sound[at]).min() > 1e-4
        # Within a millisecond it reaches a third of its peak.
        assert np.abs(sound[at : at + 48]).max() > np.abs(sound).max() / 3


@pytest.mark.parametrize("rate", RATES, ids=str)
def test_a_subframe_impact_starts_on_the_sample_of_its_cause(step, render, rate):
    time = Fraction(19, 7) / rate
    sound = render([step(4, time=time)], 2 * int(rate) + 3, rate, subframe=True)
    at = int(time * 48_000 + Fraction(1, 2))
    assert not sound[:at].any()
    assert np.abs(sound[at]).min() > 1e-4


def test_no_events_give_silence_of_exact_length(score_of, read_wav, tmp_path):
    report = write_wav(score_of(frames=100, rate=Fraction(30000, 1001)), tmp_path / "a.wav")
    sound = read_wav(tmp_path / "a.wav")
    assert len(sound) == report.samples == 160_160
    assert not sound.any()
    assert (report.peak_db, report.rms_db, report.events) == (-np.inf, -np.inf, 0)


def test_between_events_there_is_silence(step, render):
    sound = render([step(1), step(49)], 72, 24)
    assert not sound[60_000:96_000].any()
    assert sound[96_000:].any()


@pytest.mark.slow
def test_a_crash_of_thousands_stays_below_the_ceiling_and_keeps_its_onset(
    step, score_of, read_wav, tmp_path
):
    crash = [
        step(3 + i % 4, who=f"brick {i}", strength=3 + i % 7, size=0.1 * (1 + i % 3), distance=1)
        for i in range(3000)
    ]
    score = score_of([step(1), *crash], 48, sound={"room": "dry", "master": "off"})
    report = write_wav(score, tmp_path / "crash.wav")
    sound = read_wav(tmp_path / "crash.wav")
    assert np.abs(sound).max() <= CEILING
    assert report.limited_db > 20
    assert np.abs(sound[4000]).min() > 1e-3
    assert report.peak_db == pytest.approx(db(np.abs(sound).max()), abs=1e-3)
    assert report.rms_db == pytest.approx(db(np.sqrt((sound**2).mean())), abs=0.01)


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(data=st.data(), rate=st.sampled_from(RATES), frames=st.integers(1, 30))
def test_any_score_gives_finite_sound_of_exact_length(
    step, score_of, read_wav, tmp_path_factory, data, rate, frames
):
    happened = data.draw(
        st.lists(
            st.builds(
                step,
                st.integers(1, frames),
                cause=st.sampled_from(["footfall", "roll", "swoosh", "boing", "squeak", "whistle"]),
                who=st.text(max_size=4),
                material=st.sampled_from(["", "chitin", "steel", "Käse"]),
                surface=st.sampled_from(["", "snow", "rock"]),
                strength=st.floats(-1e300, 1e300),
                energy=st.floats(0, 1e300),
                size=st.floats(1e-300, 1e300),
                distance=st.floats(0, 1e300),
                azimuth=st.floats(-10, 10),
                duration=st.floats(0, 1e300),
            ),
            max_size=8,
        )
    )
    path = tmp_path_factory.mktemp("wav") / "score.wav"
    report = write_wav(score_of(happened, frames, rate), path)
    sound = read_wav(path)
    assert len(sound) == report.samples == sample_of_frame(frames + 1, rate)
    assert abs(len(sound) - 48_000 * frames / rate) <= Fraction(1, 2)
    assert np.abs(sound).max() <= CEILING
    first = min((event.frame for event in happened), default=frames + 1)
    assert not sound[: sample_of_frame(first, rate)].any()


def test_the_order_of_events_does_not_matter(step, score_of, tmp_path):
    happened = [step(1 + i % 7, part=f"foot_{i % 5}", azimuth=i / 9 - 1) for i in range(40)]
    write_wav(score_of(happened), tmp_path / "a.wav")
    write_wav(score_of(happened[::-1]), tmp_path / "b.wav")
    assert (tmp_path / "a.wav").read_bytes() == (tmp_path / "b.wav").read_bytes()


def test_an_event_sounds_the_same_whatever_the_other_events(step, render):
    alone = render([step(20)], 48)
    after = render([step(1, who="cow", material="steel", part="x"), step(20)], 48)
    before = render([step(1, who="cow", material="steel", part="x")], 48)
    # Each is rounded to 24 bits separately.
    assert np.abs(after - before - alone).max() <= 2 / 2**23


_PROGRAM = """
import sys
from fractions import Fraction
from pathlib import Path
from audio.midi_file import write_midi
from audio.wav_file import write_wav
from audio.score import Score, ScoreEvent
from audio.config.sound import Sound
events = [
    ScoreEvent(1 + i, Fraction(i, 24), cause, who, f"foot_{i % 6}", "terrain", material, "dry soil")
    for i, (cause, who, material) in enumerate(
        [("footfall", "bug", "chitin"), ("swoosh", "bird", ""), ("collision", "crate", "oak")] * 6
    )
]
score = Score(Fraction(24), 48, tuple(events), Sound(), 7, "twice")
write_wav(score, Path(sys.argv[1]) / "s.wav")
write_midi(score, Path(sys.argv[1]) / "s.mid")
"""


@pytest.mark.nightly
def test_two_processes_write_the_same_bytes(tmp_path):
    digests = set()
    for run in ("1", "2"):
        folder = tmp_path / run
        folder.mkdir()
        subprocess.run(
            [sys.executable, "-c", _PROGRAM, str(folder)],
            check=True,
            env={**os.environ, "PYTHONHASHSEED": run, "OPENBLAS_NUM_THREADS": run},
        )
        whole = (folder / "s.wav").read_bytes() + (folder / "s.mid").read_bytes()
        digests.add(hashlib.sha256(whole).hexdigest())
    assert len(digests) == 1


def test_azimuth_sets_the_side_and_keeps_power(step, render):
    def power(azimuth):
        return (render([step(1, azimuth=azimuth)]) ** 2).sum(axis=0)

    left, ahead, right, behind = (power(a) for a in (-np.pi / 2, 0, np.pi / 2, np.pi))
    assert left[0] > 0
    assert left[1] == 0
    assert right[0] == 0
    assert ahead[0] == ahead[1]
    for each in (ahead, right, behind, power(0.7)):
        assert each.sum() == pytest.approx(left.sum(), rel=1e-3)
    balance = [np.divide(*power(a)[::-1]) for a in (-1, -0.5, 0, 0.5, 1)]
    assert balance == sorted(set(balance))


def test_mute_and_gain_apply(step, render, score_of, tmp_path):
    plain = np.abs(render([step(1)])).max()
    louder = np.abs(render([step(1)], sound={"volume_db": -3, "voices": [{"gain_db": 9}]})).max()
    assert db(louder / plain) == pytest.approx(6, abs=0.01)
    report = write_wav(score_of([step(1)], sound={"voices": [{"mute": True}]}), tmp_path / "m.wav")
    assert (report.events, report.muted, report.peak_db) == (0, 1, -np.inf)


def test_a_sound_cut_by_the_end_does_not_click(step, render):
    sound = render([step(23, material="steel", surface="steel")], 24)
    body = np.abs(np.diff(sound[44_000:47_700, 0])).max()
    assert np.abs(sound[-400:-200]).max() > 0.01 * np.abs(sound).max()
    assert np.abs(sound[-1]).max() < 1e-6
    assert np.abs(np.diff(sound[-240:, 0])).max() < 1.5 * body


def test_an_equal_file_is_left_alone(step, score_of, tmp_path):
    path = tmp_path / "score.wav"
    assert write_wav(score_of([step(1)]), path).changed
    before = path.stat()
    assert not write_wav(score_of([step(1)]), path).changed
    assert path.stat().st_mtime_ns == before.st_mtime_ns
    assert write_wav(score_of([step(1)], seed=1), path).changed


def test_a_failure_keeps_the_earlier_file(step, score_of, tmp_path, monkeypatch):
    path = tmp_path / "score.wav"
    write_wav(score_of([step(1)]), path)
    earlier = path.read_bytes()

    def fail(handle):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr("pipeline.atomic_file.os.fsync", fail)
    with pytest.raises(SoundFileError, match="Input/output"):
        write_wav(score_of([step(2)]), path)
    with pytest.raises(ScoreError, match="hours"):
        write_wav(score_of(frames=24 * 3600 * 5), path)
    assert path.read_bytes() == earlier
    assert [p.name for p in tmp_path.iterdir()] == ["score.wav"]
