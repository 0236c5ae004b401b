"""Inverse kinematics of a herd's legs, with feet in the air kept out of the ground.

Feet on the ground stay where they stand. Feet in the air come as near to their goals as the legs
allow, and are lifted out of the ground. Where that fails, because a low body cannot fold its knees
or a wall leaves no room above, the nearest free place that the leg reaches is searched.

Source: Sims 1987, 7.4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.tip_ik import TipSolution, solve_each_tip, solve_tips
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.swing.swing_trajectory import lowest_center_height
from pipeline.simulation.spatial import Array, turn, turn_inverse
from pipeline.simulation.terrain import Ground


@dataclass(frozen=True, slots=True)
class FootLift:
    """Constants of the lifting of feet out of the ground.

    Attributes:
        max_stretch: greatest stretch of a leg in the air, in its length.
        min_fold: least fold of a leg in the air, in its folded length.
        missed_distance: of a foot in the air from its goal, beyond which the ground is tested [m].
        max_lifts: number of attempts to lift a foot.
        min_depth: depth in the ground from which a foot is lifted [m].
    """

    max_stretch: float = 0.985
    min_fold: float = 1.01
    missed_distance: float = 1e-4
    max_lifts: int = 8
    min_depth: float = 2e-4


@dataclass(frozen=True, slots=True)
class FreePlaceSearch:
    """Constants of the search for the free place of a foot.

    Attributes:
        tolerance: distance of a foot from a place that it still reaches [m].
        height: least height of a free foot above the ground [m].
        latitudes, longitudes: directions searched, from top to bottom and around the hip.
        stretches: distances searched, in leg lengths; at least the folded length.
    """

    tolerance: float = 1e-4
    height: float = 2e-4
    latitudes: int = 9
    longitudes: int = 16
    stretches: tuple[float, ...] = (0.97, 0.85, 0.7, 0.55, 0.4, 0.28)


FOOT_LIFT, FREE_PLACE_SEARCH = FootLift(), FreePlaceSearch()


class LegSolver:
    """Solves the legs of one herd.

    Attributes:
        herd: the creatures.
        ground: that feet stay above.
        folds: (L,) least distances from hip to foot [m].
        directions: (n, L, 3) of the last links, see `solve_tips`.
    """

    def __init__(
        self, herd: Herd, ground: Ground, folds: Array, directions: Array | None = None
    ) -> None:
        self.herd, self.ground, self.folds = herd, ground, folds
        self.directions = directions

    def solve(
        self, goals: Array, R: Array, p: Array, down: NDArray[np.bool_], limp: NDArray[np.bool_]
    ) -> TipSolution:
        """Return legs at goals (n, L, 3), or as near as they come.

        Args:
            goals: relative to the bodies [m].
            R: (n, C, 3, 3) orientations of the bodies.
            p: (n, C, 3) places of the bodies [m].
            down: (n, L) feet on the ground.
            limp: (n, L) feet of fallen creatures.
        """
        clamped = self._clamp_reach(goals, down)
        moved = np.abs(clamped - goals).max(axis=-1) > FOOT_LIFT.missed_distance
        return self._lift_feet(clamped, R, p, down | limp, moved)

    def _lift_feet(
        self,
        goals: Array,
        R: Array,
        p: Array,
        fixed: NDArray[np.bool_],
        clamped: NDArray[np.bool_],
    ) -> TipSolution:
        """Return legs at goals (n, L, 3), with feet that miss them lifted out of the ground.

        Args:
            goals: relative to the bodies [m].
            R: (n, C, 3, 3) orientations of the bodies.
            p: (n, C, 3) places of the bodies [m].
            fixed: (n, L) feet that are not moved.
            clamped: (n, L) feet whose goals were changed.
        """
        herd = self.herd
        solution = solve_tips(herd.legs, herd.chains, goals, self.directions)
        for _ in range(FOOT_LIFT.max_lifts):
            misses = clamped | (solution.residual > FOOT_LIFT.missed_distance)
            rows, legs = np.nonzero(~fixed & misses)
            rows, legs, depth = self._buried_feet(solution, R, p, rows, legs)
            if not len(rows):
                break
            c = herd.owner[legs]
            up = np.zeros((len(rows), 3))
            up[:, 1] = 1.3 * depth + 0.01 * herd.legs.lengths[legs]
            goals[rows, legs] += turn_inverse(R[rows, c], up)
            self._resolve(solution, goals, rows)
        else:
            misses = clamped | (solution.residual > FOOT_LIFT.missed_distance)
            self._relocate_feet(solution, goals, R, p, ~fixed & misses)
        return solution

    def _relocate_feet(
        self,
        solution: TipSolution,
        goals: Array,
        R: Array,
        p: Array,
        candidates: NDArray[np.bool_],
    ) -> None:
        """Move feet (n, L) that are still in the ground to free places."""
        herd = self.herd
        rows, legs = self._buried_feet(solution, R, p, *np.nonzero(candidates))[:2]
        for row, leg in zip(rows.tolist(), legs.tolist(), strict=True):
            c, folded_length = herd.owner[leg], float(self.folds[leg])
            place = free_foot_place(
                herd, self.ground, R[row, c], p[row, c], leg, goals[row, leg], folded_length
            )
            if place is not None:
                goals[row, leg] = place
        if len(rows):
            self._resolve(solution, goals, rows)

    def _buried_feet(
        self,
        solution: TipSolution,
        R: Array,
        p: Array,
        rows: NDArray[np.int64],
        legs: NDArray[np.int64],
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Return which of some feet are in the ground, and how deep [m]."""
        c = self.herd.owner[legs]
        # The tips (k, 3) of some legs, in the frames of their bodies [m].
        batch = self.herd.legs
        last = batch.is_joint[legs].sum(axis=-1) - 1
        X = solution.X_BJ[rows, legs, last]
        arm = batch.tips[legs] - batch.places[legs, last]
        tips = p[rows, c] + turn(R[rows, c], (X[:, :3, 3] + turn(X[:, :3, :3], arm)))
        depth = (
            lowest_center_height(self.ground, tips[:, 0], tips[:, 2], self.herd.foot_radius[legs])
            - tips[:, 1]
        )
        is_buried = depth > FOOT_LIFT.min_depth
        return rows[is_buried], legs[is_buried], depth[is_buried]

    def _resolve(self, solution: TipSolution, goals: Array, rows: NDArray[np.int64]) -> None:
        """Solve the legs of some rows again for goals (n, L, 3)."""
        chosen = np.unique(rows)
        directions = None if self.directions is None else self.directions[chosen]
        result = solve_tips(self.herd.legs, self.herd.chains, goals[chosen], directions)
        for name in ("q", "X_BJ", "residual"):
            getattr(solution, name)[chosen] = getattr(result, name)

    def _clamp_reach(self, goals: Array, down: NDArray[np.bool_]) -> Array:
        """Return goals (n, L, 3) in the air, limited to what legs can stretch and fold [m]."""
        herd = self.herd
        offset = goals - herd.hips
        distance = np.maximum(np.sqrt((offset * offset).sum(axis=-1)), 1e-9)
        longest = FOOT_LIFT.max_stretch * herd.legs.lengths
        shortest = FOOT_LIFT.min_fold * self.folds
        near = ~down & (distance < shortest)
        k = np.where(down, 1.0, np.minimum(distance, longest) / distance)
        offset = k[..., None] * offset
        if near.any():
            # To the side: the ground is below a low body.
            side = (herd.legs.tips - herd.hips)[:, [0, 2]] + 1e-6
            side = np.broadcast_to(side, (*near.shape, 2))[near] + 4.0 * offset[near][:, [0, 2]]
            side /= np.maximum(np.sqrt((side * side).sum(axis=-1)), 1e-9)[:, None]
            room = np.broadcast_to(shortest, near.shape)[near] ** 2 - offset[near][:, 1] ** 2
            out = np.sqrt(np.maximum(room, 0.0))[:, None] * side
            offset[near] = np.stack([out[:, 0], offset[near][:, 1], out[:, 1]], axis=-1)
        # Feet that are down keep their exact goals, whatever other legs do.
        return np.where(down[..., None], goals, herd.hips + offset)


def free_foot_place(
    herd: Herd, ground: Ground, R: Array, p: Array, leg: int, goal: Array, folded_length: float
) -> Array | None:
    """Return the nearest free place (3,) of a foot in the frame of its body, or None [m].

    Args:
        herd: the creatures.
        ground: that the foot is to be above.
        R: (3, 3) orientation of the body.
        p: (3,) place of the body [m].
        leg: number of the leg in the herd.
        goal: (3,) of the foot, in the frame of the body [m].
        folded_length: least distance from hip to foot [m].
    """
    search = FREE_PLACE_SEARCH
    hip, length = herd.hips[leg], float(herd.legs.lengths[leg])
    distances = np.array(
        [k * length for k in search.stretches if k * length > folded_length]
        + [1.02 * folded_length]
    )
    # Unit vectors (k, 3) all around.
    y = np.linspace(-1.0, 1.0, search.latitudes)
    angle = np.arange(search.longitudes) * (2.0 * math.pi / search.longitudes)
    r = np.sqrt(1.0 - y * y)[:, None]
    level = np.broadcast_to(y[:, None], (search.latitudes, search.longitudes))
    result: Array = np.stack([r * np.cos(angle), level, r * np.sin(angle)], axis=-1)
    places = hip + (distances[:, None, None] * result.reshape(-1, 3)).reshape(-1, 3)
    places = places[np.argsort(((places - goal) ** 2).sum(axis=-1), kind="stable")]
    feet = places @ R.T + p
    lowest = lowest_center_height(ground, feet[:, 0], feet[:, 2], herd.foot_radius[leg])
    places = places[feet[:, 1] >= lowest + search.height]
    legs = np.full(len(places), leg)
    _, error = solve_each_tip(herd.legs, herd.chains, legs, places)
    reached: NDArray[np.int64] = np.flatnonzero(error <= search.tolerance)
    return places[reached[0]] if len(reached) else None
