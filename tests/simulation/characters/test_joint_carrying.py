"""Joint carrying: things go from hand to hand, and two carry one thing together."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.bodies.body_guide import pose_of_holds
from pipeline.simulation.bodies.collider_troupe import ColliderTroupe
from pipeline.simulation.characters.crew import STANDOFF, CarryEnd, Crew, Stage, crew_of
from pipeline.simulation.dynamics.kinematic_bodies import Poses
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import matrix
from pipeline.spec import read_scene
from tests.simulation.characters.scripted_people import node_path, run_scene, troupe_of


@pytest.mark.slow
@pytest.mark.parametrize("names", ["ab", pytest.param("ba", marks=pytest.mark.nightly)])
@pytest.mark.nightly
def test_what_another_holds_is_handed_over(names: str) -> None:
    giver, taker = names[0], names[1]
    cast = {
        giver: f"  - {{name: {giver}, character: adult, at: [0.8, 0], heading_deg: 180}}\n",
        taker: f"  - {{name: {taker}, character: child, at: [2, 1.5]}}\n",
    }
    simulation = run_scene(
        cast["a"] + cast["b"] + "  - {name: ball, character: ball, at: [0, 0], scale: 0.5}",
        11.0,
        f"  - {{at: 0.1, who: {giver}, do: {{grab: ball}}}}\n"
        f"  - {{when: {{arrived: {giver}}}, who: {taker}, do: {{grab: ball}}}}\n",
    )
    assert [order.outcome for order in simulation.take().orders] == ["done", "done"]
    people = {one.name: one for one in troupe_of(simulation).dispatcher.controllers}
    assert people[taker].hands_holding("ball")
    assert not people[giver].hands_holding("ball")
    # It never lay on the ground in between.
    heights = node_path(simulation, "ball")[:, 1]
    first = int(np.argmax(heights > 0.4))
    assert heights[first:].min() > 0.3


@pytest.mark.nightly
def test_one_who_does_something_keeps_what_it_holds() -> None:
    simulation = run_scene(
        "  - {name: a, character: adult, at: [0.8, 0], heading_deg: 180}\n"
        "  - {name: b, character: child, at: [1, 1.2]}\n"
        "  - {name: ball, character: ball, at: [0, 0], scale: 0.5}",
        9.5,
        "  - {at: 0.1, who: a, do: {grab: ball}}\n"
        "  - {when: {arrived: a}, who: b, do: {grab: ball}}\n"
        "  - {when: {arrived: a}, who: a, do: {follow: b}}\n",
    )
    (order,) = [order for order in simulation.take().orders if order.who == "b"]
    assert (order.outcome, order.reason) == ("given up", "a holds it")


CRATE = """pronk: 1
duration: {duration}
cast:
  - {{name: a, character: adult, at: [-1.6, 0.3]}}
  - {{name: b, character: adult, at: [1.7, -0.2], heading_deg: 180}}
  - {{name: box, {box}}}
script:
  - {{at: 0.1, who: a, do: {{carry: box, to: [0.4, 2.2], hand: both}}}}
  - {{at: 0.1, who: b, do: {{carry: box, to: [0.4, 2.2], hand: both}}}}
"""
BOXES = {
    "character": "character: box, at: [0, 0]",
    "body": "body: {shape: box, size: [0.9, 0.4, 0.4], density: 280}, at: [0, 0.202, 0]",
}


@pytest.mark.nightly
@pytest.mark.parametrize("box", BOXES)
def test_two_carry_a_crate_level_and_put_it_down_together(box: str) -> None:
    simulation = Simulation(read_scene(CRATE.format(duration=20, box=BOXES[box])))
    while not simulation.finished:
        simulation.step()
    first, second = simulation.take().orders
    assert (first.outcome, second.outcome) == ("done", "done")
    assert abs(first.end - second.end) < 10
    path = node_path(simulation, "box")
    assert path[:, 1].max() > path[0, 1] + 0.2
    take = simulation.take()
    node = next(k for k, node in enumerate(take.nodes) if node.performer == "box")
    up = matrix(take.rotations[:, node])[:, 1, 1]
    assert np.degrees(np.arccos(np.clip(up.min(), -1.0, 1.0))) < 15.0
    assert np.hypot(*(path[-1, [0, 2]] - [0.4, 2.2])) < 0.4
    assert abs(path[-1, 1] - path[0, 1]) < 0.05


def test_a_crew_takes_the_two_ends_that_are_nearer() -> None:
    simulation = Simulation(read_scene(CRATE.format(duration=1, box=BOXES["body"])))
    simulation.step()
    troupe = troupe_of(simulation)
    troupe.see_members({"box": simulation._members.state("box")})
    crew = crew_of("box", "box", troupe.dispatcher.controllers)
    assert crew.stage is Stage.GATHER
    # The first stands on the side of -X, and the hands of both lie at the ends, apart.
    assert crew.along[0] == pytest.approx(-1.0, abs=1e-3)
    assert (crew.hands[0, :, 0] < -0.3).all()
    assert (crew.hands[1, :, 0] > 0.3).all()
    assert np.abs(np.diff(crew.hands[:, :, 2], axis=1)).min() > 0.3
    arm = crew.people[0].arm
    reach = np.abs(crew.hands[0] @ crew.along).max()
    assert crew.place(0)[0] == pytest.approx(-reach - STANDOFF * arm)


@pytest.mark.parametrize("names", ["ab", "ba"])
@pytest.mark.parametrize("box", BOXES)
def test_both_of_a_crew_hold_what_they_took_at_once(box: str, names: str) -> None:
    lines = CRATE.format(duration=2, box=BOXES[box]).splitlines()
    first = next(k for k, line in enumerate(lines) if "name: a," in line)
    lines[first : first + 2] = sorted(lines[first : first + 2], reverse=names == "ba")
    simulation = Simulation(read_scene("\n".join(lines)))
    dispatcher = troupe_of(simulation).dispatcher
    crew = _form_crew(simulation)
    crew.stage, crew.ready = Stage.TAKE, [True, True]
    for _ in range(3):
        simulation.step()
    assert crew.stage is Stage.LIFT
    assert all(one.hands_holding("box") == (0, 1) for one in dispatcher.controllers)
    if box == "body":
        bodies = next(one for one in simulation.troupes if isinstance(one, ColliderTroupe))
        assert len(bodies.guided.guides[0].holds) == 2
    # Hands that come open end it for both.
    dispatcher.controllers[0].let_go(0)
    dispatcher.controllers[0].let_go(1)
    for _ in range(4):
        simulation.step()
    reason = f"{dispatcher.controllers[0].name} has lost hold of it"
    assert [end.reason for end in simulation.take().orders] == [reason, reason]


def test_what_does_not_lie_at_its_goal_is_not_carried_there() -> None:
    simulation = Simulation(read_scene(CRATE.format(duration=1.5, box=BOXES["character"])))
    _form_crew(simulation).stage = Stage.DONE
    while not simulation.finished:
        simulation.step()
    orders = simulation.take().orders
    assert [order.outcome for order in orders] == ["given up", "given up"]
    assert orders[0].reason == "it lies 2.2 m off '[0.4, 2.2]'"


def _form_crew(simulation: Simulation) -> Crew:
    """Step until the crew of a crate has formed."""
    dispatcher = troupe_of(simulation).dispatcher
    while not isinstance(task := dispatcher.task(0), CarryEnd):
        simulation.step()
    return task.crew


def test_a_body_that_two_hold_lies_between_them() -> None:
    p = np.array([[0.0, 1.0, -0.2], [0.0, 1.0, 0.2], [2.0, 1.4, -0.2], [2.0, 1.4, 0.2]])
    poses = Poses(p, np.tile(np.eye(3), (4, 1, 1)))
    pose = pose_of_holds(poses, [(0, 1), (2, 3)])
    assert pose[:3, 3] == pytest.approx([1.0, 1.2, 0.0])
    # Along the way from one to the other, which rises.
    assert pose[:3, 0] == pytest.approx(np.array([2.0, 0.4, 0.0]) / np.hypot(2.0, 0.4))
    alone = pose_of_holds(poses, [(0, 1)])
    assert alone[:3, 3] == pytest.approx([0.0, 1.0, 0.0])
