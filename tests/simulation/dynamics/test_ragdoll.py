"""Ragdolls against closed forms, kinematics and invariants of every step."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import dataclass

import mujoco
import numpy as np
import pytest

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.dynamics.ragdoll import DEPENETRATION_SPEED, Ragdoll
from pipeline.simulation.dynamics.ragdoll_model import (
    FRICTION,
    SINEW_RATIO,
    WORLD,
    Bone,
    RagdollState,
    flesh_of,
    size_of,
)
from pipeline.simulation.figures.base_change import displacement_at
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass, build_bones
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.spatial import Array, matrix, quaternion, rotation
from pipeline.simulation.take import Take
from pipeline.simulation.terrain.heightfield import HeightField
from tests.simulation.conftest import scene_of
from tests.simulation.locomotion.hop_recorder import hop_through

DT = 1.0 / 96.0
LEVEL = HeightField(np.zeros((2, 2)), (20.0, 20.0))
HILLS = "{preset: hills, size: [40, 40], cells: [160, 160]}"

CORNERS = 0.5 * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
CUBE = Bone(WORLD, np.zeros(3), (), MassProperties(6.0, np.zeros(3), np.eye(3)), CORNERS)


def cube_at(x: float, y: float, v: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Ragdoll:
    none = np.zeros(0)
    begin = RagdollState(np.array([x, y, 0.0]), np.eye(4)[0], np.array(v), np.zeros(3), none, none)
    return Ragdoll([CUBE], begin, LEVEL)


# --- one bone -------------------------------------------------------------------------


def test_a_fall_is_one_impact_with_its_speed_and_energy():
    ragdoll = cube_at(0.0, 1.5)
    impacts = [(k, impact) for k in range(200) for impact in ragdoll.advance(DT)]
    ((step, impact),) = impacts
    # The edge is 1 m long and starts at a height of 1.5 m, so it falls by 1 m.
    assert step * DT + impact.time == pytest.approx(math.sqrt(2.0 / GRAVITY), abs=0.004)
    assert impact.speed == pytest.approx(math.sqrt(2.0 * GRAVITY), rel=0.02)
    assert impact.energy == pytest.approx(6.0 * GRAVITY, rel=0.04)
    assert impact.normal == pytest.approx([0, 1, 0])
    assert abs(impact.place[1]) < 0.02
    assert ragdoll.is_at_rest
    assert ragdoll.attitude.p[1] == pytest.approx(0.5, abs=0.005)


def test_a_sliding_body_stops_at_the_friction_distance():
    ragdoll = cube_at(-5.0, 0.5, (2.0, 0.0, 0.0))
    for _ in range(200):
        ragdoll.advance(DT)
    distance = 2.0**2 / (2.0 * FRICTION * GRAVITY)
    assert ragdoll.attitude.p[0] + 5.0 == pytest.approx(distance, rel=0.1)


@pytest.mark.parametrize("depth", [0.01, 0.05, 0.2])
def test_an_initial_overlap_with_the_ground_resolves_slowly(depth):
    ragdoll = cube_at(0.0, 0.5 - depth)
    before, fastest = 0.5 - depth, 0.0
    for _ in range(400):
        assert not ragdoll.advance(DT)
        y = float(ragdoll.attitude.p[1])
        fastest, before = max(fastest, (y - before) / DT), y
    assert fastest < 1.5 * DEPENETRATION_SPEED * ragdoll.size / ragdoll.tau
    assert before == pytest.approx(0.5, abs=0.005)


def test_a_body_that_leaves_the_terrain_falls_below_it():
    ragdoll = cube_at(9.9, 0.6, (3.0, 0.0, 0.0))
    for _ in range(600):
        ragdoll.advance(DT)
    assert ragdoll.is_gone
    assert np.isfinite(ragdoll.attitude.p).all()
    assert ragdoll.attitude.p[1] < -10.0


# --- figures ----------------------------------------------------------------------------


@dataclass
class Fallen:
    """A figure that fell, and measurements of its fall."""

    figure: Figure
    ragdoll: Ragdoll
    order: Array
    field: HeightField
    energies: list[float]
    limit_excess: float
    impact_count: int
    seconds: float

    @property
    def q(self) -> Array:
        """(J,) joint values, numbered as in the figure [rad or m]."""
        q = np.empty(len(self.order))
        q[self.order] = self.ragdoll.attitude.joints
        return q

    def points(self) -> Array:
        """Return the vertices of its solids (n, 3) [m]."""
        attitude, tree, found = self.ragdoll.attitude, JointTree.of(self.figure.skeleton), []
        X_BJ = tree.pose(self.q)
        for piece in self.figure.pieces:
            joint, own = self.figure.skeleton.links[piece.link].joint, piece.solid.vertices
            if joint != BODY:
                X = displacement_at(tree, X_BJ, joint)
                own = own @ X[:3, :3].T + X[:3, 3]
            found.append(attitude.p + own @ matrix(attitude.q).T)
        return np.concatenate(found)


def limit_excess(figure: Figure, q: Array) -> float:
    """Return the largest excess of a joint over its limits [rad or m]."""
    skeleton = figure.skeleton
    return max(float((skeleton.lower - q).max()), float((q - skeleton.upper).max()), 0.0)


def drop_figure(name: str, terrain: str, seconds: float, scale: float = 1.0) -> Fallen:
    """Drop a figure with a spin from above its standing height."""
    member = f"{{figure: {name}, scale: {scale}, pronk: {{}}}}"
    hops = Simulation(scene_of(member, terrain=terrain))
    troupe = next(iter(hops.troupes))
    figure, hopping, field = troupe.herd.figures[0], troupe.simulations[0], hops.world.ground.field
    leg = hopping.hopper.leg_length
    now = hopping.state.body(hopping.hopper)
    R = now.R @ rotation(np.array([1.0, 0.0, 0.0]), 0.6)
    own = build_bones(figure)
    begin = RagdollState(
        now.origin + np.array([0.0, 0.4 * leg, 0.0]),
        quaternion(R),
        math.sqrt(leg) * np.array([1.0, 0.0, 0.5]),
        np.array([0.5, 0.0, 1.5]) / math.sqrt(leg),
        figure.skeleton.preferred[own.joints],
        np.zeros(len(own.joints)),
    )
    ragdoll = Ragdoll(own.bones, begin, field)
    fallen = Fallen(figure, ragdoll, own.joints, field, [ragdoll.energy], 0.0, 0, 0.0)
    while fallen.seconds < seconds and not ragdoll.is_at_rest:
        fallen.impact_count += len(ragdoll.advance(DT))
        fallen.energies.append(ragdoll.energy)
        fallen.limit_excess = max(fallen.limit_excess, limit_excess(figure, fallen.q))
        fallen.seconds += DT
    return fallen


def test_masses_and_joints_are_those_of_the_figure(shipped: Figure):
    """MuJoCo numbers bodies depth first, figures limb by limb."""
    own, skeleton = build_bones(shipped), shipped.skeleton
    assert sorted(own.joints.tolist()) == list(range(len(skeleton.joint_names)))
    whole = FigureMass(shipped).at_rest.mass
    assert sum(bone.mass.mass for bone in own.bones) == pytest.approx(whole, rel=1e-12)
    rng = np.random.default_rng(1)
    q = skeleton.lower + rng.random(len(skeleton.lower)) * (skeleton.upper - skeleton.lower)
    R = rotation(np.array([0.6, 0.0, 0.8]), 2.0)
    p = np.array([1.0, 90.0, 2.0])
    begin = RagdollState(p, quaternion(R), p, p, q[own.joints], q[own.joints])
    ragdoll = Ragdoll(own.bones, begin, LEVEL)
    np.testing.assert_array_equal(ragdoll.attitude.joints, q[own.joints])
    np.testing.assert_array_equal(ragdoll.attitude.speeds, q[own.joints])
    X_BJ = JointTree.of(skeleton).pose(q)
    for i, link in enumerate(skeleton.links[1:], start=1):
        body = ragdoll.data.body(f"bone {i}")
        X = X_BJ[link.joint]
        np.testing.assert_allclose(body.xpos, p + R @ X[:3, 3], atol=1e-9)
        np.testing.assert_allclose(body.xmat.reshape(3, 3), R @ X[:3, :3], atol=1e-9)


def test_no_solid_stands_out_of_the_hull_of_its_bone(shipped: Figure):
    rng = np.random.default_rng(3)
    ways = rng.normal(size=(300, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    bones = build_bones(shipped).bones
    for i, bone in enumerate(bones):
        solids = [piece.solid.vertices for piece in shipped.pieces if piece.link == i]
        reach = (np.concatenate(solids) @ ways.T).max(axis=0)
        outside = reach - (bone.corners @ ways.T).max(axis=0)
        assert outside.max() < 0.006 * size_of(bones)


def test_in_the_air_the_centre_of_mass_falls_freely():
    fallen = drop_figure("kangaroo", "flat", 0.0)
    ragdoll = fallen.ragdoll
    ragdoll.data.qpos[1] += 50.0

    def centre() -> Array:
        mujoco.mj_fwdPosition(ragdoll.model, ragdoll.data)
        mujoco.mj_comVel(ragdoll.model, ragdoll.data)
        mujoco.mj_subtreeVel(ragdoll.model, ragdoll.data)
        return np.stack([ragdoll.data.subtree_com[1], ragdoll.data.subtree_linvel[1]])

    (_, v), time = centre(), 48 * DT
    for _ in range(48):
        ragdoll.advance(DT)
    _, after = centre()
    np.testing.assert_allclose(after, v - [0.0, GRAVITY * time, 0.0], atol=1e-3)


FAST = [("kangaroo", "flat"), ("hopper", HILLS), ("person", HILLS)]
LIBRARY = [
    "antelope",
    "beetle",
    "camel",
    "centipede",
    "hopper",
    "horse",
    "kangaroo",
    "ostrich",
    "person",
    "scorpion",
    "spider",
    "tripod",
]
REST = [(name, terrain) for name in LIBRARY for terrain in ("flat", HILLS)]


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("name", "terrain"),
    [
        pytest.param(
            *one, marks=() if one in FAST else pytest.mark.nightly, id=f"{one[0]}-{one[1][:8]}"
        )
        for one in REST
    ],
)
def test_figures_fall_and_come_to_rest_on_the_ground(name, terrain):
    fallen = drop_figure(name, terrain, 14.0)
    ragdoll, points = fallen.ragdoll, fallen.points()
    assert ragdoll.is_at_rest
    assert not ragdoll.is_gone
    depth = fallen.field.height(points[:, 0], points[:, 2]) - points[:, 1]
    assert depth.max() < 0.01 * ragdoll.size
    # It touches the ground, too.
    assert depth.max() > -0.002 * ragdoll.size
    assert limit_excess(fallen.figure, fallen.q) < math.radians(1.0)
    # A leg between the ground and the falling body yields for a while.
    assert fallen.limit_excess < math.radians(15.0)
    energies = np.array(fallen.energies)
    assert np.diff(energies).max() < 1e-5 * energies[0]
    assert 0 < fallen.impact_count < 3 * len(fallen.figure.skeleton.links)


@pytest.mark.nightly
@pytest.mark.parametrize("scale", [0.02, 4.0])
def test_falls_scale_with_size(scale):
    one, other = (drop_figure("hopper", "flat", 14.0 * max(s, 1.0), s) for s in (1.0, scale))
    assert other.ragdoll.is_at_rest
    assert other.seconds / math.sqrt(scale) == pytest.approx(one.seconds, rel=0.5)
    assert limit_excess(other.figure, other.q) < math.radians(2.0)


def test_a_light_link_is_damped_by_the_sinews_of_the_joint_before_it():
    mass = MassProperties(1.0, np.zeros(3), 0.1 * np.eye(3))
    toe = MassProperties(1e-3, np.array([0.5, -1.0, 0.0]), 1e-5 * np.eye(3))
    bones = [
        Bone(WORLD, np.zeros(3), (), mass, CORNERS),
        Bone(0, np.array([0.5, 0.0, 0.0]), (), mass, CORNERS),
        Bone(1, np.array([0.5, -0.9, 0.0]), (), toe, CORNERS),
    ]
    *_, leg, foot = flesh_of(bones)
    assert foot.damping == pytest.approx(SINEW_RATIO * leg.damping)
    assert foot.inertia < 0.01 * leg.inertia


# --- in scenes -----------------------------------------------------------------------------


def toppling_step(take: Take) -> int:
    """Return the step of the first toppling."""
    return next(note.step for note in take.notes if note.kind == "toppled")


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["kangaroo", "antelope"])
def test_motion_is_continuous_at_the_start_of_a_fall(name):
    hops = hop_through(scene_of(f"{{figure: {name}, pronk: {{balance: 0}}}}", duration=2))
    row, p = toppling_step(hops.take), hops.simulation.recorder.positions
    bends = np.linalg.norm(p[2:] - 2.0 * p[1:-1] + p[:-2], axis=-1).max(axis=1)
    assert hops.states[0][-1].phase == "fallen"
    # Row k bends by the k - 1st of these. Muscles that let go bend the way by a few times gravity,
    # and so do swinging legs before; a jump of the speed by 0.5 m/s would exceed both.
    swing = bends[row - 8 : row - 1].max()
    assert swing < 4.8 * 9.81 * DT**2
    assert bends[row - 1 : row + 3].max() < max(4.0 * 9.81 * DT**2, swing)


@pytest.mark.nightly
def test_joints_move_in_a_ragdoll_and_not_in_a_rigid_fall():
    moved = {}
    for fall in ("ragdoll", "rigid"):
        config = f"{{balance: 0, fall: {fall}}}"
        hops = hop_through(scene_of(f"{{figure: kangaroo, pronk: {config}}}", duration=2))
        values = hops.simulation.recorder.values[toppling_step(hops.take) + 1 :, 2:]
        moved[fall] = float(np.ptp(values, axis=0).max())
    assert moved["rigid"] < 1e-9
    assert moved["ragdoll"] > 0.5


@pytest.mark.nightly
def test_each_striking_link_makes_contacts_of_its_own_name():
    take = simulate(scene_of("{figure: kangaroo, pronk: {balance: 0}}", duration=4))
    falls = [c for c in take.contacts if c.kind == "hit" and c.step >= toppling_step(take)]
    parts = {part.name for part in take.parts}
    assert {c.part for c in falls} <= parts
    assert len({c.part for c in falls}) > 5
    for part in {c.part for c in falls}:
        times = [(c.step + c.fraction) * DT for c in falls if c.part == part]
        assert np.diff(times).min(initial=1.0) > 0.1
    assert all(c.speed > 0.0 and c.energy > 0.0 for c in falls)


@pytest.mark.nightly
def test_a_fall_does_not_change_other_hoppers():
    """A ragdoll needs its poses earlier in the step than a rigid fall."""
    other = "{name: b, figure: hopper, at: [2, 3], pronk: {}}"
    found = []
    for fall in ("ragdoll", "rigid"):
        one = f"{{name: a, figure: kangaroo, pronk: {{balance: 0, fall: {fall}}}}}"
        take = simulate(scene_of(one, other, duration=1.5))
        assert toppling_step(take) > 0
        own = [i for i, node in enumerate(take.nodes) if node.performer == "b"]
        found.append((take.positions[:, own].tobytes(), take.rotations[:, own].tobytes()))
    assert found[0] == found[1]


@pytest.mark.nightly
def test_falls_need_no_compiler():
    lines = (
        "import sys",
        "from pipeline.simulation.simulate import simulate",
        "from pipeline.spec import read_scene",
        "words = '{figure: kangaroo, pronk: {balance: 0}}'",
        "take = simulate(read_scene(f'pronk: 1\\nduration: 1\\ncast: [{words}]\\n'))",
        "assert any(note.kind == 'toppled' for note in take.notes)",
        "print('numba' in sys.modules, 'mujoco' in sys.modules)",
    )
    script = "\n".join(lines)
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["False", "True"]


@pytest.mark.nightly
def test_a_hopper_that_falls_off_the_terrain_is_noted_as_dropped():
    terrain = "{kind: flat, size: [4, 4]}"
    member = "{figure: kangaroo, at: [1.2, 0], pronk: {balance: 0, distance: 1.5}}"
    take = simulate(scene_of(member, terrain=terrain, duration=6))
    assert [note.kind for note in take.notes].count("dropped") == 1
