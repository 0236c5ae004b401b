"""Approach: the potential field by closed forms, and ways around obstacles."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.simulation.characters.behaviours.approach import LEAST, REPELS, Way, walk_vector
from tests.simulation.characters.minded import layout, simulation, steps, troupe

EMPTY = np.zeros((0, 2)), np.zeros(0), np.zeros(0)


def test_without_obstacles_it_goes_straight_and_no_faster_than_its_pace() -> None:
    for to in ([3.0, 4.0], [30.0, 40.0], [0.3, 0.4]):
        w = walk_vector(np.array(to), *EMPTY, 1.5)
        np.testing.assert_allclose(w, np.array([0.9, 1.2]), rtol=1e-12)
    assert math.hypot(*walk_vector(np.array([0.03, 0.0]), *EMPTY, 1.5)) == pytest.approx(0.15)
    assert not walk_vector(np.zeros(2), *EMPTY, 1.5).any()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_an_obstacle_ahead_pushes_back_and_round(sense: float) -> None:
    to, away = np.array([5.0, 0.0]), np.array([[-1.0, 0.0]])
    for gap in (0.05, 0.5, 1.0):
        w = walk_vector(to, away, np.array([gap]), np.array([sense]), 1.0)
        push = REPELS / max(gap, LEAST)
        np.testing.assert_allclose(w, [1.0 - push, -sense * push], rtol=1e-12)


def test_what_lies_behind_does_not_push() -> None:
    to, away = np.array([5.0, 0.0]), np.array([[1.0, 0.0]])
    w = walk_vector(to, away, np.array([0.2]), np.array([1.0]), 1.0)
    np.testing.assert_allclose(w, [1.0, 0.0])


def test_who_gets_no_farther_tries_one_way_and_then_the_other() -> None:
    way = Way()
    forced = []
    for k in range(200):
        way.note(3.0, 0.1 * k)
        if 0.1 * k < way.until and (not forced or way.forced != forced[-1]):
            forced.append(way.forced)
    assert forced[:3] == [1.0, -1.0, 1.0]


COUNTS = [
    pytest.param(range(12), marks=pytest.mark.nightly),
    pytest.param(range(200), marks=pytest.mark.nightly),
]


@pytest.mark.xfail(strict=True, reason="two in five do not arrive within 24 s")
@pytest.mark.parametrize("seeds", COUNTS)
def test_it_finds_its_way_around_obstacles(seeds: range) -> None:
    failed = []
    for seed in seeds:
        made = simulation(layout(seed), 24, f"seed: {seed}\nsteps: 1\nsamples: 1")
        characters = troupe(made)
        minds = characters.minds
        assert minds is not None
        for _ in steps(made):
            if minds.minds[0].gap(1) < 0.45:
                break
        else:
            failed.append((seed, characters.persons[0].at.tolist()))
        places = characters.crowd.p[:, [0, 2]]
        assert np.abs(places).max() < 12.0
    assert len(failed) <= 0.03 * len(seeds), f"these do not arrive: {failed}"
