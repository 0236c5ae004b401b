"""Ragdoll: rigid bodies connected by joints that fall on a terrain.

One creature is one MuJoCo model; `mujoco` is imported when the first ragdoll is built. MuJoCo
solves joints, limits and contacts together. Contacts give way a little and return nothing; bones
that begin inside the ground are pushed out slowly.

Only ratios of masses count, so their sum is one, and times scale with the time that the ragdoll
takes to fall over, τ = √(size / g): a mouse and an elephant cost the same.

Source: Todorov 2014 (MuJoCo); Sims 1987, 9.4.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.ragdoll_model import (
    CONTACT_DAMPING,
    CONTACT_TIME,
    Bone,
    RagdollState,
    build_model,
    size_of,
)
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField

MAX_SUBSTEP = 1.0 / 200.0
"""Longest sub-step [τ]."""


DEPENETRATION_SPEED = 0.03
"""Speed at which a bone that begins in the ground is pushed out [size / τ]."""

HEARD_SPEED = 0.06
"""Least speed of an audible impact of a bone [size / τ]."""

HEARD_PAUSE = 0.35
"""Time that a bone has to be clear of the ground before it is heard again [τ]."""

REST_SPEED = 0.02
"""Speed of the first bone below which a ragdoll comes to rest [size / τ]."""

REST_JOINT_SPEED = 0.5
"""The same for its joints [1 / τ]: limbs may tremble, but a body that topples goes on."""

BRAKING_TIME = 0.5
"""Time in which the braking of a slow ragdoll grows by a factor e [τ]."""

BRAKING_TIMES = 6.0
"""Number of such times after which it rests."""


LOST_DEPTH = 20.0
"""Depth below the terrain at which a ragdoll is lost, in sizes."""


@dataclass(frozen=True, slots=True, eq=False)
class BoneImpact:
    """Impact of a bone on the ground.

    Attributes:
        bone: number of the bone.
        time: after the start of the advance [s].
        place, normal: (3,) position [m], and normal of the ground.
        speed: approach speed [m/s].
        energy: kinetic energy of the approach [J].
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
        begin: initial state.
        field: the terrain.

    Attributes:
        size: greatest extent [m].
        tau: time to fall over, about [s].
        mass: [kg].
        is_at_rest: whether it no longer moves.
        is_gone: whether it fell off the terrain.
    """

    def __init__(self, bones: Sequence[Bone], begin: RagdollState, field: HeightField) -> None:
        self.size = size_of(bones)
        self.tau = math.sqrt(self.size / GRAVITY)
        self.mass = sum(bone.mass.mass for bone in bones)
        self.is_at_rest = self.is_gone = False
        self.model, self.data, self._mujoco = build_model(
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
        self._floor = float(field.heights.min()) - LOST_DEPTH * self.size
        self._touched = np.full(len(bones), -math.inf)
        self._slow_time = 0.0
        self._mujoco.mj_forward(self.model, self.data)
        deep = self._depths()
        self._touched[deep > -math.inf] = 0.0
        self._soft = self._times_for_depth(deep)

    @property
    def attitude(self) -> RagdollState:
        """Present state, as copies."""
        x, v = self.data.qpos.copy(), self.data.qvel.copy()
        return RagdollState(x[:3], x[3:7], v[:3], v[3:6], x[self._places], v[self._dofs])

    def _put(self, it: RagdollState) -> None:
        x, v = self.data.qpos, self.data.qvel
        x[:3], x[3:7], x[self._places] = it.p, it.q, it.joints
        v[:3], v[3:6], v[self._dofs] = it.v, it.w, it.speeds

    @property
    def energy(self) -> float:
        """Kinetic, potential and elastic energy [J]."""
        self._mujoco.mj_fwdPosition(self.model, self.data)
        self._mujoco.mj_energyPos(self.model, self.data)
        self._mujoco.mj_energyVel(self.model, self.data)
        return self.mass * float(self.data.energy.sum())

    def advance(self, h: float) -> list[BoneImpact]:
        """Advances by `h` [s]; returns impacts on the ground in the order of time."""
        found = list[BoneImpact]()
        if self.is_at_rest:
            return found
        count = max(1, math.ceil(h / (MAX_SUBSTEP * self.tau) - 1e-9))
        one = self.model.opt.timestep = h / count
        began = self.data.time
        for k in range(count):
            if float(self._soft.max()) > CONTACT_TIME * self.tau:
                self._soft = np.minimum(self._soft, self._times_for_depth(self._depths()))
                self.model.geom_solref[self._geoms, 0] = self._soft
            self._mujoco.mj_step(self.model, self.data)
            # Contacts are those at the start of the sub-step.
            found += self._impacts(began + k * one, k * one)
            self._brake(one)
        self.is_gone = float(self.data.qpos[1]) < self._floor
        if self._slow_time > BRAKING_TIMES or self.is_gone:
            self.is_at_rest = True
            self.data.qvel[:] = 0.0
        return found

    # --- within a step ---------------------------------------------------------------

    def _times_for_depth(self, deep: Array) -> Array:
        # An overdamped spring comes out by depth / (2 SPENT² time) a second.
        slow = deep / (2.0 * CONTACT_DAMPING**2 * DEPENETRATION_SPEED * self.size / self.tau)
        return np.maximum(slow, CONTACT_TIME * self.tau)

    def _depths(self) -> Array:
        """Returns the depth of bones (n,) in the ground, -inf without contact [m]."""
        deep = np.full(len(self._touched), -math.inf)
        np.maximum.at(deep, self._bones(), -self.data.contact.dist)
        return deep

    def _bones(self) -> list[int]:
        """Returns the bones of all contacts: the ground is the first geom."""
        geoms = self.data.contact.geom.reshape(-1, 2).max(axis=1)
        return [self._bone_of[geom] for geom in geoms.tolist()]

    def _impacts(self, now: float, after: float) -> list[BoneImpact]:
        data, found = self.data, list[BoneImpact]()
        if not data.ncon:
            return found
        contact, speeds = data.contact, dict[int, tuple[float, int]]()
        for i, (bone, row) in enumerate(zip(self._bones(), contact.efc_address, strict=True)):
            if row >= 0:
                speed = -float(data.efc_vel[row])
                speeds[bone] = max(speeds.get(bone, (-math.inf, i)), (speed, i))
        least = HEARD_SPEED * self.size / self.tau
        for bone, (speed, i) in sorted(speeds.items()):
            clear = now - self._touched[bone] > HEARD_PAUSE * self.tau
            self._touched[bone] = now
            if clear and speed > least:
                normal = contact.frame.reshape(-1, 9)[i, :3].copy()
                if normal[1] < 0.0:
                    normal = -normal
                place = contact.pos.reshape(-1, 3)[i].copy()
                energy = 0.5 * float(self._carried[bone]) * speed * speed
                found.append(BoneImpact(bone, after, place, normal, speed, energy))
        return found

    def _brake(self, h: float) -> None:
        """Brakes a ragdoll that lies and hardly moves, ever harder until it is still.

        Compliant joints and contacts creep on for long. Scaling the speed takes energy away, and
        nothing else.
        """
        v, tau = self.data.qvel, self.tau
        first = max(float(np.abs(v[:3]).max()), self.size * float(np.abs(v[3:6]).max()))
        joints = float(np.abs(v[6:]).max(initial=0.0))
        slow = (
            first < REST_SPEED * self.size / tau
            and joints < REST_JOINT_SPEED / tau
            and self.data.ncon > 0
        )
        # A ragdoll kept awake by a trembling limb comes to rest all the same.
        self._slow_time = max(
            self._slow_time + (1.0 if slow else -2.0) * h / (BRAKING_TIME * tau), 0.0
        )
        v *= math.exp(-h / tau * math.expm1(max(self._slow_time - 0.5, 0.0)))


# --- the model --------------------------------------------------------------------------
