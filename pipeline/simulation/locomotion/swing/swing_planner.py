"""Swing planner: swings that are not plain arches, of least effort or passive.

A swing is planned at lift-off, for the trajectory that the body will have. It is an arch and a
bend, as the plain one is an arch alone.

The swing of least effort varies the height of the arch, where along the swing it is highest, and
whether the foot hurries early or late; ends, duration and ground clearance stay. A coarse grid is
tried as one batch, then the best is refined, each time by half the step. The plain swing is among
the candidates, so the best is never worse.

Source: Sims 1987, 7.3.2, 7.4 and 9.3. His effort is the integral of force over time, which is not a
work; here it is ∫ Σ |τ q̇| dt.
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
from pipeline.simulation.locomotion.foot_placement.foothold_search import Foothold
from pipeline.simulation.locomotion.foot_placement.step_batch import StepRequest
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress
from pipeline.simulation.locomotion.swing.passive_swing import plan_passive_swing
from pipeline.simulation.locomotion.swing.swing_dynamics import FRACTIONS, LegModel, SwingTrial
from pipeline.simulation.locomotion.swing.swing_trajectory import (
    CLEARANCE,
    KNOTS,
    POINTS,
    clearance_height,
    fit_bend,
)
from pipeline.simulation.spatial import UP, Array
from pipeline.simulation.terrain import Ground
from pipeline.spec.creature import Creature

# Parameters of the plain swing: height in step heights, how early the arch is highest, how early
# the foot hurries; and their bounds. From 1 on a part of the swing would run backward.
PLAIN = np.array([1.0, 0.0, 0.0])
LOWER_BOUNDS, UPPER_BOUNDS = np.array([0.5, -0.6, -0.5]), np.array([1.4, 0.6, 0.5])

# Coarse grid, and first step and number of the refinements.
GRID = [0.6, 1.0], [-0.35, 0.0, 0.35], [-0.25, 0.0, 0.25]
FIRST_STEP, REFINEMENTS = np.array([0.2, 0.18, 0.13]), 3

# Miss of a leg that is allowed beyond the plain swing's, in leg lengths.
EXTRA_MISS = 1e-3

Planner = Callable[[SwingTrial, Ground, float, float], tuple[float, Array]]


# --- least effort -------------------------------------------------------------------


def plan_least_effort_swing(
    trial: SwingTrial, ground: Ground, foot_radius: float, step_height: float
) -> tuple[float, Array]:
    """Return height [m] and bend of the swing that takes the least work.

    Args:
        trial: the swing.
        ground: under it.
        foot_radius: [m].
        step_height: of the plain swing on level ground [m].
    """
    candidates = _Candidates(trial, ground, foot_radius, step_height)
    best, work = candidates.best([PLAIN, *(np.array(row) for row in itertools.product(*GRID))])
    step = FIRST_STEP
    for _ in range(REFINEMENTS):
        moved = [best[0] + sign * step * axis for axis in np.eye(3) for sign in (-1.0, 1.0)]
        bounded = [np.clip(row, LOWER_BOUNDS, UPPER_BOUNDS) for row in moved]
        near, less = candidates.best(bounded)
        if less < work:
            best, work = near, less
        step = 0.5 * step
    return best[1], best[2]


@dataclass(frozen=True, eq=False)
class _Candidates:
    """The candidate paths of one swing."""

    trial: SwingTrial
    ground: Ground
    foot_radius: float
    step_height: float

    def best(self, rows: list[Array]) -> tuple[tuple[Array, float, Array], float]:
        """Return parameters, height [m] and bend of the best of some paths, and its work [J]."""
        trial = self.trial
        paths = [(row, *self._path(row)) for row in rows]
        tips = np.stack([trial.tips(height, bend) for _, height, bend in paths], axis=1)
        work, missed = trial.works(tips)
        allowed = EXTRA_MISS * float(trial.model.batch.lengths[0]) + missed[0]
        work = np.where(missed <= allowed, work, np.inf)
        number = int(np.argmin(work))
        return paths[number], float(work[number])

    def _path(self, row: Array) -> tuple[float, Array]:
        """Return height and bend of the path with parameters `row` (3,)."""
        trial, (part, early, hurry) = self.trial, row
        least = float(part) * self.step_height
        if not (early or hurry):
            bend = np.zeros((POINTS, 3))
            return self._clearance(least, bend), bend
        along = ease(_warped(KNOTS, hurry)) - ease(KNOTS)
        level = along[:, None] * (trial.end - trial.start)
        height = self._clearance(least, fit_bend(level))
        shift = bump(_warped(KNOTS, early)) - bump(KNOTS)
        bend = fit_bend(level + height * shift[:, None] * UP)
        return max(height, self._clearance(least, bend)), bend

    def _clearance(self, least: float, bend: Array) -> float:
        ends = self.trial.start, self.trial.end
        # A lower arch clears the ground by no less than the plain one.
        margin = CLEARANCE * self.step_height
        return clearance_height(self.ground, *ends, self.foot_radius, least, bend, margin)


def _warped(s: Array, early: float) -> Array:
    """Map 0..1 to itself, the middle coming sooner with `early` above 0."""
    return s + early * s * (1.0 - s)


# --- planning -----------------------------------------------------------------------

# Planners by their names in the scene; `spline` needs none.
PLANNERS: Mapping[str, Planner] = {
    "least-effort": plan_least_effort_swing,
    "passive": plan_passive_swing,
}


class SwingPlanner:
    """Plans the swings of a herd, some of whose creatures do not take plain arches."""

    def __init__(self, kinds: Mapping[int, str], progress: RouteProgress, ground: Ground) -> None:
        self.kinds, self.progress, self.ground = kinds, progress, ground
        self.herd = progress.herd

    @staticmethod
    def of(
        cast: Sequence[tuple[int, Creature, Figure]], progress: RouteProgress, ground: Ground
    ) -> SwingPlanner | None:
        """Return the planner of a herd, None if all take plain arches."""
        kinds = {
            c: member.walk.swing
            for c, (_, member, _) in enumerate(cast)
            if member.walk is not None and member.walk.swing in PLANNERS
        }
        return SwingPlanner(kinds, progress, ground) if kinds else None

    @property
    def no_bends(self) -> Array:
        """(L, m, 3) bends of plain arches."""
        return np.zeros((len(self.herd.owner), POINTS, 3))

    @cached_property
    def _models(self) -> Mapping[int, LegModel]:
        """Models of the legs whose swings are planned."""
        inertias = {c: FigureMass(self.herd.figures[c]) for c in self.kinds}
        return {
            leg: LegModel.of(self.herd, leg, inertias[int(c)])
            for leg, c in enumerate(self.herd.owner)
            if int(c) in self.kinds
        }

    def plan(
        self, request: StepRequest, hold: Foothold, step_height: float, lowering: Array
    ) -> tuple[float, Array]:
        """Return height [m] and bend (m, 3) of a swing.

        Args:
            request: the step.
            hold: the foothold at its end, with the plain arch.
            step_height: on level ground [m].
            lowering: (L,) of the bodies for the footholds of their legs [m].
        """
        herd, owner = self.herd, int(self.herd.owner[request.leg])
        if owner not in self.kinds:
            return hold.swing_height, np.zeros((POINTS, 3))
        # As in `pose_solver.total_lowering`, where each comes and goes.
        low = float((lowering[herd.owner == owner] ** 4).sum() ** 0.25)
        trial, foot_radius = (
            self.trial(request, hold.tip, low),
            float(herd.foot_radius[request.leg]),
        )
        return PLANNERS[self.kinds[owner]](trial, self.ground, foot_radius, step_height)

    def trial(self, request: StepRequest, end: Array, lowering: float) -> SwingTrial:
        """Return the trial of a swing to a tip (3,) below a body that is lowered [m]."""
        assert request.present is not None
        owner, timing, progress = int(self.herd.owner[request.leg]), request.timing, self.progress
        phases, creature = timing.up + FRACTIONS * timing.swing, np.full(len(FRACTIONS), owner)
        up, fraction = np.array([timing.up]), request.speed_fraction
        ahead = progress.paces.distances(creature[:1], up, phases[None])[0] * math.sqrt(fraction)
        distance, fractions = request.distance + ahead, np.full(len(phases), fraction)
        if request.forecast is not None:
            distance = request.forecast.distance(phases)
            fractions = request.forecast.fraction(phases)
        R, p = progress.trajectory.pose(creature, distance, phases, fractions)
        p[:, 1] -= lowering
        # A creature that has come to rest brings its feet down at full pace.
        rate = math.sqrt(fraction) if fraction > 0.0 else 1.0
        time = timing.swing * float(progress.cycle[owner]) / rate
        return SwingTrial(self._models[request.leg], request.present, end, time, R, p)
