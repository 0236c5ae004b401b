"""Solid contacts: characters collide with solids of other rooms, push them, and are heard."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.simulation.characters.body_arrays import NOBODY, SOLID
from pipeline.simulation.characters.solid_arrays import Solids, solids_of
from pipeline.simulation.characters.solid_kinematics import signed_distance
from pipeline.simulation.dynamics.compiled import entry
from pipeline.simulation.obstacles import Obstacle
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array
from pipeline.spec import read_scene
from tests.simulation.characters.character_yard import link_length_error, random_rotation
from tests.simulation.characters.scripted_people import STEPS, node_path, run_scene, troupe_of

pytestmark = pytest.mark.slow

WALL = "{name: wall, prop: {shape: box, size: [0.4, 1, 3]}, at: [0, 0]}"


def deepest_node(simulation: Simulation) -> float:
    """Return the deepest penetration of a node into a solid in the last row [m]."""
    coupling = simulation.coupling
    assert coupling is not None
    coupling.update(simulation.last_row())
    characters = troupe_of(simulation)
    solids, nodes = characters.workspace.solids, characters.arrays.nodes
    deepest = 0.0
    for solid in solids.bodies:
        local = (nodes["p"] - solid["p"]) @ solid["R"]
        first, count = solid["planes"]
        planes = solids.planes[first : first + count]
        if solid["radius"] > 0.0:
            gap = np.linalg.norm(local - solid["middle"], axis=1) - solid["radius"]
        else:
            gap = (local @ planes[:, :3].T - planes[:, 3]).max(axis=1)
        deepest = max(deepest, float((nodes["radius"] - gap)[nodes["inverse_mass"] > 0].max()))
    return deepest


# --- signed distances ----------------------------------------------------------------------


@entry
def gaps(solids: Solids, places: Array, out: Array) -> None:
    for k in range(len(places)):
        at = (places[k, 0], places[k, 1], places[k, 2])
        gap, way = signed_distance(solids, 0, at, 10.0)
        out[k, 0] = gap
        for c in range(3):
            out[k, 1 + c] = way[c]


def _convex_solid(corners: Array, rng: np.random.Generator) -> tuple[Solids, Array, Array]:
    solids, which = solids_of([Obstacle(0, "it", "it", "wood", corners)], 1)
    assert which == [0]
    p, R = rng.normal(size=3), random_rotation(rng)
    solids.bodies["p"], solids.bodies["R"], solids.bodies["is_present"] = p, R, True
    return solids, p, R


def test_signed_distance_leads_to_the_surface_of_a_polyhedron() -> None:
    rng = np.random.default_rng(3)
    for _ in range(8):
        corners = rng.normal(size=(12, 3)) * [0.5, 0.3, 1.0]
        solids, p, R = _convex_solid(corners, rng)
        places = p + rng.normal(size=(200, 3))
        out = np.zeros((200, 4))
        gaps(solids, places, out)
        normals, offsets = solids.planes[:, :3], solids.planes[:, 3]
        local = (places - p) @ R
        # A point of the surface is on one plane and outside none.
        at = (places - out[:, :1] * out[:, 1:] - p) @ R
        over = (at @ normals.T - offsets).max(axis=1)
        assert np.abs(over).max() < 1e-9
        inside = (local @ normals.T - offsets).max(axis=1)
        assert ((out[:, 0] < 0.0) == (inside < 0.0)).all()
        assert out[inside < 0.0, 0] == pytest.approx(inside[inside < 0.0], abs=1e-12)
        # No convex combination of corners is nearer.
        points = rng.dirichlet(np.full(len(corners), 0.3), size=2000) @ corners
        points = np.concatenate([corners, points])
        nearest = np.linalg.norm(local[:, None] - points, axis=2).min(axis=1)
        outside = inside > 0.0
        assert (nearest[outside] >= out[outside, 0] - 1e-9).all()
        assert (nearest[outside] <= out[outside, 0] + 0.35).all()


def test_balls_are_recognised_and_rounded_boxes_are_not() -> None:
    ball = run_scene(
        "- {character: ball, at: [5, 5]}\n"
        "- {prop: {shape: ball, radius: 0.3}, at: [0, 1, 0]}\n"
        "- {prop: {shape: box, size: [0.5, 0.5, 0.5]}, at: [2, 0]}",
        0.1,
    )
    bodies = troupe_of(ball).workspace.solids.bodies
    assert bodies["radius"] == pytest.approx([0.3, 0.0], rel=0.01)
    assert bodies["half"][1] == pytest.approx([0.25, 0.25, 0.25], rel=0.01)


# --- fixed and moving obstacles -------------------------------------------------------------


def test_a_doll_falls_on_a_table_lies_there_and_is_heard() -> None:
    table = "{name: table, prop: {shape: box, size: [1.2, 0.5, 1.2]}, at: [0, 0]}"
    simulation = run_scene(f"- {{name: doll, character: ragdoll, at: [0, 0.9, 0]}}\n- {table}", 4)
    assert deepest_node(simulation) < 0.003
    p = troupe_of(simulation).arrays.p
    assert p[:, 1].min() > 0.5
    assert bool(troupe_of(simulation).arrays.owners["asleep"][0])
    take = simulation.take()
    first = next(c for c in take.contacts if c.other == "table")
    # A fall of 0.4 m with air damping.
    assert first.step / STEPS == pytest.approx(math.sqrt(2 * 0.4 / 9.81), abs=0.03)
    assert first.performer == "doll"
    assert first.surface == "wood"
    event = next(e for e in take.events if e.other == "table")
    assert (event.cause, event.who) == ("collision", "doll")
    assert event.frame == 1 + math.ceil((first.step + first.fraction) / 4)
    assert first.energy > 0.0


def test_a_crate_rests_on_a_thinner_post() -> None:
    post = "{name: post, prop: {shape: box, size: [0.2, 0.6, 0.2]}, at: [0, 0]}"
    simulation = run_scene(f"- {{name: crate, character: box, at: [0, 0.8, 0]}}\n- {post}", 3)
    assert node_path(simulation, "crate")[-1] == pytest.approx([0.0, 0.6, 0.0], abs=0.01)


def test_a_moving_prop_pushes_a_doll() -> None:
    ram = "{name: ram, prop: {shape: box, size: [0.4, 0.6, 2]}, at: [-1.5, 0.3, 0], velocity: V}"
    for speed in (0.5, 1.5):
        moving = ram.replace("V", f"[{speed}, 0, 0]")
        seconds = 2.4 / speed + 0.5
        cast = f"- {{name: doll, character: ragdoll, at: [0, 0]}}\n- {moving}"
        simulation = run_scene(cast, round(seconds, 1))
        face = node_path(simulation, "ram")[-1, 0] + 0.2
        assert face > 0.8
        nodes = troupe_of(simulation).arrays.nodes
        assert (nodes["p"][:, 0] - nodes["radius"]).min() > face - 0.015
        touched = {c.other for c in simulation.take().contacts if c.performer == "doll"}
        assert "ram" in touched


def test_a_ball_bounces_off_a_wall_as_off_the_ground() -> None:
    ball = "{name: ball, character: ball, at: [-2, 0.3, 0], velocity: [6, 2, 0]}"
    x = node_path(run_scene(f"- {ball}\n- {WALL}", 1), "ball")[:, 0]
    hit = int(np.argmax(x))
    assert x[hit] == pytest.approx(-0.2 - 0.12, abs=0.05)
    before, after = x[hit - 4] - x[hit - 8], x[hit + 8] - x[hit + 4]
    assert -after / before == pytest.approx(0.55, abs=0.04)


def test_a_person_stops_before_a_wall_and_stands() -> None:
    simulation = run_scene(
        f"- {{name: bob, character: adult, at: [-1.5, 0]}}\n- {WALL}",
        4,
        "- {at: 0, who: bob, do: walk}",
    )
    pelvis = node_path(simulation, "bob")
    assert -0.7 < pelvis[-1, 0] < -0.3
    assert pelvis[:, 1].min() > 0.8 * pelvis[0, 1]
    assert deepest_node(simulation) < 0.005


def test_a_touch_trigger_waits_for_a_rigid_ball() -> None:
    simulation = run_scene(
        "- {name: bob, character: adult, at: [0, 0]}\n"
        "- {name: ball, at: [-2, 1.2, 0], velocity: [6, 1, 0], body: "
        "{shape: sphere, radius: 0.12, density: 300, collide: all}}",
        4,
        "- {when: {touch: [ball, bob]}, who: bob, do: {go_to: [0, 2]}}",
    )
    pelvis = node_path(simulation, "bob")
    assert np.abs(pelvis[:24, 2]).max() < 0.05
    assert pelvis[-1, 2] == pytest.approx(2.0, abs=0.2)


@pytest.mark.nightly
def test_a_horse_pushes_people_out_of_its_way() -> None:
    simulation = run_scene(
        "- {name: doll, character: adult, limp: true, at: [1.8, 0], rotation_deg: [0, 90, 0]}\n"
        "- {name: bob, character: adult, at: [3, 0.1], heading_deg: 180}\n"
        "- {name: horse, figure: horse, at: [-1.4, 0], walk: {speed: 1.4}}",
        4,
    )
    contacts = simulation.take().contacts
    touches = [c for c in contacts if c.performer == "doll" and c.other.startswith("horse.")]
    assert touches
    # A sliding link makes one contact with each limb.
    pair = touches[0].part, touches[0].other
    when = [c.step for c in touches if (c.part, c.other) == pair]
    assert len(when) == 1 or min(np.diff(when)) > 0.08 * STEPS - 1
    # The horse keeps its path and the person backs off.
    horse, bob = node_path(simulation, "horse"), node_path(simulation, "bob")
    assert horse[-1, 0] == pytest.approx(4.2, abs=0.2)
    assert np.linalg.norm(horse - bob, axis=1).min() > 0.3
    assert bob[-1, 0] > 3.5
    assert link_length_error(troupe_of(simulation).arrays) < 0.05


def test_carried_things_are_no_obstacles() -> None:
    simulation = run_scene(
        "- {name: bob, character: adult, at: [0, 0]}\n"
        "- {name: hat, prop: {shape: ball, radius: 0.2}, at: [0, 0, 0], parent: bob.head}",
        0.5,
    )
    assert simulation.coupling is None


def test_a_solid_around_a_character_at_the_start_is_ignored() -> None:
    simulation = run_scene(
        "- {name: bob, character: adult, at: [0.5, 0]}\n"
        "- {name: sky, prop: {shape: ball, radius: 9}, at: [0, 0, 0]}\n"
        "- {name: room, prop: {shape: box, size: [4, 3, 4]}, at: [0, 0]}",
        1,
    )
    assert np.abs(node_path(simulation, "bob") - node_path(simulation, "bob")[0]).max() < 0.03
    assert not troupe_of(simulation).workspace.solids.bodies["is_present"].any()


# --- light bodies ----------------------------------------------------------------------------


def test_a_rigid_ball_passes_momentum_to_a_ball_of_nodes() -> None:
    rock = (
        "{name: rock, body: {shape: sphere, radius: 0.1, collide: all, density: 200, "
        "bounciness: 0.3}, at: [-1, 3, 0], velocity: [5, 0, 0]}"
    )
    simulation = run_scene(f"- {{name: ball, character: ball, at: [0, 2.88, 0]}}\n- {rock}", 0.4)
    light, heavy = 0.4, 200 * 4 / 3 * math.pi * 0.1**3
    ball, rock_path = node_path(simulation, "ball")[:, 0], node_path(simulation, "rock")[:, 0]
    v, u = ((p[-1] - p[-9]) * STEPS / 8 for p in (ball, rock_path))
    assert light * v + heavy * u == pytest.approx(5.0 * heavy, rel=0.02)
    # The higher bounciness of two applies, as among characters.
    assert v - u == pytest.approx(0.55 * 5.0, rel=0.05)
    hit = next(c for c in simulation.take().contacts if c.performer == "ball")
    assert hit.other == "rock"
    reduced = light * heavy / (light + heavy)
    assert hit.energy == pytest.approx(0.5 * reduced * 5.0**2, rel=0.03)
    assert hit.step / STEPS == pytest.approx((1.0 - 0.22) / 5.0, abs=2.5 / STEPS)


def test_a_person_struck_by_a_rigid_ball_staggers() -> None:
    cast = (
        "- {name: bob, character: adult, at: [0, 0]}\n"
        "- {name: rock, body: {shape: sphere, radius: 0.12, collide: all, density: D}, "
        "at: [2, 1.1, 0], velocity: [-7, 1.5, 0]}"
    )
    calm, struck = (run_scene(cast.replace("D", str(d)), 2) for d in (20, 1500))
    bent = [-node_path(one, "bob", "bob.chest")[:, 0].min() for one in (calm, struck)]
    assert bent[1] > 0.06 > 3.0 * bent[0]
    # The muscles are slack for a while, and the pelvis moves with the blow.
    assert float(np.ptp(node_path(struck, "bob")[:, 0])) > 0.05
    take = struck.take()
    hit = next(c for c in take.contacts if c.other == "rock")
    assert hit.performer == "bob"
    assert hit.speed == pytest.approx(7.0, rel=0.15)
    event = next(e for e in take.events if e.other == "rock")
    assert (event.who, event.material) == ("bob", hit.material)
    assert event.frame == 1 + math.ceil((hit.step + hit.fraction) / 4)
    # The collision stops the ball.
    assert node_path(struck, "rock")[:, 0].min() > 0.0


@pytest.mark.sample(1)
@pytest.mark.parametrize(("density", "goes"), [(20, (1.0, 9.0)), (2500, (-0.01, 0.05))])
def test_people_push_light_bodies_and_stop_at_heavy_ones(
    density: float, goes: tuple[float, float]
) -> None:
    cast = (
        "- {name: bob, character: adult, at: [-1.5, 0]}\n"
        f"- {{name: block, body: {{shape: cube, size: 0.6, collide: all, density: {density}}}, "
        "at: [0, 0]}"
    )
    simulation = run_scene(cast, 4, "- {at: 0, who: bob, do: walk}")
    block, bob = node_path(simulation, "block"), node_path(simulation, "bob")
    assert goes[0] < block[-1, 0] < goes[1]
    assert bob[:, 1].min() > 0.8 * bob[0, 1]
    assert (bob[-1, 0] > 1.2) == (density < 100)
    assert deepest_node(simulation) < 0.01


def test_a_rigid_cube_lies_still_on_a_crate() -> None:
    cast = (
        "- {name: crate, character: box, at: [0, 0]}\n"
        "- {name: cube, body: {shape: cube, size: 0.3, collide: all, density: 300}, "
        "at: [0.05, 0.7, 0]}"
    )
    cube = node_path(run_scene(cast, 4), "cube")
    assert cube[-1, 1] == pytest.approx(0.65, abs=0.003)
    assert np.abs(cube[-1] - cube[-96]).max() < 0.004


def test_a_rigid_ball_does_not_go_through_the_side_of_a_crate() -> None:
    cast = (
        "- {name: crate, character: box, at: [0, 0]}\n"
        "- {name: shot, body: {shape: sphere, radius: 0.06, collide: all, density: 1000}, "
        "at: [-1.5, 0.25, 0.02], velocity: [8, 0.8, 0]}"
    )
    simulation = run_scene(cast, 1)
    crate, shot = node_path(simulation, "crate"), node_path(simulation, "shot")
    assert (shot[:, 0] < crate[:, 0] - 0.25).all()
    assert crate[-1, 0] > 0.02


def test_links_sense_the_solids_they_touch() -> None:
    scene = read_scene(
        "pronk: 1\nduration: 2\ncast:\n- {name: ball, character: ball, at: [0, 0.6, 0]}\n"
        "- {prop: {shape: box, size: [9, 0.1, 9]}, at: [30, 0]}\n"
        "- {name: table, prop: {shape: box, size: [1, 0.5, 1]}, at: [0, 0]}"
    )
    simulation = Simulation(scene)
    pairs, touched = list[tuple[str, str]](), set[int]()
    links = troupe_of(simulation).arrays.links
    while not simulation.finished:
        simulation.step()
        touched.add(int(links["touched"][0]))
        pairs += [(h.who, h.other) for h in simulation.signals if h.kind == "touch"]
    assert touched == {NOBODY, SOLID - 1}
    assert pairs[0] == ("ball", "table")


# --- stability and batches ---------------------------------------------------------------


@pytest.mark.sample(2)
@pytest.mark.parametrize("seed", range(20))
def test_characters_stay_stable_among_props_and_bodies(seed: int) -> None:
    rng = np.random.default_rng(seed)
    lines = list[str]()
    for k in range(3):
        kind = ("ragdoll", "ball", "box", "adult")[int(rng.integers(4))]
        limp = ", limp: true" if kind == "adult" else ""
        x, y, z = rng.uniform([-0.8, 1.2, -0.8], [0.8, 2.2, 0.8])
        v = rng.uniform(-6.0, 6.0, 3)
        lines.append(
            f"- {{name: c{k}, character: {kind}{limp}, at: [{x:.3f}, {y:.3f}, {z:.3f}], "
            f"velocity: [{v[0]:.2f}, {v[1]:.2f}, {v[2]:.2f}]}}"
        )
    for k in range(3):
        x, z = rng.uniform(-1.0, 1.0, 2)
        a, b, c = rng.uniform(0.1, 0.8, 3)
        spin = f", spin_deg: [0, {rng.uniform(-90, 90):.0f}, 0]" if k == 0 else ""
        lines.append(
            f"- {{name: p{k}, prop: {{shape: box, size: [{a:.2f}, {b:.2f}, {c:.2f}]}}, "
            f"at: [{x:.3f}, {z:.3f}]{spin}}}"
        )
    for k in range(3):
        v = rng.uniform(-8.0, 8.0, 3)
        lines.append(
            f"- {{name: b{k}, body: {{shape: {('sphere', 'cube')[k % 2]}, collide: all, "
            f"density: {rng.uniform(30, 2000):.0f}}}, "
            f"at: [{2.0 * k - 2.0}, 3.0, 0], velocity: [{v[0]:.2f}, {v[1]:.2f}, {v[2]:.2f}]}}"
        )
    scene = read_scene("pronk: 1\nduration: 2.5\ncast:\n" + "\n".join(lines))
    simulation = Simulation(scene)
    arrays = troupe_of(simulation).arrays
    h = simulation.world.clock.dt / troupe_of(simulation).count
    fastest = []
    while not simulation.finished:
        simulation.step()
        v = np.linalg.norm(arrays.p - arrays.previous, axis=1) / h
        fastest.append(float(v.max()))
        assert np.isfinite(fastest[-1])
    # No speed exceeds that of a fall from the highest starting point.
    assert max(fastest) < 30.0
    assert max(fastest[-24:]) < 6.0
    assert link_length_error(arrays) < 0.05
    assert deepest_node(simulation) < 0.08


def test_a_lone_character_has_no_coupling_and_large_batches() -> None:
    alone = Simulation(
        read_scene(
            "pronk: 1\nduration: 1\ncast:\n- {character: adult, at: [0, 0]}\n"
            "- {body: {shape: sphere, collide: terrain}, at: [3, 3, 0]}"
        )
    )
    assert alone.coupling is None
    assert alone.scheduler.batch_size > 16
    assert len(troupe_of(alone).workspace.solids.bodies) == 0


def test_fixed_obstacles_are_updated_once_and_keep_large_batches() -> None:
    text = (
        "pronk: 1\nduration: 1\ncast:\n- {name: doll, character: ragdoll, at: [0, 0.7, 0]}\n"
        "- {name: table, prop: {shape: box, size: [1, 0.5, 1]}, at: [0, 0]}"
    )
    once, always = Simulation(read_scene(text)), Simulation(read_scene(text))
    assert once.scheduler.batch_size > 16
    assert always.coupling is not None
    always.coupling.still, always.scheduler.batch_size = False, 1
    for simulation in (once, always):
        while not simulation.finished:
            simulation.step()
    assert np.array_equal(once.take().positions, always.take().positions)


def test_moving_obstacles_give_the_same_take_in_any_batch_size() -> None:
    text = (
        "pronk: 1\nduration: 1.5\ncast:\n- {name: doll, character: ragdoll, at: [0, 0.7, 0]}\n"
        "- {name: bob, character: child, at: [-1, 0]}\n"
        "- {name: table, prop: {shape: box, size: [1, 0.5, 1]}, at: [0, 0], spin_deg: [0, 40, 0]}\n"
        "- {name: cup, prop: {shape: ball, radius: 0.1}, at: [0.3, 0.6, 0], parent: table}\n"
        "- {name: rock, body: {shape: sphere, radius: 0.1, collide: all}, at: [-2, 0.8, 0],"
        " velocity: [4, 1, 0]}\n"
        "- {name: fly, prop: {shape: ball, radius: 0.03}, at: [0, 0.2, 0], parent: rock}"
    )
    often, seldom = Simulation(read_scene(text)), Simulation(read_scene(text))
    assert seldom.scheduler.batch_size > 4
    often.scheduler.batch_size = 1
    for simulation in (often, seldom):
        while not simulation.finished:
            simulation.step()
    one, other = often.take(), seldom.take()
    for name in ("positions", "rotations", "alive", "values", "scales"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert [repr(c) for c in one.contacts] == [repr(c) for c in other.contacts]
    assert [repr(e) for e in one.events] == [repr(e) for e in other.events]
    assert one.contacts
