"""Character plans: nodes and links of people and things."""

from __future__ import annotations

import re

import numpy as np
import pytest

from pipeline.simulation.characters.body_plan import character_arrays
from pipeline.simulation.characters.character_plans import LINK_NAMES, RAGDOLL, person_plan
from pipeline.simulation.characters.playthings import (
    BALL_RADIUS,
    BOX_SIZES,
    DECK_RADIUS,
    merry_go_round_plan,
)
from pipeline.simulation.people.proportions import ADULT, CHILD, JOINTS, SEGMENTS, Proportions
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene
from pipeline.spec.character_kinds import KIND_TEXTS
from tests.simulation.characters.character_yard import (
    build_yard,
    largest_joint_excess,
    random_rotation,
)
from tests.simulation.characters.scripted_people import STEPS, troupe_of

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("body", [ADULT, CHILD])
def test_a_person_is_sixteen_nodes_and_thirteen_links(body: Proportions) -> None:
    plan = person_plan(body)
    assert len(plan.rest) == len(JOINTS) == 16
    touched = [link for link in plan.links if link.radius > 0.0]
    # The skull is a sphere around a node.
    assert len([link for link in touched if link.ends[0] != link.ends[1]]) == len(SEGMENTS) == 13
    assert [name for name in LINK_NAMES if name not in SEGMENTS] == ["skull"]
    assert plan.mass.sum() == pytest.approx(body.mass, rel=1e-9)


def test_a_merry_go_round_is_eighteen_nodes_and_forty_one_links() -> None:
    plan = merry_go_round_plan(1.3, 90.0)
    assert len(plan.rest) == 18
    assert len(plan.links) == 41
    assert len([link for link in plan.links if link.radius > 0.0]) == 25


@pytest.mark.parametrize("body", [ADULT, CHILD])
@pytest.mark.parametrize("seed", range(4))
def test_reversed_knees_and_elbows_recover(body: Proportions, seed: int) -> None:
    rng = np.random.default_rng(seed)
    plan = person_plan(body)
    turn = random_rotation(rng)
    rest = plan.rest.copy()
    # Knees bent back and elbows forward by 10 cm.
    for name, way in (("knee", -0.1), ("elbow", 0.1)):
        for side in "lr":
            rest[JOINTS.index(f"{name}_{side}"), 0] += way
    yard = build_yard([plan], [rest @ turn.T + [0.0, 20.0, 0.0]], gravity=0.0)
    assert largest_joint_excess(yard.arrays.nodes, yard.arrays.limbs) > 0.1
    # They come back at a limited speed.
    yard.step(20)
    assert largest_joint_excess(yard.arrays.nodes, yard.arrays.limbs) < 1e-6
    # In the present axes of the trunk the knee lies in front of hip and foot.
    p = {name: yard.arrays.p[k] for k, name in enumerate(JOINTS)}
    forward = np.cross(p["spine"] - p["pelvis"], p["hip_r"] - p["hip_l"])
    for side in "lr":
        hip, knee, foot = (p[f"{name}_{side}"] for name in ("hip", "knee", "foot"))
        along = (foot - hip) / np.linalg.norm(foot - hip)
        aside = (knee - hip) - ((knee - hip) @ along) * along
        assert aside @ forward > -1e-9


def test_node_and_link_numbers_are_offset_by_each_characters_first() -> None:
    plans = [person_plan(CHILD), merry_go_round_plan(1.3, 90.0), person_plan(ADULT)]
    arrays = character_arrays(plans, [plan.rest for plan in plans])
    for k, owner in enumerate(arrays.owners):
        first, count = owner.links
        links = arrays.links[first : first + count]
        assert (links["owner"] == k).all()
        assert (arrays.nodes["owner"][links["ends"]] == k).all()
        first, count = owner.pairs
        assert (arrays.links["owner"][arrays.pairs[first : first + count]] == k).all()
    assert (arrays.links["owner"][arrays.nodes["ground_link"]] == arrays.nodes["owner"]).all()


def test_a_merry_go_round_rests_on_its_base_and_keeps_turning() -> None:
    simulation = Simulation(
        read_scene(
            "pronk: 1\nduration: 2\ncast: [{character: merry-go-round, spin_deg: [0, 60, 0]}]\n"
        )
    )
    arrays = troupe_of(simulation).arrays
    assert arrays.p[:, 1].min() == pytest.approx(0.22, abs=0.001)
    angles = []
    while not simulation.finished:
        simulation.step()
        angles.append(np.arctan2(-arrays.p[2, 2], arrays.p[2, 0]))
    rates = np.degrees(np.diff(np.unwrap(angles))) * STEPS
    # Only air slows the merry-go-round.
    assert rates[-1] == pytest.approx(rates[0] * np.exp(-0.12 * 2.0), rel=0.02)


def test_listed_sizes_are_those_of_the_bodies() -> None:
    sizes = {
        "child": (CHILD.height,),
        "adult": (ADULT.height,),
        "ragdoll": (RAGDOLL.height,),
        "ball": (2 * BALL_RADIUS,),
        "merry-go-round": (2 * DECK_RADIUS,),
        "box": BOX_SIZES["box"][0][:1],
        "bench": BOX_SIZES["bench"][0][2:0:-1],
    }
    for kind, text in KIND_TEXTS.items():
        told = tuple(float(number) for number in re.findall(r"([\d.]+) m ", text))
        assert told == pytest.approx(sizes[kind])
