"""Tests of people in crowds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from benchmarks.crossing import Watch, cross, scene_text
from pipeline.simulation.characters import (
    arm_clearance,
    half_planes,
    headway,
    passage_lanes,
    right_of_way,
)
from pipeline.simulation.characters.body_arrays import RecordArray
from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.characters.crowd_avoidance import (
    CALMING_RATE,
    LATENESS_RATE,
    LOOK_INTERVAL,
    THRONG_SIDESTEP,
    _squeeze,
)
from pipeline.simulation.characters.headway import headway_share, passing_share
from pipeline.simulation.characters.neighbours import (
    find_neighbours,
    find_within,
    insert_nearest,
    order_along_x,
    places_in_order,
)
from pipeline.simulation.characters.pelvis_motion import LATE_GAIN
from pipeline.simulation.characters.person_record import PERSON
from pipeline.simulation.characters.right_of_way import (
    hold_up_one_another,
    lag_at_crossing,
    lag_at_passage,
)
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.spatial import Array
from pipeline.spec import read_scene
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


def test_walkers_look_at_others_in_turns() -> None:
    cast = ", ".join(
        f"{{name: p{k}, character: adult, at: [{1.2 * k}, 0], heading_deg: 90}}" for k in range(8)
    )
    script = "".join(
        f"  - {{at: 0, who: p{k}, do: {{go_to: [{1.2 * k}, -4]}}}}\n" for k in range(8)
    )
    looked = play_scene(f"duration: 0.5\ncast: [{cast}]\nscript:\n{script}").records["looked"]
    assert ((looked == 0).sum(axis=1) == 8 // LOOK_INTERVAL).all()
    assert ((looked == 0).sum(axis=0) >= len(looked) // LOOK_INTERVAL).all()


@pytest.mark.parametrize(
    ("ahead", "aside", "fastest"),
    [(0.75, 0.0, 0.37), (1.3, 0.0, 0.89), (3.0, 0.0, 1.3), (0.75, 0.6, 1.3), (-0.75, 0.0, 1.3)],
)
def test_walkers_in_a_crowd_keep_a_headway_by_their_speed(
    ahead: float, aside: float, fastest: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    persons = zero_records(2, PERSON)
    persons["height"] = 1.72
    persons["at"][1] = ahead, aside
    assert speed_behind(persons, monkeypatch) == pytest.approx(fastest, abs=0.01)


def speed_behind(persons: RecordArray, monkeypatch: pytest.MonkeyPatch) -> float:
    """Return how fast the first of two people goes along x behind the second [m/s]."""
    for rule in ("share_lane", "goes_before"):
        plain: Any = getattr(passage_lanes, rule)
        monkeypatch.setattr(headway, rule, plain.py_func)
    monkeypatch.setattr(passage_lanes, "hypotenuse", math.hypot)
    share: Any = headway_share
    return 1.3 * float(share.py_func(persons, persons[0], np.array([1]), 1, 1.3, 0.0))


@pytest.mark.parametrize(
    ("ahead", "aside", "fastest"),
    # Closer behind others, and behind those who are half abreast as well.
    [(0.75, 0.0, 0.57), (0.75, 0.37, 0.68), (0.75, 0.5, 1.3), (-0.2, 0.0, 1.3)],
)
def test_walkers_in_one_lane_of_an_opening_close_up_in_files(
    ahead: float, aside: float, fastest: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    persons = zero_records(2, PERSON)
    persons["height"] = 1.72
    persons["lane_right"][:, 1] = 1.0
    persons["at"][1] = ahead, aside
    persons["way_to_lane"] = 1.0, 1.0 - ahead
    assert speed_behind(persons, monkeypatch) == pytest.approx(fastest, abs=0.01)


def test_of_two_who_come_together_before_an_opening_the_nearer_goes_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    persons = zero_records(2, PERSON)
    persons["height"] = 1.72
    persons["lane_right"][:, 1] = 1.0
    persons["at"][1] = 0.4, 0.2
    persons["way_to_lane"] = 0.8, 0.5
    assert speed_behind(persons, monkeypatch) < 0.2
    persons["way_to_lane"] = 0.5, 0.8
    assert speed_behind(persons, monkeypatch) == 1.3
    # Abreast none is the nearer, whatever the last bits say.
    persons["way_to_lane"] = 0.8 - 1e-12, 0.8
    assert speed_behind(persons, monkeypatch) < 0.2
    # Nor does the way to another opening count.
    persons["way_to_lane"] = 0.5, 0.8
    persons["lane_middle"][1] = 5.0, 0.0
    assert speed_behind(persons, monkeypatch) < 0.2
    persons["lane_middle"] = 0.0
    # Who comes the other way is no part of the lane.
    persons["lane_right"][1, 1] = -1.0
    assert speed_behind(persons, monkeypatch) < 0.2


def test_far_from_an_opening_only_those_who_walk_alike_share_a_lane(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(passage_lanes, "hypotenuse", math.hypot)
    plain: Any = passage_lanes.share_lane
    two = zero_records(2, PERSON)
    two["lane_right"][:, 1], two["way_to_lane"] = 1.0, 6.0
    two["velocity"] = [[1.0, 0.5], [1.0, 0.2]]
    assert plain.py_func(two[0], two[1])
    two["velocity"][1] = 0.0, 1.0
    assert not plain.py_func(two[0], two[1])
    two["way_to_lane"] = 3.0
    assert plain.py_func(two[0], two[1])
    two["lane_right"][1] = 0.0
    assert not plain.py_func(two[0], two[1])


def test_who_is_held_up_grows_late_and_calms_down_again() -> None:
    person: Any = zero_records(1, PERSON)[0]
    squeeze: Any = _squeeze
    # It stands, held up by others whom it cannot squeeze past.
    person.impatience, person.held_up = 1.0, 1.0
    for _ in range(round(1.0 / LATENESS_RATE) + 1):
        squeeze.py_func(person, 0.01, 1.3, 0.0)
    assert person.lateness == 1.0
    person.velocity[0], person.held_up = 1.3, 0.0
    for _ in range(round(1.0 / CALMING_RATE) + 1):
        squeeze.py_func(person, 0.01, 1.3, 0.0)
    assert person.lateness == 0.0


@pytest.mark.parametrize(
    ("impatience", "share", "in_throng"), [(0.2, 2.0, True), (0.2, 0.5, False), (-0.3, 2.0, False)]
)
def test_who_waits_for_others_is_in_a_throng_and_who_waits_before_a_thing_is_not(
    impatience: float, share: float, in_throng: bool
) -> None:
    person: Any = zero_records(1, PERSON)[0]
    person.impatience, person.held_up = impatience, share * THRONG_SIDESTEP * 1.3
    squeeze: Any = _squeeze
    squeeze.py_func(person, 0.01, 1.3, 0.0)
    assert person.in_throng == in_throng


def test_who_is_late_walks_faster() -> None:
    scene = """
duration: 5
cast:
  - {name: anna, character: adult, at: [0, 0]}
  - {name: ben, character: adult, at: [0, 4]}
script:
  - {at: 0, who: anna, do: {go_to: [14, 0]}}
  - {at: 0, who: ben, do: {go_to: [14, 4]}}
"""

    def delay(troupe: Characters, step: int) -> None:
        troupe.persons[0].lateness = 1.0

    play = play_scene(scene, delay)
    late, other = (np.ptp(play.joint(who, "pelvis")[-2 * STEPS :, 0]) for who in ("anna", "ben"))
    assert late / other == pytest.approx(1.0 + LATE_GAIN, abs=0.03)


@pytest.mark.parametrize("turn", [0.0, 0.8, -2.0])
def test_walkers_in_a_crowd_brake_rather_than_step_aside(
    turn: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nearest_on_line(
        lines: Array, room: Array, walls: int, count: int, limit: float, *wanted: float
    ) -> Array:
        point, direction = lines[0, :2], lines[0, 2:]
        nearest: Array = point + direction * float(direction @ (np.array(wanted) - point))
        return nearest

    monkeypatch.setattr(half_planes, "allowed_velocity", nearest_on_line)
    c, s = np.cos(turn), np.sin(turn)
    to_world, point, direction = np.array([[c, -s], [s, c]]), np.array([0.7, 0.0]), [0.6, 0.8]
    lines = np.tile(np.concatenate([to_world @ point, to_world @ direction]), (2, 1))
    plain: Any = half_planes.velocity_by_braking
    velocity = np.array(plain.py_func(lines, lines, 0, 1, 1.4, 2.0, 1.2 * c, 1.2 * s)) @ to_world
    off = velocity - point
    assert direction[0] * off[1] - direction[1] * off[0] == pytest.approx(0.0, abs=1e-12)
    # The least of what it costs to brake and to step aside, on the edge of what is allowed.
    along, across = velocity - [1.2, 0.0]
    assert along * direction[0] + 2.0**2 * across * direction[1] == pytest.approx(0.0, abs=1e-12)


def test_the_nearest_people_are_kept_whatever_the_order() -> None:
    far = np.random.default_rng(2).permutation(30).astype(float)
    plain: Any = insert_nearest
    squares, nearest, count = np.zeros(8), np.zeros(8, dtype=np.int64), 0
    for number, square in enumerate(far):
        count = plain.py_func(squares, nearest, count, square, number)
    assert count == 8
    np.testing.assert_array_equal(nearest, np.argsort(far)[:8])


def test_neighbours_are_all_people_within_reach_from_near_to_far_on_each_side() -> None:
    persons = zero_records(30, PERSON)
    x = np.random.default_rng(4).uniform(-8.0, 8.0, 30)
    persons["at"][:, 0] = x
    persons["at"][:, 1] = np.random.default_rng(5).uniform(-3.0, 3.0, 30)
    ordered: Any = order_along_x
    neighbours: Any = find_neighbours
    within: Any = find_within
    side_by_side: Any = places_in_order
    order = ordered.py_func(persons)
    places = side_by_side.py_func(persons, order)
    z = persons["at"][:, 1]
    np.testing.assert_array_equal(order, np.argsort(x))
    found = np.zeros(30, dtype=np.int64)
    for n in range(30):
        near = found[: neighbours.py_func(places, order, n, 2.5, found)]
        offset = x[near] - x[order[n]]
        assert set(near) == set(np.flatnonzero(np.abs(x - x[order[n]]) <= 2.5)) - {order[n]}
        for side in (offset[offset < 0.0], offset[offset > 0.0]):
            assert (np.diff(np.abs(side)) > 0.0).all()
        distances = np.hypot(x - x[order[n]], z - z[order[n]])
        expected = [k for k in near.tolist() if distances[k] < 2.5]
        assert found[: within.py_func(places, order, n, 2.5, found)].tolist() == expected


@pytest.mark.parametrize(
    ("aside", "in_crowd", "kept"),
    [(0.8, True, 1.0), (1.1, True, 0.5), (1.4, True, 0.0), (0.8, False, 0.0)],
)
def test_walkers_in_a_crowd_keep_their_arms_in_before_others_pass_close_by(
    aside: float, in_crowd: bool, kept: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain: Any = arm_clearance.least_distance
    monkeypatch.setattr(arm_clearance, "least_distance", plain.py_func)
    monkeypatch.setattr(arm_clearance, "walks_with", lambda *_: False)
    two = zero_records(2, PERSON)
    two["height"] = 1.7
    two["at"], two["velocity"] = [[0.0, 0.0], [1.2, aside]], [[1.2, 0.0], [-1.2, 0.0]]
    keep_arms_in: Any = arm_clearance.keep_arms_in
    keep_arms_in.py_func(two, two[0], np.array([1]), 1, in_crowd)
    assert two["arms_wanted_in"][0] == pytest.approx(kept, abs=0.1)


@pytest.mark.parametrize(
    ("aside", "speed", "share"),
    [(0.3, 1.3, 0.2), (0.6, 1.3, 0.58), (0.8, 1.3, 1.0), (0.6, 0.3, 1.0)],
)
def test_walkers_in_a_crowd_pass_the_more_slowly_the_closer(
    aside: float, speed: float, share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain: Any = passing_share
    least_distance: Any = arm_clearance.least_distance
    monkeypatch.setattr(headway, "least_distance", least_distance.py_func)
    two = zero_records(2, PERSON)
    two["height"] = 1.72
    two["at"], two["velocity"] = [[0.0, 0.0], [0.4, aside]], [[speed, 0.0], [-speed, 0.0]]
    found = plain.py_func(two, two[0], np.array([1]), 1)
    assert found == pytest.approx(share, abs=0.02)


def test_who_meets_others_beside_a_wall_does_not_brush_against_it() -> None:
    scene = """
duration: 5
cast:
  - {name: anna, character: adult, at: [-2.2, 0.15]}
  - {name: ben, character: adult, at: [2.2, 0.15], heading_deg: 180}
  - {name: carl, character: adult, at: [3.0, -0.5], heading_deg: 180}
  - {name: wall, prop: {shape: box, size: [8, 2.2, 0.3]}, at: [0, 0, 0.7]}
script:
  - {at: 0, who: anna, do: {go_to: [2.5, 0.1]}}
  - {at: 0, who: ben, do: {go_to: [-2.5, 0.1]}}
  - {at: 0, who: carl, do: {go_to: [-1.8, -0.55]}}
"""
    play = play_scene(scene)
    assert play.joint("anna", "pelvis")[-1, 0] > 0.5
    assert not [contact for contact in play.contacts if contact.other == "wall"]


def test_walls_hold_nobody_up_as_others_do() -> None:
    scene = """
duration: 7
cast:
  - {name: anna, character: adult, at: [-2.0, 0.3]}
  - {name: ben, character: adult, at: [1.2, 0]}
  - {name: box, prop: {shape: box, size: [0.1, 0.1, 0.1]}, at: [0.9, 0.4]}
  - {name: near, prop: {shape: box, size: [0.5, 1.2, 3]}, at: [-0.3, 0]}
  - {name: far, prop: {shape: box, size: [0.5, 1.2, 3]}, at: [2.7, 0]}
  - {name: left, prop: {shape: box, size: [3, 1.2, 0.5]}, at: [1.2, -1.5]}
  - {name: right, prop: {shape: box, size: [3, 1.2, 0.5]}, at: [1.2, 1.5]}
script:
  - {at: 0.3, who: anna, do: {grab: box}}
"""
    # Whom others hold up waits for longer than the scene lasts.
    (order,) = simulate(read_scene("pronk: 1\n" + scene)).orders
    assert order.outcome == "given up"
    assert "the way is blocked" in order.reason


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("kind", "seed"), [("head-on", 1), ("corner", 1), ("gate", 1), ("gate", 3)]
)
def test_two_groups_cross_without_a_blow(kind: str, seed: int) -> None:
    out = cross(kind, 25, seed)
    assert out.is_good, out.text()


def passing_sides(size: int, duration: float) -> tuple[Watch, list[float]]:
    """Return a crossing of a gate, and how far to the right of its middle each person passed [m].

    Args:
        size: of each of the two groups.
        duration: watched [s].
    """
    watch = Watch(Simulation(read_scene(scene_text("gate", size, 1))), 2 * size)
    ahead = np.repeat([1.0, -1.0], size)
    sides: list[float] = []
    before = ahead * watch.troupe.persons["at"][:, 0]
    while watch.simulation.step_number * watch.dt < duration:
        watch.step()
        at = watch.troupe.persons["at"]
        passed = (before < 0.0) & (ahead * at[:, 0] >= 0.0)
        sides += (ahead * at[:, 1])[passed].tolist()
        before = ahead * at[:, 0]
    return watch, sides


def test_who_meets_others_in_an_opening_keeps_to_its_right_half() -> None:
    watch, sides = passing_sides(4, 6.5)
    assert len(sides) == 8
    assert min(sides) > 0.0
    assert not watch.outcome.hurt


def test_who_walks_about_behind_an_opening_is_not_met_in_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(passage_lanes, "find_within", find_within.py_func)  # type: ignore[attr-defined]
    monkeypatch.setattr(passage_lanes, "hypotenuse", math.hypot)
    two = zero_records(2, PERSON)
    two["at"], two["has_goal"], two["partner"] = [[-5.0, 0.5], [4.0, 0.0]], True, -1
    two["owner"] = 0, 1
    opening = passage_lanes.Opening(0.0, 0.0, 1.0, 0.0, 5.0, -2.0, 0.5)
    order, near = np.arange(2), np.zeros(2, dtype=np.int64)
    plain: Any = passage_lanes._met_share
    for goal, share in ((2.5, 0.0), (-5.0, 1.0 / passage_lanes.MANY)):
        two["goal"][1] = goal, 0.0
        found = plain.py_func(two, two["at"], order, 0, near, opening)
        assert found == pytest.approx(share)


@pytest.mark.nightly
def test_a_hundred_people_pass_a_gate_both_ways_without_a_jam() -> None:
    watch, sides = passing_sides(50, 26.0)
    assert len(sides) == 100
    assert min(sides) > -0.5
    # Where the halves are not kept, as many pass on the left.
    assert np.mean(np.array(sides) > 0.0) > 0.95
    assert not watch.outcome.hurt + watch.outcome.dazed


def test_the_one_nearer_to_the_crossing_of_two_ways_goes_first() -> None:
    plain: Any = lag_at_crossing
    two = zero_records(2, PERSON)
    two["at"], two["goal"] = [[-2.0, 0.0], [0.0, -1.4]], [[5.0, 0.0], [0.0, 6.0]]
    two["impatience"] = -0.4
    assert plain.py_func(two[0], two[1]) == pytest.approx(0.6)
    assert plain.py_func(two[1], two[0]) == pytest.approx(-0.6)
    two["at"][1] = [0.0, 1.0]  # past the crossing
    assert plain.py_func(two[0], two[1]) == 1.0
    two["at"], two["goal"] = [[-2.0, 0.0], [2.0, 0.1]], [[5.0, 0.0], [-5.0, 0.0]]  # head-on
    assert plain.py_func(two[0], two[1]) == 0.0


def test_of_two_who_wait_for_one_another_the_nearer_goes_first_for_sure() -> None:
    plain: Any = lag_at_crossing
    two = zero_records(2, PERSON)
    two["at"], two["goal"] = [[-0.5, 0.0], [0.0, -0.4]], [[5.0, 0.0], [0.0, 6.0]]
    two["impatience"] = -0.4
    assert plain.py_func(two[0], two[1]) == pytest.approx(0.1)
    two["impatience"][0] = 1.0  # only one of them waits
    assert plain.py_func(two[0], two[1]) == pytest.approx(0.1)
    two["impatience"] = 0.0
    assert plain.py_func(two[0], two[1]) == pytest.approx(1.0)
    assert plain.py_func(two[1], two[0]) == pytest.approx(-1.0)


def test_who_comes_out_of_a_passage_goes_before_those_who_go_in(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plain: Any = lag_at_passage
    held: Any = hold_up_one_another
    monkeypatch.setattr(right_of_way, "hold_up_one_another", held.py_func)
    two = zero_records(2, PERSON)
    two["passage"] = -0.4, 0.5
    assert plain.py_func(two[0], two[1]) == 0.0
    two["has_passage"] = True
    assert plain.py_func(two[0], two[1]) == pytest.approx(-0.9)
    assert plain.py_func(two[1], two[0]) == pytest.approx(0.9)
    # Of two that stand before one another between the walls, one steps back for sure.
    two["passage"] = -0.05, 0.05
    two["at"], two["goal"] = [[-0.4, 0.0], [0.4, 0.0]], [[5.0, 0.0], [-5.0, 0.0]]
    assert plain.py_func(two[0], two[1]) == pytest.approx(-0.1)
    two["impatience"] = 1.0
    assert plain.py_func(two[0], two[1]) == -1.0
    assert plain.py_func(two[1], two[0]) == 1.0
