"""Second tries: what is stuck is tried once more from elsewhere, then given up; arms sink."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.simulation.characters.contact_tasks import Grab
from pipeline.simulation.characters.person_record import SWINGING
from pipeline.simulation.characters.second_try import REGRET_TIME, StepAside
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene
from tests.simulation.characters.scripted_people import STEPS, run_scene, troupe_of

pytestmark = pytest.mark.slow

TAKE = """pronk: 1
duration: 8
cast:
  - {name: kid, character: child}
  - {name: doll, character: ragdoll, at: [1.5, 0]}
script:
  - {at: 0, who: kid, do: {grab: doll, hand: both}}
"""


def test_what_is_stuck_is_tried_from_elsewhere_and_then_given_up_visibly() -> None:
    simulation = Simulation(read_scene(TAKE))
    troupe = troupe_of(simulation)
    (controller,) = troupe.dispatcher.controllers
    person, tries, looks = controller.record, list[Grab](), list[float]()
    places, gave_up = list[np.ndarray](), -1
    while not simulation.finished:
        simulation.step()
        task, step = troupe.dispatcher.task(0), simulation.step_number
        if isinstance(task, Grab) and task not in tries and task.time > 0.0:
            tries.append(task)
            places.append(np.array(person.at))
            task.stick("stays out of reach")
        if simulation.order_log.ended and gave_up < 0:
            gave_up = step
            assert (person.arm_mode == SWINGING).all()
        if gave_up > 0 and person.has_look_target:
            looks.append(float(person.look_at[1]))
    assert len(tries) == 2
    # From another side of the doll.
    ways = [np.array([1.5, 0.0]) - place for place in places]
    turn = math.acos(float(ways[0] @ ways[1]) / (math.hypot(*ways[0]) * math.hypot(*ways[1])))
    assert turn > math.radians(20.0)
    (order,) = simulation.take().orders
    assert (order.outcome, order.reason) == ("given up", "stays out of reach")
    # It looks at the doll, then down, and then ahead again.
    assert len(looks) == pytest.approx(REGRET_TIME * STEPS, abs=3)
    assert not person.has_look_target
    head, hand = troupe.arrays.p[int(person.node) + 3], controller.hand(1)
    assert hand[1] < head[1] - 0.3


def test_what_no_place_can_mend_is_given_up_at_once() -> None:
    simulation = run_scene(
        "  - {name: kid, character: child}\n"
        "  - {name: ball, character: ball, at: [2, 0], scale: 3}",
        2.0,
        "  - {at: 0.1, who: kid, do: {grab: ball}}\n",
    )
    (order,) = simulation.take().orders
    assert order.reason.startswith("wider than both hands")
    assert order.end - order.step < 5
    assert not isinstance(troupe_of(simulation).dispatcher.task(0), StepAside)


def test_arms_sink_after_a_shove_and_when_a_hugged_partner_leaves() -> None:
    simulation = run_scene(
        "  - {name: a, character: adult}\n  - {name: doll, character: ragdoll, at: [1.2, 0]}\n"
        "  - {name: b, character: adult, at: [0, 5]}\n"
        "  - {name: c, character: child, at: [1, 5], heading_deg: 180}",
        8.5,
        "  - {at: 0.1, who: a, do: {grapple: doll}}\n"
        "  - {at: 0.1, who: b, do: {hug: c}}\n"
        "  - {at: 4.5, who: c, do: {go_to: [2.8, 5]}}\n",
    )
    assert [order.outcome for order in simulation.take().orders] == ["done"] * 3
    controllers = troupe_of(simulation).dispatcher.controllers
    assert all((one.record.arm_mode == SWINGING).all() for one in controllers)
    for one in controllers:
        for k in range(2):
            out = (one.hand(k) - one.shoulder(k))[[0, 2]]
            assert math.hypot(*out) < 0.45 * one.arm
