"""Jerk measurement and retiming, against closed forms and scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import optimize, signal, stats
from scipy.spatial import cKDTree

from pipeline.simulation.curves import ease
from pipeline.simulation.dancers.jerk import (
    CUTOFF_FREQUENCY,
    FILTER_ORDER,
    MINIMUM_DIMENSIONLESS_JERK,
    SAMPLE_RATE,
    low_passed,
    measure_jerk,
    minimum_jerk_between,
    rank_correlation,
    resampled,
    third_derivative,
)
from pipeline.simulation.dancers.minimum_jerk_retiming import retime_for_minimum_jerk
from pipeline.simulation.dancers.paper_jerk import PAPER_JERK, PAPER_SUBTASK_COUNT
from pipeline.spec import read_scene


def reach(
    time: float, displacement: np.ndarray, rate: float = 96.0
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the minimum-jerk straight reach from 0 to `time`, with rest before and after."""
    t = np.arange(-1.0, time + 1.0, 1.0 / rate)
    return t, ease(np.clip(t / time, 0, 1))[:, None] * displacement


def test_filter_matches_scipy_sosfiltfilt() -> None:
    rng = np.random.default_rng(1)
    t = np.arange(0, 6, 1 / SAMPLE_RATE)
    p = np.stack([np.sin(t), t**2 / 9, np.cumsum(rng.normal(size=len(t))) * 0.02], axis=-1)
    sections = signal.butter(FILTER_ORDER, CUTOFF_FREQUENCY, fs=SAMPLE_RATE, output="sos")
    theirs = signal.sosfiltfilt(sections, p, axis=0)
    inner = slice(40, -40)
    np.testing.assert_allclose(low_passed(p)[inner], theirs[inner], atol=2e-5)


def test_resampling_and_differences_are_exact_for_cubics() -> None:
    t = np.arange(0, 2, 1 / 96)
    c = np.array([[1.0, -2, 0.5], [0.3, 1, -1], [2, 0, 1], [-0.7, 0.4, 3]])
    p = sum(c[k] * t[:, None] ** k for k in range(4))
    at, x = resampled(t, p)
    np.testing.assert_allclose(x, sum(c[k] * at[:, None] ** k for k in range(4)), atol=1e-12)
    np.testing.assert_allclose(third_derivative(x), np.broadcast_to(6 * c[3], x.shape), atol=1e-7)


@pytest.mark.parametrize("rate", [96.0, 100.0, 240.0])
def test_minimum_jerk_reach_approaches_720_with_duration(rate: float) -> None:
    # The filter removes content above 10 Hz, which slower movements have less of.
    found = [
        measure_jerk(*reach(time, np.array([0.3, 0.4, 0]), rate), 0.0, time)
        for time in (1, 2, 4, 8)
    ]
    lost = [1 - jerk.dimensionless / MINIMUM_DIMENSIONLESS_JERK for jerk in found]
    assert all(0 < lost[k + 1] < lost[k] for k in range(3))
    assert lost[0] < 0.12
    assert lost[3] < 0.02
    assert found[0].distance == pytest.approx(0.5, rel=1e-3)
    assert found[1].mean == pytest.approx(found[1].integral / 2)


def test_jerk_scales_with_duration_and_distance() -> None:
    base = measure_jerk(*reach(4, np.array([0.3, 0, 0])), 0.0, 4.0)
    slow = measure_jerk(*reach(8, np.array([0.3, 0, 0])), 0.0, 8.0)
    long = measure_jerk(*reach(4, np.array([0, 0.6, 0])), 0.0, 4.0)
    assert slow.integral == pytest.approx(base.integral / 32, rel=0.05)
    assert long.integral == pytest.approx(4 * base.integral, rel=1e-9)


def test_quintic_is_lower_bound() -> None:
    rng = np.random.default_rng(4)
    for _ in range(30):
        t = np.arange(0, 4, 1 / 96)
        p = sum(
            rng.normal(size=3) / k**2 * np.sin(k * t[:, None] + rng.uniform(0, 6, 3))
            for k in range(1, 6)
        )
        assert minimum_jerk_between(t, p, 1.0, 3.0) <= measure_jerk(t, p, 1.0, 3.0).integral * 1.02
    t, p = reach(2, np.array([0.3, 0.4, 0]))
    quintic = measure_jerk(t, p, 0.0, 2.0).integral
    assert minimum_jerk_between(t, p, 0.0, 2.0) == pytest.approx(quintic, rel=0.06)


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("power", [1.0, 1.3, 2.0])
def test_retimed_straight_path_is_minimum_jerk_reach(power: float) -> None:
    # Long durations, since the filter smooths the ends of fast reaches.
    for time, lost in ((4.0, 0.035), (8.0, 0.018)):
        t = np.arange(-1.0, time + 1.0, 1 / 96)
        u = np.clip(t / time, 0, 1)
        p = ease(u**power)[:, None] * np.array([0.3, 0.4, 0])
        best = retime_for_minimum_jerk(t, p, 0.0, time)
        assert best.integral * time**5 / 0.25 == pytest.approx(MINIMUM_DIMENSIONLESS_JERK, rel=lost)
        assert best.integral <= best.danced == measure_jerk(t, p, 0.0, time).integral
        assert power == 1.0 or best.danced > 1.5 * best.integral
        along = best.places @ np.array([0.6, 0.8, 0])
        np.testing.assert_allclose(along, 0.5 * ease(best.times / time), atol=0.015)


def spiral(u: np.ndarray) -> np.ndarray:
    """Returns positions on three quarters of a rising spiral, at phases `u`."""
    a = 1.5 * np.pi * u
    r = 0.2 + 0.1 * u
    return np.stack([r * np.cos(a), 0.2 * u, r * np.sin(a)], axis=-1)


def test_chebyshev_search_finds_no_better_timing() -> None:
    time = 2.0
    t = np.arange(-1.0, time + 1.0, 1 / 96)
    u = np.clip(t / time, 0, 1)

    def moved(waves: np.ndarray) -> np.ndarray:
        series = np.polynomial.chebyshev.chebval(2 * u - 1, waves)
        return spiral(ease(u) + (u * (1 - u)) ** 3 * series)

    def jerks(waves: np.ndarray) -> np.ndarray:
        inside = slice(60, 60 + round(time * SAMPLE_RATE) + 1)
        return third_derivative(low_passed(resampled(t, moved(waves))[1]))[inside].ravel()

    p = spiral(ease(u**1.4))
    best = retime_for_minimum_jerk(t, p, 0.0, time)
    assert best.integral < 0.6 * best.danced
    waves = optimize.least_squares(jerks, np.zeros(10)).x
    theirs = measure_jerk(t, moved(waves), 0.0, time).integral
    assert theirs < measure_jerk(t, moved(np.zeros(1)), 0.0, time).integral
    # The filter smooths the ends of theirs; ours keeps the recorded end states.
    assert best.integral == pytest.approx(theirs, rel=0.15)
    again = retime_for_minimum_jerk(t, moved(waves), 0.0, time)
    assert again.integral == pytest.approx(theirs, rel=0.05)

    # The result stays on the path and never moves backward.
    path = spiral(np.linspace(0, 1, 20001))
    distances, nearest = cKDTree(path).query(best.places)
    assert distances.max() < 1e-3
    assert (np.diff(nearest) >= 0).all()


def test_retimed_jerk_lies_between_quintic_and_recorded() -> None:
    rng = np.random.default_rng(8)
    for _ in range(12):
        t = np.arange(0, 4, 1 / 96)
        p = sum(
            rng.normal(size=3) / k**2 * np.sin(k * t[:, None] + rng.uniform(0, 6, 3))
            for k in range(1, 6)
        )
        best = retime_for_minimum_jerk(t, p, 1.0, 3.0)
        assert best.danced == measure_jerk(t, p, 1.0, 3.0).integral
        assert 0.98 * minimum_jerk_between(t, p, 1.0, 3.0) < best.integral <= best.danced
        # Position, velocity and acceleration are kept at both ends.
        x = low_passed(resampled(t, p)[1])
        for own, danced in ((best.places[:4], x[60:64]), (best.places[-4:], x[177:181])):
            np.testing.assert_allclose(own, danced, atol=4e-3)
        np.testing.assert_allclose(best.places[[0, -1]], x[[60, 180]], atol=1e-9)


def test_retiming_of_rest_and_of_shortest_movement() -> None:
    t = np.arange(0, 3, 1 / 96)
    still = np.broadcast_to(np.array([0.1, 1.2, 0.3]), (len(t), 3))
    assert retime_for_minimum_jerk(t, still, 1.0, 2.0).integral < 1e-9
    assert retime_for_minimum_jerk(t, np.outer(t, [1.0, 0, 0]), 1.0, 1.005).integral == 0.0


def test_failed_search_keeps_recorded_timing(monkeypatch) -> None:
    def endless(*_args: object, **_options: object) -> None:
        raise RuntimeError("too many iterations")

    monkeypatch.setattr("pipeline.simulation.dancers.minimum_jerk_retiming.nnls", endless)
    t, p = reach(2, np.array([0.3, 0.4, 0]))
    best = retime_for_minimum_jerk(t, p, 0.0, 2.0)
    assert best.integral == best.danced == measure_jerk(t, p, 0.0, 2.0).integral


def test_rank_correlation_matches_scipy() -> None:
    rng = np.random.default_rng(6)
    for _ in range(20):
        a, b = rng.integers(0, 8, (2, 12)).astype(float)
        assert rank_correlation(a, b) == pytest.approx(stats.spearmanr(a, b)[0], abs=1e-12)


def test_paper_jerk_matches_library_dance() -> None:
    scene = read_scene("pronk: 1\nduration: 1\ncast: [{dancer: torso}]\n")
    dance = scene.dances["macarena"]
    assert len(dance.subtasks) == PAPER_SUBTASK_COUNT
    assert set(dance.durations) == set(PAPER_JERK)
    for name, column in PAPER_JERK.items():
        times = dance.durations[name]
        assert [time is None for time in times] == [jerk is None for jerk in column]
    assert sum(time or 0 for time in dance.durations["human"]) == pytest.approx(12.23)
