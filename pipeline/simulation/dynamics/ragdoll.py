"""Ragdoll: rigid bodies that hang together by joints, and fall on a terrain.

One creature, one MuJoCo model; `mujoco` is imported when the first ragdoll is built. MuJoCo
solves joints, limits and contacts together. Contacts give way a little and throw nothing back;
what begins inside the ground is pushed out slowly.

Mass counts in proportion alone, so all of it is one, and times go by how long the ragdoll
takes to fall over, τ = √(size / g): a mouse and an elephant cost the same.

Source: Todorov 2014 (MuJoCo); Sims 1987, 9.4.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.simulation.dynamics.bones import Bone, Flesh, flesh_of, size_of
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.dynamics.mujoco_model import (
    add_ground,
    is_level,
    log_warnings,
    memory_for,
    use_upward_collision,
)
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField

FRICTION = 0.7
"""Of flesh on the ground."""

SUBSTEP, HARD, SPENT = 1.0 / 200.0, 1.0 / 90.0, 3.0
"""Longest sub-step, and time constant of contacts, in τ, and their damping in the critical one."""

GRIPS = 4
"""Rounds in which friction is made to hold: without them what lies creeps."""

LIGHTEST, THINNEST = 1e-5, 1e-8
"""Least mass and moment of inertia of a bone, in the mass of all, and in that times size²."""

OUT = 0.03
"""Speed at which what begins in the ground is pushed out, in size / τ."""

HEARD, AGAIN = 0.06, 0.35
"""Speed from which a bone is heard on the ground, in size / τ, and how long it has to be clear of
it to be heard again, in τ."""

SLOW, TWITCH = 0.02, 0.5
"""Speed of the first bone below which a ragdoll is on its way to rest, in size / τ, and of its
joints, in 1 / τ: limbs may tremble, but what still topples is let topple."""

DROWSES, SLEEPS = 0.5, 6.0
"""How long it takes, in τ, until what still moves is braked e times as hard, and after how many
such times it rests."""

STOPS = 4.0
"""Damping of the limits of joints, in the critical one: so they give nothing back."""

GONE = 20.0
"""Depth below the terrain at which nothing matters any more, in sizes."""

GROUND = 1
"""Bit of what bones meet."""


@dataclass(frozen=True, slots=True, eq=False)
class Attitude:
    """How a ragdoll is.

    Attributes:
        p: (3,) origin of the first bone's creation frame [m].
        q: (4,) its attitude wxyz.
        v: (3,) velocity of that origin [m/s].
        w: (3,) angular velocity, in the bone's own frame [rad/s].
        joints: (J,) values, bone by bone [rad or m].
        speeds: (J,) of them [rad/s or m/s].
    """

    p: Array
    q: Array
    v: Array
    w: Array
    joints: Array
    speeds: Array


@dataclass(frozen=True, slots=True, eq=False)
class Knock:
    """A bone has struck the ground.

    Attributes:
        bone: its number.
        time: after the begin of the advance [s].
        place, normal: (3,) where [m], and of the ground.
        speed: of approach [m/s].
        energy: of what came at this speed [J].
    """

    bone: int
    time: float
    place: Array
    normal: Array
    speed: float
    energy: float


class Ragdoll:
    """Bones over a terrain.

    Args:
        bones: the first one moves freely.
        begin: how it is.
        field: the terrain.

    Attributes:
        size: greatest extent of it [m].
        tau: time that it takes to fall over, about [s].
        mass: [kg].
        is_at_rest: whether it moves no more.
        is_gone: whether that is because it fell off the terrain.
    """

    def __init__(self, bones: Sequence[Bone], begin: Attitude, field: HeightField) -> None:
        self.size = size_of(bones)
        self.tau = math.sqrt(self.size / GRAVITY)
        self.mass = sum(bone.mass.mass for bone in bones)
        self.is_at_rest = self.is_gone = False
        self.model, self.data, self._mujoco = _build(
            bones, begin, field, self.mass, self.size, self.tau
        )
        # MuJoCo numbers bodies and joints depth first.
        joints = [self.model.joint(f"joint {k}") for k in range(len(begin.joints))]
        self._places = np.array([int(j.qposadr[0]) for j in joints], dtype=np.int64)
        self._dofs = np.array([int(j.dofadr[0]) for j in joints], dtype=np.int64)
        named = [self.model.body(f"bone {i}") for i in range(len(bones))]
        self._geoms = np.array([int(body.geomadr[0]) for body in named], dtype=np.int64)
        self._bone_of = {int(geom): i for i, geom in enumerate(self._geoms)}
        inverse = self.model.body_invweight0[[int(body.id) for body in named], 0]
        self._carried = self.mass / inverse
        self._put(begin)
        self._floor = float(field.heights.min()) - GONE * self.size
        self._touched = np.full(len(bones), -math.inf)
        self._drowsy = 0.0
        self._soft = self._slowly()

    @property
    def attitude(self) -> Attitude:
        """How it is just now, as copies."""
        x, v = self.data.qpos.copy(), self.data.qvel.copy()
        return Attitude(x[:3], x[3:7], v[:3], v[3:6], x[self._places], v[self._dofs])

    def _put(self, it: Attitude) -> None:
        x, v = self.data.qpos, self.data.qvel
        x[:3], x[3:7], x[self._places] = it.p, it.q, it.joints
        v[:3], v[3:6], v[self._dofs] = it.v, it.w, it.speeds

    @property
    def energy(self) -> float:
        """Of motion, height, and joints away from their rest [J]."""
        self._mujoco.mj_fwdPosition(self.model, self.data)
        self._mujoco.mj_energyPos(self.model, self.data)
        self._mujoco.mj_energyVel(self.model, self.data)
        return self.mass * float(self.data.energy.sum())

    def advance(self, h: float) -> list[Knock]:
        """Go on by `h` [s]; return what has struck the ground, in the order of time."""
        found = list[Knock]()
        if self.is_at_rest:
            return found
        count = max(1, math.ceil(h / (SUBSTEP * self.tau) - 1e-9))
        one = self.model.opt.timestep = h / count
        began = self.data.time
        for k in range(count):
            self._harden()
            self._mujoco.mj_step(self.model, self.data)
            # Contacts are those of the begin of the sub-step.
            found += self._knocks(began + k * one, k * one)
            self._brake(one)
        self.is_gone = float(self.data.qpos[1]) < self._floor
        if self._drowsy > SLEEPS or self.is_gone:
            self.is_at_rest = True
            self.data.qvel[:] = 0.0
        return found

    # --- within a step ---------------------------------------------------------------

    def _slowly(self) -> Array:
        """Return the time constants of contacts of bones (n,), long if they begin deep [s]."""
        self._mujoco.mj_forward(self.model, self.data)
        deep = self._depths()
        self._touched[deep > -math.inf] = 0.0
        return self._times(deep)

    def _harden(self) -> None:
        """Make contacts of what began in the ground as hard as all others, as it comes out."""
        if float(self._soft.max()) > HARD * self.tau:
            self._soft = np.minimum(self._soft, self._times(self._depths()))
            self.model.geom_solref[self._geoms, 0] = self._soft

    def _times(self, deep: Array) -> Array:
        # An overdamped spring comes out by depth / (2 SPENT² time) a second.
        slow = deep / (2.0 * SPENT**2 * OUT * self.size / self.tau)
        result: Array = np.maximum(slow, HARD * self.tau)
        return result

    def _depths(self) -> Array:
        """Return how deep bones (n,) are in the ground, less than any where they are not [m]."""
        deep = np.full(len(self._touched), -math.inf)
        np.maximum.at(deep, self._bones(), -self.data.contact.dist)
        return deep

    def _bones(self) -> list[int]:
        """Return the bones that contacts are of: the ground is the first geom."""
        geoms = self.data.contact.geom.reshape(-1, 2).max(axis=1)
        return [self._bone_of[geom] for geom in geoms.tolist()]

    def _knocks(self, now: float, after: float) -> list[Knock]:
        data, found = self.data, list[Knock]()
        if not data.ncon:
            return found
        contact, speeds = data.contact, dict[int, tuple[float, int]]()
        for i, (bone, row) in enumerate(zip(self._bones(), contact.efc_address, strict=True)):
            if row >= 0:
                speed = -float(data.efc_vel[row])
                speeds[bone] = max(speeds.get(bone, (-math.inf, i)), (speed, i))
        least = HEARD * self.size / self.tau
        for bone, (speed, i) in sorted(speeds.items()):
            clear = now - self._touched[bone] > AGAIN * self.tau
            self._touched[bone] = now
            if clear and speed > least:
                normal = contact.frame.reshape(-1, 9)[i, :3].copy()
                if normal[1] < 0.0:
                    normal = -normal
                place = contact.pos.reshape(-1, 3)[i].copy()
                energy = 0.5 * float(self._carried[bone]) * speed * speed
                found.append(Knock(bone, after, place, normal, speed, energy))
        return found

    def _brake(self, h: float) -> None:
        """Brake what lies and hardly moves ever harder, until it is still.

        Joints and contacts that give way a little creep on for long. Taking speed away takes
        energy away, and nothing else.
        """
        v, tau = self.data.qvel, self.tau
        first = max(float(np.abs(v[:3]).max()), self.size * float(np.abs(v[3:6]).max()))
        joints = float(np.abs(v[6:]).max(initial=0.0))
        slow = first < SLOW * self.size / tau and joints < TWITCH / tau and self.data.ncon > 0
        # What is woken again and again by one that trembles falls asleep all the same.
        self._drowsy = max(self._drowsy + (1.0 if slow else -2.0) * h / (DROWSES * tau), 0.0)
        v *= math.exp(-h / tau * math.expm1(max(self._drowsy - 0.5, 0.0)))


# --- the model --------------------------------------------------------------------------


def _build(
    bones: Sequence[Bone],
    begin: Attitude,
    field: HeightField,
    mass: float,
    size: float,
    tau: float,
) -> tuple[Any, Any, Any]:
    """Return model, data and module: the ground's geom first, then one of each bone."""
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
    option.noslip_iterations = GRIPS
    option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    if not is_level(field):
        use_upward_collision(option, mujoco)
    hard = [HARD * tau, SPENT]
    matter = {"friction": [FRICTION, 0.0, 0.0], "condim": 3, "solref": hard}
    matter["solimp"] = [0.95, 0.99, 0.001 * size, 0.5, 2.0]
    # Bones are round: fifty places carry one well, and all its cells would cost hundreds.
    add_ground(spec, mujoco, field, [], {"contype": GROUND, "conaffinity": 0, **matter})
    # What is said of bones holds of both: the ground gives way as little as they do.
    matter |= {"contype": 0, "conaffinity": GROUND, "priority": 1}
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
    """Add a bone, whose own frame stands at its joints; that of the first where it was created."""
    if not made:
        body = spec.worldbody.add_body(name=name)
        body.add_freejoint()
    else:
        body = made[bone.parent].add_body(name=name, pos=bone.place - bones[bone.parent].place)
    own: MassProperties = bone.mass
    body.explicitinertial = True
    body.mass = max(own.mass / mass, LIGHTEST)
    body.ipos = own.centre - bone.place
    i = own.inertia / mass + THINNEST * size * size * np.eye(3)
    body.fullinertia = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
    return body


def _add_joints(
    body: Any,
    mujoco: Any,
    bone: Bone,
    flesh: Flesh,
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
            solref_limit=[hard[0], STOPS],
            solimp_limit=[0.995, 0.9999, 0.001, 0.5, 2.0],
        )
