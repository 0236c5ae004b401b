"""Colliders in scenes: arrangements, refusals, creatures that push, contacts."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.bodies.collider_troupe import ColliderTroupe
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.take import Take
from pipeline.spec import Scene, dump, find_scene, load_scene, read_scene

Scenes = Callable[..., Scene]

CRATE = "{{name: {name}, body: {{shape: box, collide: all}}, at: {at}}}"


def crate(name: str, at: object) -> str:
    return CRATE.format(name=name, at=at)


def positions_of(take: Take, name: str) -> np.ndarray:
    """Where a node is in all rows (K, 3)."""
    return take.positions[:, [node.name for node in take.nodes].index(name)]


def error_text(scene: Scene) -> str:
    with pytest.raises(SceneError) as caught:
        Simulation(scene)
    return str(caught.value)


def test_wall_is_many_nodes_of_one_performer(scene_of: Scenes) -> None:
    scene = scene_of(
        "{name: wall, many: {of: brick, rows: 4, columns: 3}, material: brick}", duration=0.5
    )
    take = simulate(scene)
    assert [node.name for node in take.nodes] == [f"wall_{i + 1}" for i in range(12)]
    assert {node.performer for node in take.nodes} == {"wall"}
    assert {part.material for part in take.parts} == {"brick"}
    np.testing.assert_allclose(take.positions[-1], take.positions[0], atol=1e-4)
    heights = sorted(set(np.round(take.positions[0, :, 1] / 0.071, 3)))
    np.testing.assert_allclose(heights, [0.5, 1.5, 2.5, 3.5], atol=0.01)
    assert take.contacts == ()


def test_every_layout_has_its_count_and_no_overlaps(scene_of: Scenes) -> None:
    configs = {
        "wall": "rows: 3, columns: 4",
        "pyramid": "rows: 4",
        "stack": "count: 5",
        "row": "count: 6, along: [[1, 0], [1, 1]], spacing: 0.4",
        "heap": "count: 7",
    }
    for layout, keys in configs.items():
        box = "{shape: box, size: [0.1, 0.3, 0.2]}"
        many = f"{{layout: {layout}, of: {box}, {keys}}}"
        text = f"{{name: some, many: {many}, heading_deg: 30}}"
        scene = scene_of(text, terrain="{kind: hills, height: 0.4}")
        (colliders,) = Simulation(scene).troupes
        assert isinstance(colliders, ColliderTroupe)
        assert len(colliders.bodies) == scene.cast[0].many.total
        assert read_scene(dump(scene)) == scene


def test_overlapping_bodies_are_refused_with_names_and_depth(
    scene_of: Scenes,
) -> None:
    message = error_text(scene_of(crate("one", [0, 1, 0]), crate("two", [0.2, 1, 0])))
    assert "cast[0].at" in message
    assert "'one' begins 0.1 m deep in 'two'; move one of them" in message


def test_bodies_that_start_in_the_ground_are_refused(scene_of: Scenes) -> None:
    message = error_text(scene_of(crate("one", [0, 0.1, 0]), crate("two", [3, 1, 0])))
    assert "'one' begins 0.05 m deep in the terrain" in message
    assert "two" not in message


def test_bodies_that_start_in_a_creature_are_refused(scene_of: Scenes) -> None:
    message = error_text(scene_of("{name: bug, figure: beetle}", crate("one", [0, 0.3, 0])))
    assert "'one' begins" in message
    assert "'bug." in message


def test_bodies_that_leave_the_terrain_are_removed_with_a_note(scene_of: Scenes) -> None:
    ball = "{name: ball, body: {shape: sphere, collide: all}, at: [4.5, 0], velocity: [3, 0, 0]}"
    take = simulate(
        scene_of(ball, crate("one", [0, 0]), terrain="{kind: flat, size: [10, 10]}", duration=4)
    )
    (note,) = take.notes
    assert (note.kind, note.part) == ("dropped", "ball")
    row = note.step
    assert positions_of(take, "ball")[row, 1] < -10.0 < positions_of(take, "ball")[row - 1, 1]
    assert take.alive[row - 1].all()
    assert not take.alive[row:, 0].any()
    assert take.alive[:, 1].all()


def test_ground_bodies_and_colliders_pass_through_each_other(
    scene_of: Scenes,
) -> None:
    alone = "{name: ghost, body: {shape: box}, at: [0, 0]}"
    take = simulate(scene_of(alone, crate("one", [0, 0]), duration=0.5))
    assert {c.other for c in take.contacts} <= {"terrain"}


def test_a_fall_makes_one_contact_with_its_speed(scene_of: Scenes) -> None:
    body = "body: {shape: box, bounciness: 0, collide: all}"
    text = f"{{name: one, {body}, at: [0, 1.15, 0], material: wood}}"
    take = simulate(scene_of(text, duration=2))
    (contact,) = take.contacts
    (event,) = take.events
    clock_time = (contact.step + contact.fraction) / 96.0
    assert clock_time == pytest.approx(np.sqrt(2.0 / 9.81), abs=1e-3)
    assert contact.speed == pytest.approx(np.sqrt(2.0 * 9.81), rel=5e-3)
    assert (contact.performer, contact.other, contact.material) == ("one", "terrain", "wood")
    assert event.cause == "collision"
    assert contact.energy == pytest.approx(0.027 * 600.0 * 9.81, rel=0.01)
    np.testing.assert_allclose(contact.place, [0, 0, 0], atol=5e-3)


def test_a_collision_of_two_bodies_is_one_contact(scene_of: Scenes) -> None:
    body = "body: {{shape: sphere, radius: 0.1, collide: all}}"
    base = f"{{{{name: {{}}, {body}, at: {{}}, velocity: {{}}, material: {{}}}}}}"
    take = simulate(
        scene_of(
            base.format("a", [-0.5, 3, 0], [2, 0, 0], "steel"),
            base.format("b", [0.5, 3, 0], [-2, 0, 0], "copper"),
            duration=0.4,
        )
    )
    (contact,) = take.contacts
    assert {contact.performer, contact.other} == {"a", "b"}
    assert {contact.material, contact.surface} == {"steel", "copper"}
    assert contact.speed == pytest.approx(4.0, rel=1e-3)
    assert (contact.step + contact.fraction) / 96.0 == pytest.approx(0.2, abs=2e-3)


@pytest.mark.slow
def test_bodies_bounce_off_a_dancers_head_and_lie_on_its_drum(scene_of: Scenes) -> None:
    ball = "{{name: {name}, at: {at}, body: {{shape: sphere, radius: 0.06, collide: all}}}}"
    cube = "{name: cube, at: [0.4, 1.02, 0], body: {shape: cube, size: 0.08, collide: all}}"
    scene = scene_of(
        "{name: zoe, dancer: torso, dance: drums}",
        ball.format(name="ball", at="[0.02, 2.4, 0.01]"),
        cube,
        duration=1.5,
        more="dances: {drums: {drums: {tom: {at: [0.4, 0.9, 0], radius: 0.2}}, "
        "subtasks: [{hand: l, reach: [0.3, 1.3, -0.4]}]}}",
    )
    take = simulate(scene)
    ball_way, cube_way = positions_of(take, "ball"), positions_of(take, "cube")
    met = [c for c in take.contacts if c.performer == "ball"]
    assert met[0].other == "zoe.head"
    assert ball_way[:, 1].min() < 0.5
    assert np.abs(ball_way[-1, [0, 2]]).max() > 0.1
    assert cube_way[-1, 1] == pytest.approx(0.9 + 0.04, abs=0.005)


@pytest.mark.nightly
def test_creature_pushes_and_is_not_pushed(scene_of: Scenes) -> None:
    walker = "{name: bug, figure: beetle, at: [-2, 0], walk: {}}"
    ball = (
        "{name: ball, body: {shape: sphere, radius: 0.15, density: 5000, collide: all}, at: [0, 0]}"
    )
    with_ball = simulate(scene_of(walker, ball, duration=4))
    without = simulate(scene_of(walker, duration=4))
    np.testing.assert_array_equal(
        with_ball.positions[:, : without.positions.shape[1]], without.positions
    )
    path = positions_of(with_ball, "ball")
    assert np.abs(path[-1, [0, 2]] - path[0, [0, 2]]).max() > 0.2
    assert any(c.other.startswith("bug.") for c in with_ball.contacts)


def test_script_orders_take_effect_between_rows(scene_of: Scenes) -> None:
    scene = scene_of(
        crate("one", [0, 1.0, 0]),
        crate("two", [0.05, 1.6, 0]),
        duration=1.0,
        more="rows_per_frame: 1",
    )
    take = simulate(scene)
    moments = [(c.step, c.fraction) for c in take.contacts]
    assert moments
    assert moments == sorted(moments)
    assert all(0 <= fraction < 1 for _, fraction in moments)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["block_pile", "kick"])
def test_shipped_scene_gives_the_same_bytes_twice(name: str) -> None:
    scene = load_scene(find_scene(name), ["duration=2"])
    assert simulate(scene).digest == simulate(scene).digest


@pytest.mark.nightly
def test_dominoes_all_fall_one_after_another() -> None:
    take = simulate(load_scene(find_scene("dominoes")))
    q = take.rotations[-1, : take.positions.shape[1] - 1]
    upright = 1.0 - 2.0 * (q[:, 1] ** 2 + q[:, 3] ** 2)
    assert (upright[:64] < 0.5).all()
    struck = [c.step for c in take.contacts if c.part and c.other.startswith("row_")]
    assert len(struck) >= 60


@pytest.mark.nightly
def test_walker_leaves_a_gap_in_the_wall() -> None:
    take = simulate(load_scene(find_scene("through_the_wall")))
    names = [node.name for node in take.nodes]
    bricks = [i for i, node in enumerate(take.nodes) if node.performer == "wall"]
    moved = np.linalg.norm(take.positions[-1, bricks] - take.positions[0, bricks], axis=1)
    assert (moved > 0.3).sum() > 10
    assert take.alive.all()
    assert take.positions[-1, names.index("walker.body"), 0] > 1.5
    assert take.positions[:, bricks, 1].min() > 0.0


def test_mesh_files_are_relative_to_the_scene(tmp_path: Path) -> None:
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    (tmp_path / "stone.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners))
    many = "{layout: stack, count: 2, of: {shape: mesh, file: stone.obj}}"
    text = f"pronk: 1\nduration: 0.1\ncast:\n- many: {many}\n"
    (tmp_path / "stones.yaml").write_text(text)
    recorder = Simulation(load_scene(tmp_path / "stones.yaml")).recorder
    assert len(recorder.nodes) == 2


# --- rolling and sliding ----------------------------------------------------------

SLED = (
    "{name: sled, body: {shape: box, size: [0.6, 0.1, 0.6], friction: 0.3, bounciness: 0,"
    " collide: all}, "
)
TABLE = (
    "{name: table, body: {shape: box, size: [6, 0.4, 2], density: 2000, bounciness: 0,"
    " collide: all}, at: [0, 0.2, 0]}"
)


def rolling_and_sliding(take: Take) -> list[tuple[str, str, str, float, float]]:
    """Return performer, motion, surface, start and end [s] of rolling and sliding."""
    found = [c for c in take.contacts if c.kind in ("roll", "slide")]
    assert [(e.step, e.cause) for e in take.events if e.cause in ("roll", "slide")] == [
        (c.step, c.kind) for c in found
    ]
    return [(c.performer, c.kind, c.other, c.step / 96, c.until / 96) for c in found]


@pytest.mark.parametrize(
    ("height", "cast", "other"), [(0.05, (), "terrain"), (0.45, (TABLE,), "table")]
)
def test_sliding_ends_at_low_speed(
    scene_of: Scenes, height: float, cast: tuple[str, ...], other: str
) -> None:
    sled = SLED + f"at: [-1, {height}, 0], velocity: [2, 0, 0]}}"
    take = simulate(scene_of(sled, *cast, terrain="flat", duration=1.5))
    ((who, kind, on, begin, end),) = rolling_and_sliding(take)
    assert (who, kind, on) == ("sled", "slide", other)
    assert begin == pytest.approx(0.0, abs=0.03)
    mu = 0.3 if other == "terrain" else 0.5  # of two frictions the greater holds
    assert end == pytest.approx((2.0 - 0.05) / (mu * 9.81), abs=0.06)


def test_a_ball_rolls_and_resting_bodies_are_silent(scene_of: Scenes) -> None:
    ball = (
        "{name: ball, body: {shape: sphere, radius: 0.2, bounciness: 0, rolling: 0, collide: all},"
        " at: [0, 0.2, 0], velocity: [1, 0, 0], spin_deg: [0, 0, -286.479]}"
    )
    stack = "{name: s, many: {layout: stack, count: 3, of: cube}, at: [-2, 2]}"
    take = simulate(scene_of(ball, stack, terrain="flat", duration=1.0))
    ((_, kind, on, begin, end),) = rolling_and_sliding(take)
    assert (kind, on, end) == ("roll", "terrain", 1.0)
    assert begin < 0.03
