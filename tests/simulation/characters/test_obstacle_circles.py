"""Obstacle circles: people walk around solids of other rooms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.simulation.characters.solid_arrays import SOLID
from pipeline.simulation.characters.visibility_route import (
    HEADROOM,
    MAX_CIRCLES,
    STEP_OVER_HEIGHT,
    ObstacleCircles,
)
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact
from pipeline.simulation.terrain import build_ground
from pipeline.spec import read_scene
from tests.simulation.characters.scripted_people import node_path, run_scene, troupe_of

GROUND = build_ground(
    read_scene("pronk: 1\nduration: 1\ncast: [{name: a, character: child}]\n").terrain, 0
)
UPRIGHT = np.eye(3)

sizes = st.tuples(*[st.floats(0.05, 4.0)] * 3)
angles = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


def circles_of(
    *solids: tuple[Array, Array, Array], mass: float = 0.0, here: bool = True
) -> ObstacleCircles:
    """Return the circles of boxes: middles (3,), rotations (3, 3), half extents (3,)."""
    bodies = zero_records(len(solids), SOLID)
    for n, (body, (p, R, half)) in enumerate(zip(bodies, solids, strict=True)):
        body["p"], body["R"], body["half"], body["is_present"], body["thing"] = p, R, half, here, n
        body["inverse_mass"] = 1.0 / mass if mass else 0.0
    circles = ObstacleCircles(GROUND)
    circles.set_solids(bodies)
    circles.update()
    return circles


def turned(angles: tuple[float, float, float]) -> Array:
    """Return a rotation (3, 3) by a vector."""
    x, y, z = angles
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    size = max(np.linalg.norm(angles), 1e-9)
    K = K / size
    return np.eye(3) + np.sin(size) * K + (1.0 - np.cos(size)) * K @ K


@given(sizes, angles)
def test_circles_cover_the_shadow_of_a_box(half, angles) -> None:
    p, R = np.array([1.0, 0.9, -2.0]), turned(angles)
    circles = circles_of((p, R, np.array(half)))
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    rng = np.random.default_rng(1).uniform(-1, 1, (200, 3))
    shadow = (p + (np.concatenate([corners, rng]) * half) @ R.T)[:, [0, 2]]
    off = np.linalg.norm(shadow[:, None] - circles.middles, axis=2) - circles.radii
    assert off.min(axis=1).max() <= 1e-9
    assert len(circles.radii) <= MAX_CIRCLES


@pytest.mark.parametrize("angle", [0.0, 0.4, 2.0])
def test_a_wall_is_a_row_of_narrow_circles(angle: float) -> None:
    R = turned((0.0, angle, 0.0))
    circles = circles_of((np.array([0.0, 1.0, 0.0]), R, np.array([0.15, 1.0, 2.0])))
    assert circles.radii.max() < 1.5 * 0.15
    along = np.abs(circles.middles @ R[[0, 2], 2])
    assert 1.8 < along.max() < 2.0
    assert len(set(circles.keys.tolist())) == len(circles.keys)
    assert set(circles.things.tolist()) == {0}


def test_low_high_light_and_absent_solids_are_no_obstacles() -> None:
    half = np.array([0.5, 0.02, 0.5])
    assert not circles_of((np.array([0.0, 0.02, 0.0]), UPRIGHT, half)).update()
    assert circles_of((np.array([0.0, STEP_OVER_HEIGHT, 0.0]), UPRIGHT, half)).update()
    assert not circles_of((np.array([0.0, HEADROOM + 0.03, 0.0]), UPRIGHT, half)).update()
    assert circles_of((np.array([0.0, HEADROOM - 0.03, 0.0]), UPRIGHT, half)).update()
    assert not circles_of((np.array([0.0, 0.5, 0.0]), UPRIGHT, half), mass=1.0).update()
    assert circles_of((np.array([0.0, 0.5, 0.0]), UPRIGHT, half), mass=20.0).update()
    assert not circles_of((np.array([0.0, 0.5, 0.0]), UPRIGHT, half), here=False).update()
    assert not circles_of().update()


def touches(simulation: Simulation) -> list[Contact]:
    """Return the contacts of ann except with the ground."""
    contacts = simulation.take().contacts
    return [c for c in contacts if c.performer == "ann" and c.other != "terrain"]


THINGS = {
    "wall": ("prop: {shape: box, size: [0.3, 1.6, 4]}", 1.9),
    "turned wall": ("prop: {shape: box, size: [0.3, 1.6, 4]}, heading_deg: 30", 1.5),
    "table": ("prop: {shape: box, size: [1.4, 0.8, 0.8]}", 0.5),
    "pillar": ("prop: {shape: cylinder, radius: 0.5, height: 3}", 0.5),
    "crate": ("body: {shape: box, size: [1.0, 1.0, 1.0], density: 600, collide: all}", 0.5),
    "dancer": ("dancer: torso", 0.3),
    "bench": ("character: bench, heading_deg: 90", 0.5),
    "box": ("character: box, scale: 1.6", 0.4),
    "carousel": ("character: merry-go-round", 1.2),
}


@pytest.mark.sample(3)
@pytest.mark.slow
@pytest.mark.parametrize("thing", THINGS)
def test_go_to_avoids_obstacles(thing: str) -> None:
    member, aside = THINGS[thing]
    simulation = run_scene(
        f"- {{name: ann, character: adult, at: [-2.8, 0.1]}}\n- {{name: it, {member}, at: [0, 0]}}",
        9,
        "- {at: 0, who: ann, do: {go_to: [2.4, 0.1]}}",
    )
    way = node_path(simulation, "ann")[:, [0, 2]]
    np.testing.assert_allclose(way[-1], [2.4, 0.1], atol=0.15)
    assert aside < np.abs(way[:, 1]).max() < aside + 1.4
    assert not touches(simulation)


@pytest.mark.sample(2)
@pytest.mark.slow
@pytest.mark.parametrize("thing", THINGS)
def test_walk_does_not_avoid_obstacles(thing: str) -> None:
    simulation = run_scene(
        f"- {{name: ann, character: adult, at: [-2, 0.1]}}\n"
        f"- {{name: it, {THINGS[thing][0]}, at: [0, 0]}}",
        4,
        "- {at: 0, who: ann, do: walk}",
    )
    assert node_path(simulation, "ann")[-1, 0] < -0.2 or touches(simulation)


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("thing", ["wall", "crate", "dancer"])
def test_a_person_with_a_mind_avoids_obstacles(thing: str) -> None:
    simulation = run_scene(
        "- {name: ann, character: adult, at: [-2.8, 0.1], behaviours: [{approach: box}]}\n"
        "- {name: box, character: box, at: [2.8, 0.1]}\n"
        f"- {{name: it, {THINGS[thing][0]}, at: [0, 0]}}",
        8,
    )
    way = node_path(simulation, "ann")[:, [0, 2]]
    assert np.linalg.norm(way[-1] - [2.8, 0.1]) < 1.5
    assert not touches(simulation)


@pytest.mark.slow
@pytest.mark.parametrize("height", [0.01, 0.05])
def test_a_rug_does_not_disturb_a_walk(height: float) -> None:
    cast = "- {name: ann, character: adult, at: [-2, 0.1]}"
    script = "- {at: 0, who: ann, do: {go_to: [2, 0.1]}}"
    rug = f"- {{name: rug, prop: {{shape: box, size: [1.5, {height}, 3]}}, at: [0, 0]}}"
    free, over = (node_path(run_scene(cast, 5, script), "ann") for cast in (cast, f"{cast}\n{rug}"))
    assert np.abs(free - over)[:, [0, 2]].max() < 0.1


@pytest.mark.slow
def test_a_free_straight_path_is_kept() -> None:
    cast = "- {name: ann, character: adult, at: [-2, 0]}"
    script = "- {at: 0, who: ann, do: {go_to: [2, 0]}}"
    beside = "- {name: it, prop: {shape: box, size: [1, 1, 1]}, at: [0, -1.2]}"
    free, past = (
        node_path(run_scene(cast, 5, script), "ann") for cast in (cast, f"{cast}\n{beside}")
    )
    np.testing.assert_array_equal(free, past)


@pytest.mark.slow
def test_go_to_avoids_a_closing_door() -> None:
    door = (
        "- {name: it, prop: {shape: box, size: [0.2, 2, 2]}, at: [0, -4], "
        "keyframes: [{at: 0.5, position: [0, 0, -4]}, {at: 1.5, position: [0, 0, 0]}]}"
    )
    simulation = run_scene(
        f"- {{name: ann, character: adult, at: [-3.4, 0]}}\n{door}",
        8,
        "- {at: 0, who: ann, do: {go_to: [2, 0]}}",
    )
    way = node_path(simulation, "ann")[:, [0, 2]]
    np.testing.assert_allclose(way[-1], [2, 0], atol=0.15)
    assert np.abs(way[:, 1]).max() > 0.9
    assert troupe_of(simulation).obstacle_circles.update()


def test_obstacle_circles_follow_the_props_of_a_scene() -> None:
    scene = read_scene(
        "pronk: 1\nduration: 1\ncast:\n- {name: ann, character: child}\n"
        "- {name: it, prop: {shape: box, size: [1, 1, 1]}, at: [3, 0]}\n"
    )
    simulation = Simulation(scene)
    simulation.step()
    simulation.step()
    circles = troupe_of(simulation).obstacle_circles
    assert circles.update()
    np.testing.assert_allclose(circles.middles, [[3.0, 0.0]], atol=1e-6)
    np.testing.assert_allclose(circles.radii, np.sqrt(0.5), rtol=0.02)
