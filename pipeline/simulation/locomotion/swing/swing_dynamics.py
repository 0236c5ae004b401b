"""Swing dynamics: the joint torques of a leg along a candidate path of its foot, known in advance.

The body follows its trajectory; the leg hangs on it, with the joint values that posing will give
it. So a trial has the torques that the take will have, but for what no plan foresees.

Source: Sims 1987, 7.3.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.inverse_dynamics import (
    FigureMotion,
    FrameMasses,
    JointLoad,
    finite_difference_motion,
    inverse_dynamics,
)
from pipeline.simulation.figures.kinematics import JointTree, LimbBatch
from pipeline.simulation.figures.limb_chains import ChainGroup, group_chains
from pipeline.simulation.figures.tip_ik import solve_tips
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.swing.swing_trajectory import swing_positions
from pipeline.simulation.spatial import Array, turn_inverse

# Pieces of a swing.
ROWS = 32

# Fractions of the swing of the rows: one before it and one after it, for the derivatives; and the
# same with the foot standing before and after.
FRACTIONS: Array = np.arange(-1.0, ROWS + 2.0) / ROWS
FOOT_FRACTIONS: Array = np.clip(FRACTIONS, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class LegModel:
    """One leg as joints with masses.

    Attributes:
        batch: the leg alone.
        chains: the same, prepared for inverse kinematics.
        tree: its joints with padding, one after the other.
        masses: of the links that they move.
    """

    batch: LimbBatch
    chains: Sequence[ChainGroup]
    tree: JointTree
    masses: FrameMasses

    @staticmethod
    def of(herd: Herd, leg: int, inertia: FigureMass) -> LegModel:
        """Model one leg of a herd.

        Args:
            herd: the creatures.
            leg: number of the leg.
            inertia: of its figure.
        """
        skeleton = inertia.figure.skeleton
        number = leg - int(np.argmax(herd.owner == herd.owner[leg]))
        joints, batch = skeleton.legs[number].joints, herd.legs.rows(np.array([leg]))
        count = batch.is_joint.shape[1]
        tree = JointTree(np.arange(count) - 1, batch.axes[0], batch.places[0], batch.prismatic[0])
        whole = FrameMasses.of(skeleton, inertia.links)
        chains = group_chains(batch, np.zeros(1, dtype=np.int64))
        return LegModel(batch, chains, tree, whole.limb(joints, count))

    def solve(self, goals: Array) -> tuple[Array, Array]:
        """Return joint values (..., n) for goals (..., 3) of the tip, and their misses [m]."""
        found = solve_tips(self.batch, self.chains, goals.reshape(-1, 1, 3))
        return found.q.reshape(*goals.shape[:-1], -1), found.residual.reshape(goals.shape[:-1])


@dataclass(frozen=True, eq=False)
class SwingTrial:
    """One swing of one leg that is about to begin.

    Attributes:
        model: of the leg.
        start, end: (3,) tips [m].
        time: duration of the swing [s].
        R_WB: (rows, 3, 3) of the body at the `FRACTIONS`.
        p_WB: (rows, 3) [m].
    """

    model: LegModel
    start: Array
    end: Array
    time: float
    R_WB: Array
    p_WB: Array

    @property
    def dt(self) -> float:
        """Time between two rows [s]."""
        return self.time / ROWS

    def motion(self, tips: Array) -> tuple[FigureMotion, Array]:
        """Return the leg's motions (rows of the swing) with its tip at `tips` (rows, K, 3).

        Returns:
            The motions, and their greatest misses (K,) [m].
        """
        R = np.broadcast_to(self.R_WB[:, None], (*tips.shape, 3))
        p = np.broadcast_to(self.p_WB[:, None], tips.shape)
        q, missed = self.model.solve(turn_inverse(R, tips - p))
        return finite_difference_motion(q, R, p, self.dt), missed.max(axis=0)

    def load(self, motion: FigureMotion) -> JointLoad:
        """Return the load of a motion of the leg, its foot in the air."""
        return inverse_dynamics(self.model.tree, self.model.masses, motion)

    def tips(self, height: float, bend: Array) -> Array:
        """Return the tips (rows, 3) on a path with an arch and a bend [m]."""
        n = len(FOOT_FRACTIONS)
        ends = np.tile(self.start, (n, 1)), np.tile(self.end, (n, 1))
        bends = np.broadcast_to(bend, (n, *bend.shape))
        return swing_positions(*ends, np.full(n, height), FOOT_FRACTIONS, bends)

    def powers(self, tips: Array) -> tuple[Array, Array]:
        """Return Σ |τ q̇| (`ROWS` + 1, K) [W] on paths (rows, K, 3), and their misses (K,) [m]."""
        motion, missed = self.motion(tips)
        power: Array = np.abs(self.load(motion).torques * motion.speeds).sum(axis=-1)
        return power, missed

    def works(self, tips: Array) -> tuple[Array, Array]:
        """Return ∫ Σ |τ q̇| dt (K,) [J] of paths (rows, K, 3), and their misses (K,) [m]."""
        power, missed = self.powers(tips)
        # Trapezoidal rule.
        work: Array = (power.sum(axis=0) - 0.5 * (power[0] + power[-1])) * self.dt
        return work, missed
