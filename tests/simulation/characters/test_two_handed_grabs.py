"""Grabs of dolls and boxes: hands get down to the ground, and two hands take two places."""

from __future__ import annotations

from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take import OrderRecord
from tests.simulation.characters.scripted_people import STEPS, play_scene, run_scene

BOX = "name: t, character: box, scale: 0.51, heading_deg: 3, at: [0, 0]"
TAKER = "name: a, character: adult, at: [-0.377, -0.639], heading_deg: 103, scale: 1.09"
NEXT_TAKER = "name: b, character: adult, at: [-2.815, -0.473], heading_deg: -172, scale: 0.94"
HANDED_TIME = 8.0  # in which a box goes from one to the other [s]


def _orders(simulation: Simulation) -> dict[str, OrderRecord]:
    """Return the last order of each person."""
    return {order.who: order for order in simulation.take().orders}


def test_a_childs_hand_gets_down_to_a_doll_on_the_ground() -> None:
    cast = (
        "- {name: a, character: child, at: [0.701, -1.747], heading_deg: 17, scale: 0.96}\n"
        "- {name: t, character: ragdoll, heading_deg: 133, at: [0, 0]}"
    )
    order = _orders(run_scene(cast, 9, "- {at: 0.3, who: a, do: {grab: t}}"))["a"]
    assert order.outcome == "done"


def test_two_hands_take_two_corners_of_a_box() -> None:
    held = list[tuple[int, int]]()

    def note_grips(troupe: Characters, _: int) -> None:
        first = int(troupe.persons["grip"][0])
        held.append((int(troupe.arrays.grips[first, 1]), int(troupe.arrays.grips[first + 1, 1])))

    play_scene(
        f"duration: 6\ncast:\n- {{{TAKER}}}\n- {{{BOX}}}\n"
        "script:\n- {at: 0.3, who: a, do: {grab: t, hand: both}}\n",
        note_grips,
    )
    left, right = held[-1]
    assert min(left, right) >= 0
    assert left != right


def test_a_box_goes_from_two_hands_to_two_hands() -> None:
    orders = _orders(
        run_scene(
            f"- {{{TAKER}}}\n- {{{NEXT_TAKER}}}\n- {{{BOX}}}",
            14,
            "- {at: 0.3, who: a, do: {grab: t, hand: both}}\n"
            "- {when: {arrived: a}, who: b, do: {grab: t, hand: both}}",
        )
    )
    assert orders["b"].outcome == "done"
    assert orders["b"].end - orders["b"].step < HANDED_TIME * STEPS


def test_a_box_held_by_its_corners_is_put_onto_a_table() -> None:
    cast = (
        "- {name: a, character: child, at: [2.251, -0.507], heading_deg: -144, scale: 1.03}\n"
        "- {name: t, character: box, scale: 0.47, heading_deg: 30, at: [0, 0]}\n"
        "- {name: table, prop: {shape: box, size: [0.8, 0.45, 0.8]}, at: [-0.586, 0.225, -2.815]}"
    )
    script = "- {at: 0.3, who: a, do: {carry: t, to: table, hand: both}}"
    assert _orders(run_scene(cast, 14, script))["a"].outcome == "done"
