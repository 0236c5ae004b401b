"""People on moving surfaces: they stand on them, are carried, ride and push."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pipeline.simulation.characters.carousel_pose import carousel_pose
from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.characters.deck_choice import top_of
from pipeline.simulation.characters.push_task import PushRound
from pipeline.simulation.characters.ride_task import CROSSING_LEAD, RideCarousel
from pipeline.simulation.keyframe_track import rotation_from_angles
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array
from pipeline.spec import read_scene
from tests.simulation.characters.scripted_people import (
    STEPS,
    Play,
    play_scene,
    run_scene,
    troupe_of,
)

CAROUSEL = "- {name: c, character: merry-go-round, spin_deg: [0, 40, 0]}\n"
CART = "prop: {shape: box, size: [1.6, 0.25, 1.0]}"
DECK_TOP = 0.25
"""Height of the deck of a merry-go-round [m]."""


def test_the_top_of_a_tilted_board_is_flat_and_of_its_size() -> None:
    signs = np.array([(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)])
    corners = signs * [0.8, 0.05, 0.25]
    R = rotation_from_angles(np.radians(np.array([[0.0, 30.0, 10.0]])))[0]
    top = top_of(corners, R)
    assert top is not None
    assert np.allclose(top.place, [0.0, 0.05, 0.0])
    assert sorted(top.half) == pytest.approx([0.25, 0.8])
    assert np.allclose(top.turn @ top.turn.T, np.eye(3))
    assert np.linalg.det(top.turn) == pytest.approx(1.0)
    on_edge = rotation_from_angles(np.radians(np.array([[0.0, 0.0, 45.0]])))[0]
    assert top_of(corners, on_edge @ on_edge[:, [1, 0, 2]]) is not None
    skew = rotation_from_angles(np.radians(np.array([[35.0, 0.0, 45.0]])))[0]
    assert top_of(corners, skew) is None


def test_a_person_on_a_turning_deck_turns_with_it() -> None:
    cast = CAROUSEL + "- {name: kid, character: child, at: [0.8, 0]}\n"
    play = play_scene(f"duration: 1.5\ncast:\n{cast}")
    hub, kid, first = play.firsts["c"], play.records[:, 0], play.firsts["c"] + 2
    rim = play.p[:, first] - play.p[:, hub]
    deck = np.unwrap(np.arctan2(-rim[:, 2], rim[:, 0]))
    at = kid["at"]
    own = np.unwrap(np.arctan2(-at[:, 1], at[:, 0]))
    turned = deck[-1] - deck[0]
    assert turned > math.radians(40.0)
    assert own[-1] - own[0] == pytest.approx(turned, abs=0.03)
    assert np.unwrap(kid["heading"])[-1] - kid["heading"][0] == pytest.approx(turned, abs=0.03)
    # Feet stay where they stand on the deck, and legs keep it upright.
    foot = kid["stance_place"][:, 0]
    around = np.unwrap(np.arctan2(-foot[:, 2], foot[:, 0]))
    # The deck slows down, and feet follow it one sub-step later.
    assert np.ptp(around - deck) < 1e-3
    assert np.hypot(foot[:, 0], foot[:, 2]) == pytest.approx(math.hypot(*foot[0, [0, 2]]))
    assert kid["floor"] == pytest.approx(DECK_TOP, abs=1e-3)
    # Its turning along is no knock, but for that of the first moment.
    assert kid["stun"].max() < 0.1
    assert kid["stun"][-1] < 0.01
    pelvis = play.joint("kid", "pelvis")[:, 1]
    assert pelvis.min() > DECK_TOP + 0.9 * kid["hip_height"][0]


@pytest.mark.nightly
def test_a_person_steps_onto_a_cart_and_is_carried() -> None:
    keys = "[{at: 3.3, position: [0, 0.125, 0]}, {at: 5.1, position: [1.2, 0.125, 0]}]"
    cast = f"- {{name: cart, {CART}, at: [0, 0.125, 0], keyframes: {keys}}}\n"
    cast += "- {name: kid, character: child, at: [0, 0.95], heading_deg: 90}\n"
    script = "script:\n- {at: 0, who: kid, do: {ride: cart}}\n"
    play = play_scene(f"duration: 5.3\ncast:\n{cast}{script}")
    kid = play.records[:, 0]
    assert play.when("kid")[0] < 3.3
    assert kid["stance_on_deck"][-1].all()
    assert kid["at"][-1, 0] - kid["at"][round(3.3 * STEPS), 0] == pytest.approx(1.2, abs=0.03)
    assert kid["floor"][-1] == pytest.approx(0.25, abs=1e-3)
    assert kid["stun"].max() < 0.05


def test_what_cannot_be_stepped_onto_is_given_up() -> None:
    cast = "- {name: wall, prop: {shape: box, size: [1, 0.6, 1]}, at: [0, 0.3, 0]}\n"
    cast += "- {name: raft, body: {shape: box, size: [1, 0.1, 1]}, at: [4, 0.06, 0]}\n"
    cast += "- {name: kid, character: child, at: [0, 1.2]}\n"
    cast += "- {name: other, character: child, at: [4, 1.2]}\n"
    script = "- {at: 0, who: kid, do: {ride: wall}}\n- {at: 0, who: other, do: {ride: raft}}\n"
    orders = {one.who: one for one in run_scene(cast, 0.3, script).take().orders}
    assert orders["kid"].outcome == orders["other"].outcome == "given up"
    assert "too high to step on: 0.60 m" in orders["kid"].reason
    assert "collide: all" in orders["other"].reason


def test_pushers_slow_a_merry_go_round_down_for_those_who_get_off() -> None:
    def crossed(rider_deck_share: float) -> bool:
        decks = SimpleNamespace(boarding={3: set[str]()}, leaving={3: {1}})
        rider = SimpleNamespace(deck_share=rider_deck_share)
        controller: Any = SimpleNamespace(view=SimpleNamespace(decks=decks, persons={1: rider}))
        pusher: Any = SimpleNamespace(owner=3)
        found = PushRound._is_crossed(pusher, controller)
        assert bool(decks.leaving[3]) == found
        return found

    assert crossed(0.4)
    assert not crossed(0.0)


PUSHED_RIDE = """cast:
- {name: c, character: merry-go-round}
- {name: rider, character: child, at: [0.9, -0.3], heading_deg: 180}
- {name: pusher, character: child, at: [-1.7, 0.2], heading_deg: 0, scale: 1.15}
script:
- {at: 0, who: rider, do: {ride: c}}
- {at: 0, who: pusher, do: {push: c, turns: 3}}
"""


def _turn_rate(play: Play) -> Array:
    """Return the rate (steps,) at which the merry-go-round "c" turns [rad/s]."""
    hub, first = play.firsts["c"], play.firsts["c"] + 2
    rim = play.p[:, first] - play.p[:, hub]
    return np.asarray(np.gradient(np.unwrap(np.arctan2(-rim[:, 2], rim[:, 0]))) * STEPS)


@pytest.mark.nightly
def test_a_rider_gets_off_a_merry_go_round_that_is_pushed_without_a_fall() -> None:
    end = "- {at: 9, who: rider, do: {go_to: [3, -3]}}\n"
    play = play_scene(f"duration: 18\n{PUSHED_RIDE}{end}")
    rider, now = play.records[:, 1], 9 * STEPS
    rate = np.abs(_turn_rate(play))
    assert rate[now] > 0.5
    assert rider["stun"][now:].max() < 0.2
    off = int(np.flatnonzero(rider["deck_share"][now:] < 0.01)[0])
    assert rate[now + off] < 0.7 * rate[now]
    assert rider["at"][-1] == pytest.approx([3.0, -3.0], abs=0.3)


def test_hands_follow_the_posts_of_a_turning_merry_go_round_from_step_to_step() -> None:
    offsets = {"rider": list[float](), "pusher": list[float]()}

    def look(troupe: Characters, step: int) -> None:
        for controller in troupe.dispatcher.controllers if step > 6 * STEPS else ():
            for k in range(2):
                if controller.held_node(k) >= 0:
                    offset = controller.held_place(k) - controller.record.arm_target[k]
                    offsets[controller.name].append(math.hypot(offset[0], offset[2]))

    play = play_scene(f"duration: 9\n{PUSHED_RIDE}", look)
    moved = 0.8 * np.abs(_turn_rate(play)).max() / STEPS
    assert moved > 0.005
    for found in offsets.values():
        # Nearly all the time a hand holds the post, and no target lags by two steps.
        assert len(found) > 2 * STEPS
        assert max(found) < 3.0 * moved


@pytest.mark.parametrize(("sense", "spin_deg"), [(1.0, 0.0), (-1.0, -20.0)])
def test_a_rider_sees_where_a_merry_go_round_carries_it(sense: float, spin_deg: float) -> None:
    # Who pushes goes on as it turns already.
    turning = f"character: merry-go-round, spin_deg: [0, {spin_deg}, 0]"
    ride = PUSHED_RIDE.replace("character: merry-go-round", turning)
    play = play_scene(f"duration: 9\n{ride}")
    rider, now = play.records[6 * STEPS :, 1], 6 * STEPS
    assert (sense * _turn_rate(play)[now:]).min() > 0.3
    v = np.diff(play.joint("rider", "pelvis")[now:, ::2], axis=0)
    way = np.arctan2(-v[:, 1], v[:, 0])
    assert np.hypot(*v.T).mean() * STEPS > 0.3
    assert (np.cos(rider["gaze"][1:, 0] - way) > 0.0).mean() > 0.98
    # The body is half turned to it, so that the neck need not be.
    assert (np.cos(rider["heading"][1:] - way) > math.cos(math.radians(75.0))).mean() > 0.95


@pytest.mark.nightly
def test_a_rider_steps_onto_a_merry_go_round_and_another_pushes_it() -> None:
    cast = "- {name: c, character: merry-go-round}\n"
    cast += "- {name: rider, character: child, at: [1.75, -0.6], heading_deg: 180}\n"
    cast += "- {name: pusher, character: child, at: [-1.7, 0.2], heading_deg: 0, scale: 1.15}\n"
    script = "script:\n- {at: 0, who: rider, do: {ride: c}}\n"
    script += "- {at: 2.5, who: pusher, do: {push: c, turns: 0.25}}\n"
    play = play_scene(f"duration: 9\ncast:\n{cast}{script}")
    # Records are in the order of names.
    pusher, rider = play.records[:, 0], play.records[:, 1]
    rate = _turn_rate(play)
    # A rider does not turn what it stands on.
    assert np.abs(rate[: round(2.5 * STEPS)]).max() < 0.03
    assert play.when("rider")
    assert play.when("pusher")
    assert rider["deck_share"][-1] == pytest.approx(1.0, abs=1e-3)
    assert rate.max() > 0.35
    assert max(rider["stun"].max(), pusher["stun"].max()) < 0.2
    assert (pusher["deck_share"] == 0.0).all()
    # Nobody's arm stays out.
    assert (pusher["arm_mode"][-1] == 0).all()


@pytest.mark.parametrize("rate", [0.4, -0.4])
def test_who_steps_onto_a_turning_deck_aims_at_where_the_gap_will_be(rate: float) -> None:
    cast = "- {name: c, character: merry-go-round}\n- {name: kid, character: child, at: [1.8, 0]}"
    characters = troupe_of(Simulation(read_scene(f"pronk: 1\nduration: 1\ncast:\n{cast}")))
    controller = characters.dispatcher.controllers[0]
    pose = carousel_pose(controller.view, controller.view.owner("c"))
    pose = replace(pose, measure_rate=lambda: rate)

    def aim(deck_share: float) -> float:
        """Return the angle from the gap to where the person goes [rad]."""
        task = RideCarousel("c", controller.view.owner("c"))
        # Its gap is right before it.
        task.gap = pose.angle_of(*controller.record.at.tolist()) - pose.angle
        controller.record.deck_share, controller.record.stepping = deck_share, True
        task._step_on(controller, pose, 1.0 / STEPS)
        return pose.angle_of(*controller.record.goal.tolist()) - pose.angle - task.gap

    assert aim(0.0) == pytest.approx(CROSSING_LEAD * rate)
    # On the deck it turns along.
    assert aim(0.5) == pytest.approx(0.0, abs=1e-9)
