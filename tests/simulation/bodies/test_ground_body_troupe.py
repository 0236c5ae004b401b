"""Ground bodies in scenes: initial poses, contacts, refusals."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import trimesh

from pipeline.errors import SceneError
from pipeline.simulation.bodies.body_model import body_hull
from pipeline.simulation.dynamics.mass import mass_of_solid
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.spatial import Array, normalized
from pipeline.simulation.take import Take
from pipeline.spec import load_scene, read_scene, simulation_key
from pipeline.spec.body import MeshBody
from tests.simulation.conftest import scene_of

DIE = "{name: die, body: {shape: die, size: 0.2}, at: [0, 0.6, 0], spin_deg: [300, 50, 200]}"


@pytest.fixture(name="die", scope="module")
def _die() -> Take:
    return simulate(scene_of(DIE, terrain="hills", duration=1.5))


def test_a_die_makes_a_contact_when_it_strikes(die: Take) -> None:
    assert die.contacts
    hits = [c for c in die.contacts if c.kind == "hit"]
    heard = [e for e in die.events if e.cause == "collision"]
    assert {(e.who, e.other) for e in heard} == {("die", "terrain")}
    # All impacts but those too soon after the last for an ear.
    steps, last = 0.04 * float(die.header.rate * die.header.steps), -math.inf
    for hit in hits:
        if hit.step + hit.fraction - last >= steps:
            last = hit.step + hit.fraction
            event = heard.pop(0)
            assert (event.step, event.fraction) == (hit.step, hit.fraction)
            assert event.strength == hit.speed
    assert heard == []
    first = hits[0]
    assert first.speed == pytest.approx(np.sqrt(2 * 9.81 * 0.5), rel=0.5)
    assert 0.0 < first.energy < 600 * 0.2**3 * 9.81 * 1.2
    assert (first.material, first.surface, first.size) == ("wood", "dry soil", 0.2)
    assert 0.0 <= first.fraction < 1.0


def test_a_die_comes_to_rest_on_a_face(die: Take) -> None:
    assert [part.name for part in die.parts] == ["die", "die.pips"]
    np.testing.assert_array_equal(die.positions[-1], die.positions[-10])


RAMP = "{kind: ramp, size: [40, 10], slope_deg: 10, course: up, start: -15, height: 4}"


def rolling_and_sliding(
    member: str, terrain: str, duration: float = 3
) -> list[tuple[str, float, float]]:
    """Return kind, start and end [s] of each stretch of rolling or sliding of a body."""
    take = simulate(scene_of(member, terrain=terrain, duration=duration))
    contacts = [c for c in take.contacts if c.kind in ("roll", "slide")]
    events = [e for e in take.events if e.cause in ("roll", "slide")]
    assert [(c.kind, c.step) for c in contacts] == [(e.cause, e.step) for e in events]
    assert [(c.step, c.until) for c in contacts] == [e.track for e in events]
    assert [e.step for e in take.events] == sorted(e.step for e in take.events)
    return [(c.kind, c.step / 96, c.until / 96) for c in contacts]


def test_a_rolling_ball_makes_one_rolling_contact() -> None:
    ball = "{body: {shape: sphere, radius: 0.2, bounciness: 0, friction: 0.8}, at: [4, -2]}"
    ((kind, begin, end),) = rolling_and_sliding(ball, RAMP)
    assert (kind, end) == ("roll", 3.0)
    # It is as quick as is heard after v / (5/7 g sin slope).
    assert begin == pytest.approx(0.1 / (5 / 7 * 9.81 * np.sin(np.radians(10))), abs=0.03)


@pytest.mark.parametrize("shape", ["sphere", "cube"])
def test_resting_bodies_neither_roll_nor_slide(shape: str) -> None:
    assert rolling_and_sliding(f"{{body: {{shape: {shape}}}, at: [0, 1, 0]}}", "flat") == []


def test_sliding_ends_at_low_speed() -> None:
    box = "{body: {shape: box, size: [0.6, 0.1, 0.6], friction: 0.3}, at: [0, 0], "
    ((kind, begin, end),) = rolling_and_sliding(box + "velocity: [2, 0, 0]}", "flat", 1.5)
    assert (kind, begin) == ("slide", pytest.approx(0.0, abs=0.02))
    assert end == pytest.approx((2.0 - 0.05) / (0.3 * 9.81), abs=0.03)


def test_takes_are_reproducible_to_the_bit() -> None:
    scene = scene_of(DIE, "{body: {shape: sphere}, at: [1, 1, 0]}", terrain="hills", duration=1)
    assert simulate(scene).digest == simulate(scene).digest


def test_a_body_without_height_stands_on_the_ground() -> None:
    simulation = Simulation(scene_of("{body: {shape: cube}, at: [1, 2]}", terrain="hills"))
    (troupe,) = simulation.troupes
    assert abs(troupe.dynamics.depths()[0]) < 1e-6  # type: ignore[attr-defined]


def test_a_body_that_leaves_the_terrain_is_removed() -> None:
    ball = (
        "{name: ball, body: {shape: sphere, radius: 0.1}, at: [1.5, 0.3, 0], velocity: [4, 0, 0]}"
    )
    take = simulate(
        scene_of(ball, terrain="{kind: flat, size: [4, 4], cells: [8, 8]}", duration=2.5)
    )
    (note,) = take.notes
    assert (note.kind, note.part) == ("dropped", "ball")
    assert take.positions[:, 0, 1].min() < -10.0
    gone = np.flatnonzero(~take.alive[:, 0])
    assert len(gone)
    np.testing.assert_array_equal(
        take.positions[gone, 0], np.tile(take.positions[-1, 0], (len(gone), 1))
    )


def test_a_mesh_body_is_its_hull(tmp_path: Path) -> None:
    trimesh.creation.icosphere(subdivisions=1, radius=0.2).export(tmp_path / "stone.obj")
    path = tmp_path / "scene.yaml"
    path.write_text(
        "pronk: 1\nduration: 0.2\ncast: [{body: {shape: mesh, file: stone.obj}, at: [0, 1, 0]}]\n",
        encoding="utf-8",
    )
    scene = load_scene(path)
    (troupe,) = Simulation(scene).troupes
    expected = trimesh.creation.icosphere(subdivisions=1, radius=0.2).volume * 600.0
    assert troupe.dynamics.bodies.mass[0] == pytest.approx(expected, rel=1e-6)  # type: ignore[attr-defined]
    before = simulation_key(scene)
    trimesh.creation.icosphere(subdivisions=1, radius=0.3).export(tmp_path / "stone.obj")
    assert simulation_key(load_scene(path)) != before


@pytest.mark.parametrize(
    ("member", "message"),
    [
        ("{name: a, body: {shape: cube}, at: [0, 0.05, 0]}", "'a' begins 0.1 m deep in"),
        ("{body: {shape: cub}}", "cub"),
        ("{body: {shape: cube, collide: al}}", "terrain"),
        ("{body: {shape: cube, bounciness: 1.2}}", "at most 1"),
        ("{body: {shape: hull, points: [[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]]}}", "plane"),
        ("{name: a, body: {shape: cube}, parent: b}", "a body moves by itself"),
        ("{body: {shape: cube}, walk: {}}", "walk"),
        ("{body: {shape: mesh, file: no.obj}}", "'no.obj' is no file in"),
    ],
)  # fmt: skip
def test_invalid_bodies_are_refused(member: str, message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        Simulation(scene_of(member, "{name: b, prop: {shape: ball}}"))
    assert all(problem.line > 0 for problem in caught.value.problems)


def mesh_of(vertices: Array) -> str:
    return "".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in vertices)


def test_large_meshes_have_the_hull_of_all_their_vertices(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    (tmp_path / "a.obj").write_text(mesh_of(rng.uniform(-0.1, 0.1, (6000, 3))))
    hull = body_hull(MeshBody(shape="mesh", file=str(tmp_path / "a.obj")), "body")
    vertices = np.loadtxt(tmp_path / "a.obj", usecols=(1, 2, 3))
    expected = trimesh.convex.convex_hull(vertices)
    assert mass_of_solid(hull.vertices, hull.faces, 1.0).mass == pytest.approx(expected.volume)


@pytest.mark.parametrize(
    ("vertices", "said"),
    [
        (normalized(np.random.default_rng(1).normal(size=(5100, 3))), "has a hull of 5100 corners"),
        (np.random.default_rng(1).uniform(-1, 1, (5100, 3)) * [1, 0, 1], "lies in one plane"),
        (np.full((9, 3), 1e308), "reaches farther than 10000 m"),
    ],
    ids=["round", "flat", "far"],
)
def test_meshes_that_take_too_long_or_are_no_solids_are_refused(
    tmp_path: Path, vertices: Array, said: str
) -> None:
    (tmp_path / "a.obj").write_text(mesh_of(vertices))
    with pytest.raises(SceneError, match=f"^body.file: 'a.obj' {said}"):
        body_hull(MeshBody(shape="mesh", file=str(tmp_path / "a.obj"), scale=100.0), "body")


def test_scripts_for_bodies_are_refused() -> None:
    with pytest.raises(SceneError, match="'die' is a body, which no script moves"):
        read_scene(
            f"pronk: 1\nduration: 1\ncast: [{DIE}]\n"
            "script: [{at: 1, who: die, do: {go_to: [1, 1]}}]\n"
        )
