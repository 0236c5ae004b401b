"""Link contacts: collisions, tactile sensing and pain."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.simulation.characters.body_arrays import NOBODY, TERRAIN
from pipeline.simulation.characters.body_plan import BodyPlan, Link
from pipeline.simulation.characters.character_plans import LINK_NAMES, RAGDOLL, person_plan
from pipeline.simulation.characters.playthings import ball_plan, box_plan, merry_go_round_plan
from pipeline.simulation.characters.verlet_step import PAIN_DECAY
from pipeline.simulation.people.proportions import ADULT, CHILD
from tests.simulation.characters.character_yard import (
    DT,
    build_yard,
    character_overlap,
    link_length_error,
)

pytestmark = pytest.mark.slow


def test_a_link_senses_the_striker_and_the_energy() -> None:
    plans = [person_plan(CHILD), ball_plan(0.1, 0.4)._replace(air_damping=0.0)]
    shin = plans[0].rest[[12, 14]].mean(axis=0)
    yard = build_yard(
        plans, [plans[0].rest, np.array([shin + np.array([0.35, 0.0, 0.0])])], gravity=0.0
    )
    v = np.zeros_like(yard.arrays.p)
    v[16, 0] = -6.0
    yard.set_velocities(v)
    links = yard.arrays.links
    while not yard.log.filled[0]:
        yard.step()
    event = yard.log.events[0]
    struck, other = LINK_NAMES.index("shin_l"), len(plans[0].links)
    assert (event.link, event.other) == (struck, other)
    assert links["touched"][struck] == other
    assert links["touched_owner"][struck] == 1
    # Half of the reduced mass times the square of the speed along the normal.
    lighter = 1.0 / (plans[0].mass[12] + plans[0].mass[14]) + 1.0 / 0.4
    speed = -np.dot(event.normal, [6.0, 0.0, 0.0])
    assert abs(speed) == pytest.approx(6.0, rel=0.02)
    assert links["energy"][struck] == pytest.approx(0.5 * speed**2 / lighter, rel=0.02)
    yard.step(60)
    assert links["touched"][struck] == NOBODY


def test_pain_decays_exponentially() -> None:
    plan = person_plan(CHILD)
    yard = build_yard([plan], [plan.rest + np.array([0.0, 20.0, 0.0])], gravity=0.0)
    yard.arrays.owners["pain"][0] = 2.0
    yard.step(96)
    assert yard.arrays.owners["pain"][0] == pytest.approx(2.0 * math.exp(-PAIN_DECAY), rel=1e-9)


def test_a_fall_hurts_and_lying_does_not() -> None:
    plan = person_plan(ADULT)
    yard = build_yard([plan], [plan.rest + np.array([0.0, 2.0, 0.0])])
    yard.step(96)
    fallen = float(yard.arrays.owners["pain"][0])
    assert fallen > 0.2
    assert (yard.arrays.links["touched"] == TERRAIN).any()
    yard.step(300)
    lying = float(yard.arrays.owners["pain"][0])
    yard.step(300)
    # From then on the pain only decays.
    left = math.exp(-PAIN_DECAY * 300 * DT)
    assert yard.arrays.owners["pain"][0] == pytest.approx(left * lying, rel=1e-9)


@pytest.mark.parametrize("apart", [0.0, 0.02, 0.15])
def test_initial_overlap_resolves_slowly(apart: float) -> None:
    plan = person_plan(ADULT)
    up = np.array([0.0, 20.0, 0.0])
    places = [plan.rest + up, plan.rest + up + [apart, 0.0, 0.01]]
    yard = build_yard([plan, plan], places, gravity=0.0)
    fastest = 0.0
    for _ in range(150):
        before = yard.arrays.p.copy()
        yard.step()
        fastest = max(fastest, float(np.abs(yard.arrays.p - before).max()) / DT)
    assert character_overlap(yard.arrays.nodes, yard.arrays.links) < 0.005
    # Links pushed apart in one step would leave at their width a step, some 15 m/s.
    assert fastest < 5.0


def test_a_ball_lies_on_a_box_and_a_person_on_a_bench() -> None:
    crate, seat = box_plan((0.5, 0.5, 0.5), 9.0), box_plan((0.42, 0.42, 1.5), 26.0)
    plans = [crate, ball_plan(0.1, 0.4), seat, person_plan(CHILD)]
    lying = plans[3].rest[:, [2, 0, 1]] - [0.0, 0.0, 0.5]
    places = [
        crate.rest,
        np.array([[0.0, 0.62, 0.0]]),
        seat.rest + np.array([3.0, 0.0, 0.0]),
        lying + np.array([3.0, 0.65, 0.0]),
    ]
    yard = build_yard(plans, places)
    yard.step(300)
    p, first = yard.arrays.p, 8 + 1 + 8
    assert p[8, 1] == pytest.approx(0.6, abs=0.005)
    assert p[first, 1] > 0.42
    assert link_length_error(yard.arrays) < 0.005


def rod(length: float, girth: float, mass: float) -> BodyPlan:
    """Return one link along X, its middle at the origin."""
    return BodyPlan(
        rest=np.array([[-0.5 * length, 0.0, 0.0], [0.5 * length, 0.0, 0.0]]),
        mass=np.full(2, 0.5 * mass),
        radius=np.full(2, girth),
        links=(Link((0, 1), girth),),
    )


@pytest.mark.parametrize("along", [0.0, 0.03, 0.05])
def test_box_edges_touch_limbs_anywhere_along_them(along: float) -> None:
    crate, limb = box_plan((0.5, 0.5, 0.5), 9.0), rod(0.4, 0.03, 2.0)
    # Across the upper edge of a box that stands on one, high above the ground.
    standing = crate.rest @ quarter().T + [0.0, 2.0, 0.0]
    edge = standing[np.argmax(standing[:, 1])] * [1.0, 1.0, 0.0]
    over = edge + np.array([along, 0.01 + 0.03 - 0.02, 0.0])
    yard = build_yard([crate._replace(mass=np.full(8, np.inf)), limb], [standing, limb.rest + over])
    assert character_overlap(yard.arrays.nodes, yard.arrays.links) > 0.01
    yard.step(12)
    for _ in range(18):
        yard.step()
        assert character_overlap(yard.arrays.nodes, yard.arrays.links) < 1e-3


def quarter() -> np.ndarray:
    """Return half of a right angle about Z, which stands a box on an edge."""
    c = math.sqrt(0.5)
    return np.array([[c, -c, 0.0], [c, c, 0.0], [0.0, 0.0, 1.0]])


def test_heavy_things_do_not_press_light_ones_into_the_ground() -> None:
    bench, limb = box_plan((0.42, 0.42, 1.5), 26.0), rod(0.15, 0.015, 0.04)
    # One end lies below the bench, near its side.
    lying = limb.rest + np.array([0.21 + 0.05, 0.015, -0.1])
    yard = build_yard([bench, limb], [bench.rest + np.array([0.0, 0.02, 0.0]), lying])
    deepest = 0.0
    for step in range(6 * 96):
        yard.step()
        if step > 96:
            deepest = max(deepest, float((limb.radius[0] - yard.arrays.p[8:, 1]).max()))
    assert deepest < 0.003
    assert character_overlap(yard.arrays.nodes, yard.arrays.links) < 0.005


KNOT = """
-31 37 7    32 41 0     73 41 -93     43 42 -152   135 56 -85   10 27 -101  66 121 -69  -64 14 -41
14 66 -82   -102 12 25  -41 43 39     -21 32 -25   -57 100 142  21 103 59   -32 25 237  -47 38 140
"""
"""The nodes of a ragdoll whose legs are in one another, where its hips do not let them part [mm].
"""


def test_tangled_legs_come_to_rest() -> None:
    plan = person_plan(RAGDOLL)
    yard = build_yard([plan], [np.array(KNOT.split(), dtype=float).reshape(16, 3) / 1000.0])
    yard.step(3 * 96)
    before = yard.arrays.p.mean(axis=0)
    yard.step(96)
    assert math.dist(yard.arrays.p.mean(axis=0), before) < 0.005
    yard.step(12 * 96)
    assert yard.arrays.owners["asleep"][0]


def test_links_touch_steep_ground_and_ignore_distant_ground() -> None:
    """A ragdoll on stairs: neither nodes nor links lie deep in them."""
    from pipeline.simulation.dynamics.terrain_grid import grid_of
    from pipeline.simulation.terrain.heightfield import HeightField

    x = np.linspace(-4.0, 4.0, 161)
    heights = np.tile(0.16 * np.floor(-x / 0.3 + 1e-9), (9, 1))
    field = HeightField(heights, (8.0, 8.0))
    plan = person_plan(RAGDOLL)
    yard = build_yard(
        [plan], [plan.rest + np.array([-2.0, 1.6, 0.0])], grid=grid_of(field), level=False
    )
    v = np.zeros_like(yard.arrays.p)
    v[:, 0] = 5.0
    yard.set_velocities(v)
    yard.step(700)
    arrays = yard.arrays
    assert np.isfinite(arrays.p).all()
    assert arrays.p[0, 0] > -1.2
    gap = arrays.p[:, 1] - field.height(arrays.p[:, 0], arrays.p[:, 2])
    # The centre of a node is never below the surface.
    assert gap.min() > 0.0
    assert link_length_error(arrays) < 0.005


def test_a_pushed_merry_go_round_turns_in_place() -> None:
    plan = merry_go_round_plan(1.3, 90.0)
    yard = build_yard([plan], [plan.rest])
    nodes = yard.arrays.nodes
    post = 2 + 8
    for _ in range(48):
        # A push along the rim.
        across = np.cross([0.0, 1.0, 0.0], yard.arrays.p[post])
        nodes["acceleration"][post] = 60.0 * across / np.linalg.norm(across)
        yard.step()
    v = yard.velocities[2:]
    rate = np.cross(yard.arrays.p[2:], v)[:, 1] / (yard.arrays.p[2:, [0, 2]] ** 2).sum(axis=1)
    assert rate.mean() > 0.1
    assert rate.std() < 0.1 * rate.mean()
    np.testing.assert_array_equal(yard.arrays.p[:2], plan.rest[:2])
    assert np.abs(yard.arrays.p[2:10, 1] - plan.rest[2:10, 1]).max() < 0.005
    assert link_length_error(yard.arrays) < 0.005


@pytest.mark.parametrize("beside", [0.03, 0.08])
def test_a_link_with_a_locked_end_stays_solid(beside: float) -> None:
    """A shin is a lever about the planted foot: hard to push near it."""
    lever, bar = rod(0.4, 0.04, 2.0), rod(0.4, 0.04, 8.0)
    lever = lever._replace(mass=np.array([np.inf, 1.0]))
    across = bar.rest[:, [2, 1, 0]] + [-0.2 + beside, 0.0, 0.0]
    places = [lever.rest + np.array([0.0, 1.0, 0.0]), across + np.array([0.0, 1.083, 0.0])]
    yard = build_yard([lever, bar], places, gravity=0.0)
    yard.set_velocities(np.array([[0.0, 0.0, 0.0]] * 2 + [[0.0, -1.0, 0.0]] * 2))
    deepest, met = 0.0, False
    for _ in range(12):
        yard.step()
        met = met or bool(yard.log.filled[0])
        deepest = max(deepest, character_overlap(yard.arrays.nodes, yard.arrays.links))
    assert met
    assert deepest < 0.0005


@pytest.mark.parametrize(
    ("embraces", "side", "is_parted"), [(1, 1.0, False), (NOBODY, 1.0, True), (1, -1.0, True)]
)
def test_only_arms_that_lie_around_somebody_come_nearer_to_the_back(
    embraces: int, side: float, is_parted: bool
) -> None:
    """A trunk is as wide as its links, and not as deep."""
    plan = person_plan(ADULT)
    belly, forearm = (plan.links[LINK_NAMES.index(name)] for name in ("belly", "forearm_r"))
    off = 0.75 * side * (belly.radius + forearm.radius)
    up = np.array([0.0, 20.0, 0.0])
    places = [plan.rest + up, plan.rest + up + [0.3 - off, 0.3, 0.0]]
    middle = places[1][list(belly.ends)].mean(axis=0)
    # Across the other's trunk, behind it or before it.
    for node, z in zip(forearm.ends, (0.12, -0.13), strict=True):
        places[0][node] = middle + np.array([off, 0.0, z])
    yard = build_yard([plan, plan], places, gravity=0.0)
    yard.arrays.owners["embraces"][0] = embraces
    yard.step(4)
    ends = yard.arrays.p[list(forearm.ends)].mean(axis=0)
    trunk = yard.arrays.p[len(plan.rest) :][list(belly.ends)].mean(axis=0)
    nearest = belly.radius + forearm.radius
    assert (side * (ends - trunk)[0] > 0.85 * nearest) == is_parted
