"""MuJoCo worlds of a few colliding bodies, without a scene."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.bodies.body_model import CUBE_CORNERS
from pipeline.simulation.dynamics.hull import hull_of
from pipeline.simulation.dynamics.mass import MassProperties, mass_of_solid
from pipeline.simulation.dynamics.mujoco_bodies import Collider
from pipeline.simulation.dynamics.mujoco_world import MujocoWorld, Strike
from pipeline.simulation.dynamics.rigid_body import BodyModel, State
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField

STEP = 1.0 / 96.0

FLAT = HeightField(np.zeros((3, 3)), (40.0, 40.0))


def box(size: Sequence[float], bounciness: float = 0.3, friction: float = 0.5) -> Collider:
    """Return a wooden box."""
    half = 0.5 * np.array(size)
    hull = hull_of(CUBE_CORNERS * half)
    return Collider(
        BodyModel(mass_of_solid(hull.vertices, hull.faces, 600.0), hull, 0.0, bounciness, friction),
        half,
    )


def ball(
    radius: float, bounciness: float = 0.3, friction: float = 0.5, mass: float = 1.0
) -> Collider:
    """Return a ball that rolls without resistance."""
    own = MassProperties(mass, np.zeros(3), 0.4 * mass * radius**2 * np.eye(3))
    return Collider(BodyModel(own, None, radius, bounciness, friction), None)


def polyhedron(corners: Array, bounciness: float = 0.3, friction: float = 0.5) -> Collider:
    """Return the hull of corners, about its centre of mass."""
    hull = hull_of(corners)
    own = mass_of_solid(hull.vertices, hull.faces, 600.0)
    hull = hull_of(hull.vertices - own.centre)
    own = mass_of_solid(hull.vertices, hull.faces, 600.0)
    return Collider(BodyModel(own, hull, 0.0, bounciness, friction), None)


def initial_state(
    p: Sequence[Sequence[float]], v: Sequence[Sequence[float]] | None = None
) -> State:
    """Return the state of unrotated bodies at p (N, 3) with velocities v (N, 3)."""
    n = len(p)
    speeds = np.zeros((n, 3)) if v is None else np.array(v, dtype=float)
    q = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    return State(np.array(p, dtype=float), q, speeds, np.zeros((n, 3)))


def world_of(
    colliders: Sequence[Collider],
    p: Sequence[Sequence[float]],
    v: Sequence[Sequence[float]] | None = None,
    field: HeightField = FLAT,
    pushers: Sequence[Array] = (),
) -> MujocoWorld:
    """Return a world of colliders at p (N, 3) with velocities v (N, 3)."""
    return MujocoWorld(colliders, initial_state(p, v), field, pushers, STEP)


def run(world: MujocoWorld, seconds: float) -> list[tuple[float, Strike]]:
    """Advance by `seconds`; return the strikes and their times [s]."""
    strikes = []
    for i in range(round(seconds / STEP)):
        strikes += [(i * STEP + strike.time, strike) for strike in world.advance()]
    return strikes
