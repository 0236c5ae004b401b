"""MuJoCo bodies: the model of rigid bodies, a terrain and kinematic bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.impact_arrays import THING
from pipeline.simulation.dynamics.mujoco_model import (
    add_ground,
    is_level,
    log_warnings,
    memory_for,
)
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.dynamics.rigid_body import Bodies, BodyModel
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField

SLEEP_SPEED = 2e-3
"""Speed below which an island of bodies may fall asleep [m/s]."""


CONTACT_IMPEDANCE = 0.99
"""MuJoCo's contacts give way a little; this fraction of the force is applied."""


CONTACT_REACH = 1.5
"""Distance from the centre at which a body is touched, in its reach."""


KINEMATIC_MASS_RATIO = 1e6
"""Mass of a kinematic body, relative to the heaviest body."""


@dataclass(frozen=True, slots=True)
class Collider:
    """A body of a MuJoCo model.

    Attributes:
        build: mass, hull and contact properties.
        half: half the extent along its axes of a box [m], otherwise None.
    """

    build: BodyModel
    half: Array | None


def impact_things(builds: Sequence[BodyModel], pushers: int) -> Records:
    """Returns the constants of terrain, bodies and kinematic bodies, in MuJoCo's order."""
    bodies = Bodies.of(builds)
    things = zero_records(1 + len(builds) + pushers, THING)
    # Ground and kinematic bodies have none of their own: the body's bounciness holds.
    things["bounciness"] = np.inf
    own = things[1 : 1 + len(builds)]
    own["bounciness"] = bodies.bounciness
    own["inverse_mass"], own["inverse_inertia"] = 1.0 / bodies.mass, bodies.inverse
    turns = np.linalg.eigvalsh(bodies.inverse)[:, -1]
    # Contacts may lie a little outside the body.
    own["gives"] = 1.0 / bodies.mass + (CONTACT_REACH * bodies.reach) ** 2 * turns
    return things


BODY_BIT, FIXED_BIT = 1, 2
"""Collision bits: bodies meet one another and what does not give way."""


def ground_is_box(colliders: Sequence[Collider], field: HeightField) -> bool:
    """Returns whether a terrain is a box for MuJoCo: a level one that no mesh meets.

    MuJoCo finds one contact of a mesh with a box, somewhere on the facet that lands flat, so the
    mesh is turned by chance. On a height field it has all of `terrain_contacts`.
    """
    return is_level(field) and all(c.build.hull is None or c.half is not None for c in colliders)


def build_model(
    colliders: Sequence[Collider], field: HeightField, pushers: Sequence[Array]
) -> tuple[Any, Any, Any]:
    """Returns model, data and module: the terrain first, then bodies, then kinematic bodies."""
    import mujoco

    log_warnings(mujoco)
    spec = mujoco.MjSpec()
    _set_options(spec, mujoco)
    matter = {"contype": FIXED_BIT, "conaffinity": 0, **_contact_options(0.0, 0.0)}
    add_ground(spec, mujoco, field, matter, ground_is_box(colliders, field))
    for i, collider in enumerate(colliders):
        _add_body(spec, mujoco, f"body {i}", collider)
    heaviest = max(c.build.mass.mass for c in colliders)
    for k, corners in enumerate(pushers):
        _add_kinematic_body(spec, mujoco, f"pusher {k}", corners, KINEMATIC_MASS_RATIO * heaviest)
    spec.nuserdata = 2
    spec.memory = memory_for(len(colliders) + len(pushers))
    model = spec.compile()
    return model, mujoco.MjData(model), mujoco


def _set_options(spec: Any, mujoco: Any) -> None:
    option = spec.option
    option.gravity = [0.0, -GRAVITY, 0.0]
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    option.sleep_tolerance = SLEEP_SPEED
    option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)


def _contact_options(friction: float, rolling: float) -> dict[str, Any]:
    # MuJoCo takes the greater friction of a pair; the fixed one has none of its own.
    return {
        "friction": [friction, 0.0, rolling],
        "condim": 6 if rolling > 0.0 else 3,
        "solref": [-1.0, -1.0],
        "solimp": [CONTACT_IMPEDANCE, CONTACT_IMPEDANCE, 0.001, 0.5, 2.0],
    }


def _add_body(spec: Any, mujoco: Any, name: str, collider: Collider) -> None:
    build = collider.build
    body = _add_free_body(spec, name, build.mass.mass, build.mass.inertia)
    common = {
        "contype": BODY_BIT,
        "conaffinity": BODY_BIT | FIXED_BIT,
        **_contact_options(build.friction, build.rolling * 2.0 * build.radius),
    }
    geom = mujoco.mjtGeom
    if build.hull is None:
        body.add_geom(type=geom.mjGEOM_SPHERE, size=[build.radius, 0.0, 0.0], **common)
    elif collider.half is not None:
        body.add_geom(type=geom.mjGEOM_BOX, size=collider.half, **common)
    else:
        spec.add_mesh(name=name, uservert=build.hull.vertices.ravel().tolist())
        body.add_geom(type=geom.mjGEOM_MESH, meshname=name, **common)


def _add_kinematic_body(spec: Any, mujoco: Any, name: str, corners: Array, mass: float) -> None:
    size = float(np.ptp(corners, axis=0).max())
    body = _add_free_body(spec, name, mass, mass * size * size * np.eye(3))
    body.gravcomp = 1.0
    body.sleep = mujoco.mjtSleepPolicy.mjSLEEP_NEVER
    spec.add_mesh(name=name, uservert=corners.ravel().tolist())
    common = {"contype": FIXED_BIT, "conaffinity": 0, **_contact_options(0.0, 0.0)}
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, **common)


def _add_free_body(spec: Any, name: str, mass: float, inertia: Array) -> Any:
    """Adds a body that moves freely about its centre of mass, with given mass properties."""
    body = spec.worldbody.add_body(name=name)
    body.add_freejoint()
    body.explicitinertial = True
    body.mass = mass
    body.ipos = [0.0, 0.0, 0.0]
    i = inertia
    body.fullinertia = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
    return body
