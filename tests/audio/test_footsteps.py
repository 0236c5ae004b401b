"""Footsteps: heel and toe, no step like the next, and grounds that are told apart."""

from __future__ import annotations

import numpy as np
import pytest

from audio.synthesis import SoundParameters, synthesize

GROUNDS = ("soil", "gravel", "sand", "snow", "grass", "wood", "stone", "water")
RATE = 48_000
VARIANTS = 16


def steps(surface: str, material: str = "leather", **more: float) -> list[np.ndarray]:
    values = {"size": 0.95, "speed": 0.6, "distance": 2.0, "pitch": 0.0, "decay": 0.0, **more}
    return [
        synthesize(
            SoundParameters("footfall", material, surface, duration=0.0, variant=v, **values), 1
        )
        for v in range(VARIANTS)
    ]


def onsets(step: np.ndarray) -> list[int]:
    """Return the times of separable blows [ms]: peaks of the smoothed level 5 dB above a dip."""
    window = np.hanning(960) / 480
    level = 10 * np.log10(np.convolve(step**2, window, "same")[::48] + 1e-9)
    level -= level.max()
    found = [int(level[:30].argmax())]
    for i in range(30, len(level) - 1):
        is_peak = level[i] >= level[i - 1] and level[i] > level[i + 1] and level[i] > -20.0
        if is_peak and i - found[-1] > 45 and level[i] - level[found[-1] : i].min() > 5.0:
            found.append(i)
    return found


@pytest.mark.parametrize("surface", GROUNDS)
def test_heel_and_toe_are_heard_apart(surface: str) -> None:
    counts = [len(onsets(step)) for step in steps(surface)]
    assert min(counts) >= 2
    # A single burst of grains may stand apart.
    assert sum(count > 4 for count in counts) <= (surface in ("gravel", "snow", "water"))


def crest_db(step: np.ndarray) -> float:
    """Return the peak over the mean of the loudest 50 ms."""
    power = np.convolve(step**2, np.ones(2400) / 2400)
    return float(10 * np.log10(np.max(step**2) / power.max()))


@pytest.mark.parametrize("surface", ["soil", "gravel", "snow", "grass"])
def test_the_body_of_a_step_is_loud_beside_its_peak(surface: str) -> None:
    assert np.mean([*map(crest_db, steps(surface))]) < 13.0
    assert np.mean([*map(crest_db, steps(surface, "chitin"))]) < 11.5


def test_a_hoof_strikes_twice_in_a_moment() -> None:
    for step in steps("stone", "horn"):
        level = np.abs(step)
        second = level[round(0.02 * RATE) : round(0.06 * RATE)].max()
        between = np.sqrt(np.mean(step[round(0.012 * RATE) : round(0.018 * RATE)] ** 2))
        assert 0.2 < second <= 1.0
        assert between < 0.5 * second


@pytest.mark.parametrize("surface", GROUNDS)
def test_no_two_steps_are_alike(surface: str) -> None:
    sounds = steps(surface)
    longest = max(map(len, sounds))
    matrix = np.corrcoef([np.pad(sound, (0, longest - len(sound))) for sound in sounds])
    apart = np.abs(matrix[~np.eye(VARIANTS, dtype=bool)])
    assert apart.max() < 0.75
    assert np.mean(apart < 0.6) > 0.98


def test_grounds_are_told_apart_by_their_spectra() -> None:
    """A classifier that saw half of the steps names nine of ten of the others."""
    edges = 2.0 ** np.arange(5.0, 14.6, 0.5)

    def bands(step: np.ndarray) -> np.ndarray:
        power = np.abs(np.fft.rfft(step, 1 << 15)) ** 2
        index = np.digitize(np.fft.rfftfreq(1 << 15, 1 / RATE), edges)
        energy = np.bincount(index, power, len(edges) + 1)[1:-1]
        return np.log(energy / energy.sum() + 1e-9)

    features = {name: np.array([bands(step) for step in steps(name)]) for name in GROUNDS}
    means = {name: rows[::2].mean(axis=0) for name, rows in features.items()}
    named = [
        min(means, key=lambda other: float(((row - means[other]) ** 2).sum())) == name
        for name, rows in features.items()
        for row in rows[1::2]
    ]
    assert np.mean(named) >= 0.9


def test_a_tuned_step_plays_its_note() -> None:
    step = steps("wood", "steel", pitch=440.0, contact=1e-3)[0]
    power = np.abs(np.fft.rfft(step, 1 << 16))
    peak = np.fft.rfftfreq(1 << 16, 1 / RATE)[power.argmax()]
    assert peak == pytest.approx(440.0, rel=0.02)


def test_small_legs_step_in_less_time() -> None:
    assert len(steps("soil", size=0.1)[0]) < 0.6 * len(steps("soil")[0])
