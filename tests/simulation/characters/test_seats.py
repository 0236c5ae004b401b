"""Seats: those who are told to sit on one bench sit side by side, and a fourth gives up."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.production.run.notes import take_notes
from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.characters.playthings import BOX_SIZES, CORNERS
from pipeline.simulation.characters.seat_perch import perch_on
from pipeline.simulation.characters.seat_task import SEAT_PITCH, bench_of
from pipeline.simulation.characters.slots import Slots
from pipeline.simulation.clock import Clock
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.spec import read_scene

SCENE = """\
pronk: 1
duration: 11
cast:
  - {name: a, character: adult, at: [-1.6, 0.2]}
  - {name: b, character: adult, at: [1.5, 1.0], heading_deg: 180}
  - {name: c, character: child, at: [1.2, -1.5]}
  - {name: d, character: adult, at: [3.0, 0.4], heading_deg: 180}
  - {name: bench, character: bench, at: [0, 0]}
script:
  - {at: 0.3, who: CAST, do: {sit: bench}}
"""


def order(names: str) -> str:
    line = "  - {at: 0.3, who: CAST, do: {sit: bench}}\n"
    return SCENE.replace(line, "".join(line.replace("CAST", name) for name in names))


@pytest.mark.slow
def test_three_sit_side_by_side_and_the_fourth_gives_up() -> None:
    take = simulate(read_scene(order("abcd")))
    outcomes = {record.who: record for record in take.orders}
    assert [outcomes[name].outcome for name in "abcd"] == ["done", "done", "done", "given up"]
    clock = Clock(take.header.rate, 264)
    (note,) = take_notes(take, clock)
    assert "all 3 seats are taken, by" in note.text
    names = [node.name for node in take.nodes]
    pelvises = np.array([take.positions[-1, names.index(f"{name}.pelvis")] for name in "abc"])
    assert np.abs(pelvises[:, 0]).max() < 0.2
    assert (np.abs(pelvises[:, 1] - 0.5) < 0.1).all()
    assert np.diff(np.sort(pelvises[:, 2])).min() > 0.8 * SEAT_PITCH


def test_a_slot_is_taken_by_one_and_free_again_after_it() -> None:
    slots = Slots()
    slots.take("bench", 1, "kid", 0.5)
    assert slots.free("bench", 3) == [0, 2]
    assert slots.facing("bench") == 0.5
    slots.take("bench", 2, "kid", 0.5)
    assert slots.free("bench", 3) == [0, 1]
    slots.leave("kid")
    assert slots.free("bench", 3) == [0, 1, 2]
    assert slots.facing("bench") is None


@pytest.mark.parametrize("turn", [0.0, 0.7, -2.1])
def test_seats_are_along_a_bench_and_face_who_comes_first(turn: float) -> None:
    c, s = math.cos(turn), math.sin(turn)
    size = np.array(BOX_SIZES["bench"][0])
    nodes = CORNERS * size @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    bench = bench_of(nodes, 2.0 * np.array([c, -s]))
    assert bench.seat_count == 3
    assert bench.ahead == pytest.approx([c, 0.0, -s])
    places = [bench.place(bench.seat_offset(n), 0.0) for n in range(3)]
    assert np.linalg.norm(np.diff(places, axis=0), axis=1) == pytest.approx([size[2] / 3.0] * 2)
    behind = bench_of(nodes, -2.0 * np.array([c, -s]), facing=turn)
    assert behind.ahead == pytest.approx(bench.ahead)
    assert behind.coordinates(-2.0 * np.array([c, -s])) == pytest.approx((0.0, -2.0), abs=1e-9)


@pytest.mark.parametrize("tilt", [0.0, 0.1, -0.15])
def test_a_bench_that_rocks_is_no_higher_than_one_at_rest(tilt: float) -> None:
    c, s = math.cos(tilt), math.sin(tilt)
    size = np.array(BOX_SIZES["bench"][0])
    nodes = CORNERS * size @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    bench = bench_of(nodes, np.array([2.0, 0.0]))
    assert bench.top == pytest.approx(c * size[1])


@pytest.mark.parametrize("at", [(2.0, 0.3), (-0.2, -2.0), (-2.0, 0.5)])
def test_a_square_thing_is_sat_on_from_the_side_that_one_comes_from(
    at: tuple[float, float],
) -> None:
    bench = bench_of(CORNERS * 0.5, np.array(at))
    assert bench.seat_count == 1
    assert float(bench.ahead[[0, 2]] @ np.array(at)) == pytest.approx(max(map(abs, at)))


@pytest.mark.parametrize(
    ("thing", "text"),
    [
        ("character: box, scale: 1.8, at: [0, 0]", "too high: 0.88 m"),
        ("character: box, scale: 0.3, at: [0, 0]", "too low: 0.15 m"),
        ("prop: {shape: box, size: [0.6, 0.9, 0.6]}, at: [0, 0.45, 0]", "too high: 0.90 m"),
    ],
)
def test_what_is_no_seat_is_given_up_with_a_note(thing: str, text: str) -> None:
    scene = (
        "pronk: 1\nduration: 0.6\ncast:\n  - {name: a, character: adult, at: [-1.2, 0]}\n"
        f"  - {{name: seat, {thing}}}\nscript:\n  - {{at: 0.1, who: a, do: {{sit: seat}}}}\n"
        "  - {when: {failed: a, act: sit}, who: a, do: freeze}\n"
    )
    take = simulate(read_scene(scene))
    sit, freeze = take.orders
    assert sit.outcome == "given up"
    assert freeze.step >= sit.end > 0
    (note,) = take_notes(take, Clock(take.header.rate, 15))
    assert text in note.text


def test_feet_of_short_legs_reach_the_ground_from_a_high_seat() -> None:
    scene = (
        "pronk: 1\nduration: 1\ncast:\n  - {name: kid, character: child, at: [0, 0], scale: 0.85}\n"
    )
    simulation = Simulation(read_scene(scene))
    troupe = next(one for one in simulation.troupes if isinstance(one, Characters))
    kid = troupe.dispatcher.controllers[0].record
    hips = float(kid.hip_height)
    low, high = perch_on(kid, 0.6 * hips, 0.2), perch_on(kid, 0.87 * hips, 0.2)
    assert low.back == 0.2
    assert low.heel_rise == 0.0
    assert 0.1 < high.back < 0.2
    assert math.radians(20.0) < high.heel_rise <= math.radians(50.0)
