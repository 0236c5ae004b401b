"""Falling: what a pronker that has toppled does, limp or stiff.

Source: Sims 1987, 9.4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.figures.base_change import displacement_at
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.locomotion.pronking.hop_events import HopEvent
from pipeline.simulation.locomotion.pronking.hop_state import HopState
from pipeline.simulation.locomotion.pronking.hopper import Hopper
from pipeline.simulation.spatial import UP, Array, matrix, quaternion, turn, unturn
from pipeline.simulation.terrain import Ground

if TYPE_CHECKING:
    from pipeline.simulation.dynamics.ragdoll import BoneImpact, Ragdoll
    from pipeline.simulation.dynamics.terrain_bodies import TerrainBodies


@dataclass(frozen=True, eq=False)
class JointState:
    """The joints of one creature.

    Attributes:
        q: (J,) values, numbered as in its skeleton [rad or m].
        speeds: (J,) of them [rad/s or m/s].
    """

    q: Array
    speeds: Array


class Fall(Protocol):
    """One creature as it falls."""

    def begin(self, of: Hopper, ground: Ground, state: HopState, limbs: JointState) -> None:
        """Let it fall from now on, as it is."""

    def advance(self, state: HopState, h: float) -> list[HopEvent]:
        """Go on by `h` [s]; return what struck the ground."""

    @property
    def q(self) -> Array | None:
        """(J,) values of its joints, None if they hold what they were at [rad or m]."""


MAX_JOINT_SPEED = 4.0
"""Speed from which a limb has not moved but was put elsewhere, in that of a leg that swings."""


class RagdollFall:
    """One creature as it falls; see `Fall`.

    Attributes:
        figure: its.
    """

    def __init__(self, figure: Figure) -> None:
        self.figure = figure
        self._ragdoll: Ragdoll | None = None
        self._order = np.zeros(0, dtype=np.int64)
        self._centre = np.zeros(3)

    def begin(self, of: Hopper, ground: Ground, state: HopState, limbs: JointState) -> None:
        """Let it fall from now on, as it is."""
        # Who stays on its feet need not wait for MuJoCo.
        from pipeline.simulation.dynamics.ragdoll import Ragdoll
        from pipeline.simulation.dynamics.ragdoll_model import RagdollState
        from pipeline.simulation.figures.figure_mass import build_bones

        own = build_bones(self.figure)
        now = state.now(of)
        w = np.array(state.turning[1])
        begin = RagdollState(
            p=now.origin,
            q=np.array(state.turning[0]),
            v=state.v + np.cross(w, now.origin - now.p),
            w=unturn(now.R, w),
            joints=limbs.q[own.joints],
            speeds=self._calm(limbs.speeds, MAX_JOINT_SPEED * math.sqrt(GRAVITY / of.leg))[
                own.joints
            ],
        )
        self._order, self._centre = own.joints, of.mass.centre
        self._ragdoll = Ragdoll(own.bones, begin, ground.field)

    def advance(self, state: HopState, h: float) -> list[HopEvent]:
        """Go on by `h` [s]; return what struck the ground."""
        ragdoll = self._ragdoll
        assert ragdoll is not None
        if ragdoll.is_at_rest:
            return []
        knocks = ragdoll.advance(h)
        it = ragdoll.attitude
        R = matrix(it.q)
        w, arm = turn(R, it.w), turn(R, self._centre)
        state.p, state.v = it.p + arm, it.v + np.cross(w, arm)
        a, b, c, d = it.q.tolist()
        x, y, z = w.tolist()
        state.turning = (a, b, c, d), (x, y, z)
        found = [_impact_event(state.time, one) for one in knocks]
        if ragdoll.is_gone:
            text = "left the terrain, and is followed no farther"
            end = state.time + h
            found.append(HopEvent("dropped", end, -1, it.p, UP, 0.0, 0.0, text))
        return found

    def _calm(self, speeds: Array, quick: float) -> Array:
        """Return speeds of joints (J,), of limbs that inverse kinematics turned in no time none."""
        result = speeds.copy()
        for limb in self.figure.skeleton.limbs:
            own = list(limb.joints)
            if float(np.abs(speeds[own]).max()) > quick:
                result[own] = 0.0
        return result

    @property
    def q(self) -> Array | None:
        """(J,) values of its joints [rad or m]."""
        if self._ragdoll is None:
            return None
        q = np.empty(len(self._order))
        q[self._order] = self._ragdoll.attitude.joints
        return q


def _impact_event(began: float, one: BoneImpact) -> HopEvent:
    time, place, normal = began + one.time, one.place, one.normal
    return HopEvent("body", time, -1, place, normal, one.speed, one.energy, link=one.bone)


BOUNCINESS, FRICTION, ROLLING = 0.22, 0.7, 0.03
"""Of flesh."""

START_CLEARANCE = 0.002
"""What a hull is lifted by above the ground that it would begin in [m]."""


class RigidFall:
    """One creature as it falls; see `Fall`.

    Attributes:
        figure: its.
    """

    def __init__(self, figure: Figure) -> None:
        self.figure = figure
        self._bouncing: TerrainBodies | None = None

    def begin(self, of: Hopper, ground: Ground, state: HopState, limbs: JointState) -> None:
        """Let it fall from now on, as it is."""
        # Bodies need a compiler, whose loading who stays on its feet need not wait for.
        from pipeline.simulation.dynamics.hull import hull_of
        from pipeline.simulation.dynamics.rigid_body import Bodies, BodyModel, unrotate
        from pipeline.simulation.dynamics.rigid_body import State as Rigid
        from pipeline.simulation.dynamics.terrain_bodies import TerrainBodies

        hull = hull_of(_outline_points(self.figure, limbs.q) - of.mass.centre)
        mass = replace(of.mass, centre=np.zeros(3))
        body = BodyModel(mass, hull, 0.0, BOUNCINESS, FRICTION, ROLLING)
        now = state.now(of)
        w = unrotate(now.R, np.array(state.turning[1]))
        q = quaternion(now.R[None])
        rigid = Rigid(now.p[None].copy(), q, state.v[None].copy(), w[None])
        self._bouncing = TerrainBodies(Bodies.of([body]), rigid, ground)
        deep = float(self._bouncing.depths()[0])
        if deep > 0.0:
            self._bouncing.state.p[0, 1] += deep + START_CLEARANCE
            self._bouncing.find_contacts()
            state.p = self._bouncing.state.p[0].copy()

    def advance(self, state: HopState, h: float) -> list[HopEvent]:
        """Go on by `h` [s]; return what struck the ground."""
        from pipeline.simulation.dynamics.rigid_body import rotate
        from pipeline.simulation.spatial import matrix

        bouncing = self._bouncing
        assert bouncing is not None
        found = [
            HopEvent(
                "body",
                state.time + one.time,
                -1,
                np.array(one.place),
                np.array(one.normal),
                one.speed,
                one.energy,
            )
            for one in bouncing.advance(h)
        ]
        rigid = bouncing.state
        state.p, state.v = rigid.p[0].copy(), rigid.v[0].copy()
        a, b, c, d = rigid.q[0].tolist()
        x, y, z = rotate(matrix(rigid.q[0]), rigid.w[0]).tolist()
        state.turning = (a, b, c, d), (x, y, z)
        return found

    @property
    def q(self) -> None:
        """Joints hold what they were at."""
        return None


def _outline_points(figure: Figure, q: Array) -> Array:
    """Return the points of a figure's links that lie farthest out, (k, 3) [m]."""
    tree = JointTree.of(figure.skeleton)
    X_BJ, points = tree.pose(q), []
    grid = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])
    for piece in figure.pieces:
        joint = figure.skeleton.links[piece.link].joint
        vertices = piece.solid.vertices
        if joint != BODY:
            X = displacement_at(tree, X_BJ, joint)
            vertices = vertices @ X[:3, :3].T + X[:3, 3]
        points.append(vertices[np.unique((vertices @ grid.T).argmax(axis=0))])
    return np.concatenate(points)
