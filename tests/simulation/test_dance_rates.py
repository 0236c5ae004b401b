"""The same dance at other frame rates and other steps."""

from __future__ import annotations

import numpy as np
import pytest

from tests.simulation.dancing import Seen, danced
from tests.simulation.test_dancers import DEPTH, unreached

BOTH = ("force-field", "joint-torque")

# The whole dance: all twelve subtasks and a while after.
BEATS = 13.0


def whole(by: str, tempo: float, rate: float, steps: int) -> Seen:
    words = f"controller: {by}, tempo_bpm: {tempo}, start: 1.0, steps_a_second: {steps}"
    return danced(words, 1.0 + BEATS * 60.0 / tempo, rate)


HALVED = [
    pytest.param(by, tempo, rate, marks=[] if (tempo, rate) == (103, 100) else pytest.mark.nightly)
    for by in BOTH
    for tempo in (60, 80, 103)
    for rate in (96, 100)
]


@pytest.mark.slow
@pytest.mark.parametrize(("by", "tempo", "rate"), HALVED)
def test_halving_the_step_moves_hands_by_less_than_two_millimetres(
    by: str, tempo: float, rate: float
) -> None:
    # At 100 steps of the world a second these are 1/1000 s and 1/2000 s to the digit.
    coarse, fine = (np.array(whole(by, tempo, rate, steps).hands) for steps in (1000, 2000))
    apart = np.linalg.norm(coarse - fine, axis=-1)
    assert apart.max() < 0.002


# 24 to 240 frames a second, of one to four steps each; steps of 1/288 s to 1/2000 s and less.
SAMPLED = [
    pytest.param(24, 240, marks=pytest.mark.slow),
    pytest.param(96, 240, marks=pytest.mark.nightly),
    pytest.param(120, 500, marks=pytest.mark.nightly),
    pytest.param(240, 240, marks=pytest.mark.slow),
    pytest.param(240, 1000, marks=pytest.mark.nightly),
    pytest.param(960, 2000, marks=pytest.mark.nightly),
]


@pytest.mark.parametrize("by", BOTH)
@pytest.mark.parametrize(("rate", "steps"), SAMPLED)
def test_every_goal_is_reached_at_every_frame_rate_and_step(by: str, rate: int, steps: int) -> None:
    seen = whole(by, 103, rate, steps)
    for rows in (seen.q, seen.hands, seen.torques):
        assert np.isfinite(np.array(rows)).all()
    assert unreached(seen, skipped=(2, 3) if by == "force-field" else ()) == []
    assert max(seen.deepest.values()) < DEPTH


# Subtasks 1 to 5 and the way to 6.
UNTIL = 1.0 + 5.5 * 0.6


def hands(by: str, rate: float, steps: int) -> np.ndarray:
    words = f"controller: {by}, tempo_bpm: 100, start: 1.0, steps_a_second: {steps}"
    return np.array(danced(words, UNTIL, rate).hands)


RATES = [
    pytest.param(96, 240, marks=pytest.mark.slow),
    pytest.param(96, 500, marks=pytest.mark.nightly),
    pytest.param(100, 1000, marks=pytest.mark.nightly),
    pytest.param(960, 2000, marks=pytest.mark.nightly),
]


@pytest.mark.parametrize("by", BOTH)
@pytest.mark.parametrize(("rate", "steps"), RATES)
def test_other_rates_and_steps_dance_the_same_dance(by: str, rate: int, steps: int) -> None:
    seen = danced(
        f"controller: {by}, tempo_bpm: 100, start: 1.0, steps_a_second: {steps}", UNTIL, rate
    )
    assert np.isfinite(np.array(seen.q)).all()
    reference = hands(by, 96.0, 2000)
    times = np.arange(1, len(reference) + 1) / 96.0
    own = np.array(seen.hands)
    at = np.array(seen.times)
    found = np.stack(
        [[np.interp(times, at, own[:, k, i]) for i in range(3)] for k in range(2)]
    ).transpose(2, 0, 1)
    inside = times <= at[-1]
    apart = np.linalg.norm(found - reference, axis=-1)[inside]
    # Where they have arrived they are at one place, on the way within what a control lasts.
    assert np.median(apart) < 0.01
    assert apart.max() < 0.08
