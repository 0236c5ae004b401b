"""Sound facts: levels by time, channel and band, and what the film's track carries."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pipeline.production.goldens.film_facts import FilmFacts, film_differences
from pipeline.production.goldens.sound_facts import facts_of_sound, sound_from
from pipeline.production.goldens.sound_levels import (
    MAX_WINDOWS,
    even_change,
    level_changes,
    level_differences,
    levels_of,
    window_of,
)
from pipeline.production.goldens.sound_onsets import RATE, SILENCE, measured_onsets

WINDOW = RATE // 10


def tones(*parts: tuple[float, float], seconds: float = 0.5) -> NDArray[np.float64]:
    """Return a sound (2, N) of tones: frequency [Hz], amplitude."""
    t = np.arange(round(seconds * RATE)) / RATE
    one = sum(amplitude * np.sin(2 * np.pi * f * t) for f, amplitude in parts)
    return np.stack([one, one])


def blows(*times: float) -> NDArray[np.float64]:
    """Return a second of sound (2, N) with blows, louder on the right."""
    t = np.arange(RATE) / RATE
    one = np.zeros(RATE)
    for time in times:
        late = t - time
        one += np.where(late >= 0, 0.3 * np.exp(-late / 0.05) * np.sin(4400 * late), 0.0)
    return np.stack([0.5 * one, one])


def test_a_tone_has_its_level_in_its_band() -> None:
    levels = np.array(levels_of(tones((100, 0.5), (2000, 0.05)), WINDOW))
    assert levels.shape == (5, 3, 4)
    # A sine of amplitude 0.5 has a mean square of 1/8.
    assert levels[:, :, 0] == pytest.approx(10 * np.log10(1 / 8), abs=0.06)
    assert levels[:, :, 2] == pytest.approx(10 * np.log10(1 / 800), abs=0.06)
    assert (levels[:, :, [1, 3]] <= -60).all()


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 3 * WINDOW))
def test_the_bands_of_a_window_add_up_to_its_power(seed: int, samples: int) -> None:
    sound = np.random.default_rng(seed).normal(0, 0.1, (2, samples))
    levels = np.array(levels_of(sound, WINDOW))
    padded = np.pad(sound, ((0, 0), (0, len(levels) * WINDOW - samples)))
    power = (padded.reshape(2, -1, WINDOW) ** 2).mean(axis=2).T
    told = (10 ** (levels[:, :2] / 10)).sum(axis=2)
    assert told == pytest.approx(power, rel=0.05, abs=5e-7)


def test_a_long_sound_has_longer_windows() -> None:
    for minutes in (0.1, 1, 60):
        samples = round(minutes * 60 * RATE)
        assert samples / window_of(samples) <= MAX_WINDOWS
    assert window_of(RATE) == WINDOW


def test_what_is_masked_counts_for_nothing() -> None:
    then = np.array([[[-20.0, -35.0, -63.0]]])
    soft, masked = np.array([0.0, -6.0, 0.0]), np.array([0.0, 0.0, -6.0])
    assert np.abs(level_changes(then, then + masked)).max() < 0.3
    assert np.abs(level_changes(then, then + soft)).max() > 4.0
    silence = np.full((1, 1, 3), SILENCE)
    assert np.abs(level_changes(silence, silence - 10.0)).max() < 3.1


def test_the_first_stretch_channel_and_band_are_named() -> None:
    then = tones((100, 0.2), (2000, 0.1))
    now = then.copy()
    now[1, 2 * WINDOW :] += tones((500, 0.1))[0, 2 * WINDOW :]
    (text,) = level_differences(levels_of(then, WINDOW), levels_of(now, WINDOW), 0.1)
    assert text.startswith("the right channel is ")
    assert "from 0.2 to 0.3 s between 250 and 1000 Hz; 3 of 5 stretches differ" in text


@pytest.mark.parametrize(
    ("gains", "says"),
    [
        ((0.5, 0.5), ["the sound is 6.0 dB softer throughout"]),
        ((1.2, 1.0), ["the left channel is 1.6 dB louder throughout"]),
        ((0.0, 1.0), ["the left channel is silent"]),
        ((1.0, -1.0), ["both channels together are"]),
        ((1.02, 0.98), []),
    ],
)
def test_an_even_change_is_told_once(gains: tuple[float, float], says: list[str]) -> None:
    then = tones((100, 0.2), (2000, 0.1))
    now = then * np.array(gains)[:, None]
    found = level_differences(levels_of(then, WINDOW), levels_of(now, WINDOW), 0.1)
    assert len(found) == len(says)
    assert all(text.startswith(start) for text, start in zip(found, says, strict=True))


def test_a_change_that_is_not_everywhere_is_not_even() -> None:
    then = np.array(levels_of(tones((100, 0.2), (2000, 0.1)), WINDOW))
    assert even_change(then, then - 2.0) == pytest.approx(-2.0)
    now = then - 2.0
    now[3] += 2.0
    assert even_change(then, now) == 0.0


def film_of(written: NDArray[np.float64], heard: NDArray[np.float64]) -> FilmFacts:
    """Return the facts of a film with a sound."""
    return FilmFacts({}, (), measured_onsets(written), facts_of_sound(written, heard))


def test_facts_are_read_back() -> None:
    facts = facts_of_sound(blows(0.2, 0.7), blows(0.2, 0.7))
    assert sound_from(json.loads(json.dumps(facts.members()))) == facts
    with pytest.raises(ValueError, match="channels"):
        sound_from({**facts.members(), "carried": [None]})


def test_the_track_of_a_film_is_measured_against_what_was_written() -> None:
    written = blows(0.2, 0.7)
    noise = np.random.default_rng(1).normal(0, 1e-3, written.shape)
    heard = np.roll(0.5 * written, 1024, axis=1) + noise
    facts = facts_of_sound(written, heard)
    for carriage, side in zip(facts.carried, written, strict=True):
        assert carriage is not None
        assert carriage.late == 1024
        assert carriage.gain == pytest.approx(-6.0, abs=0.1)
        expected = 10 * np.log10(1e-6 / (0.25 * np.mean(side**2)))
        assert carriage.noise == pytest.approx(expected, abs=0.6)
    assert facts_of_sound(np.zeros((2, RATE)), heard).carried == (None, None)
    # One channel, and a track that is too short.
    short = facts_of_sound(written, heard[:1, : RATE // 2])
    assert short.carried[1] is not None
    assert short.carried[1].gain <= -80


def test_what_differs_is_told_in_plain_words() -> None:
    sound = blows(0.2, 0.7)
    golden = film_of(sound, sound)
    assert list(film_differences(golden, film_of(sound, sound), 1 / 24)) == []
    late = np.roll(sound, 500, axis=1)
    assert list(film_differences(golden, film_of(late, late), 1 / 24)) == [
        "the sound is 500 samples (10.4 ms) late: 0.25 frames"
    ]
    second = np.concatenate([sound[:, : RATE // 2], 0.8 * sound[:, RATE // 2 :]], axis=1)
    found = list(film_differences(golden, film_of(second, second), 1 / 24))
    assert found[0].startswith("the left channel is 1.9 dB softer from 0.7 to 0.8 s")
    assert found[-1] == "the sound at 0.700 s is 2.0 dB softer"
    assert not any("0.200 s" in text for text in found)
    assert list(film_differences(golden, film_of(sound, 0.8 * sound), 1 / 24)) == [
        f"the film's track: the {name} channel is 1.9 dB softer than written"
        for name in ("left", "right")
    ]


def test_a_golden_of_an_earlier_version_is_compared_by_its_onsets() -> None:
    sound = blows(0.2, 0.7)
    golden = FilmFacts({}, (), tuple(type(o)(o.time, o.rise) for o in measured_onsets(sound)))
    softer, other = (film_of(s, s) for s in (0.5 * sound, blows(0.2, 0.8)))
    assert list(film_differences(golden, softer, 1 / 24)) == []
    assert len(list(film_differences(golden, other, 1 / 24))) == 2
