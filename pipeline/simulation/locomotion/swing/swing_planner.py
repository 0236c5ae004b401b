"""Swing plans: how feet swing whose creatures do not take the plain spline.

A swing is planned when its foot lifts, for the way that the body will go, and is then a
height and a bend, as the plain one is a height alone.

Source: Sims 1987, 7.3.2, 7.4 and 9.3.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.curves import bump, ease
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.locomotion.gaits.gait_transition import StepTiming
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress
from pipeline.simulation.locomotion.swing.passive_swing import passive
from pipeline.simulation.locomotion.swing.swing_dynamics import PARTS, LegModel, SwingTrial
from pipeline.simulation.locomotion.swing.swing_trajectory import (
    KNOTS,
    POINTS,
    clearance_height,
    fit_offset,
)
from pipeline.simulation.spatial import UP, Array
from pipeline.simulation.terrain import Ground
from pipeline.spec.creature import Creature

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
        height = self._lift(least, fit_offset(level))
        arch = bump(_warped(KNOTS, early)) - bump(KNOTS)
        bend = fit_offset(level + height * arch[:, None] * UP)
        return max(height, self._lift(least, bend)), bend

    def _lift(self, least: float, bend: Array) -> float:
        ends = self.trial.start, self.trial.end
        # A lower arch is to clear the ground by no less than the plain one.
        return clearance_height(self.ground, *ends, self.sole, least, bend, 0.4 * self.least)


def _warped(s: Array, early: float) -> Array:
    """Map 0..1 to itself, what is at the middle coming sooner with `early` above 0."""
    result: Array = s + early * s * (1.0 - s)
    return result


Planner = Callable[[SwingTrial, Ground, float, float], tuple[float, Array]]

PLANNERS: Mapping[str, Planner] = {"least-effort": least_effort, "passive": passive}
"""By the words of the language; `spline` needs none."""


@dataclass(frozen=True, eq=False)
class SwingRequest:
    """A swing that is about to begin.

    Attributes:
        step: when it swings.
        start, end: (3,) tips [m].
        way: that the body has gone at its begin [m].
        drive: part of its speed at which the body goes.
        step_height: height of the arch on level ground [m].
    """

    step: StepTiming
    start: Array
    end: Array
    way: float
    drive: float
    step_height: float


class SwingPlanner:
    """Plans swings for a herd of whom some ask for it."""

    def __init__(self, kinds: Mapping[int, str], going: RouteProgress, ground: Ground) -> None:
        self.kinds = kinds
        self.going = going
        self.herd = going.herd
        self.ground = ground

    @staticmethod
    def of(
        cast: Sequence[tuple[int, Creature, Figure]], going: RouteProgress, ground: Ground
    ) -> SwingPlanner | None:
        """Return the plans of a herd, None if all swing plainly."""
        kinds = {
            c: member.walk.swing
            for c, (_, member, _) in enumerate(cast)
            if member.walk is not None and member.walk.swing in PLANNERS
        }
        return SwingPlanner(kinds, going, ground) if kinds else None

    @property
    def none(self) -> Array:
        """(L, m, 3) bends of swings that have none."""
        return np.zeros((len(self.herd.owner), POINTS, 3))

    @cached_property
    def _models(self) -> Mapping[int, LegModel]:
        """Of the legs whose swings are planned."""
        inertias = {c: FigureMass(self.herd.figures[c]) for c in self.kinds}
        return {
            leg: LegModel.of(self.herd, leg, inertias[int(c)])
            for leg, c in enumerate(self.herd.owner)
            if int(c) in self.kinds
        }

    def plan(
        self, leg: int, asked: SwingRequest, height: float, stoop: Array
    ) -> tuple[float, Array]:
        """Return height [m] and bend (m, 3) of a swing.

        Args:
            leg: which.
            asked: its swing.
            height: of the plain swing [m].
            stoop: (L,) how far bodies are lowered for the footholds of their legs [m].
        """
        herd, owner = self.herd, int(self.herd.owner[leg])
        if owner not in self.kinds:
            return height, np.zeros((POINTS, 3))
        # All legs of a body stoop together as in posing, where each comes and goes.
        low = float((stoop[herd.owner == owner] ** 4).sum() ** 0.25)
        trial, sole = self.trial(leg, asked, low), float(herd.sole[leg])
        return PLANNERS[self.kinds[owner]](trial, self.ground, sole, asked.step_height)

    def trial(self, leg: int, asked: SwingRequest, stoop: float) -> SwingTrial:
        """Return a swing as it can be tried beforehand, the body `stoop` lower [m]."""
        owner, step, going = int(self.herd.owner[leg]), asked.step, self.going
        moments, creature = step.up + PARTS * step.swing, np.full(len(PARTS), owner)
        ahead = going.paces.way(owner, step.up, moments) * math.sqrt(asked.drive)
        R, p = going.path.pose(creature, asked.way + ahead, moments, asked.drive)
        p[:, 1] -= stoop
        # Who has come to rest brings its feet down at their full pace.
        pace = math.sqrt(asked.drive) if asked.drive > 0.0 else 1.0
        time = step.swing * float(going.cycle[owner]) / pace
        return SwingTrial(self._models[leg], asked.start, asked.end, time, R, p)
