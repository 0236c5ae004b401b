"""MuJoCo world: rigid bodies that meet one another, the terrain and kinematic bodies.

`mujoco` is imported when the first world is built. MuJoCo finds the contacts, solves them together
with friction, and lets islands of bodies sleep; the impact law sets the strength of contacts in
every step, before MuJoCo computes their forces.

World and bodies keep their axes, gravity points down Y; only the height field is turned, see
`mujoco_model`. Letters as in `rigid_body`: p, q, v in the world, w in the body; a free joint of
MuJoCo has the same coordinates in this order.

Source: Todorov 2014 (MuJoCo's contacts).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.collision_masks import CollisionMasks
from pipeline.simulation.dynamics.contact_sliding import (
    Contacts,
    SlidingMotion,
    sliding_motion,
)
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.kinematic_bodies import KinematicBodies, Poses
from pipeline.simulation.dynamics.mujoco_bodies import (
    Collider,
    build_model,
    ground_is_box,
    impact_things,
)
from pipeline.simulation.dynamics.mujoco_callback import ImpactCallback
from pipeline.simulation.dynamics.mujoco_terrain import TerrainCollision
from pipeline.simulation.dynamics.rigid_body import State
from pipeline.simulation.dynamics.substeps import Substeps
from pipeline.simulation.spatial import Array, matrix, turn
from pipeline.simulation.terrain.heightfield import HeightField

TERRAIN = -1
"""Number of the terrain among things: bodies are numbered from 0, then kinematic bodies."""

FLIGHT_TOLERANCE = 1e-9
"""Difference from the velocity of a free flight below which a body met nothing [m/s]."""


@dataclass(frozen=True, slots=True)
class Strike:
    """The start of an impact.

    Attributes:
        one: number of a body.
        other: number of another body, a kinematic body, or the terrain.
        time: after the start of the step [s].
        place: [m].
        normal: from the other to the one.
        speed: approach speed [m/s].
        energy: kinetic energy of the approach [J].
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
    """Two things that overlap by `depth` [m]; see `Strike`."""

    one: int
    other: int
    depth: float


class MujocoWorld:
    """Bodies, terrain and kinematic bodies in one MuJoCo model.

    Args:
        colliders: N bodies.
        state: their initial state.
        field: the terrain.
        pushers: corners (V, 3) of P convex kinematic bodies, each in its own frame [m].
        step: length of a step [s].

    Attributes:
        masks: which bodies and kinematic bodies meet.
        ballistic: (N,) which bodies fly along exact parabolas while they meet nothing; the others
            are off by half a sub-step of gravity, as the solver integrates.
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
        self.model, self.data, self._mujoco = build_model(colliders, field, pushers)
        self._qpos: Array = self.data.qpos.reshape(-1, 7)
        self._qvel: Array = self.data.qvel.reshape(-1, 6)
        self._awake = self.data.tree_awake
        moving = (self._qpos, self._qvel, self._awake)
        self.substeps = Substeps(builds, pushers, field, step, *moving)
        things, own = impact_things(builds, len(pushers)), (self.model, self.data, self._mujoco)
        self.law = ImpactCallback(things, self.count, *own)
        self._terrain = (
            None
            if ground_is_box(colliders, field)
            else TerrainCollision(builds, state, field, *own)
        )
        self.masks = CollisionMasks(self.model, self.data, self._mujoco, self.count)
        self.ballistic = np.zeros(self.count, dtype=bool)
        self._any_gone = False
        self._cut = 0
        self._is_pushed = False
        self._put(state)

    # --- state --------------------------------------------------------------------

    @property
    def state(self) -> State:
        """State of the bodies, as copies."""
        qpos, qvel = self._qpos[: self.count], self._qvel[: self.count]
        return State(qpos[:, :3].copy(), qpos[:, 3:].copy(), qvel[:, :3].copy(), qvel[:, 3:].copy())

    @property
    def asleep(self) -> NDArray[np.bool_]:
        """(N,) which bodies sleep."""
        return self._awake[: self.count] == 0

    def _put(self, state: State) -> None:
        n = self.count
        self._qpos[:n, :3], self._qpos[:n, 3:] = state.p, state.q
        self._qvel[:n, :3], self._qvel[:n, 3:] = state.v, state.w

    @property
    def touching(self) -> NDArray[np.bool_]:
        """(N,) which bodies touched anything in the last sub-step."""
        found = np.zeros(self.model.nbody, dtype=bool)
        found[self._things_that_touch()] = True
        return found[1 : 1 + self.count]

    def push(self, impulses: Array, twists: Array) -> None:
        """Spreads impulses over the next step.

        Args:
            impulses: (N, 3) [N s].
            twists: (N, 3) angular impulses about the centres [N m s].
        """
        pushes = self.data.xfrc_applied[1 : 1 + self.count]
        pushes[:, :3], pushes[:, 3:] = impulses / self.step, twists / self.step
        self._is_pushed = bool(pushes.any())

    def lift(self, p: Array) -> None:
        """Sets the positions of the bodies (N, 3) [m]."""
        self._qpos[: self.count, :3] = p

    def place_pushers(self, poses: Poses) -> None:
        """Sets the initial poses of the kinematic bodies."""
        self._qpos[self.count :] = self.pushers.put(poses)

    def drop(self, which: NDArray[np.int64]) -> None:
        """Removes bodies from the world."""
        for body in which.tolist():
            self.set_present(body, False)
        self._qvel[which] = 0.0

    def set_present(self, body: int, is_present: bool) -> None:
        """Lets a body meet others and be moved by the solver, or neither."""
        self.substeps.limits["gone"][body] = not is_present
        self._any_gone = bool(self.substeps.limits["gone"].any())
        self.masks.show_body(body, is_present)

    def put(self, which: NDArray[np.int64], state: State) -> None:
        """Sets pose and velocity of some bodies."""
        self._qpos[which, :3], self._qpos[which, 3:] = state.p, state.q
        self._qvel[which, :3], self._qvel[which, 3:] = state.v, state.w

    # --- what the world is asked --------------------------------------------------

    def overlaps(self) -> list[Overlap]:
        """Returns all overlaps."""
        self._mujoco.mj_kinematics(self.model, self.data)
        self._mujoco.mj_comPos(self.model, self.data)
        with self._terrain_installed():
            self._mujoco.mj_collision(self.model, self.data)
        deepest = dict[tuple[int, int], float]()
        things, dists = self._things_that_touch().tolist(), self.data.contact.dist.tolist()
        for (a, b), dist in zip(things, dists, strict=True):
            one, other = sorted((a - 1, b - 1), key=_bodies_first(self.count))
            deepest[one, other] = max(deepest.get((one, other), 0.0), -dist)
        return [Overlap(*pair, depth) for pair, depth in deepest.items()]

    def sliding_motion(self) -> SlidingMotion:
        """Returns how bodies move along what they touch, numbered as in `Strike`."""
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
        """Returns the two things (K, 2) of each contact, the terrain 0."""
        geoms = self.data.contact.geom.reshape(-1, 2)
        return self.model.geom_bodyid[geoms].astype(np.int64)

    def advance(self, poses: Poses | None = None) -> list[Strike]:
        """Advances by one step.

        Args:
            poses: of the kinematic bodies at the end of it, None without any.

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
            self._qvel[: self.count][self.substeps.limits["gone"]] = 0.0
        speeds = self._qvel[: self.count, :3].copy() if self.ballistic.any() else None
        before = self._mujoco.get_mjcb_passive()
        self._mujoco.set_mjcb_passive(law.callback)
        try:
            with self._terrain_installed():
                self._go(n, motion)
        finally:
            self._mujoco.set_mjcb_passive(before)
        if speeds is not None:
            self._correct_flights(speeds, self.step / n)
        told = law.told.item()
        if not told:
            return []
        return [self._strike(*values, began) for values in law.strikes[:told].tolist()]

    def _correct_flights(self, before: Array, h: float) -> None:
        """Moves bodies in free flight onto their parabolas.

        The solver moves a body by the velocity at the end of each sub-step `h` [s], and so by
        g t h / 2 too low.

        Args:
            before: (N, 3) velocities at the start of the step [m/s].
            h: length of its sub-steps [s].
        """
        free = before - np.array([0.0, GRAVITY * self.step, 0.0])
        off = np.abs(self._qvel[: self.count, :3] - free).max(axis=1)
        flies = self.ballistic & (off < FLIGHT_TOLERANCE)
        self._qpos[: self.count, 1][flies] += 0.5 * GRAVITY * self.step * h

    def _terrain_installed(self) -> AbstractContextManager[None]:
        return nullcontext() if self._terrain is None else self._terrain.installed()

    def _rests(self) -> bool:
        """Returns whether all bodies sleep."""
        awake: int = self.data.ntree_awake
        return awake == 0

    def _go(self, n: int, motion: Array) -> None:
        """Advances by `n` sub-steps at velocities (P, 6) of the kinematic bodies, v and w."""
        model, data, step = self.model, self.data, self._mujoco.mj_step
        if not len(motion):
            step(model, data, n)
            return
        pushing = slice(self.count, None)
        self._qpos[pushing] = self.pushers.begin
        for _ in range(n):
            # Contacts change the velocity of no kinematic body.
            self._qvel[pushing] = motion
            step(model, data)

    def _strike(self, one: int, other: int, time: float, *rest: Any) -> Strike:
        """Returns an impact from the columns of `STRIKE`, followed by the start of the step [s]."""
        place, normal, speed, energy, began = rest
        after = min(max(time - began, 0.0), math.nextafter(self.step, 0.0))
        return Strike(one, other, after, _triple(place), _triple(normal), speed, energy)


def _triple(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = values
    return float(x), float(y), float(z)


def _bodies_first(count: int) -> Any:
    """Returns a sort key: bodies in order, before terrain and kinematic bodies."""
    return lambda number: (not 0 <= number < count, number)
