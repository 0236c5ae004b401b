"""Rigid bodies over a terrain, built without a scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.simulation.bodies.ground_body_troupe import GroundBodyTroupe
from pipeline.simulation.clock import Clock
from pipeline.simulation.dynamics.rigid_body import State
from pipeline.simulation.dynamics.terrain_bodies import TerrainBodies
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground, build_ground
from pipeline.simulation.troupe import World
from pipeline.spec import read_scene
from pipeline.spec.body import Body

DT = 1.0 / 96.0

SHAPES: tuple[dict[str, Any], ...] = (
    {"shape": "box", "size": [0.4, 0.2, 0.3]},
    {"shape": "brick"},
    {"shape": "cube"},
    {"shape": "die", "size": 0.1},
    {"shape": "tetrahedron"},
    {"shape": "octahedron"},
    {"shape": "dodecahedron"},
    {"shape": "icosahedron"},
    {"shape": "prism", "sides": 5},
    {"shape": "pyramid", "sides": 4},
    {
        "shape": "hull",
        "points": [[0, 0, 0], [0.3, 0, 0], [0, 0.4, 0], [0, 0, 0.5], [0.2, 0.2, 0.3]],
    },
)
POLYHEDRA = [config["shape"] for config in SHAPES]


def ground_of(terrain: str, seed: int = 3) -> Ground:
    """Return the ground of a terrain config."""
    text = f"pronk: 1\nduration: 1\nterrain: {terrain}\ncast: [{{prop: {{shape: ball}}}}]\n"
    return build_ground(read_scene(text).terrain, seed)


def build_terrain_bodies(
    configs: Sequence[dict[str, Any]], ground: Ground, state: State | None = None, **common: Any
) -> TerrainBodies:
    """Return bodies over a ground, in a state if given.

    Args:
        configs: config of each body.
        ground: the terrain.
        state: initial state; far above the ground if None.
        common: config keys of all bodies.
    """
    top = float(ground.field.heights.max()) + 50.0
    cast = [
        (i, Body.model_validate({"body": {**config, **common}, "at": (0.0, top, 0.0)}))
        for i, config in enumerate(configs)
    ]
    world = World(ground, Clock(24, 1), 1)  # type: ignore[arg-type]
    bodies = GroundBodyTroupe(cast, world, ["wood"] * len(cast)).dynamics
    if state is not None:
        bodies.state.put(np.arange(len(cast)), state)
        bodies.find_contacts()
    return bodies


def attitudes(rng: np.random.Generator, count: int) -> Array:
    """Return attitudes (count, 4), each as likely as any other."""
    q = rng.normal(size=(count, 4))
    result: Array = q / np.linalg.norm(q, axis=1, keepdims=True)
    return result


def still(p: Array, q: Array | None = None) -> State:
    """Return bodies at rest at p (N, 3)."""
    p = np.asarray(p, dtype=float)
    q = np.tile([1.0, 0.0, 0.0, 0.0], (len(p), 1)) if q is None else q
    return State(p.copy(), q.copy(), np.zeros((len(p), 3)), np.zeros((len(p), 3)))


def face_down(terrain_bodies: TerrainBodies) -> Array:
    """Return attitudes (N, 4) in which the first facet of each body looks down."""
    n = np.array([[0, -1, 0] if h is None else h.normals[0] for h in terrain_bodies.bodies.hulls])
    # The shortest turn from n to -Y: (1 - n·y, n × -y), normalised.
    q = np.column_stack([1.0 - n[:, 1], n[:, 2], np.zeros(len(n)), -n[:, 0]])
    up = n[:, 1] > 1.0 - 1e-9
    q[up] = [0.0, 1.0, 0.0, 0.0]
    result: Array = q / np.linalg.norm(q, axis=1, keepdims=True)
    return result
