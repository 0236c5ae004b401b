"""Reaching: from where bodies and feet are to how the legs between them bend.

Feet on the ground are where they stand; those in the air come as near to where they are to be
as legs allow, and not into the ground.

Source: Sims 1987, 7.4.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.rest_ik import (
    RestSolution,
    solve_each_near_rest,
    solve_near_rest,
)
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.swing.swing_trajectory import lowest_center_height
from pipeline.simulation.spatial import Array, turn, unturn
from pipeline.simulation.terrain import Ground

MAX_STRETCH, MIN_FOLD = 0.985, 1.01
"""How far legs stretch at most in the air, in their lengths, and how far they fold, in what
they can."""


UNREACHED_DISTANCE, MAX_LIFTS = 1e-4, 8
"""Distance of a foot in the air from where it is to be from which the ground is looked at [m],
and how often it is lifted out of that."""

LIFT_DEPTH = 2e-4
"""Depth of a foot in the ground from which it is lifted [m]."""


class LegSolver:
    """The legs of one herd.

    Attributes:
        herd: whose they are.
        ground: that feet are kept above.
        folds: (L,) least distances from hips to feet [m].
    """

    def __init__(self, herd: Herd, ground: Ground, folds: Array) -> None:
        self.herd, self.ground, self.folds = herd, ground, folds

    def settled(
        self, goals: Array, R: Array, p: Array, down: NDArray[np.bool_], limp: NDArray[np.bool_]
    ) -> RestSolution:
        """Return legs at goals (n, L, 3), or as near to them as they come.

        Args:
            goals: relative to the bodies [m].
            R: (n, C, 3, 3) and
            p: (n, C, 3) of the bodies [m].
            down: (n, L) feet that are where they are.
            limp: (n, L) those of who has fallen.
        """
        reined = self._reined(goals, down)
        moved = np.abs(reined - goals).max(axis=-1) > UNREACHED_DISTANCE
        return self._above(reined, R, p, down | limp, moved)

    def _above(
        self,
        goals: Array,
        R: Array,
        p: Array,
        leave: NDArray[np.bool_],
        reined: NDArray[np.bool_],
    ) -> RestSolution:
        """Return legs at their goals (n, L, 3); those that miss them are kept above the ground.

        Args:
            goals: relative to the bodies [m].
            R: (n, C, 3, 3) and
            p: (n, C, 3) of the bodies [m].
            leave: (n, L) whose feet are where they are.
            reined: (n, L) whose feet are not where they were to be.
        """
        herd = self.herd
        found = solve_near_rest(herd.legs, herd.chains, goals)
        for _ in range(MAX_LIFTS):
            rows, legs = np.nonzero(~leave & (reined | (found.residual > UNREACHED_DISTANCE)))
            rows, legs, deep = self._in_the_ground(found, R, p, rows, legs)
            if not len(rows):
                break
            c = herd.owner[legs]
            up = np.zeros((len(rows), 3))
            up[:, 1] = 1.3 * deep + 0.01 * herd.legs.lengths[legs]
            goals[rows, legs] += unturn(R[rows, c], up)
            self._again(found, goals, rows)
        else:
            self._in_refuges(
                found, goals, R, p, ~leave & (reined | (found.residual > UNREACHED_DISTANCE))
            )
        return found

    def _in_refuges(
        self, found: RestSolution, goals: Array, R: Array, p: Array, which: NDArray[np.bool_]
    ) -> None:
        """Bring feet (n, L) that are in the ground yet to where they are out of it."""
        herd = self.herd
        rows, legs = self._in_the_ground(found, R, p, *np.nonzero(which))[:2]
        for row, leg in zip(rows.tolist(), legs.tolist(), strict=True):
            c, fold = herd.owner[leg], float(self.folds[leg])
            place = free_foot_place(
                herd, self.ground, R[row, c], p[row, c], leg, goals[row, leg], fold
            )
            if place is not None:
                goals[row, leg] = place
        if len(rows):
            self._again(found, goals, rows)

    def _in_the_ground(
        self,
        found: RestSolution,
        R: Array,
        p: Array,
        rows: NDArray[np.int64],
        legs: NDArray[np.int64],
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Return which of some feet are in the ground, and how deep [m]."""
        c = self.herd.owner[legs]
        tips = p[rows, c] + turn(R[rows, c], self._tips(found, rows, legs))
        deep = (
            lowest_center_height(self.ground, tips[:, 0], tips[:, 2], self.herd.sole[legs])
            - tips[:, 1]
        )
        low = deep > LIFT_DEPTH
        return rows[low], legs[low], deep[low]

    def _again(self, found: RestSolution, goals: Array, rows: NDArray[np.int64]) -> None:
        """Bring the legs of some rows to their goals (n, L, 3) anew."""
        some = np.unique(rows)
        again = solve_near_rest(self.herd.legs, self.herd.chains, goals[some])
        for name in ("q", "X_BJ", "residual"):
            getattr(found, name)[some] = getattr(again, name)

    def _tips(self, found: RestSolution, rows: NDArray[np.int64], legs: NDArray[np.int64]) -> Array:
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
        most, least = MAX_STRETCH * herd.legs.lengths, MIN_FOLD * self.folds
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
        # Feet that are down stay where they are to the last bit, whoever is beside them.
        return np.where(down[..., None], goals, herd.hips + way)


SOLVED_DISTANCE = 1e-4
"""Distance of a foot from a place that it does not come to [m]."""

FREE_HEIGHT = 2e-4
"""Height above the ground of a foot that is out of it, at least [m]."""

LATITUDES, LONGITUDES = 9, 16
"""Directions in which a leg is looked for, from up to down and round the hip."""

STRETCH_LEVELS = (0.97, 0.85, 0.7, 0.55, 0.4, 0.28)
"""How far it is stretched there, in its length; not farther than it folds."""


def free_foot_place(
    herd: Herd, ground: Ground, R: Array, p: Array, leg: int, goal: Array, fold: float
) -> Array | None:
    """Return a place (3,) for a foot in the frame of its body, None if there is no better one [m].

    Args:
        herd: that the leg belongs to.
        ground: that the foot is to be out of.
        R: (3, 3) and
        p: (3,) of the body [m].
        leg: its number in the herd.
        goal: (3,) where the foot was to be, in the frame of the body [m].
        fold: least distance from hip to foot [m].
    """
    hip, length = herd.hips[leg], float(herd.legs.lengths[leg])
    far = np.array([k * length for k in STRETCH_LEVELS if k * length > fold] + [1.02 * fold])
    places = hip + (far[:, None, None] * _sphere_directions()).reshape(-1, 3)
    places = places[np.argsort(((places - goal) ** 2).sum(axis=-1), kind="stable")]
    feet = places @ R.T + p
    least = lowest_center_height(ground, feet[:, 0], feet[:, 2], herd.sole[leg])
    places = places[feet[:, 1] >= least + FREE_HEIGHT]
    legs = np.full(len(places), leg)
    _, gap = solve_each_near_rest(herd.legs, herd.chains, legs, places)
    good: NDArray[np.int64] = np.flatnonzero(gap <= SOLVED_DISTANCE)
    return places[good[0]] if len(good) else None


def _sphere_directions() -> Array:
    """Return unit vectors (k, 3) all around."""
    y = np.linspace(-1.0, 1.0, LATITUDES)
    angle = np.arange(LONGITUDES) * (2.0 * math.pi / LONGITUDES)
    r = np.sqrt(1.0 - y * y)[:, None]
    level = np.broadcast_to(y[:, None], (LATITUDES, LONGITUDES))
    result: Array = np.stack([r * np.cos(angle), level, r * np.sin(angle)], axis=-1)
    return result.reshape(-1, 3)
