"""Stick-slip friction against an integrated mass on a belt."""

import numpy as np
import pytest

from audio.stick_slip import SLIP_SHARE, slip_impulses, slip_pulse, slip_rate

RATE = 48_000


def belt(speed, k=400.0, m=1e-3, sticking=1.0, sliding=0.4):
    """Return the slip rate of a mass on a belt [1/s], integrated step by step."""
    x, v, stuck, slips, t, dt = 0.0, speed, True, [], 0.0, 2e-6
    while len(slips) < 7:
        if stuck:
            x += speed * dt
            if k * x > sticking:
                stuck, v = False, speed
                slips.append(t)
        else:
            v += (sliding - k * x) / m * dt
            x += v * dt
            stuck = v >= speed and k * x < sticking
        t += dt
    return 1 / float(np.diff(slips[1:]).mean())


@pytest.mark.slow
def test_the_closed_form_matches_an_integrated_mass_on_a_belt():
    k, m, drop = 400.0, 1e-3, 0.6
    swing = 2 * np.pi * np.sqrt(m / k)
    for speed in (0.002, 0.01, 0.05):
        closed = 1 / (2 * drop / (k * speed) + swing / 2)
        assert belt(speed) == pytest.approx(closed, rel=0.06)
    # The same law relative to the greatest speed.
    top_speed = 2 * drop / k / (swing / 2) * SLIP_SHARE / (1 - SLIP_SHARE)
    top = np.full(3, 1 / (2 * drop / (k * top_speed) + swing / 2))
    share = np.array([1.0, 0.5, 0.1])
    closed = 1 / (2 * drop / (k * share * top_speed) + swing / 2)
    assert slip_rate(top, share) == pytest.approx(closed, rel=1e-9)


@pytest.mark.parametrize("rate", [5.0, 80.0, 1300.0])
def test_slips_have_the_given_rate_and_start_at_once(rate):
    impulses = slip_impulses(np.full(RATE, rate), 0.0, np.random.default_rng(0))
    assert impulses[0] == 1
    assert impulses.sum() == pytest.approx(rate, abs=1.01)
    at = np.flatnonzero(impulses)
    assert np.diff(at[impulses[at] > 0.5]) == pytest.approx(RATE / rate, abs=1.01)


def test_a_resting_joint_slips_once():
    assert np.count_nonzero(slip_impulses(np.zeros(1000), 0.1, np.random.default_rng(0))) == 1


@pytest.mark.parametrize("pitch", [30.0, 1300.0, 12_000.0])
def test_a_slip_pulse_has_zero_mean(pitch):
    assert abs(slip_pulse(pitch).sum()) < 1e-9
