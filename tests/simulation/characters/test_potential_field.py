"""Potential field by closed forms, and routes around obstacles."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.simulation.characters import visibility_route
from pipeline.simulation.characters.behaviours.potential_field import (
    BALANCE_GAP,
    MIN_GAP,
    walk_vector,
)
from pipeline.simulation.characters.mind.detour_state import DetourState
from pipeline.simulation.characters.visibility_route import (
    CLEARANCES,
    RING_PLACES,
    Route,
    are_free,
    shortest_way,
)
from pipeline.simulation.spatial import Array
from tests.simulation.characters.mind_scenes import obstacle_course, simulation, steps, troupe

pytestmark = pytest.mark.slow

EMPTY = np.zeros((0, 2)), np.zeros(0), np.zeros(0)


def velocity(to: list[float], away: Array, gaps: Array, senses: Array, pace: float) -> Array:
    return np.array(walk_vector(to[0], to[1], away, gaps, senses, pace))


def test_without_obstacles_a_walk_is_straight_and_limited_to_its_pace() -> None:
    for to in ([3.0, 4.0], [30.0, 40.0], [0.3, 0.4]):
        w = velocity(to, *EMPTY, 1.5)
        np.testing.assert_allclose(w, np.array([0.9, 1.2]), rtol=1e-12)
    assert math.hypot(*velocity([0.03, 0.0], *EMPTY, 1.5)) == pytest.approx(0.15)
    assert not velocity([0.0, 0.0], *EMPTY, 1.5).any()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_an_obstacle_ahead_pushes_back_and_aside(sense: float) -> None:
    away = np.array([[-1.0, 0.0]])
    for gap in (0.05, 0.5, 1.0):
        w = velocity([5.0, 0.0], away, np.array([gap]), np.array([sense]), 1.0)
        push = BALANCE_GAP / max(gap, MIN_GAP)
        np.testing.assert_allclose(w, [1.0 - push, -sense * push], rtol=1e-12)


def test_obstacles_behind_do_not_push() -> None:
    away = np.array([[1.0, 0.0]])
    w = velocity([5.0, 0.0], away, np.array([0.2]), np.array([1.0]), 1.0)
    np.testing.assert_allclose(w, [1.0, 0.0])


def test_a_stalled_walk_tries_both_sides() -> None:
    path = DetourState()
    forced = []
    for k in range(200):
        path.update_progress(3.0, 0.1 * k)
        if 0.1 * k < path.forced_until and (not forced or path.forced != forced[-1]):
            forced.append(path.forced)
    assert forced[:3] == [1.0, -1.0, 1.0]


WIDE = np.array([[-20.0, -20.0], [20.0, 20.0]])


def length_of(path: np.ndarray, start: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(np.vstack([start, path]), axis=0), axis=1).sum())


def test_an_enclosed_goal_is_found_so_from_within(monkeypatch: pytest.MonkeyPatch) -> None:
    # A ring of circles about the goal, and a field of others, which need not be searched.
    angles = np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False)
    ring = 1.5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    field = np.stack(np.meshgrid(*2 * [np.arange(3.0, 16.0, 2.0)]), axis=-1).reshape(-1, 2)
    middles = np.concatenate([ring, field])
    reaches = np.full(len(middles), 0.45)
    searched = []

    def count(start: Array, *rest: Array) -> Array:
        searched.append(start)
        return np.asarray(are_free(start, *rest))

    monkeypatch.setattr(visibility_route, "are_free", count)
    start, goal = np.array([14.0, 4.0]), np.zeros(2)
    assert len(shortest_way(start, goal, middles, reaches, WIDE)) == 0
    assert len(searched) < RING_PLACES * len(ring)
    # A gap in the ring is found.
    way = shortest_way(start, goal, middles[1:], reaches[1:], WIDE)
    assert way[-1].tolist() == goal.tolist()


def test_lines_are_free_outside_all_circles() -> None:
    start, ends = np.zeros(2), np.array([[4.0, 0.0], [1.2, 0.0], [0.0, 4.0], [4.0, 4.0]])
    middles, reaches = np.array([[2.0, 0.0], [2.0, 3.0]]), np.array([0.9, 0.8])
    np.testing.assert_array_equal(
        are_free(start, ends, middles, reaches), [False, False, True, False]
    )
    assert are_free(start, ends, middles, 0.5 * reaches).tolist() == [False, True, True, True]


def test_a_route_around_a_circle_is_nearly_the_shortest() -> None:
    start, goal, radius = np.array([-3.0, 0.0]), np.array([3.0, 0.0]), 1.0
    path = shortest_way(start, goal, np.zeros((1, 2)), np.array([radius]), WIDE)
    np.testing.assert_array_equal(path[-1], goal)
    thread = 2.0 * math.sqrt(9.0 - 1.0) + (math.pi - 2.0 * math.acos(1.0 / 3.0))
    assert thread < length_of(path, start) < 1.03 * thread
    for a, b in zip(np.vstack([start, path]), path, strict=False):
        along = a + np.linspace(0.0, 1.0, 200)[:, None] * (b - a)
        assert np.hypot(*along.T).min() > radius - 1e-6


@pytest.mark.parametrize("seed", range(20))
def test_routes_are_free_and_no_shorter_than_a_straight_line(seed: int) -> None:
    rng = np.random.Generator(np.random.PCG64(seed))
    start, goal = np.array([-4.0, 0.0]), np.array([4.0, 0.0])
    middles, reaches = rng.uniform(-3.0, 3.0, (6, 2)), rng.uniform(0.2, 0.9, 6)
    path = shortest_way(start, goal, middles, reaches, WIDE)
    assert 0 < len(path) <= 6 * RING_PLACES + 1
    assert length_of(path, start) >= 8.0 - 1e-9
    for a, b in zip(np.vstack([start, path]), path, strict=False):
        assert are_free(a, b[None], middles, reaches)[0]


def test_narrow_gaps_are_used_only_without_wider_ones() -> None:
    start, goal = np.array([-3.0, 0.0]), np.array([3.0, 0.0])
    wall = np.stack([np.zeros(41), np.linspace(-20.0, 20.0, 41)], axis=1)
    assert len(shortest_way(start, goal, wall, np.full(41, 0.6), WIDE)) == 0
    # A gap of 2 x 0.1 m at z = 4 is the widest.
    reaches = np.full(41, 0.6)
    reaches[[24]] = 0.0
    reaches[[23, 25]] = 0.9
    place, length = Route().next(start, goal, wall[reaches > 0], reaches[reaches > 0], WIDE)
    assert 0.1 < CLEARANCES[1]
    assert length > 9.9
    assert place[1] > 1.0


def test_a_route_is_kept_until_something_moves() -> None:
    route, goal = Route(), np.array([3.0, 0.02])
    middles, reaches = np.zeros((1, 2)), np.array([0.5])
    first, _ = route.next(np.array([-3.0, 0.0]), goal, middles, reaches, WIDE)
    # The other side is as good now, but the route is kept.
    again, _ = route.next(np.array([-2.9, -0.05]), goal, middles, reaches, WIDE)
    np.testing.assert_array_equal(first, again)
    moved, length = route.next(np.array([-2.9, 0.0]), goal, middles + 9.0, reaches, WIDE)
    np.testing.assert_array_equal(moved, goal)
    assert length == pytest.approx(5.9, abs=1e-3)


COUNTS = [
    pytest.param(range(3), id="3"),
    pytest.param(range(20), marks=pytest.mark.nightly, id="20"),
    pytest.param(range(200), marks=pytest.mark.nightly, id="200"),
]


@pytest.mark.nightly
@pytest.mark.parametrize("seeds", COUNTS)
def test_random_obstacle_courses_are_solved(seeds: range) -> None:
    failed = []
    for seed in seeds:
        made = simulation(obstacle_course(seed), 24, f"seed: {seed}\nsteps: 1\nrows_per_frame: 1")
        characters = troupe(made)
        minds = characters.minds
        assert minds is not None
        goal = characters.dispatcher.view.number("goal")
        for _ in steps(made):
            if minds.minds[0].gap(goal) < 0.45:
                break
        else:
            failed.append((seed, characters.persons[0].at.tolist()))
        places = characters.arrays.p[:, [0, 2]]
        assert np.abs(places).max() < 12.0
    assert len(failed) <= 0.03 * len(seeds), f"these do not arrive: {failed}"


def test_one_that_is_pushed_past_a_place_on_its_way_does_not_go_back_to_it() -> None:
    middles, reaches = np.array([[0.0, 0.0]]), np.array([0.8])
    route, goal = Route(), np.array([3.0, 0.02])
    first, _ = route.next(np.array([-3.0, 0.0]), goal, middles, reaches, WIDE)
    assert len(route.places) > 1
    side = math.copysign(1.0, first[1])
    # Still before the circle, which bars the straight way from here, but past the first place.
    at = np.array([first[0] + 0.5, side * 0.9])
    second = route.places[1].copy()
    place, _ = route.next(at, goal, middles, reaches, WIDE)
    assert place[0] > at[0]
    np.testing.assert_allclose(place, second)
