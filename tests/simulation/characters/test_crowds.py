"""Tests of people in crowds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.crossing import cross
from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.characters.crowd_avoidance import headway_share
from pipeline.simulation.characters.neighbours import find_neighbours, order_along_x
from pipeline.simulation.characters.person_record import PERSON
from pipeline.simulation.dynamics.record_array import zero_records
from tests.simulation.characters.scripted_people import STEPS, play_scene


def test_who_makes_way_goes_back_to_its_place() -> None:
    def squeeze(troupe: Characters, step: int) -> None:
        # Records are in the order of the names.
        walker = troupe.persons[0]
        walker.impatience = 1.0 if walker.at[0] < 0.3 else 0.0

    scene = """
duration: 7
cast:
  - {name: anna, character: adult, at: [-2, 0]}
  - {name: ben, character: adult, at: [0, 0.15], heading_deg: 90}
script:
  - {at: 0, who: anna, do: {go_to: [2.5, 0]}}
"""
    play = play_scene(scene, squeeze)
    assert play.when("anna")
    place = play.joint("ben", "pelvis")[:, [0, 2]]
    off = np.linalg.norm(place - place[0], axis=1)
    assert off.max() > 0.15
    assert off[-1] < 0.12


def test_who_arrives_ends_its_walk_before_it_makes_way() -> None:
    def press(troupe: Characters, step: int) -> None:
        troupe.persons[0].impatience = 1.0

    scene = """
duration: 4
cast:
  - {name: anna, character: adult, at: [-1, 0]}
  - {name: ben, character: adult, at: [0.1, 1.8], heading_deg: 90}
script:
  - {at: 0, who: anna, do: {speed: 0.05}}
  - {at: 0, who: anna, do: {go_to: [2.5, 0]}}
  - {at: 0, who: ben, do: {go_to: [0.1, 0.3]}}
"""
    play = play_scene(scene, press)
    arrived = round(play.when("ben")[0] * STEPS)
    gave_way = play.records["gave_way"][:, 1]
    assert not gave_way[:arrived].any()
    assert gave_way[arrived:].any()


@pytest.mark.parametrize(
    ("ahead", "aside", "fastest"),
    [(0.75, 0.0, 0.37), (1.3, 0.0, 0.89), (3.0, 0.0, 1.3), (0.75, 0.6, 1.3), (-0.75, 0.0, 1.3)],
)
def test_walkers_in_a_crowd_keep_a_headway_by_their_speed(
    ahead: float, aside: float, fastest: float
) -> None:
    persons = zero_records(2, PERSON)
    persons["height"] = 1.72
    persons["at"][1] = ahead, aside
    plain: Any = headway_share
    share = plain.py_func(persons, persons[0], np.array([1]), 1, 1.3, 0.0)
    assert 1.3 * share == pytest.approx(fastest, abs=0.01)


def test_neighbours_are_all_people_within_reach_from_near_to_far_on_each_side() -> None:
    persons = zero_records(30, PERSON)
    x = np.random.default_rng(4).uniform(-8.0, 8.0, 30)
    persons["at"][:, 0] = x
    ordered: Any = order_along_x
    neighbours: Any = find_neighbours
    order = ordered.py_func(persons)
    np.testing.assert_array_equal(order, np.argsort(x))
    found = np.zeros(30, dtype=np.int64)
    for n in range(30):
        near = found[: neighbours.py_func(persons, order, n, 2.5, found)]
        offset = x[near] - x[order[n]]
        assert set(near) == set(np.flatnonzero(np.abs(x - x[order[n]]) <= 2.5)) - {order[n]}
        for side in (offset[offset < 0.0], offset[offset > 0.0]):
            assert (np.diff(np.abs(side)) > 0.0).all()


@pytest.mark.nightly
@pytest.mark.parametrize("kind", ["head-on", "corner"])
def test_two_groups_cross_without_a_blow(kind: str) -> None:
    out = cross(kind, 25, 1)
    assert out.is_good, out.text()
