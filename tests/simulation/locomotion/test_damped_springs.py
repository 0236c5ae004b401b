"""Springs against the closed forms of a damped oscillator."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.locomotion.body_motion.damped_springs import Oscillators, SpringFollower
from pipeline.simulation.spatial import Array

W, Z = 7.0, 0.3
SWING = W * np.sqrt(1.0 - Z * Z)


def springs(dt: float) -> Oscillators:
    return Oscillators(np.array([W]), np.array([Z]), dt)


def starting_lag(times: Array, e: float, w: float) -> Array:
    """Return the position of a damped oscillator that starts at `e` with speed `w`."""
    left = np.exp(-Z * W * times)
    result: Array = left * (
        e * np.cos(SWING * times) + (w + Z * W * e) / SWING * np.sin(SWING * times)
    )
    return result


@pytest.mark.parametrize("dt", [0.003, 0.04, 0.7])
def test_free_oscillation_is_exact_at_any_step(dt: float) -> None:
    e, w, found = np.array([0.4]), np.array([-2.0]), []
    for _ in range(60):
        e, w = springs(dt).step(e, w)
        found.append(e[0])
    times = dt * np.arange(1, 61)
    np.testing.assert_allclose(found, starting_lag(times, 0.4, -2.0), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("dt", [0.01, 0.05])
def test_lag_behind_a_starting_goal_matches_the_closed_form(dt: float) -> None:
    times = dt * np.arange(120)
    goals = 1.7 * np.maximum(times - 5 * dt, 0.0)[:, None]
    late = SpringFollower(springs(dt)).follow(goals)[:, 0]
    since = np.maximum(times - 5 * dt, 0.0)
    np.testing.assert_allclose(late, starting_lag(since, 0.0, -1.7), rtol=0.0, atol=1e-13)


def test_no_lag_behind_a_resting_or_even_goal() -> None:
    times = 0.01 * np.arange(100)
    for goals in (np.full(100, 3.0), 5.0 - 2.0 * times):
        assert np.abs(SpringFollower(springs(0.01)).follow(goals[:, None])).max() < 1e-12


def test_refinement_converges_to_second_order() -> None:
    def late(rate: int) -> Array:
        times = np.arange(2 * rate + 1) / rate
        goals = times**3 * np.sin(5.0 * times)  # starts at rest
        return SpringFollower(springs(1.0 / rate)).follow(goals[:, None])[:: rate // 20, 0]

    truth = late(2560)
    coarse, fine = (np.abs(late(rate) - truth).max() for rate in (40, 80))
    assert np.abs(truth).max() > 1.0
    assert fine < 0.26 * coarse


def test_rows_do_not_depend_on_batch_size() -> None:
    goals = np.random.default_rng(5).normal(size=(97, 4, 3)).cumsum(axis=0)
    many = Oscillators(np.array([2.0, 5.0, 9.0, 40.0]), np.array([0.1, 0.3, 0.6, 0.9]), 1 / 96)
    whole = SpringFollower(many).follow(goals)
    for sizes in ([1] * 97, [1, 96], [50, 1, 46]):
        trailing, parts, first = SpringFollower(many), [], 0
        for size in sizes:
            parts.append(trailing.follow(goals[first : first + size]))
            first += size
        assert np.concatenate(parts).tobytes() == whole.tobytes()


def test_stiff_springs_are_stable() -> None:
    stiff = Oscillators(np.array([1e4]), np.array([0.05]), 0.1)
    goals = np.random.default_rng(6).normal(size=(500, 1))
    late = SpringFollower(stiff).follow(goals)
    assert np.isfinite(late).all()
    assert np.abs(late).max() < 1.0
