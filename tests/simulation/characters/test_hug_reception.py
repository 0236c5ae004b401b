"""Hug reception: those who are to be hugged finish or interrupt a walk, and turn."""

from __future__ import annotations

import math

import pytest

from pipeline.simulation.characters.hug_tasks import Hug
from tests.simulation.characters.scripted_people import run_scene, troupe_of

pytestmark = pytest.mark.slow


def gap_and_turn(cast: str, seconds: float, script: str) -> tuple[float, float, list[str]]:
    """Return the distance of the pelvises [m], how far b faces away [rad], and the outcomes."""
    simulation = run_scene(cast, seconds, script)
    a, b = troupe_of(simulation).dispatcher.controllers[:2]
    gap = a.ground_distance(a.view.pelvis(int(b.record.owner)))
    turn = math.acos(float(b.ahead @ b.direction_to(a.waist())))
    return gap, turn, [order.outcome for order in simulation.take().orders]


def test_who_has_nothing_to_do_turns_to_who_hugs_it() -> None:
    cast = "  - {name: a, character: adult}\n  - {name: b, character: child, at: [1.2, 0]}"
    gap, turn, outcomes = gap_and_turn(cast, 6, "  - {at: 0, who: a, do: {hug: b}}")
    assert gap < 0.075 * (1.72 + 1.15) + 0.1
    assert turn < math.radians(45)
    assert outcomes == ["done"]


def test_a_walk_to_near_by_is_finished_first() -> None:
    cast = "  - {name: a, character: adult}\n  - {name: b, character: child, at: [1.8, 0.6]}"
    orders = "  - {at: 0, who: b, do: {go_to: [0.3, 0]}}\n  - {at: 0, who: a, do: {hug: b}}"
    gap, _, outcomes = gap_and_turn(cast, 14, orders)
    assert gap < 0.075 * (1.72 + 1.15) + 0.1
    assert outcomes == ["done"] * 2


@pytest.mark.nightly
def test_a_long_walk_is_interrupted_for_a_hug_and_resumed() -> None:
    cast = (
        "  - {name: a, character: adult, at: [0, 0.4]}\n  - {name: b, character: child, at: [2, 0]}"
    )
    orders = (
        "  - {at: 0, who: b, do: {go_to: [12, 0]}}\n  - {at: 0, who: b, do: {speed: 0.5}}\n"
        "  - {at: 0, who: a, do: {hug: b}}\n  - {at: 14, who: a, do: {let_go: both}}\n"
    )
    simulation = run_scene(cast, 38, orders, terrain="{kind: flat, size: [30, 8]}")
    dispatcher = troupe_of(simulation).dispatcher
    assert not isinstance(dispatcher.task(0), Hug)
    goal, hug = [order for order in simulation.take().orders if " " in order.text][:2]
    assert (goal.outcome, hug.outcome) == ("done", "done")
