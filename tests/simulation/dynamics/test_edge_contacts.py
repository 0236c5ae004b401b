"""Contacts at edges: symmetric throws on symmetric ground stay symmetric, in both engines."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from pipeline.simulation.dynamics.mujoco_bodies import FIXED_BIT
from pipeline.simulation.dynamics.mujoco_terrain import _collision_table
from pipeline.simulation.dynamics.mujoco_world import MujocoWorld
from pipeline.simulation.dynamics.rigid_body import Bodies, State
from pipeline.simulation.dynamics.terrain_bodies import TerrainBodies
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground
from pipeline.simulation.terrain.heightfield import HeightField, QuadField
from tests.simulation.dynamics.collision_worlds import ball, initial_state
from tests.simulation.dynamics.terrain_body_builder import ground_of

DT = 1.0 / 96.0
RADII = (0.04, 0.1, 0.25)
GRID = "size: [8, 4], cells: [200, 100]"
STONES = f"kind: stones, {GRID}, start: -2, jitter: 0, height_variation: 0"
TERRAINS = {
    "stairs": f"{{kind: stairs, {GRID}, start: -2}}",
    "ramp": f"{{kind: ramp, {GRID}, start: -2}}",
    "ditches": f"{{kind: ditches, {GRID}, start: -3}}",
    "stones": f"{{{STONES}}}",
    "quads": f"{{{STONES}, polygons: quads}}",
}


def _boulders() -> Ground:
    """Return domes along z = 0, some of them in pits."""
    x, z = np.meshgrid(np.linspace(-4.0, 4.0, 201), np.linspace(-2.0, 2.0, 101))
    away = np.hypot((x + 0.6) % 1.2 - 0.6, z)
    heights = np.sqrt(np.maximum(0.09 - away**2, 0.0)) - 0.3 * (np.abs(x % 2.0 - 1.0) < 0.2)
    # Rounding differs between the sides of numpy's grid.
    field = QuadField(0.5 * (heights + heights[::-1]), (8.0, 4.0))
    return Ground(field, np.zeros((100, 200), dtype=bool), "dry soil")


def _ground(name: str) -> Ground:
    return _boulders() if name == "boulders" else ground_of(TERRAINS[name])


def _paths_over_terrain(ground: Ground, radii: Array, state: State, steps: int) -> Array:
    """Return paths (steps + 1, N, 3) [m] of balls that meet the terrain alone."""
    bodies = Bodies.of([ball(r, 0.6).build for r in radii])
    dynamics = TerrainBodies(bodies, state, ground)
    paths = [dynamics.state.p.copy()]
    for _ in range(steps):
        dynamics.advance(DT)
        paths.append(dynamics.state.p.copy())
    return np.array(paths)


def _paths_in_mujoco(ground: Ground, radii: Array, state: State, steps: int) -> Array:
    """Return paths (steps + 1, N, 3) [m] of colliders that do not meet one another."""
    world = MujocoWorld([ball(r, 0.6) for r in radii], state, ground.field, [], DT)
    world.model.geom_conaffinity[1:] = FIXED_BIT
    paths = [world.state.p]
    for _ in range(steps):
        world.advance()
        paths.append(world.state.p)
    return np.array(paths)


Paths = Callable[[Ground, Array, State, int], Array]
ENGINES: dict[str, Paths] = {"terrain": _paths_over_terrain, "all": _paths_in_mujoco}


def _throws(ground: Ground, rng: np.random.Generator, count: int) -> tuple[Array, State]:
    """Return radii (N,) [m] and a state of balls thrown along the plane z = 0."""
    radii, x = rng.choice(RADII, count), rng.uniform(-3.0, 3.0, count)
    p, v = np.zeros((count, 3)), np.zeros((count, 3))
    p[:, 0], p[:, 1] = x, ground.field.heights.max() + radii + rng.uniform(0.05, 0.8, count)
    v[:, 0], v[:, 1] = rng.uniform(-3.0, 3.0, count), rng.uniform(-3.0, 2.0, count)
    state = initial_state(p.tolist(), v.tolist())
    return radii, state


def _lengths(paths: Array) -> Array:
    """Return the length (steps, N) of paths up to each row [m]."""
    lengths: Array = np.linalg.norm(np.diff(paths, axis=0), axis=-1).cumsum(axis=0)
    return lengths


@pytest.mark.sample(3)
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("terrain", [*TERRAINS, "boulders"])
@pytest.mark.parametrize(
    "count",
    [
        pytest.param(20, marks=pytest.mark.slow, id="20"),
        pytest.param(1000, marks=pytest.mark.nightly, id="1000"),
    ],
)
def test_throws_along_a_plane_of_symmetry_stay_in_it(terrain: str, engine: str, count: int) -> None:
    ground = _ground(terrain)
    radii, state = _throws(ground, np.random.default_rng(count), count)
    paths = ENGINES[engine](ground, radii, state, 192)
    assert (np.abs(paths[1:, :, 2]) <= 1e-6 * _lengths(paths)).all()
    # Balls met the ground: they did not only fly.
    assert (paths[-1, :, 1] > -3.0).sum() > count / 3


@pytest.mark.sample(2)
@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("terrain", ["stairs", "ramp", "ditches", "quads"])
def test_mirrored_throws_take_mirrored_paths(terrain: str, engine: str) -> None:
    ground, rng, count = _ground(terrain), np.random.default_rng(5), 50
    radii, state = _throws(ground, rng, count)
    state.p[:, 2], state.v[:, 2] = rng.uniform(-1.0, 1.0, count), rng.uniform(-1.0, 1.0, count)
    paths = ENGINES[engine](ground, radii, State(*map(np.copy, vars(state).values())), 96)
    state.p[:, 2] *= -1.0
    state.v[:, 2] *= -1.0
    mirrored = ENGINES[engine](ground, radii, state, 96) * [1.0, 1.0, -1.0]
    apart = np.linalg.norm(paths - mirrored, axis=-1)[1:]
    assert (apart <= 1e-6 * _lengths(paths)).all()


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("kind", [HeightField, QuadField])
def test_balls_roll_straight_over_edges_between_coplanar_triangles(
    kind: type[HeightField], engine: str
) -> None:
    heights = np.zeros((41, 41))
    # One low corner makes it a height field and no plane.
    heights[0, 0] = -1.0
    ground = Ground(kind(heights, (4.0, 4.0)), np.zeros((40, 40), dtype=bool), "dry soil")
    radii = np.array(RADII)
    p = np.column_stack([np.full(3, -0.9), radii, [-0.51, 0.03, 0.52]])
    way = np.array([np.cos(0.3), 0.0, np.sin(0.3)])
    paths = ENGINES[engine](
        ground, radii, initial_state(p.tolist(), [(1.5 * way).tolist()] * 3), 96
    )
    moved = paths - paths[0]
    np.testing.assert_allclose(np.cross(moved, way)[..., 1], 0.0, atol=1e-6)
    assert (np.abs(moved[..., 1]) < 1e-3).all()
    # A ball that slides first rolls at five sevenths of its speed.
    assert ((moved[-1] @ way > 1.0) & (moved[-1] @ way < 1.5)).all()


def test_the_table_of_collision_functions_is_left_as_it_was() -> None:
    def functions() -> list[list[int | None]]:
        return [list(row) for row in _collision_table(mujoco)]

    before = functions()
    _paths_in_mujoco(_ground("stairs"), np.array([0.1]), initial_state([[0.0, 2.0, 0.0]]), 20)
    assert functions() == before
