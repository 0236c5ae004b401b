"""Properties of all gaits, of any number of legs."""

from __future__ import annotations

import itertools
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.simulation.locomotion.gaits.gait import FlightBounce, Gait
from pipeline.simulation.locomotion.gaits.named_gaits import (
    LegRows,
    available_gaits,
    ripple,
    trot,
    wave,
)
from pipeline.simulation.spatial import Array
from pipeline.spec.walk import AUTO, LEG_REQUIREMENTS, GaitName

FINE = np.linspace(0.0, 1.0, 2001)
GROUNDED = {"walk", "amble", "tripod", "ripple"}
"""Named gaits whose diagrams have no flight."""


@st.composite
def sides(draw: st.DrawFn, least: int = 1, middle: bool = True) -> list[str]:
    """Draw the sides of 1 to 20 legs."""
    return draw(st.lists(st.sampled_from("lrm" if middle else "lr"), min_size=least, max_size=20))


@st.composite
def rows(draw: st.DrawFn, least: int = 1) -> LegRows:
    """Draw legs at random places, in random order."""
    sides_ = draw(sides(least))
    forward = draw(st.permutations(range(len(sides_))))
    return LegRows.of(sides_, [float(x) for x in forward])


def even(left: int, right: int) -> LegRows:
    """Return rows with legs opposite each other, numbered left first, front to back."""
    return LegRows(tuple(range(left)), tuple(range(left, left + right)))


def apart(a: Array | float, b: Array | float) -> Array:
    """Return the circular distance of phases."""
    result: Array = np.abs(np.mod(np.asarray(a) - b + 0.5, 1.0) - 0.5)
    return result


@given(rows())
def test_phases_lie_in_a_cycle_and_every_foot_swings_and_stands(legs: LegRows) -> None:
    for gait in available_gaits(legs).values():
        for phases in (gait.up, gait.down):
            assert phases.shape == (legs.count,)
            assert ((phases >= 0.0) & (phases < 1.0)).all()
        assert ((gait.swing > 0.0) & (gait.swing < 1.0)).all()


@given(rows())
def test_some_foot_is_down_at_every_phase_of_a_gait_without_flight(legs: LegRows) -> None:
    for name, gait in available_gaits(legs).items():
        grounded = (
            name in GROUNDED
            or (name == "trot" and legs.count > 1)
            or (name == "wave" and max(len(legs.left), len(legs.right)) > 1)
        )
        assert gait.standing(FINE).any(axis=-1).all() == grounded
        assert (len(gait.flights()) == 0) == grounded


@given(rows(least=2))
def test_neighbours_never_swing_together_in_a_trot(legs: LegRows) -> None:
    swinging = ~trot(legs).standing(FINE)
    for row in legs:
        for a, b in itertools.pairwise(row):
            assert not (swinging[:, a] & swinging[:, b]).any()


@pytest.mark.slow
@given(rows(least=2))
def test_wave_runs_from_back_to_front_without_swinging_neighbours(legs: LegRows) -> None:
    gait = wave(legs)
    for row in legs:
        lag = np.mod(np.diff(gait.up[list(row[::-1])]), 1.0)
        assert np.allclose(lag, lag[:1])
        assert (lag > gait.swing[list(row)].max(initial=0.0)).all()


@given(rows())
def test_each_row_of_a_wave_is_timed_by_its_own_legs(legs: LegRows) -> None:
    gait = wave(legs)
    for row in legs:
        alone = wave(LegRows(tuple(range(len(row))), ()))
        assert np.allclose(gait.up[list(row)], alone.up)
        assert np.allclose(gait.swing[list(row)], alone.swing)


@given(st.integers(1, 10))
def test_mirror_image_is_shifted_by_half_a_cycle_or_not_at_all(n: int) -> None:
    mirror = np.concatenate([np.arange(n, 2 * n), np.arange(n)])
    legs = even(n, n)
    for gait, lag in ((trot(legs), 0.5), (ripple(legs), 0.5), (wave(legs), 0.0)):
        assert apart(gait.up[mirror], gait.up + lag).max() < 1e-12
        assert apart(gait.down[mirror], gait.down + lag).max() < 1e-12


@pytest.mark.parametrize("name", ["walk", "amble", "pace"])
def test_symmetrical_gaits_mirror_after_half_a_cycle(name: str) -> None:
    gait = available_gaits(even(2, 2))[name]
    assert apart(gait.down[[2, 3, 0, 1]], gait.down + 0.5).max() < 1e-12


def test_trot_alternates_diagonals_of_two_four_and_six_legs() -> None:
    assert trot(even(1, 1)).up.tolist() == [0.0, 0.5]
    diagonal = trot(even(2, 2)).up
    assert diagonal[0] == diagonal[3] != diagonal[1] == diagonal[2]
    tripods = trot(even(3, 3)).up
    assert set(np.flatnonzero(tripods == tripods[0])) == {0, 2, 4}


def test_wave_is_a_bound_for_four_legs_and_a_hop_for_two() -> None:
    bound = wave(even(2, 2)).up
    assert bound[0] == bound[2] != bound[1] == bound[3]
    hop = wave(even(1, 1))
    assert hop.up[0] == hop.up[1]
    assert len(hop.flights()) == 1


def test_ripple_of_an_insect_lifts_one_foot_per_side() -> None:
    """Wilson 1966: of six legs, one of a side at a time."""
    swinging = ~ripple(even(3, 3)).standing(FINE)
    assert swinging[:, :3].sum(axis=1).max() == swinging[:, 3:].sum(axis=1).max() == 1


def test_middle_leg_alternates_with_its_neighbours() -> None:
    legs = LegRows.of(["l", "m", "r"], [-0.1, 0.2, -0.1])
    assert legs == LegRows((1, 0), (2,))
    gait = trot(legs)
    assert gait.up[0] == gait.up[2] != gait.up[1]


# --- Hildebrand ---------------------------------------------------------------------

L_FORE, L_HIND, R_FORE, R_HIND = range(4)


def quadruped(name: str) -> Gait:
    """Return a gait of four legs."""
    return available_gaits(even(2, 2))[name]


@pytest.mark.parametrize(
    ("name", "walks", "fore_after_hind"),
    [
        # Walking gaits have a foot down for more than half of the cycle, running ones for
        # less; classes of footfall are eighths of a cycle wide (Hildebrand 1965, 1976).
        ("walk", True, (0.1875, 0.3125)),
        ("amble", False, (0.1875, 0.3125)),
        ("pace", False, (-0.0625, 0.0625)),
        ("trot", True, (0.4375, 0.5625)),
    ],
)
def test_symmetrical_gaits_match_their_footfall_class(
    name: str, walks: bool, fore_after_hind: tuple[float, float]
) -> None:
    gait = quadruped(name)
    assert ((gait.duty > 0.5) == walks).all()
    for fore, hind in ((L_FORE, L_HIND), (R_FORE, R_HIND)):
        after = np.mod(gait.down[fore] - gait.down[hind] + 0.25, 1.0) - 0.25
        assert fore_after_hind[0] < after < fore_after_hind[1]


def test_walk_has_lateral_sequence_and_two_or_three_feet_down() -> None:
    gait = quadruped("walk")
    start = gait.down[L_HIND]
    order = np.argsort(np.mod(gait.down - start, 1.0))
    assert order.tolist() == [L_HIND, L_FORE, R_HIND, R_FORE]
    assert set(gait.standing(FINE).sum(axis=1)) == {2, 3}


@pytest.mark.parametrize(
    ("name", "order", "flights"),
    [
        ("canter", [[L_HIND], [R_HIND, L_FORE], [R_FORE]], 1),
        ("transverse gallop", [[L_HIND], [R_HIND], [L_FORE], [R_FORE]], 1),
        ("rotary gallop", [[L_HIND], [R_HIND], [R_FORE], [L_FORE]], 2),
        ("bound", [[L_HIND, R_HIND], [L_FORE, R_FORE]], 2),
        ("pace", [[L_FORE, L_HIND], [R_FORE, R_HIND]], 2),
    ],
)
def test_running_gaits_have_their_beats_and_flights(
    name: str, order: list[list[int]], flights: int
) -> None:
    gait = quadruped(name)
    beats = [sorted(np.flatnonzero(gait.down == moment)) for moment in np.unique(gait.down)]
    assert beats == [sorted(beat) for beat in order]
    assert gait.beats == len(order)
    assert len(gait.flights()) == flights
    assert (gait.duty < 0.5).all()


def test_bipeds_have_their_gaits() -> None:
    gaits = available_gaits(even(1, 1))
    assert {"walk", "run", "hop", "skip", "trot", "wave"} == set(gaits)
    assert [len(gaits[name].flights()) for name in ("walk", "run", "hop", "skip")] == [0, 2, 1, 1]
    assert set(available_gaits(even(0, 1))) == {"trot", "wave", "hop"}


def test_every_special_gait_has_leg_requirements() -> None:
    found = {name for n in range(10) for m in (n, n + 1) for name in available_gaits(even(n, m))}
    assert found | {AUTO} == {*LEG_REQUIREMENTS, "trot", "wave", AUTO} == set(get_args(GaitName))


# --- duty and flights ---------------------------------------------------------------


@given(rows(), st.floats(0.05, 0.95))
def test_duty_keeps_the_middle_of_each_swing(legs: LegRows, duty: float) -> None:
    for gait in available_gaits(legs).values():
        changed = gait.with_duty(duty)
        assert np.allclose(changed.duty, duty)
        middles = (one.up + 0.5 * one.swing for one in (gait, changed))
        assert apart(*middles).max() < 1e-9


@given(rows(), st.floats(0.05, 0.95))
def test_flights_are_the_times_without_a_foot_down(legs: LegRows, duty: float) -> None:
    gait = trot(legs).with_duty(duty)
    flights = gait.flights()
    for start, length in flights:
        inside = start + length * np.linspace(0.01, 0.99, 50)
        assert not gait.standing(inside).any()
    free = ~gait.standing(FINE[:-1]).any(axis=-1)
    assert abs(flights[:, 1].sum() - free.mean()) < 0.005


@given(rows(), st.floats(0.05, 0.4))
def test_bounce_is_free_fall_in_flight_with_continuous_speed(legs: LegRows, duty: float) -> None:
    for gait in available_gaits(legs).values():
        bounce = FlightBounce.of(gait.with_duty(duty))
        if bounce is None:
            continue
        for start, length in bounce.flights:
            s = start + length * np.linspace(0.1, 0.9, 9)
            heights = bounce.height(s)
            assert np.allclose(np.diff(heights, 2) / (0.1 * length) ** 2, -1.0, atol=1e-5)
            assert (heights > 0.0).all()
            for edge in (start, start + length):
                before, at, after = bounce.height(edge + np.array([-1e-6, 0.0, 1e-6]))
                assert abs((after - at) - (at - before)) < 1e-9
        # The amplitude is half of the rise, within the sampling.
        assert np.abs(bounce.beat(FINE)).max() < 2.0 + 1e-3


def test_only_gaits_with_flights_bounce() -> None:
    assert FlightBounce.of(quadruped("walk")) is None
    assert FlightBounce.of(quadruped("pace")) is not None
