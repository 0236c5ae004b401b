"""Goal misses: keys that a posed limb misses, and goals that it loses."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.figure_frames import FigureFrames, LimbParent
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.limb_goals import LimbGoals
from pipeline.simulation.figures.pose_plan import JointRun, PointRun
from pipeline.simulation.keyframe_track import SAME_TIME
from pipeline.simulation.spatial import Array

FULL_WEIGHT = 1.0 - 1e-9
"""Weight from which a run has taken over completely."""

MISS_FRACTION, MISS_ANGLE = 1e-2, 1e-2
"""Misses that are worth a note: of places, in lengths of the limb, and of angles [rad]."""


@dataclass(frozen=True, slots=True)
class GoalMiss:
    """A goal that a limb misses.

    Attributes:
        row: of the miss.
        limb: name of the limb.
        part: the node or joint, as its author named it.
        at: time of the key [s]; None where a goal is lost that was held.
        gap: [m], or [rad] of directions and joints that turn.
        is_place: whether it is a distance.
        is_slow: whether the joints turn too slowly; else it is out of reach.
        nearest: (3,) the nearest place that can be reached, in the frame of the key [m]; None of
            other goals.
    """

    row: int
    limb: str
    part: str
    at: float | None
    gap: float
    is_place: bool
    is_slow: bool
    nearest: Array | None = None

    @property
    def text(self) -> str:
        """A sentence for the author."""
        distance = f"{self.gap:.2g} m" if self.is_place else f"{math.degrees(self.gap):.2g} degrees"
        reason = "its joints would have to turn faster" if self.is_slow else "it is out of reach"
        if self.at is None:
            return f"{self.part} no longer keeps its goal, by {distance}: {reason}"
        if self.nearest is not None and not self.is_slow:
            place = ", ".join(f"{value:.3g}" for value in self.nearest)
            reason += f"; [{place}] is the nearest place within it"
        return f"{self.part} misses its key at {self.at:g} s by {distance}: {reason}"


class MissWatch:
    """Finds the misses of one limb, batch of rows by batch of rows.

    Args:
        limb: name of the limb.
        batch: the limb alone.
        runs: its points, then its joints.
    """

    def __init__(self, limb: str, batch: LimbBatch, runs: Sequence[PointRun | JointRun]) -> None:
        self.limb, self.batch, self.runs = limb, batch, runs
        self._missing = np.zeros(len(runs), dtype=bool)

    def misses(
        self,
        goals: LimbGoals,
        q: Array,
        wanted: Array,
        weights: Array,
        frames: FigureFrames,
        parent: LimbParent,
    ) -> Iterator[GoalMiss]:
        """Return keys that are missed, and goals that are lost while they are to be held.

        Args:
            goals: of n rows.
            q: (n, k) joint values [rad or m].
            wanted: (n, k) joint values if joints could turn as fast as need be.
            weights: (n, m) of each point, then of each joint.
            frames: of the figure.
            parent: of the limb.
        """
        whole = weights > FULL_WEIGHT
        rows = np.flatnonzero(whole.any(axis=1))
        if not len(rows):
            self._missing[:] = False
            return
        gaps = np.zeros(weights.shape)
        gaps[rows] = goals.rows(rows).misses(self.batch, self.batch.pose(q[rows]))
        size = float(self.batch.lengths[0])
        for i, asked in enumerate(self.runs):
            place = asked if isinstance(asked, PointRun) and asked.goal == "reach" else None
            most = MISS_FRACTION * size if place else MISS_ANGLE
            missed = (gaps[:, i] > most) & whole[:, i]
            before = np.logical_or.accumulate(np.append(self._missing[i], missed[:-1]))
            before &= whole[:, i]
            # A goal that is held is lost once, however a body sways.
            self._missing[i] = (before[-1] or missed[-1]) and whole[-1, i]
            if not missed.any():
                continue
            keys = asked.run.track.times
            passed = np.searchsorted(keys, frames.times + SAME_TIME, side="right")
            earlier = np.searchsorted(keys, frames.times - frames.dt + SAME_TIME, side="right")
            is_held = (passed == len(keys)) & (earlier == passed)
            for row in np.flatnonzero(missed & ((passed > earlier) | (is_held & ~before))).tolist():
                at = float(keys[passed[row] - 1]) if passed[row] > earlier[row] else None
                yield GoalMiss(
                    row=row,
                    limb=self.limb,
                    part=asked.name,
                    at=at,
                    gap=float(gaps[row, i]),
                    is_place=place is not None,
                    is_slow=bool(self._gap(goals, wanted, row, i) <= most),
                    nearest=self._place(place, wanted, frames, parent, row) if place else None,
                )

    def _gap(self, goals: LimbGoals, q: Array, row: int, number: int) -> float:
        """Return the gap of one goal in one row."""
        chosen = np.array([row])
        gaps = goals.rows(chosen).misses(self.batch, self.batch.pose(q[chosen]))
        return float(gaps[0, number])

    def _place(
        self, asked: PointRun, q: Array, frames: FigureFrames, parent: LimbParent, row: int
    ) -> Array:
        """Return where a node is (3,) in one row, in the frame of its values."""
        R_WG, p_WG = frames.frame(asked.frame)
        there = asked.point.at(self.batch, self.batch.pose(q[row : row + 1]))[0]
        on_body = parent.p_BP[row] + parent.R_BP[row] @ there
        result: Array = R_WG[row].T @ (frames.p_WB[row] + frames.R_WB[row] @ on_body - p_WG[row])
        return result
