"""Poses of hoppers: from bodies and feet to all nodes, many rows at a time.

Inverse kinematics joins feet to bodies; heads, tails and arms move as on any creature. The buffer
solves snapshots in batches, and earlier when a creature falls and its joint state is needed.

Source: Sims 1987, 7.4.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.tip_ik import TipSolution
from pipeline.simulation.locomotion.body_motion.foot_roll import FootRoll
from pipeline.simulation.locomotion.body_motion.free_limb_motion import FreeLimbMotion
from pipeline.simulation.locomotion.body_motion.gaze import BodyMotion, LookTarget
from pipeline.simulation.locomotion.body_motion.idle_motion import FreeJoints
from pipeline.simulation.locomotion.gaits.moods import MotionStyle
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.inventory import NodeTable
from pipeline.simulation.locomotion.pronking.hop_state import BodyState
from pipeline.simulation.locomotion.pronking.hopper_fall import JointState
from pipeline.simulation.locomotion.routes.route import straight_route
from pipeline.simulation.locomotion.swing.swing_depenetration import LegSolver
from pipeline.simulation.spatial import Array, turn, turn_inverse
from pipeline.simulation.terrain import Ground

MIN_ROW_FRACTION = 0.3
"""Shortest time over which speeds are measured, in rows."""


@dataclass(frozen=True, eq=False)
class HopperSnapshot:
    """A herd at one step.

    Attributes:
        step: its number.
        R: (C, 3, 3) orientations of the bodies.
        p: (C, 3) places of the bodies [m].
        tips: (L, 3) feet [m].
        down: (L,) which feet are on the ground.
        phase: (C,) of the jump cycle, 0 to 1.
        speed: (C,) over the ground [m/s].
        looks: look targets by creature.
        limp: (C,) which creatures have fallen.
        hanging: (J,) joint values of fallen creatures with limp joints, by creature.
    """

    step: int
    R: Array
    p: Array
    tips: Array
    down: NDArray[np.bool_]
    phase: Array
    speed: Array
    looks: Mapping[int, LookTarget]
    limp: NDArray[np.bool_]
    hanging: Mapping[int, Array] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class HopperPoses:
    """Nodes at n moments.

    Attributes:
        positions: (n, J, 3) [m].
        rotations: (n, J, 3, 3).
        values: (n, K) channels.
        residual: (n, L) distances of planted feet from their footholds [m].
    """

    positions: Array
    rotations: Array
    values: Array
    residual: Array


class HopperPoser:
    """Computes the poses of one herd."""

    def __init__(
        self,
        herd: Herd,
        ground: Ground,
        free_joints: FreeJoints,
        table: NodeTable,
        folds: Array,
        row_dt: float,
    ) -> None:
        self.herd, self.free_joints, self.table = herd, free_joints, table
        self.ground, self.folds = ground, folds
        self.foot_roll = FootRoll(herd, ground)
        self.row_dt = row_dt
        self.free_limb_motion = FreeLimbMotion(herd, free_joints, ground, row_dt)
        self.style = MotionStyle.neutral(len(herd.names))
        self._routes = [
            straight_route(start, float(angle))
            for start, angle in zip(herd.starts, herd.headings, strict=True)
        ]
        self._last_values: Array | None = None

    def poses(self, snapshots: Sequence[HopperSnapshot], time: Array) -> HopperPoses:
        """Return the nodes of snapshots taken at times (n,) [s]."""
        herd = self.herd
        R, p, tips, phase, speed = (
            np.stack([getattr(snapshot, name) for snapshot in snapshots])
            for name in ("R", "p", "tips", "phase", "speed")
        )
        down = np.stack([snapshot.down for snapshot in snapshots])
        limp = np.stack([snapshot.limp for snapshot in snapshots])
        solution = self._solved_legs(tips, (R, p), down, limp)
        n, zeros = len(snapshots), np.zeros_like(phase)
        q = self.free_limb_motion.values(
            BodyMotion(
                time,
                zeros,
                zeros,
                zeros,
                zeros,
                MotionStyle.stacked([self.style] * n),
                [self._routes] * n,
                [snapshot.looks for snapshot in snapshots],
                R,
                p,
            )
        )
        q = self._hold_fallen(q, limp)
        for row, snapshot in enumerate(snapshots):
            for c, values in snapshot.hanging.items():
                self._set_joints(solution, q, row, c, values)
        X_BN = self.table.poses(solution.X_BJ.reshape(n, -1, 4, 4), self.free_joints.tree.pose(q))
        R_node = R[:, self.table.owner]
        return HopperPoses(
            p[:, self.table.owner] + turn(R_node, X_BN[..., :3, 3]),
            R_node @ X_BN[..., :3, :3],
            np.concatenate([phase, speed, solution.q[:, herd.legs.is_joint], q], axis=1),
            np.where(down, solution.residual, 0.0),
        )

    def legs(self, snapshot: HopperSnapshot) -> Array:
        """Return the joint values (L, n) of the legs in a snapshot [rad or m]."""
        bodies = snapshot.R[None], snapshot.p[None]
        down, limp = snapshot.down[None], snapshot.limp[None]
        return self._solved_legs(snapshot.tips[None], bodies, down, limp).q[0]

    def _solved_legs(
        self,
        tips: Array,
        bodies: tuple[Array, Array],
        down: NDArray[np.bool_],
        limp: NDArray[np.bool_],
    ) -> TipSolution:
        """Return the legs at n moments; see `HopperSnapshot` for the arrays."""
        herd, (R, p) = self.herd, bodies
        goals = turn_inverse(R[:, herd.owner], tips - p[:, herd.owner])
        directions = self.foot_roll.directions(tips, bodies, limp)
        solver = LegSolver(herd, self.ground, self.folds, directions)
        return solver.solve(goals, R, p, down, limp[:, herd.owner])

    def _set_joints(self, legs: TipSolution, q: Array, row: int, c: int, values: Array) -> None:
        """Set all joints of a creature to values (J,) [rad or m]."""
        herd, free = self.herd, self.free_joints.owner == c
        q[row, free] = values[self.free_joints.number[free]]
        own = np.flatnonzero(herd.owner == c)
        joints = [j for limb in herd.figures[c].skeleton.legs for j in limb.joints]
        # Shorter legs are padded.
        leg_values = legs.q[row, own]
        leg_values[herd.legs.is_joint[own]] = values[joints]
        legs.q[row, own] = leg_values
        legs.X_BJ[row, own] = herd.legs.rows(own).pose(leg_values).X_BJ

    def _hold_fallen(self, q: Array, limp: NDArray[np.bool_]) -> Array:
        """Return joint values (n, M) in which fallen creatures keep theirs."""
        fallen = limp[:, self.free_joints.owner]
        if fallen.any():
            for row in range(len(q)):
                before = q[row - 1] if row else self._last_values
                if before is not None:
                    q[row, fallen[row]] = before[fallen[row]]
        self._last_values = q[-1].copy()
        return q


class HopperPoseBuffer:
    """Snapshots of one herd that wait for the take, and the poses computed from them.

    Attributes:
        poser: computes the poses.
        dt: duration of a step [s].
    """

    def __init__(self, poser: HopperPoser, dt: float) -> None:
        self.poser, self.dt = poser, dt
        self._waiting: list[HopperSnapshot] = []
        self._posed: list[tuple[list[HopperSnapshot], HopperPoses]] = []
        # The last two snapshots with their channel values.
        self._last: list[tuple[HopperSnapshot, Array]] = []

    def keep(self, snapshot: HopperSnapshot) -> None:
        """Append a snapshot as the next row."""
        self._waiting.append(snapshot)

    def take(self) -> list[tuple[list[HopperSnapshot], HopperPoses]]:
        """Return all rows since the last call, with their poses."""
        self._pose()
        batches, self._posed = self._posed, []
        return batches

    def joint_state(
        self, c: int, now: BodyState, tips: Array, down: NDArray[np.bool_]
    ) -> JointState:
        """Return the joints of one creature between two rows.

        Args:
            c: number of the creature.
            now: its body.
            tips: (n, 3) its feet [m].
            down: (n,) which of them are on the ground.
        """
        self._pose()
        herd, columns = self.poser.herd, self._columns(c)
        skeleton = herd.figures[c].skeleton
        (before, earlier), (snapshot, last) = self._last[0], self._last[-1]
        q, speeds = last[columns], np.zeros(len(columns))
        elapsed = (snapshot.step - before.step) * self.dt
        since = now.time - snapshot.step * self.dt
        if elapsed > 0.0:
            speeds = (q - earlier[columns]) / elapsed
        # Heads and tails continue their motion; legs follow their feet.
        ahead = np.clip(q + since * speeds, skeleton.lower, skeleton.upper)
        joints = [j for limb in skeleton.legs for j in limb.joints]
        ahead[joints] = self._legs(c, snapshot, now, tips, down)
        if since > MIN_ROW_FRACTION * elapsed > 0.0:
            speeds[joints] = ((ahead - q) / since)[joints]
        return JointState(ahead, speeds)

    def _legs(
        self, c: int, snapshot: HopperSnapshot, now: BodyState, tips: Array, down: NDArray[np.bool_]
    ) -> Array:
        """Return the leg joint values of one creature [rad or m]."""
        herd = self.poser.herd
        own = herd.owner == c
        R, p, feet = snapshot.R.copy(), snapshot.p.copy(), snapshot.tips.copy()
        planted = snapshot.down.copy()
        R[c], p[c], feet[own], planted[own] = now.R, now.origin, tips, down
        q = self.poser.legs(replace(snapshot, R=R, p=p, tips=feet, down=planted))
        return q[own][herd.legs.is_joint[own]]

    def _columns(self, c: int) -> NDArray[np.int64]:
        """Return the columns (J,) of a creature's joints among the channel values."""
        herd, free_joints = self.poser.herd, self.poser.free_joints
        skeleton, is_joint = herd.figures[c].skeleton, herd.legs.is_joint
        columns = np.empty(len(skeleton.joint_names), dtype=np.int64)
        legs = [j for limb in skeleton.legs for j in limb.joints]
        first = 2 * len(herd.names) + int(is_joint[herd.owner < c].sum())
        columns[legs] = np.arange(first, first + len(legs))
        free = np.flatnonzero(free_joints.owner == c)
        columns[free_joints.number[free]] = 2 * len(herd.names) + int(is_joint.sum()) + free
        return columns

    def _pose(self) -> None:
        if not self._waiting:
            return
        times = np.array([snapshot.step for snapshot in self._waiting]) * self.dt
        poses = self.poser.poses(self._waiting, times)
        self._posed.append((self._waiting, poses))
        self._last += zip(self._waiting, poses.values, strict=True)
        self._last, self._waiting = self._last[-2:], []
