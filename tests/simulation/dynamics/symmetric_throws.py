"""Symmetric throws: bodies, grounds and starts with a common plane of symmetry, z = 0."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from pipeline.simulation.bodies.body_model import build_body
from pipeline.simulation.characters.playthings import ball_plan
from pipeline.simulation.dynamics.mujoco_bodies import FIXED_BIT, Collider
from pipeline.simulation.dynamics.mujoco_world import MujocoWorld
from pipeline.simulation.dynamics.rigid_body import Bodies, State
from pipeline.simulation.dynamics.terrain_bodies import TerrainBodies
from pipeline.simulation.dynamics.terrain_grid import grid_of
from pipeline.simulation.scalar_rotation import quaternion_product
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.terrain import Ground
from pipeline.simulation.terrain.heightfield import QuadField
from pipeline.spec.body import BodyShape
from tests.simulation.characters.character_yard import build_yard
from tests.simulation.dynamics.terrain_body_builder import ground_of

DT = 1.0 / 96.0
TOLERANCE = 1e-6
"""Largest deviation from symmetry, in lengths of the path."""

MIRROR = np.array([1.0, 1.0, -1.0])


@dataclass(frozen=True)
class Kind:
    """Bodies of several sizes, in attitudes in which z = 0 is a plane of symmetry.

    Attributes:
        configs: of the bodies.
        q: their common attitude wxyz.
    """

    configs: tuple[dict[str, Any], ...]
    q: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)


_EIGHTH_TURN = (math.cos(math.pi / 8.0), 0.0, math.sin(math.pi / 8.0), 0.0)
_QUARTER_TURN = (math.cos(math.pi / 4.0), 0.0, math.sin(math.pi / 4.0), 0.0)

KINDS: Mapping[str, Kind] = {
    "ball": Kind(tuple({"shape": "sphere", "radius": r} for r in (0.04, 0.1, 0.25))),
    "box": Kind(({"shape": "box", "size": [0.4, 0.2, 0.3]}, {"shape": "brick"}, {"shape": "cube"})),
    "tetrahedron": Kind(({"shape": "tetrahedron"},), _EIGHTH_TURN),
    "octahedron": Kind(({"shape": "octahedron"},)),
    "dodecahedron": Kind(({"shape": "dodecahedron"},)),
    "icosahedron": Kind(({"shape": "icosahedron"},)),
    "prism": Kind(tuple({"shape": "prism", "sides": n} for n in (3, 5, 6, 24)), _QUARTER_TURN),
    "pyramid": Kind(tuple({"shape": "pyramid", "sides": n} for n in (3, 4, 5)), _QUARTER_TURN),
}

GRID = "size: [8, 4], cells: [200, 100]"
STONES = f"kind: stones, {GRID}, start: -2, jitter: 0, height_variation: 0, polygons: quads"
TERRAINS = {
    "stairs": f"{{kind: stairs, {GRID}, start: -2}}",
    "ramp": f"{{kind: ramp, {GRID}, start: -2}}",
    "ditches": f"{{kind: ditches, {GRID}, start: -3}}",
    "stones": f"{{{STONES}}}",
}


def _x_z() -> tuple[Array, Array]:
    x, z = np.linspace(-4.0, 4.0, 201), np.linspace(-2.0, 2.0, 101)
    # Rounding differs between the sides of numpy's grid.
    return tuple(np.meshgrid(x, 0.5 * (z - z[::-1])))  # type: ignore[return-value]


def _level() -> Array:
    heights = np.zeros((101, 201))
    # One low corner on either side makes it a height field and no plane.
    heights[0, 0] = heights[-1, 0] = -1.0
    return heights


def _pits() -> Array:
    x, z = _x_z()
    return np.where((np.abs(x % 1.6 - 0.8) < 0.41) & (np.abs(z) < 0.41), -0.5, 0.0)


def _ridge() -> Array:
    return -0.6 * np.abs(_x_z()[1])


def _crags() -> Array:
    heights = np.random.default_rng(4).normal(scale=0.02, size=(101, 201)).cumsum(axis=1)
    return 0.5 * (heights + heights[::-1])


def _domes() -> Array:
    x, z = _x_z()
    away = np.hypot((x + 0.6) % 1.2 - 0.6, z)
    return np.sqrt(np.maximum(0.09 - away**2, 0.0)) - 0.3 * (np.abs(x % 2.0 - 1.0) < 0.2)


def _rough() -> Array:
    heights = np.random.default_rng(4).normal(scale=0.02, size=(101, 201))
    return 0.5 * (heights + heights[::-1])


HEIGHTS: Mapping[str, Callable[[], Array]] = {
    "level": _level,
    "pits": _pits,
    "ridge": _ridge,
    "domes": _domes,
    "rough": _rough,
    "crags": _crags,
}
GROUNDS = (*HEIGHTS, *TERRAINS)


def symmetric_ground(name: str) -> Ground:
    """Return a ground that is symmetric about z = 0."""
    if name in TERRAINS:
        return ground_of(TERRAINS[name])
    field = QuadField(HEIGHTS[name](), (8.0, 4.0))
    return Ground(field, np.zeros((100, 200), dtype=bool), "dry soil")


def colliders(kind: Kind, which: Sequence[int]) -> list[Collider]:
    """Return bodies of a kind, by their number in it."""
    read = TypeAdapter(BodyShape)
    bodies = []
    for config in kind.configs:
        model = read.validate_python({"bounciness": 0.6, **config})
        build = build_body(model, "")
        size = getattr(model, "size", None)
        is_box = config["shape"] in ("box", "brick", "cube")
        half = 0.5 * np.broadcast_to(np.array(size), 3) if is_box else None
        bodies.append(Collider(build, half))
    return [bodies[k] for k in which]


@dataclass(frozen=True)
class Throws:
    """N bodies and their starts."""

    bodies: list[Collider]
    state: State
    align: Array

    def mirrored(self) -> Throws:
        """Return the mirror images in z = 0."""
        s, align = self.state, self.align
        turn = product(s.q, align * [1.0, -1.0, -1.0, -1.0]) * [1.0, -1.0, -1.0, 1.0]
        R = matrix(align)
        w = ((s.w @ R.T) * [-1.0, -1.0, 1.0]) @ R
        return Throws(
            self.bodies, State(s.p * MIRROR, product(turn, align), s.v * MIRROR, w), align
        )


def product(a: Array, b: Array) -> Array:
    """Return the products (..., 4) of quaternions wxyz."""
    one, other = np.moveaxis(a, -1, 0), np.moveaxis(b, -1, 0)
    return np.stack(quaternion_product(tuple(one), tuple(other)), axis=-1)


def throws(
    kind: Kind, ground: Ground, rng: np.random.Generator, count: int, *, in_plane: bool
) -> Throws:
    """Return random throws, along z = 0 or aslant."""
    which = rng.integers(len(kind.configs), size=count)
    bodies = colliders(kind, which)
    reach = Bodies.of([b.build for b in bodies]).reach
    align = np.array(kind.q)
    p, v, w = np.zeros((3, count, 3))
    p[:, 0] = rng.uniform(-3.0, 3.0, count)
    p[:, 1] = ground.field.heights.max() + reach + rng.uniform(0.05, 0.8, count)
    v[:, 0], v[:, 1] = rng.uniform(-3.0, 3.0, count), rng.uniform(-3.0, 2.0, count)
    w[:, 2] = rng.uniform(-6.0, 6.0, count)
    angle = rng.uniform(-math.pi, math.pi, count)
    q = np.column_stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)])
    if not in_plane:
        p[:, 2], v[:, 2] = rng.uniform(-1.0, 1.0, count), rng.uniform(-1.0, 1.0, count)
        w = rng.uniform(-4.0, 4.0, (count, 3))
        q = rng.normal(size=(count, 4))
        q /= np.linalg.norm(q, axis=1)[:, None]
    return Throws(bodies, State(p, product(q, align), v, w @ matrix(align)), align)


def paths_over_terrain(ground: Ground, thrown: Throws, steps: int) -> Array:
    """Return paths (steps + 1, N, 3) [m] of bodies that meet the terrain alone."""
    dynamics = TerrainBodies(
        Bodies.of([b.build for b in thrown.bodies]), copy(thrown.state), ground
    )
    paths = [dynamics.state.p.copy()]
    for _ in range(steps):
        dynamics.advance(DT)
        paths.append(dynamics.state.p.copy())
    return np.array(paths)


def paths_in_mujoco(ground: Ground, thrown: Throws, steps: int) -> Array:
    """Return paths (steps + 1, N, 3) [m] of colliders that do not meet one another."""
    world = MujocoWorld(thrown.bodies, copy(thrown.state), ground.field, [], DT)
    world.model.geom_conaffinity[1:] = FIXED_BIT
    paths = [world.state.p]
    for _ in range(steps):
        world.advance()
        paths.append(world.state.p)
    return np.array(paths)


def paths_of_characters(ground: Ground, thrown: Throws, steps: int) -> Array:
    """Return paths (steps + 1, N, 3) [m] of characters that are balls, each alone."""
    grid, paths = grid_of(ground.field), np.zeros((steps + 1, len(thrown.bodies), 3))
    for n, body in enumerate(thrown.bodies):
        plan = ball_plan(body.build.radius, 0.4)
        yard = build_yard([plan], [thrown.state.p[n][None]], grid=grid, level=False)
        yard.set_velocities(thrown.state.v[n][None])
        paths[0, n] = yard.arrays.p[0]
        for k in range(steps):
            yard.step()
            paths[k + 1, n] = yard.arrays.p[0]
    return paths


ENGINES = {"terrain": paths_over_terrain, "all": paths_in_mujoco, "character": paths_of_characters}


def copy(state: State) -> State:
    return State(*map(np.copy, vars(state).values()))


def deviations(paths: Array, mirrored: Array) -> Array:
    """Return the largest deviation of each path (N,) from its mirror image, in its length."""
    lengths = np.linalg.norm(np.diff(paths, axis=0), axis=-1).cumsum(axis=0)
    apart = np.linalg.norm(paths - mirrored * MIRROR, axis=-1)[1:]
    return (apart / np.maximum(lengths, 1e-300)).max(axis=0)
