"""Targets of other rooms: people go up to, chase, flee, grab, throw, kick and sit on members."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache

import numpy as np
import pytest

from pipeline.simulation.characters.contact_tasks import GRAB_PATIENCE, Grab
from pipeline.simulation.convex_distance import convex_distance
from pipeline.simulation.dynamics.compiled import Record
from pipeline.simulation.members import MemberState
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.order_outcome import GripChange
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.spatial import Array
from pipeline.spec import read_scene
from tests.simulation.characters.scripted_people import node_path, run_scene, troupe_of

pytestmark = pytest.mark.slow

EVERYBODY = """pronk: 1
duration: 7
cast:
  - {name: kid, character: child, at: [0, 0]}
  - {name: ada, character: adult, at: [0, 4]}
  - {name: cat, character: adult, at: [-6, 8]}
  - {name: dan, character: child, at: [-6, 0]}
  - {name: eve, character: adult, at: [-6, 4]}
  - {name: fay, character: child, at: [-10, 4]}
  - {name: gus, character: child, at: [0, -6]}
  - {name: hal, character: adult, at: [-6, -6]}
  - {name: ivy, character: child, at: [5, -8], heading_deg: 180}
  - {name: ned, character: adult, at: [5, -4]}
  - {name: bug, figure: beetle, walk: {}, at: [3, 0]}
  - {name: rock, body: {shape: cube, size: 0.25, density: 2600}, at: [2, 0.126, 4]}
  - {name: marble, body: {shape: sphere, radius: 0.06, density: 400}, at: [1, 0.061, -6]}
  - {name: underfoot, body: {shape: sphere, radius: 0.13, density: 120}, at: [4.8, 0.131, -7.95]}
  - {name: behind, prop: {shape: ball, radius: 0.1}, at: [4.75, 0.1, -4]}
  - {name: stool, prop: {shape: box, size: [0.45, 0.45, 0.45]}, at: [-6, 0.225, 6.5]}
  - {name: pillar, prop: {shape: box, size: [0.5, 1.5, 0.5]}, at: [-3, 0.75, -1.5]}
  - {name: ball, character: ball, at: [-5, 0]}
places: {spot: [-3, -6]}
script:
  - {at: 0, who: kid, do: {chase: bug}}
  - {at: 0, who: ada, do: {grab: rock}}
  - {at: 1, who: ada, do: {throw: rock, to: bug}}
  - {at: 2, who: ada, do: {sit: pillar}}
  - {at: 0, who: cat, do: {sit: stool}}
  - {at: 0, who: dan, do: {grab: ball}}
  - {when: {arrived: dan}, who: dan, do: {throw: ball, to: pillar}}
  - {at: 0, who: eve, do: {reach: [-6, 3, 8]}}
  - {at: 2.5, who: eve, do: {go_to: pillar, gap: 0.5}}
  - {at: 0, who: fay, do: {avoid: eve}}
  - {at: 0.5, who: fay, do: {flee: eve, distance: 6}}
  - {at: 0, who: gus, do: {grab: marble}}
  - {when: {arrived: gus}, who: gus, do: {throw: marble, to: bug}}
  - {at: 0, who: hal, do: {go_to: spot}}
  - {at: 0, who: ivy, do: {grab: underfoot, hand: both}}
  - {at: 0, who: ned, do: {grab: behind, hand: both}}
"""

KICKS = """pronk: 1
duration: 3
cast:
  - {name: bob, character: adult, at: [0, 8]}
  - {name: amy, character: child, at: [0, 0]}
  - {name: rock, body: {shape: cube, size: 0.25, density: 2600}, at: [2, 0.126, 4]}
  - {name: football, body: {shape: sphere, radius: 0.11, density: 80}, at: [1.5, 0.111, 8]}
  - {name: balloon, body: {shape: sphere, radius: 0.25, density: 40}, at: [1.5, 0.251, 0]}
  - {name: stool, prop: {shape: box, size: [0.45, 0.45, 0.45]}, at: [-6, 0.225, 6.5]}
script:
  - {at: 0, who: bob, do: {kick: football, to: [6, 0, 10], speed: 6}}
  - {at: 0, who: amy, do: {kick: balloon, speed: 6}}
"""

OUT_OF_REACH = """pronk: 1
duration: 6
cast:
  - {name: amy, character: child, at: [0, 0]}
  - {name: bob, character: adult, at: [-2, 4]}
  - {name: kid, character: child, at: [-2, 8]}
  - {name: marble, body: {shape: sphere, radius: 0.06, density: 400}, at: [0.6, 0.061, 0]}
  - {name: ann, character: adult, at: [0, -4]}
  - {name: zoe, character: child, at: [4, -8]}
  - {name: lamp, prop: {shape: ball, radius: 0.05}, at: [4.3, 2.4, -8]}
  - {name: die, prop: {shape: box, size: [0.1, 0.1, 0.1]}, at: [1.2, 0.05, -4]}
  - {name: cart, prop: {shape: box, size: [0.4, 0.4, 0.4]}, at: [0, 0.2, 4], velocity: [0.9, 0, 0]}
  - {name: car, prop: {shape: box, size: [0.4, 0.4, 0.4]}, at: [0, 0.2, 8], velocity: [6, 0, 0]}
script:
  - {at: 0, who: amy, do: {grab: marble}}
  - {when: {arrived: amy}, who: amy, do: {throw: marble, to: [14, 0, 0]}}
  - {at: 0, who: bob, do: {follow: cart, gap: 0.8}}
  - {at: 0, who: kid, do: {chase: car}}
  - {at: 0, who: ann, do: {grab: die}}
  - {at: 0, who: zoe, do: {grab: lamp}}
"""


@dataclass
class Course:
    """What happened in a simulation.

    Attributes:
        arrived: times [s] by name.
        reasons: of orders that were given up, by name.
        grips: times [s] and changes.
        speeds: greatest speed of members [m/s].
        states: of members at the end.
        places: (2,) of people at the end [m].
        sitting: people that sit at the end.
    """

    arrived: dict[str, list[float]] = field(default_factory=dict)
    reasons: dict[str, list[str]] = field(default_factory=dict)
    grips: list[tuple[float, GripChange]] = field(default_factory=list)
    speeds: dict[str, float] = field(default_factory=dict)
    states: dict[str, MemberState] = field(default_factory=dict)
    places: dict[str, Array] = field(default_factory=dict)
    sitting: set[str] = field(default_factory=set)


@cache
def course() -> Course:
    """Simulate the scene once for all tests."""
    simulation = Simulation(read_scene(EVERYBODY))
    troupe, found = troupe_of(simulation), Course()
    members = simulation._members
    watched = ("ball", "bug", "pillar", "stool")
    while not simulation.finished:
        simulation.step()
        facts, time = troupe.facts(), simulation.step_number * simulation.world.clock.dt
        for name in facts.arrived:
            found.arrived.setdefault(name, []).append(time)
        for outcome in facts.outcomes:
            found.reasons.setdefault(outcome.who, []).append(outcome.reason)
        found.grips += [(time, change) for change in facts.grips]
        members.update(simulation.last_row())
        for name in watched:
            speed = float(np.linalg.norm(members.state(name).v))
            found.speeds[name] = max(found.speeds.get(name, 0.0), speed)
    found.states = {name: members.state(name) for name in watched}
    for controller in troupe.dispatcher.controllers:
        found.places[controller.name] = np.array(controller.record.at)
        if controller.record.sit_blend == 1.0:
            found.sitting.add(controller.name)
    return found


@pytest.mark.nightly
def test_people_step_off_from_balls_at_their_feet_and_take_them() -> None:
    for name, ball in (("ivy", "underfoot"), ("ned", "behind")):
        assert course().arrived[name][0] < 5.0
        change = next(change for _, change in course().grips if change.member == ball)
        assert change.hands == (f"{name}.hand_l", f"{name}.hand_r")


ROLLING = """pronk: 1
duration: 7
terrain: {{kind: ramp, course: up, start: -15, slope_deg: {slope}, height: 4}}
cast:
{cast}
script:
{script}
"""


@pytest.mark.nightly
@pytest.mark.parametrize("slope", [0.5, 3.0])
def test_people_take_balls_that_roll_up_to_them_from_all_sides(slope: float) -> None:
    cast, script = [], []
    for k in range(12):
        kind, angle = ("child", "adult")[k % 2], np.radians(30.0 * k)
        x, z = 3.0 * (k % 4) - 4.5, 3.0 * (k // 4) - 3.0
        c, s = float(np.cos(angle)), float(np.sin(angle))
        at = [x + 1.2 * c, 0.133 + np.tan(np.radians(slope)) * (x + 1.2 * c + 15.0), z - 1.2 * s]
        ball = "shape: sphere, radius: 0.13, density: 120, rolling: 0.06"
        towards = f"[{-1.2 * c:.3f}, 0, {1.2 * s:.3f}]"
        cast.append(f"  - {{name: person{k}, character: {kind}, at: [{x}, {z}]}}")
        cast.append(
            f"  - {{name: ball{k}, body: {{{ball}}},"
            f" at: [{at[0]:.3f}, {at[1]:.3f}, {at[2]:.3f}], velocity: {towards}}}"
        )
        script.append(f"  - {{at: 0.5, who: person{k}, do: {{grab: ball{k}, hand: both}}}}")
    scene = ROLLING.format(slope=slope, cast="\n".join(cast), script="\n".join(script))
    orders = simulate(read_scene(scene)).orders
    assert [(order.who, order.outcome) for order in orders if order.outcome != "done"] == []
    assert len(orders) == 12


@pytest.mark.nightly
def test_a_child_chases_a_creature_until_it_touches_it() -> None:
    assert course().arrived["kid"][0] < 5.0


@pytest.mark.nightly
def test_impossible_orders_are_given_up_with_a_reason() -> None:
    heavy, empty, high = course().reasons["ada"]
    assert heavy == "too heavy for both hands (40.7 of at most 34.0 kg)"
    assert empty == "does not hold 'rock'"
    assert high.startswith("too high: 1.50 m, sits at 0.2")
    assert "m out of reach at [-6.00, 4.00]" in course().reasons["eve"][0]
    assert "ada" not in course().arrived


@pytest.mark.nightly
def test_people_walk_up_to_members_and_to_places_by_name() -> None:
    pillar, eve = course().states["pillar"], course().places["eve"]
    feet = np.array([[eve[0], 0.5, eve[1]]])
    # Half a metre from the surface to the side of the body.
    assert convex_distance(pillar.solids[0], feet) == pytest.approx(0.5 + 0.17 * 1.72, abs=0.2)
    assert np.hypot(*(course().places["hal"] - [-3.0, -6.0])) < 0.15
    assert len(course().arrived["hal"]) == 1


@pytest.mark.nightly
def test_kicks_send_bodies_off_in_their_direction() -> None:
    simulation, fastest = Simulation(read_scene(KICKS)), {"football": 0.0, "balloon": 0.0}
    while not simulation.finished:
        simulation.step()
        simulation._members.update(simulation.last_row())
        for name, speed in fastest.items():
            v = simulation._members.state(name).v
            fastest[name] = max(speed, float(np.linalg.norm(v)))
    # Nearly as fast as the foot, and past the target.
    assert 5.0 < fastest["football"] < 6.5
    path = node_path(simulation, "football")[:, [0, 2]]
    assert np.hypot(*(path - [6.0, 10.0]).T).min() < 0.3
    # The toes that meet a wide ball first add nothing to the kick.
    assert 4.0 < fastest["balloon"] < 6.5
    (kick,) = [order for order in simulation.take().orders if order.who == "amy"]
    assert kick.outcome == "done"


def _record_of(simulation: Simulation, name: str) -> Record:
    controllers = troupe_of(simulation).dispatcher.controllers
    return next(one.record for one in controllers if one.name == name)


@pytest.mark.nightly
def test_throws_and_chases_beyond_ones_strength_are_given_up() -> None:
    simulation = Simulation(read_scene(OUT_OF_REACH))
    while not simulation.finished:
        simulation.step()
    orders = {order.text.split()[0]: order for order in simulation.take().orders}
    # An adult gets down to a small prop on the ground.
    (grab,) = [order for order in simulation.take().orders if order.who == "ann"]
    assert grab.outcome == "done"
    assert "as hard as it can" in orders["throw"].reason
    # A lamp high overhead is not waited for.
    (lamp,) = [order for order in simulation.take().orders if order.who == "zoe"]
    assert "out of reach" in lamp.reason
    assert lamp.end < 4.5 / 6.0 * simulation.world.clock.last_step
    # It flies nevertheless.
    assert node_path(simulation, "marble")[:, 0].max() > 5.0
    assert orders["chase"].reason.startswith("is not fast enough")
    assert orders["chase"].end < simulation.world.clock.last_step
    # The follower walks on behind the cart, which is half as wide as 0.4 m.
    follower, cart = _record_of(simulation, "bob"), node_path(simulation, "cart")[-1, 0]
    assert cart - 0.2 - float(follower["at"][0]) == pytest.approx(0.8 + 0.17 * 1.72, abs=0.25)


@pytest.mark.nightly
def test_a_grabbed_body_is_handed_over_and_thrown() -> None:
    (start, taken), (end, thrown) = [pair for pair in course().grips if pair[1].holder == "gus"]
    assert (taken.hands, taken.member, taken.taken) == (("gus.hand_r",), "marble", True)
    assert not thrown.taken
    assert start < 4.0 < 7.0 > end > start + 0.4
    assert thrown.velocity is not None
    assert np.linalg.norm(thrown.velocity) < 10.0


@pytest.mark.nightly
def test_a_child_takes_a_wide_ball_with_both_hands_and_throws_it() -> None:
    took, threw = course().arrived["dan"]
    assert took < 4.0
    assert threw < took + 3.0
    assert course().speeds["ball"] > 2.0


@pytest.mark.nightly
def test_an_adult_sits_down_on_a_prop() -> None:
    assert "cat" in course().sitting
    assert np.hypot(*(course().places["cat"] - [-6.0, 6.5])) < 0.6


def test_a_child_flees_until_it_is_far_enough() -> None:
    assert len(course().arrived["fay"]) == 1
    assert course().arrived["fay"][0] < 5.0


BALLS = {
    "prop": "prop: {shape: ball, radius: 0.12}, at: [0.4, 0.12, 0]",
    "character": "character: ball, at: [0.4, 0]",
}


@pytest.mark.slow
@pytest.mark.parametrize("ball", [pytest.param("prop", marks=pytest.mark.nightly), "character"])
def test_a_ball_is_lifted_between_both_hands_and_thrown_at_once(ball: str) -> None:
    take = simulate(
        read_scene(
            f"""
pronk: 1
duration: 4
cast:
  - {{name: kid, character: child, at: [0, 0]}}
  - {{name: ball, {BALLS[ball]}}}
script:
  - {{at: 0.1, who: kid, do: {{grab: ball, hand: both}}}}
  - {{when: {{arrived: kid}}, who: kid, do: {{throw: ball, to: [2.1, 0.7, 0]}}}}
"""
        )
    )
    names = NodeNames.of(take)
    left, right, middle = (
        take.positions[:, names.find(name)] for name in ("kid.hand_l", "kid.hand_r", "ball")
    )
    rate = float(take.header.rate) * take.header.samples
    speed = np.linalg.norm(np.diff(middle, axis=0), axis=1) * rate
    grabbed = next(order.end for order in take.orders if order.text.startswith("grab"))
    first = grabbed // (take.header.steps // take.header.samples)
    launch = first + int(np.argmax(speed[first:] > 3.0))
    assert first < launch < len(middle) - 1
    # Until the throw it is between the hands, and does not fly up.
    held = slice(first, launch - 1)
    between = 0.5 * (left + right)[held] - middle[held]
    assert np.linalg.norm(between, axis=1).max() < 0.2
    # Where it passes over the target, which its surface hits.
    passed = launch + int(np.argmax(middle[launch:, 0] > 2.1))
    assert passed > launch
    assert middle[passed, 1] == pytest.approx(0.82, abs=0.15)
    assert abs(middle[passed, 2]) < 0.1


@pytest.mark.nightly
@pytest.mark.parametrize("ball", BALLS)
def test_a_ball_that_is_carried_lies_still_where_it_is_put_down(ball: str) -> None:
    order = "  - {at: 0.1, who: kid, do: {carry: ball, to: [1.8, 0.4], hand: both}}\n"
    cast = f"  - {{name: kid, character: child, at: [0, 0]}}\n  - {{name: ball, {BALLS[ball]}}}"
    simulation = run_scene(cast, 8.0, order)
    (carry,) = simulation.take().orders
    assert carry.outcome == "done"
    path = node_path(simulation, "ball")
    assert path[:, 1].max() > 0.5
    assert np.linalg.norm(path[-1] - path[-24]) < 0.01
    assert np.hypot(*(path[-1, [0, 2]] - [1.8, 0.4])) < 0.25


@pytest.mark.nightly
def test_what_is_in_one_hand_is_taken_by_both() -> None:
    simulation = run_scene(
        "  - {name: kid, character: child, at: [0, 0]}\n"
        "  - {name: ball, prop: {shape: ball, radius: 0.06}, at: [0.5, 0.06, 0]}",
        6.0,
        "  - {at: 0.1, who: kid, do: {grab: ball, hand: right}}\n"
        "  - {at: 3.5, who: kid, do: {grab: ball, hand: both}}\n",
    )
    assert [order.outcome for order in simulation.take().orders] == ["done", "done"]
    controller = troupe_of(simulation).dispatcher.controllers[0]
    assert controller.hands_holding("ball") == (0, 1)


@pytest.mark.nightly
def test_a_ball_that_rolls_away_too_fast_is_given_up() -> None:
    simulation = run_scene(
        "  - {name: kid, character: child, at: [-6, 0]}\n"
        "  - {name: ball, body: {shape: sphere, radius: 0.13, density: 120, rolling: 0.02},"
        " at: [-5, -0.3, 0], velocity: [1.1, 0, 0]}",
        11.0,
        "  - {at: 0.3, who: kid, do: {grab: ball, hand: both}}\n",
        terrain="{kind: ramp, course: down, start: -15, slope_deg: 3, height: 4}",
    )
    (grab,) = simulation.take().orders
    assert grab.reason.startswith("is not fast enough; still ")


def test_a_hand_lets_go_again_of_one_that_the_other_cannot_take() -> None:
    simulation = run_scene(
        "  - {name: kid, character: child, at: [0, 0]}\n"
        "  - {name: doll, character: ragdoll, at: [0.4, 0]}",
        0.2,
    )
    controller = troupe_of(simulation).dispatcher.controllers[0]
    owner = controller.view.number("doll")
    grab = Grab((0, 1), owner)
    controller.grip(1, controller.node_to_grip(owner, None, 1))
    grab.progress.time = 2.0 * GRAB_PATIENCE
    grab.progress.least = 0.0
    grab._check_progress(controller, 0.44, 0.01)
    assert controller.hands_holding("doll") == ()
    assert grab.failure.startswith("lets go again: the other hand stays 0.44 m out of reach at [")


PORTERS = """pronk: 1
duration: 13
terrain: {kind: flat, size: [20, 20]}
cast:
  - {name: kid, character: child, at: [0.31, -0.41], heading_deg: 160}
  - {name: tin, prop: {shape: box, size: [0.07, 0.08, 0.1]}, at: [0, 0.04, 0]}
  - {name: ada, character: adult, at: [-2.17, 4.86], heading_deg: 162, scale: 1.07}
  - {name: brick, prop: {shape: box, size: [0.1, 0.08, 0.1]}, at: [0, 0.04, 4]}
  - {name: ben, character: adult, at: [-1.3, -4], heading_deg: 20}
  - {name: cup, prop: {shape: box, size: [0.08, 0.1, 0.08]}, at: [-0.2, 0.05, -4]}
  - name: table
    prop: {shape: box, size: [0.8, 0.45, 0.8]}
    at: [1.5, 0.225, -4]
    keyframes: [{at: 10.5, position: [1.5, 0.225, -4]}, {at: 10.8, position: [4.5, 0.225, -4]}]
script:
  - {at: 0.3, who: kid, do: {carry: tin, to: [-2.03, -0.58]}}
  - {at: 0.3, who: ada, do: {carry: brick, to: [1.09, 5.72]}}
  - {at: 0.3, who: ben, do: {carry: cup, to: table}}
"""


def test_a_hand_puts_a_thing_down_before_its_shoulder_and_stays_done() -> None:
    """On the way to the middle the thigh would bar it; what becomes of it later is another's."""
    orders = simulate(read_scene(PORTERS)).orders
    assert [(order.who, order.outcome) for order in orders] == [
        ("kid", "done"),
        ("ada", "done"),
        ("ben", "done"),
    ]
    took = {order.who: (order.end - order.step) / 96.0 for order in orders}
    assert max(took.values()) < 9.5, took
