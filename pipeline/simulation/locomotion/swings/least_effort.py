"""Least effort: the way of a swinging foot that takes the least work.

What is varied is how high the foot is lifted, where along the swing its arch is highest,
and whether it hurries early or late; where it begins and ends, how long it takes and that
it clears the ground stay as they are. A coarse grid is looked at as one batch, then the
best of it is refined, each time by half the step. The plain swing is one of those looked
at, so the best is never worse.

Source: Sims 1987, 7.3.2, where the effort is the integral of force over time; that is no
work. Here it is ∫ Σ |τ q̇| dt.
"""

from __future__ import annotations

import itertools

import numpy as np

from pipeline.simulation.curves import bump, ease
from pipeline.simulation.locomotion.swings.bend import KNOTS, POINTS, bend_through
from pipeline.simulation.locomotion.swings.swing import lift_to_clear
from pipeline.simulation.locomotion.swings.trial import SwingTrial
from pipeline.simulation.spatial import UP, Array
from pipeline.simulation.terrain import Ground

PLAIN = np.array([1.0, 0.0, 0.0])
"""Height as a part of the step height, how early the arch is highest, how early the foot
hurries: the plain swing's."""

LOWEST, HIGHEST = np.array([0.5, -0.6, -0.5]), np.array([1.4, 0.6, 0.5])
"""Bounds of them. From 1 on a part of the swing would run backward."""

GRID = [0.6, 1.0], [-0.35, 0.0, 0.35], [-0.25, 0.0, 0.25]
STEPS = np.array([0.2, 0.18, 0.13])
"""Of the first refinement."""

REFINEMENTS = 3

REACHED = 1e-3
"""Distance that a leg may lack of a way, in its lengths, where the plain swing lacks less."""


def least_effort(
    trial: SwingTrial, ground: Ground, sole: float, step_height: float
) -> tuple[float, Array]:
    """Return height [m] and bend of the swing that takes the least work.

    Args:
        trial: the swing.
        ground: that is to be cleared.
        sole: radius of the foot [m].
        step_height: of the plain swing on level ground [m].
    """
    asked = _Asked(trial, ground, sole, step_height)
    grid = [PLAIN, *(np.array(row) for row in itertools.product(*GRID))]
    best, cost = asked.best(grid)
    step = STEPS
    for _ in range(REFINEMENTS):
        moved = [best[0] + sign * step * axis for axis in np.eye(3) for sign in (-1.0, 1.0)]
        near, less = asked.best([np.clip(row, LOWEST, HIGHEST) for row in moved])
        if less < cost:
            best, cost = near, less
        step = 0.5 * step
    return best[1], best[2]


class _Asked:
    """What the ways of one swing are measured by."""

    def __init__(self, trial: SwingTrial, ground: Ground, sole: float, least: float) -> None:
        self.trial = trial
        self.ground = ground
        self.sole = sole
        self.least = least

    def best(self, rows: list[Array]) -> tuple[tuple[Array, float, Array], float]:
        """Return parameters, height and bend of the best of some ways, and its work [J]."""
        trial = self.trial
        ways = [(row, *self._way(row)) for row in rows]
        tips = np.stack([trial.tips(height, bend) for _, height, bend in ways], axis=1)
        work, left = trial.works(tips)
        worst = REACHED * float(trial.model.batch.lengths[0]) + left[0]
        work = np.where(left <= worst, work, np.inf)
        number = int(np.argmin(work))
        return ways[number], float(work[number])

    def _way(self, row: Array) -> tuple[float, Array]:
        """Return height and bend of the way with parameters `row` (3,)."""
        trial, (part, early, hurry) = self.trial, row
        least = float(part) * self.least
        if not (early or hurry):
            bend = np.zeros((POINTS, 3))
            return self._lift(least, bend), bend
        along = ease(_warped(KNOTS, hurry)) - ease(KNOTS)
        level = along[:, None] * (trial.end - trial.start)
        height = self._lift(least, bend_through(level))
        arch = bump(_warped(KNOTS, early)) - bump(KNOTS)
        bend = bend_through(level + height * arch[:, None] * UP)
        return max(height, self._lift(least, bend)), bend

    def _lift(self, least: float, bend: Array) -> float:
        ends = self.trial.start, self.trial.end
        # A lower arch is to clear the ground by no less than the plain one.
        return lift_to_clear(self.ground, *ends, self.sole, least, bend, 0.4 * self.least)


def _warped(s: Array, early: float) -> Array:
    """Map 0..1 to itself, what is at the middle coming sooner with `early` above 0."""
    result: Array = s + early * s * (1.0 - s)
    return result
