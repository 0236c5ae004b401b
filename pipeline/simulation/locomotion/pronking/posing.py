"""Posing: from where bodies and feet of pronkers are to where all their parts are.

Inverse kinematics joins feet to bodies, for dozens of moments at once; heads, tails and arms
do what they do on any creature.

Source: Sims 1987, 7.4.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.settling import Settled, settle
from pipeline.simulation.locomotion.carriage.bearing import Bearing
from pipeline.simulation.locomotion.carriage.carriage import Carriage
from pipeline.simulation.locomotion.carriage.idle import Idlers
from pipeline.simulation.locomotion.carriage.looking import Look, Rows
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.inventory import NodeTable
from pipeline.simulation.locomotion.pronking.refuges import refuge
from pipeline.simulation.locomotion.swings.sole import lowest
from pipeline.simulation.locomotion.ways.route import straight
from pipeline.simulation.spatial import Array, turn, unturn
from pipeline.simulation.terrain import Ground

LONGEST, SHORTEST = 0.985, 1.01
"""How far legs stretch at most in the air, in their lengths, and how far they fold, in what
they can."""

MISSES, LIFTINGS = 1e-4, 8
"""Distance of a foot in the air from where it is to be from which the ground is looked at [m],
and how often it is lifted out of that."""

LOW = 2e-4
"""Depth of a foot in the ground from which it is lifted [m]."""


@dataclass(frozen=True, eq=False)
class Moment:
    """A herd at one step.

    Attributes:
        step: its number.
        R: (C, 3, 3) and
        p: (C, 3) of the bodies [m].
        tips: (L, 3) feet [m].
        down: (L,) which are on the ground.
        phase, speed: (C,) of the jump, and over the ground [m/s].
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
    limp: NDArray[np.bool_]
    hanging: Mapping[int, Array] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Poses:
    """Where everything is at n moments: (n, J, 3), (n, J, 3, 3), (n, K) and (n, L) misses [m]."""

    positions: Array
    rotations: Array
    values: Array
    residual: Array


class Posing:
    """Works out the poses of one herd."""

    def __init__(
        self,
        herd: Herd,
        ground: Ground,
        idlers: Idlers,
        table: NodeTable,
        folds: Array,
        row_dt: float,
    ) -> None:
        self.ground = ground
        self.herd, self.idlers, self.table, self.folds = herd, idlers, table, folds
        self.row_dt = row_dt
        self.carriage = Carriage(herd, idlers, ground, row_dt)
        self.bearing = Bearing.neutral(len(herd.names))
        self._routes = [
            straight(start, float(angle))
            for start, angle in zip(herd.starts, herd.headings, strict=True)
        ]
        self._limp: Array | None = None

    def poses(self, moments: Sequence[Moment], looks: Mapping[int, Look], time: Array) -> Poses:
        """Return where everything is at `moments`, which are at times (n,) [s]."""
        herd = self.herd
        R, p, tips, phase, speed = (
            np.stack([getattr(moment, name) for moment in moments])
            for name in ("R", "p", "tips", "phase", "speed")
        )
        down = np.stack([moment.down for moment in moments])
        limp = np.stack([moment.limp for moment in moments])
        solution = self._settled(R, p, tips, down, limp)
        n, still = len(moments), np.zeros_like(phase)
        q = self.carriage.values(
            Rows(
                time,
                still,
                still,
                still,
                Bearing.stacked([self.bearing] * n),
                [self._routes] * n,
                [looks] * n,
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
        return Poses(
            p[:, self.table.owner] + turn(own, X_BN[..., :3, 3]),
            own @ X_BN[..., :3, :3],
            np.concatenate([phase, speed, solution.q[:, herd.legs.is_joint], q], axis=1),
            np.where(down, solution.residual, 0.0),
        )

    def legs(self, moment: Moment) -> Array:
        """Return the joint values (L, n) of legs at a moment [rad or m]."""
        R, p, tips = moment.R[None], moment.p[None], moment.tips[None]
        result: Array = self._settled(R, p, tips, moment.down[None], moment.limp[None]).q[0]
        return result

    def _settled(
        self,
        R: Array,
        p: Array,
        tips: Array,
        down: NDArray[np.bool_],
        limp: NDArray[np.bool_],
    ) -> Settled:
        """Return the legs at some moments; see `Moment`."""
        owner = self.herd.owner
        asked = unturn(R[:, owner], tips - p[:, owner])
        goals = self._reined(asked, down)
        reined = np.abs(goals - asked).max(axis=-1) > MISSES
        return self._above(goals, R, p, down | limp[:, owner], reined)

    def _let_hang(self, legs: Settled, q: Array, row: int, c: int, values: Array) -> None:
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

    def _above(
        self,
        goals: Array,
        R: Array,
        p: Array,
        leave: NDArray[np.bool_],
        reined: NDArray[np.bool_],
    ) -> Settled:
        """Return legs at their goals (n, L, 3); those that miss them are kept above the ground.

        Args:
            goals: relative to the bodies [m].
            R: (n, C, 3, 3) and
            p: (n, C, 3) of the bodies [m].
            leave: (n, L) whose feet are where they are.
            reined: (n, L) whose feet are not where they were to be.
        """
        herd = self.herd
        found = settle(herd.legs, herd.chains, goals)
        for _ in range(LIFTINGS):
            rows, legs = np.nonzero(~leave & (reined | (found.residual > MISSES)))
            rows, legs, deep = self._in_the_ground(found, R, p, rows, legs)
            if not len(rows):
                break
            c = herd.owner[legs]
            up = np.zeros((len(rows), 3))
            up[:, 1] = 1.3 * deep + 0.01 * herd.legs.lengths[legs]
            goals[rows, legs] += unturn(R[rows, c], up)
            self._again(found, goals, rows)
        else:
            self._in_refuges(found, goals, R, p, ~leave & (reined | (found.residual > MISSES)))
        return found

    def _in_refuges(
        self, found: Settled, goals: Array, R: Array, p: Array, which: NDArray[np.bool_]
    ) -> None:
        """Bring feet (n, L) that are in the ground yet to where they are out of it."""
        herd = self.herd
        rows, legs = self._in_the_ground(found, R, p, *np.nonzero(which))[:2]
        for row, leg in zip(rows.tolist(), legs.tolist(), strict=True):
            c, fold = herd.owner[leg], float(self.folds[leg])
            place = refuge(herd, self.ground, R[row, c], p[row, c], leg, goals[row, leg], fold)
            if place is not None:
                goals[row, leg] = place
        if len(rows):
            self._again(found, goals, rows)

    def _in_the_ground(
        self, found: Settled, R: Array, p: Array, rows: NDArray[np.int64], legs: NDArray[np.int64]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Return which of some feet are in the ground, and how deep [m]."""
        c = self.herd.owner[legs]
        tips = p[rows, c] + turn(R[rows, c], self._tips(found, rows, legs))
        deep = lowest(self.ground, tips[:, 0], tips[:, 2], self.herd.sole[legs]) - tips[:, 1]
        low = deep > LOW
        return rows[low], legs[low], deep[low]

    def _again(self, found: Settled, goals: Array, rows: NDArray[np.int64]) -> None:
        """Bring the legs of some rows to their goals (n, L, 3) anew."""
        some = np.unique(rows)
        again = settle(self.herd.legs, self.herd.chains, goals[some])
        for name in ("q", "X_BJ", "residual"):
            getattr(found, name)[some] = getattr(again, name)

    def _tips(self, found: Settled, rows: NDArray[np.int64], legs: NDArray[np.int64]) -> Array:
        """Return where some tips (k, 3) came to, in the frames of their bodies [m]."""
        batch = self.herd.legs
        last = batch.is_joint[legs].sum(axis=-1) - 1
        X = found.X_BJ[rows, legs, last]
        arm = batch.tips[legs] - batch.places[legs, last]
        result: Array = X[:, :3, 3] + turn(X[:, :3, :3], arm)
        return result

    def _reined(self, goals: Array, down: NDArray[np.bool_]) -> Array:
        """Return feet (n, L, 3) in the air so that no leg stretches or folds too far [m]."""
        herd = self.herd
        way = goals - herd.hips
        far = np.maximum(np.sqrt((way * way).sum(axis=-1)), 1e-9)
        most, least = LONGEST * herd.legs.lengths, SHORTEST * self.folds
        near = ~down & (far < least)
        k = np.where(down, 1.0, np.minimum(far, most) / far)
        way = k[..., None] * way
        if near.any():
            # Out to the side, for below a low body is the ground.
            side = (herd.legs.tips - herd.hips)[:, [0, 2]] + 1e-6
            side = np.broadcast_to(side, (*near.shape, 2))[near] + 4.0 * way[near][:, [0, 2]]
            side /= np.maximum(np.sqrt((side * side).sum(axis=-1)), 1e-9)[:, None]
            room = np.broadcast_to(least, near.shape)[near] ** 2 - way[near][:, 1] ** 2
            out = np.sqrt(np.maximum(room, 0.0))[:, None] * side
            way[near] = np.stack([out[:, 0], way[near][:, 1], out[:, 1]], axis=-1)
        result: Array = herd.hips + way
        return result

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
