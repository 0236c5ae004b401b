"""Ragdoll model: bones and joints of a ragdoll, and the MuJoCo model of them.

The passive stiffness of a joint follows from the bodies beyond it: a mass m whose radius of
gyration about the joint is l swings with √(g / l) and weighs m g l at most; stiffness and damping
are fractions of these. So a ragdoll falls limply in the same way at any scale.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.mass import MassProperties, joined
from pipeline.simulation.dynamics.mujoco_model import (
    add_ground,
    is_level,
    log_warnings,
    memory_for,
    use_upward_collision,
)
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField

WORLD = -1
"""Parent of the first bone."""

STIFFNESS_RATIO = 0.12
"""Stiffness of a joint, relative to the moment of the weight beyond it."""

DAMPING_RATIO = 0.4
"""Damping of a joint, relative to the critical damping of the pendulum beyond it."""

SINEW_RATIO = 0.45
"""Least damping of a joint, relative to that of the joint before it, whose muscles its sinews come
from: a toe that weighs next to nothing does not flap."""

ARMATURE_RATIO = 0.1
"""Extra inertia of a joint, relative to that beyond it: a body that lies on a thin tail would
twist it."""


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """One degree of freedom.

    Attributes:
        axis: (3,) in the creation frame, of length one.
        slides: whether it slides along its axis instead of turning about it.
        lower, upper: limits [rad or m].
        rest: value that passive stiffness draws it to [rad or m].
    """

    axis: Array
    slides: bool
    lower: float
    upper: float
    rest: float


@dataclass(frozen=True, slots=True, eq=False)
class Bone:
    """A rigid body, in the creation frame, in which all joint values are zero.

    Attributes:
        parent: number of the bone that it hangs on, a lower one; `WORLD` for the first.
        place: (3,) of its joints [m].
        joints: from the parent outward, none for the first, which moves freely.
        mass: its mass properties.
        corners: (V, 3) of its convex hull [m].
    """

    parent: int
    place: Array
    joints: tuple[Joint, ...]
    mass: MassProperties
    corners: Array


@dataclass(frozen=True, slots=True)
class JointFlesh:
    """Passive properties of a revolute joint; see `of_sliding`.

    Attributes:
        stiffness: [N m/rad].
        damping: [N m s/rad].
        inertia: [kg m²].
        length: that divides them for a prismatic joint [m].
    """

    stiffness: float
    damping: float
    inertia: float
    length: float

    def of_sliding(self) -> JointFlesh:
        """Returns the same for a prismatic joint, [N/m], [N s/m] and [kg]."""
        a = self.length
        return JointFlesh(self.stiffness / a**2, self.damping / a**2, self.inertia / a**2, a)


def flesh_of(bones: Sequence[Bone]) -> list[JointFlesh]:
    """Returns the passive properties of each bone's joints; meaningless for the first bone."""
    beyond: list[list[MassProperties]] = [[bone.mass] for bone in bones]
    for i in reversed(range(1, len(bones))):
        beyond[bones[i].parent] += beyond[i]
    found = list[JointFlesh]()
    for bone, masses in zip(bones, beyond, strict=True):
        flesh = _flesh(joined(masses), bone.place)
        if bone.parent > 0:
            before = SINEW_RATIO * found[bone.parent].damping
            flesh = replace(flesh, damping=max(flesh.damping, before))
        found.append(flesh)
    return found


def _flesh(hangs: MassProperties, place: Array) -> JointFlesh:
    length = math.sqrt(0.5 * float(np.trace(hangs.about(place))) / hangs.mass)
    weight = hangs.mass * GRAVITY * length
    critical = 2.0 * hangs.mass * length**2 * math.sqrt(GRAVITY / length)
    return JointFlesh(
        STIFFNESS_RATIO * weight,
        DAMPING_RATIO * critical,
        ARMATURE_RATIO * hangs.mass * length**2,
        length,
    )


def size_of(bones: Sequence[Bone]) -> float:
    """Returns the greatest extent of a ragdoll as it was created [m]."""
    return float(np.ptp(np.concatenate([bone.corners for bone in bones]), axis=0).max())


FRICTION = 0.7
"""Friction of a body on the ground."""


CONTACT_TIME = 1.0 / 90.0
"""Time constant of contacts [τ]."""


CONTACT_DAMPING = 3.0
"""Damping ratio of contacts."""


FRICTION_ROUNDS = 4
"""Iterations that enforce friction: without them resting bodies creep."""


MIN_MASS = 1e-5
"""Least mass of a bone, relative to the mass of all."""


MIN_INERTIA = 1e-8
"""Least moment of inertia of a bone, relative to the mass of all times size²."""


LIMIT_DAMPING = 4.0
"""Damping ratio of joint limits, so that they return nothing."""


GROUND_BIT = 1
"""Collision bit of the ground."""


def build_model(
    bones: Sequence[Bone],
    begin: RagdollState,
    field: HeightField,
    mass: float,
    size: float,
    tau: float,
) -> tuple[Any, Any, Any]:
    """Returns model, data and module: the ground's geom first, then one of each bone."""
    import mujoco

    log_warnings(mujoco)
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    option = spec.option
    option.gravity = [0.0, -GRAVITY, 0.0]
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    option.tolerance = 1e-7
    option.noslip_iterations = FRICTION_ROUNDS
    option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    if not is_level(field):
        use_upward_collision(option, mujoco)
    hard = [CONTACT_TIME * tau, CONTACT_DAMPING]
    matter = {"friction": [FRICTION, 0.0, 0.0], "condim": 3, "solref": hard}
    matter["solimp"] = [0.95, 0.99, 0.001 * size, 0.5, 2.0]
    # Bones are round: fifty contacts support one, and tiles would cost hundreds of geoms.
    ground = {"contype": GROUND_BIT, "conaffinity": 0, **matter}
    add_ground(spec, mujoco, field, ground, is_level(field))
    # Options of bones have priority over those of the ground.
    matter |= {"contype": 0, "conaffinity": GROUND_BIT, "priority": 1}
    made, first = list[Any](), 0
    for i, (bone, flesh) in enumerate(zip(bones, flesh_of(bones), strict=True)):
        body = _add_bone(spec, mujoco, f"bone {i}", bone, bones, made, mass, size)
        spec.add_mesh(name=f"bone {i}", uservert=(bone.corners - bone.place).ravel().tolist())
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"bone {i}", **matter)
        values = begin.joints[first : first + len(bone.joints)]
        _add_joints(body, mujoco, bone, flesh, mass, values.tolist(), first, hard)
        first += len(bone.joints)
        made.append(body)
    spec.memory = memory_for(len(bones))
    model = spec.compile()
    return model, mujoco.MjData(model), mujoco


def _add_bone(
    spec: Any,
    mujoco: Any,
    name: str,
    bone: Bone,
    bones: Sequence[Bone],
    made: Sequence[Any],
    mass: float,
    size: float,
) -> Any:
    """Adds a bone, whose frame stands at its joints; that of the first where it was created."""
    if not made:
        body = spec.worldbody.add_body(name=name)
        body.add_freejoint()
    else:
        body = made[bone.parent].add_body(name=name, pos=bone.place - bones[bone.parent].place)
    own: MassProperties = bone.mass
    body.explicitinertial = True
    body.mass = max(own.mass / mass, MIN_MASS)
    body.ipos = own.centre - bone.place
    i = own.inertia / mass + MIN_INERTIA * size * size * np.eye(3)
    body.fullinertia = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
    return body


def _add_joints(
    body: Any,
    mujoco: Any,
    bone: Bone,
    flesh: JointFlesh,
    mass: float,
    values: Sequence[float],
    first: int,
    hard: list[float],
) -> None:
    kinds = mujoco.mjtJoint
    for k, (joint, value) in enumerate(zip(bone.joints, values, strict=True), start=first):
        held = flesh.of_sliding() if joint.slides else flesh
        body.add_joint(
            name=f"joint {k}",
            type=kinds.mjJNT_SLIDE if joint.slides else kinds.mjJNT_HINGE,
            axis=joint.axis,
            limited=1,
            range=[min(joint.lower, value), max(joint.upper, value)],
            stiffness=held.stiffness / mass,
            springref=joint.rest,
            damping=held.damping / mass,
            armature=held.inertia / mass,
            solref_limit=[hard[0], LIMIT_DAMPING],
            solimp_limit=[0.995, 0.9999, 0.001, 0.5, 2.0],
        )


@dataclass(frozen=True, slots=True, eq=False)
class RagdollState:
    """State of a ragdoll.

    Attributes:
        p: (3,) origin of the first bone's creation frame [m].
        q: (4,) its attitude wxyz.
        v: (3,) velocity of that origin [m/s].
        w: (3,) angular velocity, in the bone's own frame [rad/s].
        joints: (J,) values, bone by bone [rad or m].
        speeds: (J,) joint speeds [rad/s or m/s].
    """

    p: Array
    q: Array
    v: Array
    w: Array
    joints: Array
    speeds: Array
