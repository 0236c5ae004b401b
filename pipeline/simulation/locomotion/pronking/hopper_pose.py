"""Posing: from where bodies and feet of pronkers are to where all their parts are.

Inverse kinematics joins feet to bodies, for dozens of moments at once; heads, tails and arms
do what they do on any creature.

Source: Sims 1987, 7.4.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.rest_ik import RestSolution
from pipeline.simulation.locomotion.body_motion.free_limb_motion import FreeLimbMotion
from pipeline.simulation.locomotion.body_motion.gaze import BodyMotion, LookTarget
from pipeline.simulation.locomotion.body_motion.idle_motion import FreeJoints
from pipeline.simulation.locomotion.gaits.moods import MotionStyle
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.inventory import NodeTable
from pipeline.simulation.locomotion.pronking.hop_state import BodyState
from pipeline.simulation.locomotion.pronking.hopper_fall import JointState
from pipeline.simulation.locomotion.pronking.swing_depenetration import LegSolver
from pipeline.simulation.locomotion.routes.route import straight_route
from pipeline.simulation.spatial import Array, turn, unturn
from pipeline.simulation.terrain import Ground


@dataclass(frozen=True, eq=False)
class HopperSnapshot:
    """A herd at one step.

    Attributes:
        step: its number.
        R: (C, 3, 3) and
        p: (C, 3) of the bodies [m].
        tips: (L, 3) feet [m].
        down: (L,) which are on the ground.
        phase, speed: (C,) of the jump, and over the ground [m/s].
        looks: what somebody is told to look at, by creature.
        limp: (C,) which have fallen.
        hanging: (J,) values of the joints of those whose limbs then hang, by creature.
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
    """Where everything is at n moments: (n, J, 3), (n, J, 3, 3), (n, K) and (n, L) misses [m]."""

    positions: Array
    rotations: Array
    values: Array
    residual: Array


class HopperPoser:
    """Works out the poses of one herd."""

    def __init__(
        self,
        herd: Herd,
        ground: Ground,
        idlers: FreeJoints,
        table: NodeTable,
        folds: Array,
        row_dt: float,
    ) -> None:
        self.herd, self.idlers, self.table = herd, idlers, table
        self.reaching = LegSolver(herd, ground, folds)
        self.row_dt = row_dt
        self.carriage = FreeLimbMotion(herd, idlers, ground, row_dt)
        self.bearing = MotionStyle.neutral(len(herd.names))
        self._routes = [
            straight_route(start, float(angle))
            for start, angle in zip(herd.starts, herd.headings, strict=True)
        ]
        self._limp: Array | None = None

    def poses(self, moments: Sequence[HopperSnapshot], time: Array) -> HopperPoses:
        """Return where everything is at `moments`, which are at times (n,) [s]."""
        herd = self.herd
        R, p, tips, phase, speed = (
            np.stack([getattr(moment, name) for moment in moments])
            for name in ("R", "p", "tips", "phase", "speed")
        )
        down = np.stack([moment.down for moment in moments])
        limp = np.stack([moment.limp for moment in moments])
        goals = unturn(R[:, herd.owner], tips - p[:, herd.owner])
        solution = self.reaching.settled(goals, R, p, down, limp[:, herd.owner])
        n, still = len(moments), np.zeros_like(phase)
        q = self.carriage.values(
            BodyMotion(
                time,
                still,
                still,
                still,
                MotionStyle.stacked([self.bearing] * n),
                [self._routes] * n,
                [moment.looks for moment in moments],
                R,
                p,
            )
        )
        q = self._held(q, limp)
        for row, moment in enumerate(moments):
            for c, values in moment.hanging.items():
                self._let_hang(solution, q, row, c, values)
        X_BN = self.table.poses(solution.X_BJ.reshape(n, -1, 4, 4), self.idlers.tree.pose(q))
        own = R[:, self.table.owner]
        return HopperPoses(
            p[:, self.table.owner] + turn(own, X_BN[..., :3, 3]),
            own @ X_BN[..., :3, :3],
            np.concatenate([phase, speed, solution.q[:, herd.legs.is_joint], q], axis=1),
            np.where(down, solution.residual, 0.0),
        )

    def legs(self, moment: HopperSnapshot) -> Array:
        """Return the joint values (L, n) of legs at a moment [rad or m]."""
        R, p, owner = moment.R[None], moment.p[None], self.herd.owner
        goals = unturn(R[:, owner], moment.tips[None] - p[:, owner])
        limp = moment.limp[None][:, owner]
        result: Array = self.reaching.settled(goals, R, p, moment.down[None], limp).q[0]
        return result

    def _let_hang(self, legs: RestSolution, q: Array, row: int, c: int, values: Array) -> None:
        """Put the joints of a creature to values (J,) [rad or m]."""
        herd, idle = self.herd, self.idlers.owner == c
        q[row, idle] = values[self.idlers.number[idle]]
        own = np.flatnonzero(herd.owner == c)
        joints = [j for limb in herd.figures[c].skeleton.legs for j in limb.joints]
        # Of legs that are shorter than others the rest is padding.
        settled = legs.q[row, own]
        settled[herd.legs.is_joint[own]] = values[joints]
        legs.q[row, own] = settled
        legs.X_BJ[row, own] = herd.legs.rows(own).pose(settled).X_BJ

    def _held(self, q: Array, limp: NDArray[np.bool_]) -> Array:
        """Return joint values (n, M) that stay what they were on those who have fallen."""
        fallen = limp[:, self.idlers.owner]
        if fallen.any():
            for row in range(len(q)):
                before = q[row - 1] if row else self._limp
                if before is not None:
                    q[row, fallen[row]] = before[fallen[row]]
        self._limp = q[-1].copy()
        return q


MIN_ROW_FRACTION = 0.3
"""Part of a row that is too short a time to tell speeds from."""


class HopperPoseBuffer:
    """What is kept of one herd.

    Attributes:
        posing: works out the poses.
        dt: time of a step [s].
    """

    def __init__(self, posing: HopperPoser, dt: float) -> None:
        self.posing, self.dt = posing, dt
        self._waiting: list[HopperSnapshot] = []
        self._posed: list[tuple[list[HopperSnapshot], HopperPoses]] = []
        # The last two moments, and all values that were written of them.
        self._last: list[tuple[HopperSnapshot, Array]] = []

    def keep(self, moment: HopperSnapshot) -> None:
        """Keep a moment as the next row."""
        self._waiting.append(moment)

    def taken(self) -> list[tuple[list[HopperSnapshot], HopperPoses]]:
        """Return what was kept since this was asked, in its order, with its poses."""
        self._pose()
        found, self._posed = self._posed, []
        return found

    def limbs(self, c: int, now: BodyState, tips: Array, down: NDArray[np.bool_]) -> JointState:
        """Return the joints of one creature, between two rows.

        Args:
            c: its number.
            now: its body.
            tips: (n, 3) its feet [m].
            down: (n,) which of them are on the ground.
        """
        self._pose()
        herd, columns = self.posing.herd, self._columns(c)
        skeleton = herd.figures[c].skeleton
        (before, earlier), (moment, last) = self._last[0], self._last[-1]
        q, speeds = last[columns], np.zeros(len(columns))
        row = (moment.step - before.step) * self.dt
        since = now.time - moment.step * self.dt
        if row > 0.0:
            speeds = (q - earlier[columns]) / row
        # Heads and tails go on; legs follow their feet.
        ahead = np.clip(q + since * speeds, skeleton.lower, skeleton.upper)
        joints = [j for limb in skeleton.legs for j in limb.joints]
        ahead[joints] = self._legs(c, moment, now, tips, down)
        if since > MIN_ROW_FRACTION * row > 0.0:
            speeds[joints] = ((ahead - q) / since)[joints]
        return JointState(ahead, speeds)

    def _legs(
        self, c: int, moment: HopperSnapshot, now: BodyState, tips: Array, down: NDArray[np.bool_]
    ) -> Array:
        """Return the values of the leg joints of one creature, one after the other [rad or m]."""
        herd = self.posing.herd
        own = herd.owner == c
        R, p, feet = moment.R.copy(), moment.p.copy(), moment.tips.copy()
        on = moment.down.copy()
        R[c], p[c], feet[own], on[own] = now.R, now.origin, tips, down
        q = self.posing.legs(replace(moment, R=R, p=p, tips=feet, down=on))
        result: Array = q[own][herd.legs.is_joint[own]]
        return result

    def _columns(self, c: int) -> NDArray[np.int64]:
        """Return where the joints (J,) of a creature are among all values of a row."""
        herd, idlers = self.posing.herd, self.posing.idlers
        skeleton, is_joint = herd.figures[c].skeleton, herd.legs.is_joint
        columns = np.empty(len(skeleton.joint_names), dtype=np.int64)
        legs = [j for limb in skeleton.legs for j in limb.joints]
        first = 2 * len(herd.names) + int(is_joint[herd.owner < c].sum())
        columns[legs] = np.arange(first, first + len(legs))
        idle = np.flatnonzero(idlers.owner == c)
        columns[idlers.number[idle]] = 2 * len(herd.names) + int(is_joint.sum()) + idle
        return columns

    def _pose(self) -> None:
        if not self._waiting:
            return
        times = np.array([moment.step for moment in self._waiting]) * self.dt
        poses = self.posing.poses(self._waiting, times)
        self._posed.append((self._waiting, poses))
        self._last += zip(self._waiting, poses.values, strict=True)
        self._last, self._waiting = self._last[-2:], []
