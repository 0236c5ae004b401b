"""The WAV file: onsets on their samples, loudness, direction, spectrum and decay."""

import hashlib
import os
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from audio.acoustic_materials import FAMILIES
from audio.errors import ScoreError, SoundFileError
from audio.time_grid import sample_of_frame
from audio.wav_file import write_wav

RATES = [10, 12, 15, 16, 18, 24, 25, 30, 48, 50, 60, 72, 90, 100, 120, 144, 240]
RATES = [Fraction(r) for r in RATES] + [Fraction(r * 1000, 1001) for r in (24, 30, 60)]
CEILING = 10 ** (-1 / 20)
BY_DAY = ("wood", "metal", "cloth", "gravel")
"""Materials of every kind of sound; the others are nightly."""

PLAIN = {"room": "dry", "master": "off"}


@pytest.fixture
def render(tmp_path, read_wav, score_of):
    """Return a function that renders events in a dry room without mastering: (N, 2)."""

    def play(*args, sound=None, **fields):
        said = {**PLAIN, **(sound or {})}
        write_wav(score_of(*args, sound=said, **fields), tmp_path / "render.wav")
        return read_wav(tmp_path / "render.wav")

    return play


def centroid(sound):
    """Return the mean frequency of the power of both sides [Hz]."""
    power = np.abs(np.fft.rfft(sound.sum(axis=1))) ** 2
    return float((np.fft.rfftfreq(len(sound), 1 / 48_000) * power).sum() / power.sum())


def db(level):
    return 20 * np.log10(level)


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


@pytest.mark.slow
@pytest.mark.parametrize(
    "material",
    [
        name if name in BY_DAY else pytest.param(name, marks=pytest.mark.nightly)
        for name in sorted(FAMILIES)
    ],
)
def test_every_material_pair_starts_at_once_and_decays(step, render, material):
    for surface in FAMILIES:
        sound = render([step(2, material=material, surface=surface)], 24 * 8, 24)
        loudest = np.abs(sound).max()
        assert not sound[:2000].any()
        assert np.abs(sound[2000]).min() > 0.002 * loudest
        assert not sound[-48:].any()
        # No constant pressure: the mean is far below the peak.
        assert np.abs(sound.mean(axis=0)).max() < 1e-5


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
    report = write_wav(score_of([step(1), *crash], 48, sound=PLAIN), tmp_path / "crash.wav")
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


@pytest.mark.slow
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


def test_seed_and_time_vary_an_impact_slightly(step, render):
    def blow(frame, seed):
        sound = render([step(frame)], 24, seed=seed)
        return sound[2000 * (frame - 1) :][:8000]

    first, reseeded, later = blow(1, 0), blow(1, 1), blow(3, 0)
    for other in (reseeded, later):
        assert np.abs(first - other).max() > 0.05 * np.abs(first).max()
        assert abs(db(np.abs(first).max() / np.abs(other).max())) < 2
        assert 0.5 < centroid(first) / centroid(other) < 2


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


@pytest.mark.parametrize(
    ("field", "values"),
    [("strength", (0.05, 0.2, 1.0)), ("distance", (24, 8, 3)), ("energy", (0.02, 0.2, 2))],
)
def test_stronger_nearer_and_heavier_is_louder(step, render, field, values):
    peaks = [np.abs(render([step(1, **{field: value})])).max() for value in values]
    assert peaks == sorted(set(peaks))


def test_twice_the_distance_is_6_db_softer(step, render):
    near, far = (np.abs(render([step(1, distance=d)])).max() for d in (3, 6))
    assert db(near / far) == pytest.approx(6.02, abs=0.01)


def test_distance_dulls_and_small_size_brightens(step, render):
    def brightness(**changes):
        return centroid(render([step(1, surface="rock", **changes)], 48))

    assert brightness(distance=400) < 0.9 * brightness(distance=4)
    small, middle, large = (brightness(size=size) for size in (0.02, 0.1, 0.6))
    assert small > 1.2 * middle > 1.4 * large


@pytest.mark.slow
@pytest.mark.parametrize(
    ("brighter", "duller"),
    [("rock", "dry soil"), ("sand", "snow"), ("glass", "wood"), ("gravel", "mud")],
)
def test_grounds_differ_in_brightness(step, render, brighter, duller):
    bright, dull = (
        np.mean([centroid(render([step(f, surface=ground)])) for f in range(1, 9)])
        for ground in (brighter, duller)
    )
    assert bright > 1.25 * dull


@pytest.mark.nightly
def test_every_pair_of_materials_has_its_own_spectrum(step, render):
    # Third-octave levels of successive blocks, averaged over variants.
    edges = 100 * 2 ** (np.arange(22) / 3)
    bands = {}
    for name in FAMILIES:
        power = 0
        for frame in (1, 3, 5, 7):
            sound = render([step(frame, material=name, surface="concrete", size=0.1)], 96)
            spectrum = np.abs(np.fft.rfft(sound[:, 0])) ** 2
            power = (
                power
                + np.histogram(np.fft.rfftfreq(len(sound), 1 / 48_000), edges, weights=spectrum)[0]
            )
        bands[name] = 10 * np.log10(power / power.sum() + 1e-6)
    names = sorted(bands)
    distance = {
        (a, b): np.sqrt(np.mean((bands[a] - bands[b]) ** 2))
        for i, a in enumerate(names)
        for b in names[i + 1 :]
    }
    assert min(distance.values()) > 1.0, min(distance, key=distance.get)


def test_metal_rings_longer_than_wood_and_wood_longer_than_rubber(step, render):
    def ringing(material):
        sound = render([step(1, material=material, surface="concrete", size=0.1)], 96)
        energy = np.cumsum((sound**2).sum(axis=1))
        return int(np.searchsorted(energy, 0.999 * energy[-1]))

    metal, wood, rubber = map(ringing, ("steel", "oak", "rubber"))
    assert metal > 3 * wood > 3 * rubber


def test_a_configured_pitch_tunes_the_ring(step, render):
    for pitch, hertz in ((57, 220.0), (81, 880.0)):
        sound = render(
            [step(1, material="steel", surface="steel")],
            96,
            sound={"voices": [{"pitch": pitch}]},
        )
        spectrum = np.abs(np.fft.rfft(sound[:, 0]))
        f = np.fft.rfftfreq(len(sound), 1 / 48_000)
        near = (f > hertz / 1.3) & (f < hertz * 1.12)
        assert f[near][spectrum[near].argmax()] == pytest.approx(hertz, rel=0.01)


def test_a_configured_length_ends_the_ring(step, render):
    def ringing(length):
        sound = render(
            [step(1, material="steel", surface="steel")],
            24 * 8,
            sound={"voices": [{"length": length}]},
        )
        return np.flatnonzero(np.abs(sound[:, 0]) > np.abs(sound).max() / 1000)[-1] / 48_000

    assert 0.02 < ringing(0.1) < 0.15
    assert 1 < ringing(3.0) < 4


def test_mute_and_gain_apply(step, render, score_of, tmp_path):
    plain = np.abs(render([step(1)])).max()
    louder = np.abs(render([step(1)], sound={"volume_db": -3, "voices": [{"gain_db": 9}]})).max()
    assert db(louder / plain) == pytest.approx(6, abs=0.01)
    report = write_wav(score_of([step(1)], sound={"voices": [{"mute": True}]}), tmp_path / "m.wav")
    assert (report.events, report.muted, report.peak_db) == (0, 1, -np.inf)


@pytest.mark.parametrize(
    "cause", ["swoosh", "whistle", "squeak", "squawk", "boing", "push off", "breath", "cry"]
)
def test_motion_sounds_start_on_their_frame_and_have_their_duration(step, render, cause):
    sound = render([step(3, cause=cause, duration=0.5, strength=3.0)], 48)
    loud = np.flatnonzero(np.abs(sound).max(axis=1) > np.abs(sound).max() / 300)
    assert not sound[:4000].any()
    assert sound[4000:4048].any()
    assert 0.3 < (loud[-1] - 4000) / 48_000 <= 0.5
    assert not sound[4000 + 24_001 :].any()


def test_a_cry_is_higher_for_a_child_and_a_hug_is_dull(step, render):
    def tone(size, strength=3.0):
        sound = render([step(1, cause="cry", size=size, strength=strength)], 24).sum(axis=1)
        # The lag of the greatest autocorrelation in its loudest part.
        part = sound[6000:14_000]
        like = np.correlate(part, part, "full")[len(part) - 1 :]
        lags = np.arange(60, 320)
        best = lags[np.argmax(like[lags])]
        return 48_000 / best, like[best] / like[0]

    (child, periodic), (adult, _) = tone(0.11), tone(0.17)
    assert 350 < child < 600
    assert 0.65 * child < adult < 0.95 * child
    assert periodic > 0.7
    cry, hug = (render([step(1, cause=c, size=0.15, strength=1.0)], 24) for c in ("cry", "hug"))
    assert centroid(cry) > 4 * centroid(hug)


def test_a_roll_has_its_duration(step, render):
    sound = render([step(3, cause="roll", duration=1.0, material="wood")], 48)
    assert np.abs(sound[4000]).min() > 1e-6
    middle, late = (np.sqrt((sound[a : a + 4800] ** 2).mean()) for a in (20_000, 45_000))
    assert abs(db(middle / late)) < 3
    assert not sound[4000 + 48_001 :].any()


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

    monkeypatch.setattr("audio.atomic_file.os.fsync", fail)
    with pytest.raises(SoundFileError, match="Input/output"):
        write_wav(score_of([step(2)]), path)
    with pytest.raises(ScoreError, match="hours"):
        write_wav(score_of(frames=24 * 3600 * 5), path)
    assert path.read_bytes() == earlier
    assert [p.name for p in tmp_path.iterdir()] == ["score.wav"]


def test_a_scuff_starts_on_its_frame_and_is_short_and_soft(step, render):
    scuff, blow = (
        render([step(3, cause=cause, surface="gravel")], 48) for cause in ("scuff", "footfall")
    )
    assert not scuff[:4000].any()
    assert scuff[4000:4048].any()
    loud = np.flatnonzero(np.abs(scuff).max(axis=1) > np.abs(scuff).max() / 300)
    assert 0.08 < (loud[-1] - 4000) / 48_000 <= 0.14
    assert db(np.abs(scuff).max() / np.abs(blow).max()) == pytest.approx(-12, abs=1.7)


@pytest.mark.parametrize(("coarse", "fine"), [("gravel", "mud"), ("rock", "dry soil")])
def test_a_scuff_is_as_bright_as_its_ground(step, render, coarse, fine):
    bright, dull = (centroid(render([step(3, cause="scuff", surface=s)])) for s in (coarse, fine))
    assert bright > 1.1 * dull
