"""Body instances: one record for each body of the cast, with its model and initial motion.

Equal bodies share one model.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import Any

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.bodies.arrangements import Placements, arrange
from pipeline.simulation.bodies.body_meshes import visible_solids
from pipeline.simulation.bodies.body_model import build_body
from pipeline.simulation.bodies.prop_bodies import collider_of_prop
from pipeline.simulation.bodies.prop_paths import path_of_prop
from pipeline.simulation.bodies.prop_shapes import prop_solid
from pipeline.simulation.dynamics.mujoco_bodies import Collider
from pipeline.simulation.dynamics.rigid_body import BodyModel, State, rotate_inverse
from pipeline.simulation.inventory import Inventory, rigid_mesh
from pipeline.simulation.keyframe_track import rotation_from_angles
from pipeline.simulation.obstacles import directions
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array, heading, quaternion, turn
from pipeline.simulation.take import Mesh, Node, Part
from pipeline.simulation.terrain import Ground
from pipeline.simulation.troupe import World
from pipeline.spec.body import Body, Box, Brick, Cube, Many
from pipeline.spec.prop import Prop

PERIMETER_SAMPLES = 33
"""Points around a body at which the height of the ground is sampled."""


@dataclass(frozen=True, eq=False)
class BodyInstance:
    """One body and its initial motion.

    Attributes:
        name: of its node.
        performer: name of its performer.
        part: its name among the performer's parts, empty for a single body.
        path: of its place in the scene.
        config: model of the body in the scene.
        material: by name.
        collider: its mass and shape.
        size: characteristic length [m].
        p: (3,) initial centre of mass; y is ignored if `on_ground` [m].
        R: (3, 3).
        v: (3,) [m/s].
        w: (3,) in the world [rad/s].
        on_ground: whether it is put on the ground below it.
        origin: (3,) of its node from its centre of mass, in its frame [m].
    """

    name: str
    performer: str
    part: str
    path: str
    config: Any
    material: str
    collider: Collider
    size: float
    p: Array
    R: Array
    v: Array
    w: Array
    on_ground: bool
    origin: Array = field(default_factory=partial(np.zeros, 3))

    @property
    def model(self) -> BodyModel:
        """Mass, hull and contact properties."""
        return self.collider.build


def instantiate_bodies(
    cast: Sequence[tuple[int, Body | Many | Prop]], world: World, materials: Sequence[str]
) -> list[BodyInstance]:
    """Returns all bodies of performers, each with its number in the cast.

    Raises:
        SceneError: if a shape is no solid.
    """
    instances, problems = list[BodyInstance](), list[Problem]()
    for (i, member), material in zip(cast, materials, strict=True):
        if isinstance(member, Prop):
            instances.append(_instance_of_prop(i, member, world, material))
            continue
        try:
            instances += _instances_of(i, member, world, material)
        except SceneError as error:
            problems += error.problems
    if problems:
        raise SceneError(problems)
    return instances


def _instances_of(i: int, member: Body | Many, world: World, material: str) -> list[BodyInstance]:
    if isinstance(member, Body):
        config, path = member.body, f"cast[{i}].body"
    else:
        config, path = member.many.of, f"cast[{i}].many.of"
    model = _cached_model(config, path)
    low, high = _bounding_box(model)
    instance = BodyInstance(
        name=member.name,
        performer=member.name,
        part="",
        path=f"cast[{i}].at",
        config=config,
        material=material,
        collider=Collider(model, _half_extent(config)),
        size=float((high - low).max()),
        p=np.array([member.at[0], member.at[1] if len(member.at) == 3 else 0.0, member.at[-1]]),
        R=heading(math.radians(member.heading_deg)),
        v=np.array(member.velocity, dtype=float),
        w=np.zeros(3),
        on_ground=len(member.at) == 2,
    )
    if isinstance(member, Body):
        own = rotation_from_angles(np.radians(np.array([member.rotation_deg])))[0]
        w = np.radians(np.array(member.spin_deg, dtype=float))
        return [replace(instance, R=instance.R @ own, w=w)]
    return _arranged_instances(member, instance, world)


def _instance_of_prop(number: int, member: Prop, world: World, material: str) -> BodyInstance:
    """Returns a prop as a body; where its path begins.

    Args:
        number: of the prop in the cast.
        member: the prop.
        world: constants of the scene.
        material: by name.
    """
    solid = prop_solid(member.prop)
    collider, centre = collider_of_prop(member)
    p, R = path_of_prop(member, world).at(np.zeros(1))
    return BodyInstance(
        name=member.name,
        performer=member.name,
        part="",
        path=f"cast[{number}].at",
        config=member.prop,
        material=material,
        collider=collider,
        size=float(np.ptp(solid.vertices, axis=0).max()),
        p=p[0] + R[0] @ centre,
        R=R[0],
        v=np.zeros(3),
        w=np.zeros(3),
        on_ground=False,
        origin=-centre,
    )


def _arranged_instances(member: Many, shared: BodyInstance, world: World) -> list[BodyInstance]:
    """Returns the bodies of an arrangement; `shared` has what they have in common."""
    rng = generator(world.seed, member.name)
    low, high = _bounding_box(shared.model)
    placements = arrange(member.many, high - low, rng)
    picked = rng.integers(0, max(len(member.many.materials), 1), len(placements.p))
    places = _arranged_positions(member, shared, placements, (low, high), world.ground)
    return [
        replace(
            shared,
            name=f"{member.name}_{k + 1}",
            part=f"{member.name}_{k + 1}",
            material=member.many.materials[picked[k]] if member.many.materials else shared.material,
            p=places[k],
            R=shared.R @ placements.R[k],
            on_ground=placements.on_ground,
        )
        for k in range(len(places))
    ]


def _arranged_positions(
    member: Many,
    shared: BodyInstance,
    placements: Placements,
    bounds: tuple[Array, Array],
    ground: Ground,
) -> Array:
    """Returns the initial centres of mass (n, 3) of an arrangement [m].

    Args:
        member: the arrangement.
        shared: properties that its bodies have in common.
        placements: their poses relative to the arrangement.
        bounds: corners (3,) of the box around one, from its centre of mass [m].
        ground: the ground below.
    """
    middle, half = 0.5 * (bounds[0] + bounds[1]), 0.5 * (bounds[1] - bounds[0])
    p: Array = shared.p + turn(shared.R, placements.p) - turn(shared.R @ placements.R, middle)
    if not placements.on_ground and len(member.at) == 2:
        # A wall is level, and stands on the highest ground below it.
        radius = float(np.sqrt((half * half).sum()) + np.sqrt((middle * middle).sum()))
        lowest = placements.p[:, 1] <= placements.p[:, 1].min() + 1e-9
        p[:, 1] += _highest_ground(ground, p[lowest][:, [0, 2]], radius)
    return p


def _highest_ground(ground: Ground, places: Array, radius: float) -> float:
    """Returns the greatest height of the ground around positions (n, 2), at vertices or near."""
    angle = np.linspace(0.0, 2.0 * np.pi, PERIMETER_SAMPLES)
    x = places[:, :1] + radius * np.cos(angle)
    highest = float(ground.height(x, places[:, 1:] + radius * np.sin(angle)).max())
    vertices = ground.field.vertices
    low, high = places.min(axis=0) - radius, places.max(axis=0) + radius
    inside = ((vertices[:, [0, 2]] >= low) & (vertices[:, [0, 2]] <= high)).all(axis=1)
    for x_v, y_v, z_v in vertices[inside & (vertices[:, 1] > highest)]:
        if np.hypot(places[:, 0] - x_v, places[:, 1] - z_v).min() < radius:
            highest = max(highest, float(y_v))
    return highest


@cache
def _cached_model(config: Any, path: str) -> BodyModel:
    return build_body(config, path)


def _half_extent(config: Any) -> Array | None:
    """Returns half the extent of a box, None for other shapes [m]."""
    if isinstance(config, Box | Brick):
        return 0.5 * np.array(config.size)
    return np.full(3, 0.5 * config.size) if isinstance(config, Cube) else None


def _bounding_box(model: BodyModel) -> tuple[Array, Array]:
    """Returns the corners (3,) of the box around a body [m]."""
    if model.hull is None:
        return np.full(3, -model.radius), np.full(3, model.radius)
    return model.hull.vertices.min(axis=0), model.hull.vertices.max(axis=0)


def corners_of(instance: BodyInstance) -> Array:
    """Returns corners (V, 3) of a body about its centre of mass; of a ball many on its surface."""
    model = instance.model
    return model.hull.vertices if model.hull is not None else model.radius * directions()


def initial_state(instances: Sequence[BodyInstance]) -> State:
    """Returns the initial state of bodies."""
    R = np.array([instance.R for instance in instances])
    return State(
        np.array([instance.p for instance in instances]),
        quaternion(R),
        np.array([instance.v for instance in instances]),
        rotate_inverse(R, np.array([instance.w for instance in instances])),
    )


def body_inventory(instances: Sequence[BodyInstance], rows: int) -> Inventory:
    """Returns nodes, meshes and parts of bodies that live through all rows."""
    nodes, meshes, parts = list[Node](), list[Mesh](), list[Part]()
    solids_of = cache(visible_solids)
    for i, instance in enumerate(instances):
        nodes.append(Node(instance.name, instance.performer, -1, (0.0, 0.0, 0.0)))
        for suffix, solid, material in solids_of(
            instance.config, instance.model, instance.material
        ):
            size = float(np.ptp(solid.vertices, axis=0).max())
            name = instance.name + suffix
            parts.append(Part(name, instance.performer, len(meshes), material, size, (0, rows)))
            meshes.append(rigid_mesh(solid, i))
    return Inventory(tuple(nodes), (), tuple(meshes), tuple(parts))
