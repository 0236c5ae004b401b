"""Body instances: one record for each body of the cast, with its model and initial motion.

Equal bodies share one model.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.bodies.arrangements import Placements, arrange
from pipeline.simulation.bodies.body_model import build_body, mesh_of, seen_of
from pipeline.simulation.dynamics.mujoco_bodies import Collider
from pipeline.simulation.dynamics.rigid_body import BodyModel, State, unrotate
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.keyframe_track import rotation_from_angles
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array, heading, quaternion, turn
from pipeline.simulation.take import Mesh, Node, Part
from pipeline.simulation.terrain import Ground
from pipeline.simulation.troupe import World
from pipeline.spec.body import Body, Box, Brick, Cube, Many

PERIMETER_SAMPLES = 33
"""Places around a body at which the ground is looked at."""


@dataclass(frozen=True, eq=False)
class BodyInstance:
    """One body and how it begins.

    Attributes:
        name: of its node.
        performer: whose it is.
        part: its name among the performer's, empty if it is all there is.
        path: where it stands in the scene.
        words: of the body.
        material: by name.
        collider: its mass and shape.
        size: characteristic length [m].
        p: (3,) where its centre of mass begins; y is left aside if `on_ground` [m].
        R: (3, 3).
        v: (3,) [m/s].
        w: (3,) in the world [rad/s].
        on_ground: whether it is put on the ground below it.
    """

    name: str
    performer: str
    part: str
    path: str
    words: Any
    material: str
    collider: Collider
    size: float
    p: Array
    R: Array
    v: Array
    w: Array
    on_ground: bool


def instantiate_bodies(
    cast: Sequence[tuple[int, Body | Many]], world: World, materials: Sequence[str]
) -> list[BodyInstance]:
    """Return all bodies.

    Raises:
        SceneError: shapes are no solids, or a name is taken.
    """
    blocks, problems = list[BodyInstance](), list[Problem]()
    for (i, member), material in zip(cast, materials, strict=True):
        try:
            blocks += _instances_of(i, member, world, material)
        except SceneError as error:
            problems += error.problems
    if problems:
        raise SceneError(problems)
    return blocks


def _instances_of(i: int, member: Body | Many, world: World, material: str) -> list[BodyInstance]:
    if isinstance(member, Body):
        words, path = member.body, f"cast[{i}].body"
    else:
        words, path = member.many.of, f"cast[{i}].many.of"
    build = _cached_model(words, path)
    half = _half_extent(words)
    block = BodyInstance(
        name=member.name,
        performer=member.name,
        part="",
        path=f"cast[{i}].at",
        words=words,
        material=material,
        collider=Collider(build, half),
        size=_size(build),
        p=np.array([member.at[0], member.at[1] if len(member.at) == 3 else 0.0, member.at[-1]]),
        R=heading(math.radians(member.heading_deg)),
        v=np.array(member.velocity, dtype=float),
        w=np.zeros(3),
        on_ground=len(member.at) == 2,
    )
    if isinstance(member, Body):
        look = rotation_from_angles(np.radians(np.array([member.rotation_deg])))[0]
        w = np.radians(np.array(member.spin_deg, dtype=float))
        return [replace(block, R=block.R @ look, w=w)]
    return _arranged_instances(member, block, world)


def _arranged_instances(member: Many, block: BodyInstance, world: World) -> list[BodyInstance]:
    """Return the bodies of an arrangement, of which `block` has what they share."""
    chance = generator(world.seed, member.name)
    low, high = _bounding_box(block.collider.build)
    spots = arrange(member.many, high - low, chance)
    picked = chance.integers(0, max(len(member.many.materials), 1), len(spots.p))
    places = _arranged_positions(member, block, spots, (low, high), world.ground)
    return [
        replace(
            block,
            name=f"{member.name}_{k + 1}",
            part=f"{member.name}_{k + 1}",
            material=member.many.materials[picked[k]] if member.many.materials else block.material,
            p=places[k],
            R=block.R @ spots.R[k],
            on_ground=spots.on_ground,
        )
        for k in range(len(places))
    ]


def _arranged_positions(
    member: Many,
    block: BodyInstance,
    spots: Placements,
    bounds: tuple[Array, Array],
    ground: Ground,
) -> Array:
    """Return where the centres of mass (n, 3) of an arrangement begin [m].

    Args:
        member: the arrangement.
        block: what its bodies share.
        spots: where they stand.
        bounds: corners (3,) of the box around one, from its centre of mass [m].
        ground: that they stand on.
    """
    middle, half = 0.5 * (bounds[0] + bounds[1]), 0.5 * (bounds[1] - bounds[0])
    p: Array = block.p + turn(block.R, spots.p) - turn(block.R @ spots.R, middle)
    if not spots.on_ground and len(member.at) == 2:
        # A wall is level, and stands on the highest ground below it.
        radius = float(np.sqrt((half * half).sum()) + np.sqrt((middle * middle).sum()))
        lowest = spots.p[:, 1] <= spots.p[:, 1].min() + 1e-9
        p[:, 1] += _highest_ground(ground, p[lowest][:, [0, 2]], radius)
    return p


def _highest_ground(ground: Ground, places: Array, radius: float) -> float:
    """Return the greatest height of the ground around places (n, 2): at a vertex, or near by."""
    angle = np.linspace(0.0, 2.0 * np.pi, PERIMETER_SAMPLES)
    x = places[:, :1] + radius * np.cos(angle)
    z = places[:, 1:] + radius * np.sin(angle)
    highest = float(ground.height(x, z).max())
    vertices = ground.field.vertices
    low, high = places.min(axis=0) - radius, places.max(axis=0) + radius
    inside = ((vertices[:, [0, 2]] >= low) & (vertices[:, [0, 2]] <= high)).all(axis=1)
    for x_v, y_v, z_v in vertices[inside & (vertices[:, 1] > highest)]:
        if np.hypot(places[:, 0] - x_v, places[:, 1] - z_v).min() < radius:
            highest = max(highest, float(y_v))
    return highest


@cache
def _cached_model(words: Any, path: str) -> BodyModel:
    """Return the build of a body; what is alike is built once."""
    return build_body(words, path)


def _half_extent(words: Any) -> Array | None:
    """Return half the extent of a box, None of what is none [m]."""
    if isinstance(words, Box | Brick):
        return 0.5 * np.array(words.size)
    return np.full(3, 0.5 * words.size) if isinstance(words, Cube) else None


def _bounding_box(build: BodyModel) -> tuple[Array, Array]:
    """Return the corners (3,) of the box around a body [m]."""
    if build.hull is None:
        return np.full(3, -build.radius), np.full(3, build.radius)
    return build.hull.vertices.min(axis=0), build.hull.vertices.max(axis=0)


def _size(build: BodyModel) -> float:
    low, high = _bounding_box(build)
    return float((high - low).max())


def initial_state(blocks: Sequence[BodyInstance], ground: Ground) -> tuple[State, list[bool]]:
    """Return how bodies begin, and which are yet to be put on the ground."""
    R = np.array([block.R for block in blocks])
    state = State(
        np.array([block.p for block in blocks]),
        quaternion(R),
        np.array([block.v for block in blocks]),
        unrotate(R, np.array([block.w for block in blocks])),
    )
    return state, [block.on_ground for block in blocks]


def body_inventory(blocks: Sequence[BodyInstance], rows: int) -> Inventory:
    """Return what bodies add to the take."""
    nodes, meshes, parts = list[Node](), list[Mesh](), list[Part]()
    seen = cache(seen_of)
    for i, block in enumerate(blocks):
        nodes.append(Node(block.name, block.performer, -1, (0.0, 0.0, 0.0)))
        for suffix, solid, material in seen(block.words, block.collider.build, block.material):
            size = float(np.ptp(solid.vertices, axis=0).max())
            name = block.name + suffix
            parts.append(Part(name, block.performer, len(meshes), material, size, (0, rows)))
            meshes.append(mesh_of(solid, i))
    return Inventory(tuple(nodes), (), tuple(meshes), tuple(parts))
