"""People that dance: hands where the dance puts them, strikes on the beat, refusals."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene
from pipeline.spec.script import Instruction, Perform
from tests.simulation.characters.scripted_people import (
    STEPS,
    Play,
    play_scene,
    run_scene,
    troupe_of,
)

DANCES = """
dances:
  salute:
    bar: 4
    tempo_bpm: 120
    subtasks:
      - {hand: r, joints: {shoulder_flexion_deg: 90, elbow_flexion_deg: 4}}
      - {hand: l, touch: chest, beats: 2}
  lift:
    bar: 2
    tempo_bpm: 120
    subtasks: [{hand: r, joints: {shoulder_flexion_deg: 60}}]
  beat_it:
    bar: 4
    drums: {tom: {at: [0.4, 1.0, 0]}}
    subtasks: [{touch: tom}]
"""

START, BEAT = 0.2, 0.5
"""Time of the order and length of a beat [s]."""


def scene_text(script: str, cast: str = "", seconds: float = 4.0) -> str:
    return (
        f"duration: {seconds}\nterrain: flat\n{DANCES}"
        f"cast:\n- {{name: anna, character: adult, at: [0, 0]}}\n{cast}script:\n{script}"
    )


@cache
def salute() -> Play:
    script = f"- {{at: {START}, who: anna, do: {{dance: salute, bars: 1}}}}\n"
    return play_scene(scene_text(script), frames=True)


def test_a_person_dances_and_lets_its_arms_hang_again() -> None:
    play = salute()
    hand, shoulder = play.joint("anna", "hand_r"), play.joint("anna", "shoulder_r")
    row = int((START + 2.4 * BEAT) * STEPS)
    arm = hand[row] - shoulder[row]
    # Straight ahead, as far as the arm reaches.
    assert arm[0] > 0.9 * np.linalg.norm(arm)
    assert abs(arm[1]) < 0.08
    assert play.when("anna") == pytest.approx([START + 6 * BEAT + 1.2], abs=1.3)
    np.testing.assert_allclose(hand[-1] - shoulder[-1], hand[0] - shoulder[0], atol=0.02)
    feet = [play.joint("anna", f"foot_{side}") for side in "lr"]
    assert max(float(np.ptp(foot, axis=0).max()) for foot in feet) < 1e-3


def test_a_touch_of_its_body_is_a_contact_on_its_beat() -> None:
    hits = [c for c in salute().contacts if c.part == "hand_l"]
    assert [c.other for c in hits[:1]] == ["breast"]
    assert hits[0].performer == "anna"
    beats = (hits[0].step / STEPS - START) / BEAT
    assert abs(beats - round(beats)) < 0.1
    # On the chest as it stands.
    assert hits[0].place[1] == pytest.approx(1.3, abs=0.12)


def test_a_palm_follows_the_dance_and_not_the_forearm_alone() -> None:
    play = salute()
    R, _ = play.frames["anna.hand_l"]
    forearm, _ = play.frames["anna.forearm_l"]
    turned = np.einsum("kji,kji->k", R, forearm)
    assert turned[: int(START * STEPS)] == pytest.approx(3.0)
    assert turned.min() < 2.9


@pytest.mark.parametrize(
    ("order", "path", "message"),
    [
        ("{dance: salut}", "script[0].do.dance", "no dance is called 'salut', did you mean"),
        ("dance", "script[0].do", "'anna' has no dance of its own; write {dance: NAME"),
        ("{dance: beat_it}", "script[0].do.dance", "'beat_it' has drums, which only a `dancer`"),
    ],
)
def test_a_dance_that_a_person_cannot_dance_is_refused(order: str, path: str, message: str) -> None:
    text = scene_text(f"- {{at: 0, who: anna, do: {order}}}\n", seconds=0.5)
    with pytest.raises(SceneError) as caught:
        Simulation(read_scene("pronk: 1\n" + text))
    assert path in str(caught.value)
    assert message in str(caught.value)


def test_an_order_from_outside_gives_the_motion_of_the_same_script() -> None:
    order = "{at: 0.1, who: anna, do: {dance: lift, bars: 1}}"
    told = Simulation(read_scene("pronk: 1\n" + scene_text(f"- {order}\n", seconds=0.8)))
    plain = scene_text("[]\n", seconds=0.8).replace("script:\n[]", "script: []")
    directed = Simulation(read_scene("pronk: 1\n" + plain), directed=True)
    directed.add_instruction(
        Instruction(at=0.1, who="anna", do=Perform(dance="lift", bars=1)),
    )
    for simulation in (told, directed):
        while not simulation.finished:
            simulation.step()
    paths = [simulation.take().positions for simulation in (told, directed)]
    np.testing.assert_array_equal(*paths)
    assert float(np.ptp(np.array(paths[0]), axis=0).max()) > 0.1


def test_full_hands_do_not_dance() -> None:
    """The order is given up with its reason, and with the event that a script waits for."""
    script = (
        "- {at: 0.1, who: anna, do: {dance: salute, bars: 1}}\n"
        "- {when: {failed: anna, act: dance}, who: anna, do: {turn_deg: 90}}\n"
    )
    prop = "- {name: cup, prop: {shape: ball, radius: 0.05}, at: [0.4, 1.0, 0.2]}\n"
    simulation = Simulation(read_scene("pronk: 1\n" + scene_text(script, prop, seconds=0.3)))
    troupe_of(simulation).dispatcher.controllers[0].hold_member("cup", (1,))
    while not simulation.finished:
        simulation.step()
    orders = simulation.take().orders
    assert [(o.outcome, o.reason) for o in orders if o.text.startswith("dance")] == [
        ("begun", ""),
        ("given up", "holds 'cup'; let go of it first"),
    ]
    assert any(o.text.startswith("turn_deg") for o in orders)


@pytest.mark.nightly
def test_a_sitting_person_rises_to_dance() -> None:
    script = (
        "  - {at: 0, who: anna, do: sit}\n  - {at: 2.0, who: anna, do: {dance: salute, bars: 1}}\n"
    )
    cast = "- {name: anna, character: adult, at: [0, 0]}"
    simulation = run_scene(cast, 9.0, script, dances=DANCES.removeprefix("\ndances:"))
    contacts = [c for c in simulation.take().contacts if c.part == "hand_l"]
    assert contacts
    assert contacts[0].step > 3.0 * STEPS
