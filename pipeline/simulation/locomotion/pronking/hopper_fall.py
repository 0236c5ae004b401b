"""How a toppled hopper falls: limp as a ragdoll, or stiff as one rigid body.

Source: Sims 1987, 9.4 and ch. 12.
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
from pipeline.simulation.locomotion.pronking.hopper import (
    OUTLINE_DIRECTIONS,
    Hopper,
    extreme_points,
)
from pipeline.simulation.spatial import Array, matrix, quaternion, turn, turn_inverse
from pipeline.simulation.terrain import Ground

if TYPE_CHECKING:
    from pipeline.simulation.dynamics.ragdoll import BoneImpact, Ragdoll
    from pipeline.simulation.dynamics.terrain_bodies import TerrainBodies


MAX_JOINT_SPEED = 4.0
"""Speed above which a limb was displaced rather than moved, in speeds of a swinging leg."""

BOUNCINESS, FRICTION, ROLLING = 0.22, 0.7, 0.03
"""Contact properties of flesh: restitution, sliding and rolling friction."""

START_CLEARANCE = 0.002
"""Distance that a hull is lifted above the ground it would start in [m]."""


@dataclass(frozen=True, eq=False)
class JointState:
    """The joints of one creature.

    Attributes:
        q: (J,) values, in the order of its skeleton [rad or m].
        speeds: (J,) their rates [rad/s or m/s].
    """

    q: Array
    speeds: Array


class Fall(Protocol):
    """The fall of one creature."""

    def begin(self, hopper: Hopper, ground: Ground, state: HopState, joints: JointState) -> None:
        """Start falling from the current state."""

    def advance(self, state: HopState, h: float) -> list[HopEvent]:
        """Advance by `h` [s]; return impacts on the ground."""

    @property
    def q(self) -> Array | None:
        """(J,) joint values; None if joints keep theirs [rad or m]."""


class RagdollFall:
    """A fall as rigid bodies joined at the joints; see `Fall`.

    Attributes:
        figure: of the creature.
    """

    def __init__(self, figure: Figure) -> None:
        self.figure = figure
        self._ragdoll: Ragdoll | None = None
        self._order = np.zeros(0, dtype=np.int64)
        self._centre = np.zeros(3)

    def begin(self, hopper: Hopper, ground: Ground, state: HopState, joints: JointState) -> None:
        """Start falling from the current state."""
        # Creatures that stay on their feet do not load MuJoCo.
        from pipeline.simulation.dynamics.ragdoll import Ragdoll
        from pipeline.simulation.dynamics.ragdoll_model import RagdollState
        from pipeline.simulation.figures.figure_mass import build_bones

        bones = build_bones(self.figure)
        now = state.body(hopper)
        w = np.array(state.attitude[1])
        start = RagdollState(
            p=now.origin,
            q=np.array(state.attitude[0]),
            v=state.v + np.cross(w, now.origin - now.p),
            w=turn_inverse(now.R, w),
            joints=joints.q[bones.joints],
            speeds=self._calm(
                joints.speeds, MAX_JOINT_SPEED * math.sqrt(GRAVITY / hopper.leg_length)
            )[bones.joints],
        )
        self._order, self._centre = bones.joints, hopper.mass.centre
        self._ragdoll = Ragdoll(bones.bones, start, ground.field)

    def advance(self, state: HopState, h: float) -> list[HopEvent]:
        """Advance by `h` [s]; return impacts on the ground."""
        ragdoll = self._ragdoll
        assert ragdoll is not None
        if ragdoll.is_at_rest:
            return []
        knocks = ragdoll.advance(h)
        pose = ragdoll.attitude
        R = matrix(pose.q)
        w, arm = turn(R, pose.w), turn(R, self._centre)
        state.p, state.v = pose.p + arm, pose.v + np.cross(w, arm)
        a, b, c, d = pose.q.tolist()
        x, y, z = w.tolist()
        state.attitude = (a, b, c, d), (x, y, z)
        events = [_impact_event(state.time, knock) for knock in knocks]
        if ragdoll.is_gone:
            text = "left the terrain, and is followed no farther"
            end = state.time + h
            events.append(HopEvent.note("dropped", end, text))
        return events

    def _calm(self, speeds: Array, max_speed: float) -> Array:
        """Return joint speeds (J,) without those of limbs that inverse kinematics displaced."""
        result = speeds.copy()
        for limb in self.figure.skeleton.limbs:
            own = list(limb.joints)
            if float(np.abs(speeds[own]).max()) > max_speed:
                result[own] = 0.0
        return result

    @property
    def q(self) -> Array | None:
        """(J,) joint values [rad or m]."""
        if self._ragdoll is None:
            return None
        q = np.empty(len(self._order))
        q[self._order] = self._ragdoll.attitude.joints
        return q


def _impact_event(start: float, knock: BoneImpact) -> HopEvent:
    time, place, normal = start + knock.time, knock.place, knock.normal
    return HopEvent("body", time, -1, place, normal, knock.speed, knock.energy, link=knock.bone)


class RigidFall:
    """A fall as one rigid body that holds its joints; see `Fall`.

    The hull of all links strikes the ground, slides and comes to rest.

    Attributes:
        figure: of the creature.
    """

    def __init__(self, figure: Figure) -> None:
        self.figure = figure
        self._bouncing: TerrainBodies | None = None

    def begin(self, hopper: Hopper, ground: Ground, state: HopState, joints: JointState) -> None:
        """Start falling from the current state."""
        # Creatures that stay on their feet do not load the compiler of rigid bodies.
        from pipeline.simulation.dynamics.hull import hull_of
        from pipeline.simulation.dynamics.rigid_body import Bodies, BodyModel, rotate_inverse
        from pipeline.simulation.dynamics.rigid_body import State as Rigid
        from pipeline.simulation.dynamics.terrain_bodies import TerrainBodies

        hull = hull_of(_outline_points(self.figure, joints.q) - hopper.mass.centre)
        mass = replace(hopper.mass, centre=np.zeros(3))
        body = BodyModel(mass, hull, 0.0, BOUNCINESS, FRICTION, ROLLING)
        now = state.body(hopper)
        w = rotate_inverse(now.R, np.array(state.attitude[1]))
        q = quaternion(now.R[None])
        rigid = Rigid(now.p[None].copy(), q, state.v[None].copy(), w[None])
        self._bouncing = TerrainBodies(Bodies.of([body]), rigid, ground)
        deep = float(self._bouncing.depths()[0])
        if deep > 0.0:
            self._bouncing.state.p[0, 1] += deep + START_CLEARANCE
            self._bouncing.find_contacts()
            state.p = self._bouncing.state.p[0].copy()

    def advance(self, state: HopState, h: float) -> list[HopEvent]:
        """Advance by `h` [s]; return impacts on the ground."""
        from pipeline.simulation.dynamics.rigid_body import rotate
        from pipeline.simulation.spatial import matrix

        bouncing = self._bouncing
        assert bouncing is not None
        events = [
            HopEvent(
                "body",
                state.time + hit.time,
                -1,
                np.array(hit.place),
                np.array(hit.normal),
                hit.speed,
                hit.energy,
            )
            for hit in bouncing.advance(h)
        ]
        rigid = bouncing.state
        state.p, state.v = rigid.p[0].copy(), rigid.v[0].copy()
        a, b, c, d = rigid.q[0].tolist()
        x, y, z = rotate(matrix(rigid.q[0]), rigid.w[0]).tolist()
        state.attitude = (a, b, c, d), (x, y, z)
        return events

    @property
    def q(self) -> None:
        """Joints keep their values."""
        return None


def _outline_points(figure: Figure, q: Array) -> Array:
    """Return the outermost points of a figure's links (k, 3) [m]."""
    tree = JointTree.of(figure.skeleton)
    X_BJ, points = tree.pose(q), []
    for piece in figure.pieces:
        joint = figure.skeleton.links[piece.link].joint
        vertices = piece.solid.vertices
        if joint != BODY:
            X = displacement_at(tree, X_BJ, joint)
            vertices = vertices @ X[:3, :3].T + X[:3, 3]
        points.append(extreme_points(vertices, OUTLINE_DIRECTIONS))
    return np.concatenate(points)
