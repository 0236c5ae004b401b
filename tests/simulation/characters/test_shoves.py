"""Shoves: palms that strike a chest throw off balance whom they strike, and hurt."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.characters.person_record import PLACED, SWINGING
from pipeline.simulation.characters.shove_task import YIELDING_TIME, Grapple
from pipeline.simulation.simulate import Simulation
from pipeline.spec import load_scene
from tests.simulation.characters.mind_scenes import simulation, troupe
from tests.simulation.characters.scripted_people import STEPS, play_scene

SCENES = Path(__file__).parents[3] / "scenes"
SCENE = """\
duration: 2.6
cast:
  - {name: a, character: adult, at: [-1.2, 0]}
  - {name: b, character: adult, at: [0, 0], heading_deg: 180}
script: [{at: 0, who: a, do: {grapple: b}}]
"""


def test_a_shove_throws_the_other_back_and_hurts() -> None:
    pains = []

    def feel(troupe: Characters, step: int) -> None:
        pains.append(troupe.arrays.owners["pain"].tolist())

    play = play_scene(SCENE, feel)
    pushed, pusher = play.joint("b", "pelvis"), play.joint("a", "pelvis")
    assert 0.3 < pushed[-1, 0] - pushed[0, 0] < 1.6
    # Not belly to belly, and the hands sink again.
    assert (pushed[:, 0] - pusher[:, 0]).min() > 0.35
    assert play.records["arm_mode"][-1, 0].tolist() == [0, 0]
    assert max(pain[1] for pain in pains) > 0.4
    assert max(pain[0] for pain in pains) == 0.0
    assert play.when("a")
    # Its feet keep up, so that it does not sink between them, and none is set back in mid-swing.
    assert pushed[:, 1].min() > 0.7 * pushed[0, 1]
    ankles = play.records["ankles"][:, 1]
    changes = np.diff(np.diff(ankles, axis=0) * STEPS, axis=0)
    assert np.linalg.norm(changes, axis=2).max() < 4.0


def test_drawn_hands_are_no_offer_of_a_hug() -> None:
    scene = SCENE.replace("heading_deg: 180}", "heading_deg: 180, behaviours: [{comfort: a}]}")
    assert "comfort" in scene
    embraces = []
    play = play_scene(scene, lambda troupe, _: embraces.append(troupe.arrays.owners["embraces"][1]))
    struck = int(np.argmax(np.diff(play.joint("b", "pelvis")[:, 0]) * STEPS > 0.5))
    assert struck > 0
    assert max(embraces[:struck]) < 0
    # It has braced and averted its face instead.
    assert play.records["braces"][struck - 5, 1]


def test_a_shoved_child_steps_back_without_sinking_between_its_feet() -> None:
    play = play_scene(SCENE.replace("character: adult", "character: child"))
    pushed = play.joint("b", "pelvis")
    assert 0.25 < pushed[-1, 0] - pushed[0, 0] < 0.6
    assert pushed[:, 1].min() > 0.85 * pushed[0, 1]


def test_a_small_child_shoves_the_belly_of_a_tall_adult() -> None:
    scene = SCENE.replace("duration: 2.6", "duration: 4").replace(
        "a, character: adult, at: [-1.2, 0]", "a, character: child, scale: 0.9, at: [-1.2, 0]"
    )
    assert "child" in scene
    play = play_scene(scene)
    assert play.when("a")
    pushed = play.joint("b", "pelvis")
    assert pushed[-1, 0] - pushed[0, 0] > 0.02


@pytest.mark.parametrize("speed", [0.5, 0.7])
def test_who_walks_off_is_followed_and_shoved(speed: float) -> None:
    play = play_scene(
        "duration: 4.5\n"
        "cast:\n"
        "  - {name: a, character: adult, at: [-1.6, 0]}\n"
        "  - {name: b, character: adult, at: [0, 0]}\n"
        "script:\n"
        f"  - {{at: 0, who: b, do: {{speed: {speed}}}}}\n"
        "  - {at: 0, who: b, do: {go_to: [9, 0]}}\n"
        "  - {at: 0.5, who: a, do: {grapple: b}}\n"
    )
    arrived, fastest = play.when("a"), np.diff(play.joint("b", "pelvis")[:, 0]).max() * STEPS
    assert arrived
    assert fastest > speed + 0.8


@pytest.mark.parametrize("sees_it", [True, False])
def test_who_sees_a_push_coming_turns_away_from_it(sees_it: bool) -> None:
    scene = SCENE.replace("duration: 2.6", "duration: 3.6")
    play = play_scene(scene if sees_it else scene.replace("heading_deg: 180", "heading_deg: 0"))
    pushed = play.joint("b", "pelvis")
    speeds = np.diff(pushed[:, 0]) * STEPS
    assert speeds.max() > 0.4
    first = int(np.argmax(speeds > 0.4))
    # A push goes along X: to its side is where the cosine is least.
    headings, gazes = play.records["heading"][:, 1], play.records["gaze"][:, 1, 0]
    if sees_it:
        # A shoulder takes it, the face is turned away; then the person faces the other again.
        assert abs(np.cos(headings[first])) < np.cos(np.radians(40.0))
        assert (np.cos(gazes[first : first + round(0.3 * STEPS)]) > -0.1).all()
        assert np.cos(gazes[-1]) < -0.9
    else:
        assert np.cos(headings[first]) > 0.9


def test_who_is_frozen_forgets_a_push_that_is_called_off() -> None:
    scene = SCENE.replace("duration: 2.6", "duration: 2.5").replace(
        "{grapple: b}}]",
        "{grapple: b}}, {at: 0.75, who: b, do: freeze}, {at: 0.8, who: a, do: {go_to: [-3, 0]}}]",
    )
    braces = play_scene(scene).records["braces"][:, 1]
    assert braces.any()
    assert not braces[round(1.6 * STEPS) :].any()


def test_two_pushes_at_once_do_not_depend_on_the_order_of_the_cast() -> None:
    people = [
        "  - {name: a, character: adult, at: [-1.2, 0]}\n",
        "  - {name: b, character: adult, at: [0, 0], heading_deg: 120}\n",
        "  - {name: c, character: adult, at: [0, 1.1], heading_deg: 90}\n",
    ]
    script = "script: [{at: 0, who: a, do: {grapple: b}}, {at: 0, who: c, do: {grapple: b}}]\n"
    plays = [
        play_scene("duration: 1.6\ncast:\n" + "".join(cast) + script)
        for cast in (people, people[::-1])
    ]
    for play, number in zip(plays, (1, 1), strict=True):
        assert play.records["braces"][:, number].any()
    assert np.array_equal(*(play.joint("b", "pelvis") for play in plays))


@pytest.mark.nightly
def test_rivals_look_where_they_go() -> None:
    made = Simulation(load_scene(SCENES / "fight.yaml"))
    persons, velocities, gazes = troupe(made).persons, [], []
    names = [one.name for one in troupe(made).dispatcher.controllers]
    rivals = [names.index("red"), names.index("blue")]
    while not made.finished:
        made.step()
        velocities.append(persons["velocity"][rivals].copy())
        gazes.append(persons["gaze"][rivals, 0].copy())
    velocity, gaze = np.array(velocities), np.array(gazes)
    walks = np.linalg.norm(velocity, axis=2) > 0.4
    ahead = velocity[..., 0] * np.cos(gaze) - velocity[..., 1] * np.sin(gaze)
    walking = walks.sum(axis=0)
    assert (walking * made.world.clock.dt > 6.0).all()
    assert ((walks & (ahead < 0.0)).sum(axis=0) < 0.03 * walking).all()


@pytest.mark.parametrize(("sooner", "braces"), [(-0.5, False), (0.5, False), (1.5, True)])
def test_who_would_strike_at_about_the_same_time_strikes_and_who_is_later_braces(
    sooner: float, braces: bool
) -> None:
    cast = "- {name: a, character: adult, at: [0, 0]}\n"
    cast += "- {name: b, character: adult, at: [0.6, 0], heading_deg: 180}"
    controller = troupe(simulation(cast, 1.0)).dispatcher.controllers[0]
    task, dt, drawn = Grapple(1), 1.0 / STEPS, 0.1
    task.drawn = drawn
    # The other strikes so much sooner than the hands of this one are drawn.
    left = task.drawing_time - drawn - dt
    controller.record.seen_push_left = left - sooner * YIELDING_TIME
    task._draw_back(controller, 0.0, dt)
    assert (task.drawn == 0.0) == braces
    mode = SWINGING if braces else PLACED
    assert controller.record.arm_mode.tolist() == [mode, mode]
