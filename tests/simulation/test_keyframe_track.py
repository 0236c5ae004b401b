"""Keyframe tracks: interpolation, eases, cycles and blending."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.simulation.keyframe_track import (
    BlendedTrack,
    CyclicTrack,
    Track,
    rotation_from_angles,
)
from pipeline.simulation.spatial import heading
from pipeline.spec.keyframes import Ease

EASES: tuple[Ease, ...] = ("spline", "linear", "in", "out", "in-out")
"""Those that never jump."""

KEYS = st.lists(
    st.tuples(st.floats(0.05, 3.0), st.floats(-5, 5), st.sampled_from(EASES)),
    min_size=1,
    max_size=7,
)


def track_of(keys: list[tuple[float, float, Ease]]) -> Track:
    times = np.cumsum([gap for gap, _, _ in keys])
    return Track.of([(float(t), (v,), e) for t, (_, v, e) in zip(times, keys, strict=True)])


@given(KEYS)
def test_a_track_passes_through_every_key(keys: list[tuple[float, float, Ease]]) -> None:
    track = track_of(keys)
    np.testing.assert_allclose(track(track.times), track.values, atol=1e-12)


@given(KEYS)
def test_a_track_is_constant_beyond_its_ends(keys: list[tuple[float, float, Ease]]) -> None:
    track = track_of(keys)
    ends = track(np.array([track.times[0] - 1.0, track.times[-1] + 1.0]))
    np.testing.assert_allclose(ends, track.values[[0, -1]], atol=1e-12)


@given(KEYS)
def test_a_track_is_continuous(keys: list[tuple[float, float, Ease]]) -> None:
    track = track_of(keys)
    step = 1e-6
    before, after = track(track.times - step), track(track.times + step)
    # No ease is faster than three times the mean speed, no spline by far.
    fastest = np.abs(np.diff(track.values[:, 0]) / np.diff(track.times)).max(initial=0.0)
    assert np.abs(after - before).max() <= 20 * step * max(fastest, 1.0)


def test_a_spline_passes_its_keys_at_speed() -> None:
    track = Track.of([(t, (t * t,), "spline") for t in (0.0, 0.7, 1.0, 2.5, 3.0)])
    inner = track.times[1:-1]
    step = 1e-5
    left = (track(inner) - track(inner - step)) / step
    right = (track(inner + step) - track(inner)) / step
    np.testing.assert_allclose(left, right, atol=1e-3)
    # The parabola through three keys of a parabola has its speed.
    np.testing.assert_allclose(left[:, 0], 2 * inner, atol=1e-3)


@pytest.mark.parametrize(("kind", "start", "end"), [("in", 0, 1), ("out", 1, 0), ("in-out", 0, 0)])
def test_eases_have_zero_speed_at_rest(kind: Ease, start: int, end: int) -> None:
    track = Track.of([(0.0, (0.0,), kind), (1.0, (1.0,), kind)])
    step = 1e-6
    speeds = np.diff(track(np.array([0.0, step, 1.0 - step, 1.0]))[:, 0])[[0, 2]] / step
    assert (speeds > 0.5).tolist() == [bool(start), bool(end)]
    values = track(np.linspace(0.0, 1.0, 100))[:, 0]
    assert (np.diff(values) > 0.0).all()


def test_hold_jumps_at_its_key() -> None:
    track = Track.of([(0.0, (1.0,), "linear"), (1.0, (4.0,), "hold"), (2.0, (4.0,), "hold")])
    values = track(np.array([0.0, 0.5, 1.0 - 1e-9, 1.0, 2.0, 3.0]))[:, 0]
    np.testing.assert_array_equal(values, [1.0, 1.0, 1.0, 4.0, 4.0, 4.0])


def test_a_spline_has_its_given_tangents() -> None:
    keys = [(t, (t * t,), "spline") for t in (0.0, 1.0, 1.5)]
    track = Track.of(keys, [(2.0,), None, (-3.0,)])  # type: ignore[arg-type]
    step = 1e-6
    found = (
        track(np.array([step, 1 + step, 1.5])) - track(np.array([0.0, 1.0, 1.5 - step]))
    ) / step
    # The one between is found as if nothing were given.
    np.testing.assert_allclose(found[:, 0], [2.0, 2.0, -3.0], atol=1e-4)


def test_a_cycle_is_smooth_at_its_ends() -> None:
    keys = [(t, (math.sin(math.pi * t), 90 * t), "spline") for t in (0.5, 0.9, 1.4, 2.0, 2.5)]
    turns = [(t, (a, 360 * (t - 0.5) / 2), e) for t, (a, _), e in keys]
    track = Track.of(turns)  # type: ignore[arg-type]
    cycle = CyclicTrack.of(track, 0.5, 2.0)
    times = np.linspace(0.5, 2.4, 77)
    for n in (1, 5):
        later = cycle(times + 2.0 * n)
        np.testing.assert_allclose(later, cycle(times), atol=1e-6)
    step = 1e-6
    slope = [cycle(np.array([t, t + step]))[:, 0] @ [-1, 1] / step for t in (2.5 - 2 * step, 2.5)]
    assert slope[0] == pytest.approx(slope[1], abs=1e-3)
    # Whole turns continue at the same rate.
    rate = np.diff(np.unwrap(cycle(np.linspace(0.5, 6.5, 601))[:, 1], period=360.0)) / 0.01
    np.testing.assert_allclose(rate, 180.0, rtol=1e-6)


def test_a_blended_track_fades_in_and_out() -> None:
    track = Track.of([(1.0, (0.0,), "spline")])
    run = BlendedTrack(track, (0.5, 1.0), (2.0, 2.5))
    weights = run.weight(np.array([0.0, 0.5, 0.75, 1.0, 1.9, 2.0, 2.25, 2.5, 9.0]))
    np.testing.assert_allclose(weights, [0, 0, 0.5, 1, 1, 1, 0.5, 0, 0], atol=1e-12)
    at_once = BlendedTrack(track, (0.0, 0.0)).weight(np.array([0.0, 1.0]))
    np.testing.assert_array_equal(at_once, [1.0, 1.0])


def test_the_vertical_rotation_is_applied_last() -> None:
    angle = np.radians([20.0, 70.0, -30.0])
    tilted = rotation_from_angles(angle * [1, 0, 1])
    np.testing.assert_allclose(rotation_from_angles(angle), heading(angle[1]) @ tilted, atol=1e-15)
    np.testing.assert_allclose(
        rotation_from_angles(np.array([0, angle[1], 0])), heading(angle[1]), atol=1e-15
    )
