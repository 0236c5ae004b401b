"""Gait transitions: every foot keeps lifting and landing in turn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.gait_transition import (
    MAX_EASE_SLOPE,
    MIN_CLOCK_RATE,
    GaitTransition,
    shortest_transition,
)
from pipeline.simulation.locomotion.gaits.named_gaits import LegRows, available_gaits
from pipeline.simulation.spatial import Array

FOUR = available_gaits(LegRows((0, 1), (2, 3)))
PAIRS = [(a, b) for a in FOUR for b in FOUR]


@st.composite
def changes(draw: st.DrawFn) -> GaitTransition:
    """Draw two gaits of the same legs and a transition of at least the shortest length."""
    n = draw(st.integers(1, 8))
    phase = st.floats(0.0, 1.0, exclude_max=True)
    swing = st.floats(0.02, 0.98)

    def gait() -> Gait:
        up = np.array(draw(st.lists(phase, min_size=n, max_size=n)))
        length = np.array(draw(st.lists(swing, min_size=n, max_size=n)))
        return Gait(up, np.mod(up + length, 1.0))

    before, after = gait(), gait()
    length = shortest_transition(before, after) * draw(st.floats(1.0, 5.0))
    return GaitTransition(before, after, draw(st.floats(0.0, 50.0)), length)


def course(
    change: Gait | GaitTransition, start: float, end: float
) -> list[list[tuple[float, float]]]:
    """Return the lift-off and touchdown cycles of each foot from `start` to `end`."""
    legs: list[list[tuple[float, float]]] = [[] for _ in change_legs(change)]
    phase = np.full(len(legs), start)
    while (phase < end).any():
        for leg in range(len(legs)):
            up = change.next_up(float(phase[leg]))
            down = change.down_after(up)
            legs[leg].append((float(up[leg]), float(down[leg])))
            phase[leg] = down[leg]
    return legs


def change_legs(change: Gait | GaitTransition) -> Array:
    return change.up if isinstance(change, Gait) else change.before.up


@given(changes())
def test_leg_clocks_always_advance(change: GaitTransition) -> None:
    phases = np.linspace(change.start - 1.0, change.end + 1.0, 400)
    speed = np.diff(change.leg_phase(phases), axis=0) / np.diff(phases)[:, None]
    assert speed.min() > MIN_CLOCK_RATE - 1e-6
    assert speed.max() < 2.0 - MIN_CLOCK_RATE + 1e-6


@pytest.mark.nightly
@settings(max_examples=30)
@given(changes())
def test_feet_lift_and_land_once_per_leg_cycle(change: GaitTransition) -> None:
    for leg, steps in enumerate(course(change, change.start - 2.0, change.end + 2.0)):
        moments = np.array(steps).ravel()
        assert (np.diff(moments) > 0.0).all()
        clock = change.leg_phase(moments[::2])[:, leg]
        # Consecutive whole numbers: no contact is skipped or doubled.
        assert np.allclose(np.diff(clock), 1.0, atol=1e-9)
        assert np.allclose(clock, np.round(clock), atol=1e-9)


@pytest.mark.nightly
@settings(max_examples=30)
@given(changes())
def test_transition_starts_and_ends_with_the_two_gaits(change: GaitTransition) -> None:
    steps = course(change, change.start - 3.0, change.end + 3.0)
    for leg, (before, after) in enumerate(
        zip(
            course(change.before, change.start - 3.0, change.start),
            course(change.after, change.end + 1.0, change.end + 3.0),
            strict=True,
        )
    ):
        early = [pair for pair in before if pair[1] < change.start - 1e-6]
        assert np.allclose(steps[leg][: len(early)], early, atol=1e-9)
        found = np.array([pair for pair in steps[leg] if pair[0] >= change.end])
        wanted = np.array([pair for pair in after if change.end + 1.0 < pair[0] < change.end + 2.0])
        assert len(wanted) in (0, 1)
        for pair in wanted:
            assert np.abs(found - pair).max(axis=1).min() < 1e-8
    assert change.at(change.start) is change.before
    assert change.at(change.end) is change.after


@pytest.mark.slow
@settings(max_examples=30)
@given(changes())
def test_blended_gait_is_continuous(change: GaitTransition) -> None:
    phases = np.linspace(change.start - 0.1, change.end + 0.1, 500)
    up = np.stack([change.at(float(phase)).up for phase in phases])
    swing = np.stack([change.at(float(phase)).swing for phase in phases])
    step = np.abs(np.mod(np.diff(up, axis=0) + 0.5, 1.0) - 0.5)
    # The steepest slope of `ease` over the shortest transition.
    each = (phases[1] - phases[0]) / change.length * 1.88
    assert step.max() <= 0.5 * each
    assert np.abs(np.diff(swing, axis=0)).max() <= each


@given(changes())
def test_legs_shift_the_shorter_way_round(change: GaitTransition) -> None:
    assert np.abs(change.shift).max() <= 0.5
    off = np.mod(change.before.up + change.shift - change.after.up + 0.5, 1.0) - 0.5
    assert np.abs(off).max() < 1e-12


@pytest.mark.sample(20)
@pytest.mark.slow
@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_swing_durations_stay_bounded_between_named_gaits(first: str, second: str) -> None:
    change = GaitTransition(FOUR[first], FOUR[second], 3.0, 3.0)
    quick = 0.5 * MAX_EASE_SLOPE / 3.0
    swings = np.concatenate([change.before.swing, change.after.swing])
    for steps in course(change, 0.0, 8.0):
        found = np.array([down - up for up, down in steps])
        assert found.min() >= swings.min() / (1.0 + quick) - 1e-9
        assert found.max() <= swings.max() / (1.0 - quick) + 1e-9


def test_transition_to_the_same_gait_changes_nothing() -> None:
    change = GaitTransition(FOUR["walk"], FOUR["walk"], 1.3, 1.0)
    both = zip(course(change, 0.0, 5.0), course(FOUR["walk"], 0.0, 5.0), strict=True)
    assert all(np.allclose(a, b, atol=1e-9) for a, b in both)


def test_too_short_transitions_are_refused() -> None:
    with pytest.raises(ValueError, match=r"take .* or more"):
        GaitTransition(FOUR["trot"], FOUR["pace"], 0.0, 0.3)
    with pytest.raises(ValueError, match="4 legs to one of 2 legs"):
        GaitTransition(FOUR["trot"], available_gaits(LegRows((0,), (1,)))["walk"], 0.0, 3.0)
