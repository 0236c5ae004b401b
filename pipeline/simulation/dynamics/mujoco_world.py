"""MuJoCo world: rigid bodies that meet one another, the terrain and what pushes them.

`mujoco` is imported when the first such world is built. MuJoCo finds the contacts, solves them
all together with friction, and lets islands of bodies sleep; how hard contacts push is the
impact law's, set in every step before MuJoCo works out its forces.

World and bodies keep their axes, gravity points down Y; only the height field is turned, see
`mujoco_ground`.

Letters as in `rigid`: p, q, v in the world, w in the body; what MuJoCo calls a free joint
has the same ones, in this order.

Source: Todorov 2014 (MuJoCo's contacts).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.body_record import zero_records
from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.dynamics.contact_sliding import (
    Contacts,
    SlidingMotion,
    sliding_motion,
)
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.impact_law import THING
from pipeline.simulation.dynamics.kinematic_bodies import KinematicBodies, Poses
from pipeline.simulation.dynamics.mujoco_callback import ImpactCallback
from pipeline.simulation.dynamics.mujoco_model import (
    add_ground,
    is_level,
    log_warnings,
    memory_for,
    use_upward_collision,
)
from pipeline.simulation.dynamics.rigid_body import Bodies, BodyModel, State
from pipeline.simulation.dynamics.substeps import Substeps
from pipeline.simulation.spatial import Array, matrix, turn
from pipeline.simulation.terrain.heightfield import HeightField

TERRAIN = -1
"""Number of the terrain among things: bodies are counted from 0, then those who push."""

STILL = 2e-3
"""Speed below which an island of bodies may fall asleep [m/s]."""

NEARLY = 0.99
"""MuJoCo's contacts give way a little; so much of the force asked for is there."""

OUTSIDE = 1.5
"""How far from its middle a body is touched, in its reach."""

HEAVIER = 1e6
"""Mass of who pushes, in that of the heaviest body."""


@dataclass(frozen=True, slots=True)
class Collider:
    """A body as MuJoCo needs it.

    Attributes:
        build: mass, hull and matter.
        half: half its extent along its axes if it is a box [m], else None.
    """

    build: BodyModel
    half: Array | None


@dataclass(frozen=True, slots=True)
class Strike:
    """The begin of an impact.

    Attributes:
        one: number of a body.
        other: of another body, of one who pushes, or the terrain.
        time: after the begin of the advance [s].
        place: where [m].
        normal: from the other to the one.
        speed: of approach [m/s].
        energy: of what came at this speed [J].
    """

    one: int
    other: int
    time: float
    place: tuple[float, float, float]
    normal: tuple[float, float, float]
    speed: float
    energy: float


@dataclass(frozen=True, slots=True)
class Overlap:
    """Two things that are in one another by `depth` [m]; see `Strike`."""

    one: int
    other: int
    depth: float


class MujocoWorld:
    """Bodies, terrain and pushers in one MuJoCo model.

    Args:
        colliders: N bodies.
        state: how they begin.
        field: the terrain.
        pushers: corners (V, 3) of P convex solids that push, each in its own frame [m].
        step: that will be advanced by [s].
    """

    def __init__(
        self,
        colliders: Sequence[Collider],
        state: State,
        field: HeightField,
        pushers: Sequence[Array],
        step: float,
    ) -> None:
        self.count = len(colliders)
        self.step = step
        builds = [c.build for c in colliders]
        self.pushers = KinematicBodies(len(pushers), step)
        self.model, self.data, self._mujoco = _build(colliders, field, pushers)
        self._qpos: Array = self.data.qpos.reshape(-1, 7)
        self._qvel: Array = self.data.qvel.reshape(-1, 6)
        self._awake = self.data.tree_awake
        moving = (self._qpos, self._qvel, self._awake)
        self.substeps = Substeps(builds, pushers, field, step, *moving)
        things, uneven = _things(builds, len(pushers)), not is_level(field)
        self.law = ImpactCallback(things, self.count, uneven, self.model, self.data, self._mujoco)
        self._any_gone = False
        self._cut = 0
        self._is_pushed = False
        self._put(state)

    # --- state --------------------------------------------------------------------

    @property
    def state(self) -> State:
        """How the bodies are just now, as copies."""
        qpos, qvel = self._qpos[: self.count], self._qvel[: self.count]
        return State(qpos[:, :3].copy(), qpos[:, 3:].copy(), qvel[:, :3].copy(), qvel[:, 3:].copy())

    @property
    def asleep(self) -> NDArray[np.bool_]:
        """(N,) which bodies sleep."""
        result: NDArray[np.bool_] = self._awake[: self.count] == 0
        return result

    def _put(self, state: State) -> None:
        n = self.count
        self._qpos[:n, :3], self._qpos[:n, 3:] = state.p, state.q
        self._qvel[:n, :3], self._qvel[:n, 3:] = state.v, state.w

    @property
    def touching(self) -> NDArray[np.bool_]:
        """(N,) which bodies touched anything in the last sub-step."""
        found = np.zeros(self.model.nbody, dtype=bool)
        found[self._things_that_touch()] = True
        result: NDArray[np.bool_] = found[1 : 1 + self.count]
        return result

    def push(self, impulses: Array, twists: Array) -> None:
        """Push bodies in the next step: (N, 3) [N s], and about their middles (N, 3) [N m s]."""
        pushes = self.data.xfrc_applied[1 : 1 + self.count]
        pushes[:, :3], pushes[:, 3:] = impulses / self.step, twists / self.step
        self._is_pushed = bool(pushes.any())

    def lift(self, p: Array) -> None:
        """Put the bodies at other places (N, 3) [m]."""
        self._qpos[: self.count, :3] = p

    def place_pushers(self, poses: Poses) -> None:
        """Put those who push at their first places."""
        self._qpos[self.count :] = self.pushers.put(poses)

    def drop(self, which: NDArray[np.int64]) -> None:
        """Take bodies out of the world."""
        self.substeps.limits.gone[which] = self._any_gone = True
        geoms = self.model.body_geomadr[which + 1]
        self.model.geom_contype[geoms] = self.model.geom_conaffinity[geoms] = 0
        self._qvel[which] = 0.0

    # --- what the world is asked --------------------------------------------------

    def overlaps(self) -> list[Overlap]:
        """Return what is in one another."""
        self._mujoco.mj_kinematics(self.model, self.data)
        self._mujoco.mj_comPos(self.model, self.data)
        self._mujoco.mj_collision(self.model, self.data)
        deepest = dict[tuple[int, int], float]()
        things, dists = self._things_that_touch().tolist(), self.data.contact.dist.tolist()
        for (a, b), dist in zip(things, dists, strict=True):
            one, other = sorted((a - 1, b - 1), key=_bodies_first(self.count))
            deepest[one, other] = max(deepest.get((one, other), 0.0), -dist)
        return [Overlap(*pair, depth) for pair, depth in deepest.items()]

    def sliding_motion(self) -> SlidingMotion:
        """Return how bodies move along what they touch, which is numbered as in `Strike`."""
        contact, count = self.data.contact, self.count
        w = turn(matrix(self._qpos[:, 3:]), self._qvel[:, 3:])
        still = np.zeros((1, 3))
        found = sliding_motion(
            Contacts(
                self._things_that_touch(),
                contact.pos.reshape(-1, 3),
                contact.frame.reshape(-1, 9)[:, :3],
                np.concatenate([still, self._qpos[:, :3]]),
                np.concatenate([still, self._qvel[:, :3]]),
                np.concatenate([still, w]),
            ),
            range(1, count + 1),
        )
        return replace(found, other=found.other - 1)

    def _things_that_touch(self) -> NDArray[np.int64]:
        """Return the two things (K, 2) of each contact, the terrain 0."""
        geoms = self.data.contact.geom.reshape(-1, 2)
        result: NDArray[np.int64] = self.model.geom_bodyid[geoms].astype(np.int64)
        return result

    def advance(self, poses: Poses | None = None) -> list[Strike]:
        """Go on by one step.

        Args:
            poses: of those who push at the end of it, None if there are none.

        Returns:
            The impacts that began, in the order of time.
        """
        motion = self.pushers.motion(poses)
        n = self.substeps.count(self.pushers)
        law, began = self.law, self.data.time
        if not len(motion) and not self._is_pushed and self._rests():
            self.data.time = began + self.step
            return []
        if n != self._cut:
            self._cut = n
            self.model.opt.timestep = law.h[0] = self.step / n
        law.told[0] = 0
        if self._any_gone:
            self._qvel[: self.count][self.substeps.limits.gone] = 0.0
        before = self._mujoco.get_mjcb_passive()
        self._mujoco.set_mjcb_passive(law.callback)
        try:
            self._go(n, motion)
        finally:
            self._mujoco.set_mjcb_passive(before)
        told = law.told.item()
        if not told:
            return []
        return [self._strike(*values, began) for values in law.strikes[:told].tolist()]

    def _rests(self) -> bool:
        """Tell whether all sleep, so that nothing happens unless somebody pushes."""
        awake: int = self.data.ntree_awake
        return awake == 0

    def _go(self, n: int, motion: Array) -> None:
        """Go on by `n` sub-steps while those who push have velocities (P, 6), v and w."""
        model, data, step = self.model, self.data, self._mujoco.mj_step
        if not len(motion):
            step(model, data, n)
            return
        pushing = slice(self.count, None)
        self._qpos[pushing] = self.pushers.begin
        for _ in range(n):
            # Nothing that they meet changes it.
            self._qvel[pushing] = motion
            step(model, data)

    def _strike(self, one: int, other: int, time: float, *rest: Any) -> Strike:
        """Return a strike of a step; see `STRIKE`, and when the step began [s] at the end."""
        place, normal, speed, energy, began = rest
        after = min(max(time - began, 0.0), math.nextafter(self.step, 0.0))
        return Strike(one, other, after, _triple(place), _triple(normal), speed, energy)


def _triple(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = values
    return float(x), float(y), float(z)


def _things(builds: Sequence[BodyModel], pushers: int) -> Records:
    """Return what stays of the terrain, of bodies and of who push, as MuJoCo numbers them."""
    bodies = Bodies.of(builds)
    things = zero_records(1 + len(builds) + pushers, THING)
    # Of the ground and of who pushes nothing is known: the body's own bounciness holds.
    things.bounciness = np.inf
    own = things[1 : 1 + len(builds)]
    own.bounciness, own.radius = bodies.bounciness, bodies.radius
    own.inverse_mass, own.inverse_inertia = 1.0 / bodies.mass, bodies.inverse
    turns = np.linalg.eigvalsh(bodies.inverse)[:, -1]
    # It is touched a little outside itself, too.
    own.gives = 1.0 / bodies.mass + (OUTSIDE * bodies.reach) ** 2 * turns
    return things


def _bodies_first(count: int) -> Any:
    """Return a key by which bodies come in order, before terrain and those who push."""
    return lambda number: (not 0 <= number < count, number)


# --- the model --------------------------------------------------------------------------

BODY, FIXED = 1, 2
"""Bits of what can be met: bodies meet one another and what does not give way."""


def _build(
    colliders: Sequence[Collider], field: HeightField, pushers: Sequence[Array]
) -> tuple[Any, Any, Any]:
    """Return model, data and module: the terrain first, then bodies, then pushers."""
    import mujoco

    log_warnings(mujoco)
    spec = mujoco.MjSpec()
    _set_options(spec, mujoco, not is_level(field))
    matter = {"contype": FIXED, "conaffinity": 0, **_matter(0.0, 0.0)}
    lying = [c.build.hull.vertices for c in colliders if c.build.hull is not None]
    add_ground(spec, mujoco, field, lying, matter)
    for i, collider in enumerate(colliders):
        _add_body(spec, mujoco, f"body {i}", collider)
    heaviest = max(c.build.mass.mass for c in colliders)
    for k, corners in enumerate(pushers):
        _add_pusher(spec, mujoco, f"pusher {k}", corners, HEAVIER * heaviest)
    spec.nuserdata = 1
    spec.memory = memory_for(len(colliders) + len(pushers))
    model = spec.compile()
    return model, mujoco.MjData(model), mujoco


def _set_options(spec: Any, mujoco: Any, is_uneven: bool) -> None:
    option = spec.option
    option.gravity = [0.0, -GRAVITY, 0.0]
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    option.sleep_tolerance = STILL
    option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)
    if is_uneven:
        use_upward_collision(option, mujoco)


def _matter(friction: float, rolling: float) -> dict[str, Any]:
    # Of two frictions MuJoCo takes the greater; what does not give way has none of its own.
    return {
        "friction": [friction, 0.0, rolling],
        "condim": 6 if rolling > 0.0 else 3,
        "solref": [-1.0, -1.0],
        "solimp": [NEARLY, NEARLY, 0.001, 0.5, 2.0],
    }


def _add_body(spec: Any, mujoco: Any, name: str, collider: Collider) -> None:
    build = collider.build
    body = _free(spec, name, build.mass.mass, build.mass.inertia)
    common = {
        "contype": BODY,
        "conaffinity": BODY | FIXED,
        **_matter(build.friction, build.rolling * 2.0 * build.radius),
    }
    geom = mujoco.mjtGeom
    if build.hull is None:
        body.add_geom(type=geom.mjGEOM_SPHERE, size=[build.radius, 0.0, 0.0], **common)
    elif collider.half is not None:
        body.add_geom(type=geom.mjGEOM_BOX, size=collider.half, **common)
    else:
        spec.add_mesh(name=name, uservert=build.hull.vertices.ravel().tolist())
        body.add_geom(type=geom.mjGEOM_MESH, meshname=name, **common)


def _add_pusher(spec: Any, mujoco: Any, name: str, corners: Array, mass: float) -> None:
    size = float(np.ptp(corners, axis=0).max())
    body = _free(spec, name, mass, mass * size * size * np.eye(3))
    body.gravcomp = 1.0
    body.sleep = mujoco.mjtSleepPolicy.mjSLEEP_NEVER
    spec.add_mesh(name=name, uservert=corners.ravel().tolist())
    common = {"contype": FIXED, "conaffinity": 0, **_matter(0.0, 0.0)}
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, **common)


def _free(spec: Any, name: str, mass: float, inertia: Array) -> Any:
    """Add a body that moves freely about its centre of mass, its own mass properties given."""
    body = spec.worldbody.add_body(name=name)
    body.add_freejoint()
    body.explicitinertial = True
    body.mass = mass
    body.ipos = [0.0, 0.0, 0.0]
    i = inertia
    body.fullinertia = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
    return body
