"""Linkage simulation: hinges, limits, servos, pulled sites and contacts, solved by MuJoCo.

Every hinge has a position servo, T = k (θ_d - θ) + k_d (θ'_d - θ'), and every pulled site a force
F = c (v_desired - v) along each axis of the world. Both are actuators whose damping is integrated
implicitly, which keeps stiff gains stable at a film's steps. `mujoco` is imported when the first
linkage is built.

Source: Todorov 2014 (MuJoCo); Matarić, Zordan and Mason 1998, sections 5 and 6.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.linkage import Capsule, Link, Linkage
from pipeline.simulation.dynamics.mujoco_model import log_warnings
from pipeline.simulation.spatial import Array

CONTACT_TIME = 0.009
"""Time constant of contacts and limits [s]; critically damped, so that nothing rebounds."""

ARMATURE = 0.004
"""Extra inertia of every hinge [kg m²]: wrists would tremble at a film's steps."""

FRICTION = 0.5
"""Friction of skin on skin."""

NO_PAIRS = frozenset[tuple[int, int]]()

CONTACT_CHECK_STEPS = 3
"""Steps between two checks for new contacts."""

LIMB_BIT, TRUNK_BIT = 1, 2
"""Collision bits."""

COLLISION_BITS = {
    "limb": (LIMB_BIT, LIMB_BIT | TRUNK_BIT),
    "trunk": (TRUNK_BIT, LIMB_BIT),
    "nothing": (0, 0),
}
"""Collision type and affinity of each collision group."""


@dataclass(frozen=True, slots=True, eq=False)
class SolidContact:
    """Two solids in contact.

    Attributes:
        one, other: their names, in the order of the linkage.
        depth: overlap [m]; negative for a gap.
        place: (3,) [m].
        normal: (3,) from the one to the other.
        speed: approach speed [m/s].
    """

    one: str
    other: str
    depth: float
    place: Array
    normal: Array
    speed: float


class LinkageSimulation:
    """A simulated linkage.

    Args:
        linkage: the linkage.
        step: of the integration [s].

    Attributes:
        q: (n,) hinge angles, a view [rad].
        v: (n,) hinge speeds, a view [rad/s].
        places: (S, 3) of the sites, a view [m].
        targets: (n,) target angles of the servos, a writable view [rad].
        velocities: (P, 3) desired velocities of the pulled sites, a writable view [m/s].
        push: (n,) additional torques, a writable view [N m].
        pulled: number of the site that each force pulls.
    """

    def __init__(self, linkage: Linkage, step: float) -> None:
        self.linkage = linkage
        self.model, self.data, self._mujoco = _build(linkage, step)
        n, pulled = len(linkage.hinges), len(linkage.pulled)
        data, model = self.data, self.model
        self.q, self.v, self.places = data.qpos, data.qvel, data.site_xpos[1:]
        self.targets = data.ctrl[:n]
        self.velocities = data.ctrl[n:].reshape(pulled, 3)
        self.push = data.qfrc_applied
        self._bodies = [model.body(link.name).id for link in linkage.links]
        sites = [site.name for site in linkage.sites]
        self.pulled = [sites.index(name) for name in linkage.pulled]
        self.solids = [model.geom(i).name for i in range(model.ngeom)]
        self._gain, self._bias = model.actuator_gainprm.copy(), model.actuator_biasprm.copy()
        self._jacobian = np.zeros((3, n))
        self._touching = NO_PAIRS
        self._pairs = b""
        self.settle()

    def settle(self) -> None:
        """Computes all poses after `q` was written."""
        self._mujoco.mj_forward(self.model, self.data)

    def advance(self, count: int) -> int:
        """Advances with constant targets, velocities and torques.

        Args:
            count: largest number of steps; it stops at a new contact.

        Returns:
            Number of steps done.
        """
        model, data, step = self.model, self.data, self._mujoco.mj_step
        done = 0
        while done < count:
            stride = min(CONTACT_CHECK_STEPS, count - done)
            step(model, data, stride)
            done += stride
            # A pair may part as another meets: then the number of contacts stays.
            before, self._touching = self._touching, self._colliding_pairs()
            if not self._touching <= before:
                break
        return done

    def _colliding_pairs(self) -> frozenset[tuple[int, int]]:
        """Returns the pairs of solids that collide."""
        data = self.data
        if not data.ncon:
            return NO_PAIRS
        return frozenset(map(tuple, data.contact.geom.tolist()))

    def share(self, first: int, last: int, pulled: int, servo: float, calm: float) -> None:
        """Sets the weights of servos and pulling force on a chain of hinges.

        Args:
            first: number of the first hinge.
            last: number of the hinge after the last.
            pulled: number of the pulled site that they carry.
            servo: weight of the servos, 0 to 1; the force has the rest.
            calm: least damping of the hinges [N m s/rad].
        """
        model, n = self.model, len(self.linkage.hinges)
        own = slice(n + 3 * pulled, n + 3 * pulled + 3)
        for rows, weight in ((slice(first, last), servo), (own, 1.0 - servo)):
            model.actuator_gainprm[rows] = weight * self._gain[rows]
            model.actuator_biasprm[rows] = weight * self._bias[rows]
        hinges = model.actuator_biasprm[first:last, 2]
        hinges[:] = np.minimum(hinges, -calm)

    def jacobian(self, pulled: int) -> Array:
        """Returns the velocity of a pulled site by each hinge (3, n), a reused array."""
        site = self.pulled[pulled] + 1
        self._mujoco.mj_jacSite(self.model, self.data, self._jacobian, None, site)
        return self._jacobian

    def place_of(self, link: int) -> Array:
        """Returns the position of a link's hinges, a view (3,) [m]."""
        return self.data.xpos[self._bodies[link]]

    def turned(self, link: int) -> Array:
        """Returns the rotation of a link, row by row, a view (9,)."""
        return self.data.xmat[self._bodies[link]]

    def poses(self) -> tuple[Array, Array]:
        """Returns rotations (L, 3, 3) and positions (L, 3) of the links, as copies."""
        return self.data.xmat[self._bodies].reshape(-1, 3, 3), self.data.xpos[self._bodies]

    def given(self) -> Array:
        """Returns (n,) torques of servos and forces on the hinges [N m]."""
        return self.data.qfrc_actuator.copy()

    def torques(self) -> Array:
        """Returns (n,) total torques on the hinges: servos, forces, compensation [N m]."""
        data = self.data
        return data.qfrc_actuator + data.qfrc_applied + data.qfrc_gravcomp

    def touches(self) -> list[SolidContact]:
        """Returns the contacts at the start of the last step."""
        data, found = self.data, list[SolidContact]()
        for i in range(data.ncon):
            one = data.contact[i]
            row = int(one.efc_address)
            if row < 0:
                continue
            names = self.solids[int(one.geom[0])], self.solids[int(one.geom[1])]
            speed = -float(data.efc_vel[row])
            place, normal = np.array(one.pos), np.array(one.frame[:3])
            found.append(SolidContact(*names, -float(one.dist), place, normal, speed))
        return found

    @property
    def has_changed(self) -> bool:
        """Whether the colliding pairs differ from those at the last query."""
        pairs = self.data.contact.geom.tobytes() if self.data.ncon else b""
        changed = pairs != self._pairs
        self._pairs = pairs
        return changed


# --- the model --------------------------------------------------------------------------


def _build(linkage: Linkage, step: float) -> tuple[Any, Any, Any]:
    import mujoco

    log_warnings(mujoco)
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    option = spec.option
    option.timestep = step
    option.gravity = [0.0, -GRAVITY, 0.0]
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    spec.worldbody.add_site(name="world")
    made = list[Any]()
    for link in linkage.links:
        made.append(_add_link(spec, mujoco, link, linkage.links, made))
    for site in linkage.sites:
        body, origin = spec.worldbody, np.zeros(3)
        if site.link >= 0:
            body, origin = made[site.link], linkage.links[site.link].place
        body.add_site(name=site.name, pos=site.place - origin)
    for disc in linkage.discs:
        # Cylinders stand on their local Z.
        spec.worldbody.add_geom(
            name=disc.name,
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            pos=disc.middle,
            quat=[math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0],
            size=[disc.radius, 0.5 * disc.height, 0.0],
            contype=TRUNK_BIT,
            conaffinity=LIMB_BIT,
            **_matter(),
        )
    for one, other in linkage.apart:
        spec.add_exclude(bodyname1=one, bodyname2=other)
    _add_servos(spec, mujoco, linkage)
    model = spec.compile()
    _check_order(model, linkage)
    return model, mujoco.MjData(model), mujoco


def _add_link(
    spec: Any, mujoco: Any, link: Link, links: Sequence[Link], made: Sequence[Any]
) -> Any:
    above, origin = spec.worldbody, np.zeros(3)
    if link.parent >= 0:
        above, origin = made[link.parent], links[link.parent].place
    body = above.add_body(name=link.name, pos=link.place - origin)
    body.gravcomp = 1.0 if link.weightless else 0.0
    for hinge in link.hinges:
        body.add_joint(
            name=hinge.name,
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=hinge.axis,
            limited=1,
            range=[hinge.lower, hinge.upper],
            armature=ARMATURE,
            solref_limit=[CONTACT_TIME, 1.0],
            solimp_limit=[0.95, 0.99, 0.001, 0.5, 2.0],
        )
    volume = sum(_volume(solid) for solid in link.solids)
    for solid in link.solids:
        own, met = COLLISION_BITS[solid.meets]
        mass = link.mass * _volume(solid) / volume
        body.add_geom(
            name=solid.name,
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=(solid.ends - link.place).ravel(),
            size=[solid.radius, 0.0, 0.0],
            mass=mass,
            contype=own,
            conaffinity=met,
            **_matter(),
        )
    return body


def _matter() -> dict[str, Any]:
    return {
        "friction": [FRICTION, 0.0, 0.0],
        "condim": 3,
        "solref": [CONTACT_TIME, 1.0],
        "solimp": [0.95, 0.99, 0.001, 0.5, 2.0],
    }


def _volume(solid: Capsule) -> float:
    length = float(np.linalg.norm(solid.ends[1] - solid.ends[0]))
    return math.pi * solid.radius**2 * (length + 4.0 / 3.0 * solid.radius)


def _add_servos(spec: Any, mujoco: Any, linkage: Linkage) -> None:
    """Adds the actuators: hinge by hinge, then x, y and z of each pulled site."""
    fixed, affine = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    for hinge in linkage.hinges:
        spec.add_actuator(
            name=hinge.name,
            target=hinge.name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            gaintype=fixed,
            gainprm=_padded([hinge.stiffness]),
            biastype=affine,
            biasprm=_padded([0.0, -hinge.stiffness, -hinge.damping]),
            forcelimited=1,
            forcerange=[-hinge.strength, hinge.strength],
        )
    for name in linkage.pulled:
        for axis in range(3):
            spec.add_actuator(
                name=f"{name} {'xyz'[axis]}",
                target=name,
                refsite="world",
                trntype=mujoco.mjtTrn.mjTRN_SITE,
                gear=np.eye(6)[axis],
                gaintype=fixed,
                gainprm=_padded([linkage.drag]),
                biastype=affine,
                biasprm=_padded([0.0, 0.0, -linkage.drag]),
                forcelimited=1,
                forcerange=[-linkage.most_force, linkage.most_force],
            )


def _padded(values: Sequence[float]) -> list[float]:
    return [*values, *[0.0] * (10 - len(values))]


def _check_order(model: Any, linkage: Linkage) -> None:
    """Checks that MuJoCo numbers hinges and sites as the linkage does: depth first."""
    names = [model.joint(i).name for i in range(model.njnt)]
    if names != [hinge.name for hinge in linkage.hinges]:
        raise AssertionError("links have to stand depth first")
    names = [model.site(i).name for i in range(1, model.nsite)]
    if names != [site.name for site in linkage.sites]:
        raise AssertionError("sites have to stand in the order of their links")
