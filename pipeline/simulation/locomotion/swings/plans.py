"""Swing plans: how feet swing whose creatures do not take the plain spline.

A swing is planned when its foot lifts, for the way that the body will go, and is then a
height and a bend, as the plain one is a height alone.

Source: Sims 1987, 7.3.2, 7.4 and 9.3.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.locomotion.gaits.paces import Step
from pipeline.simulation.locomotion.swings.bend import POINTS
from pipeline.simulation.locomotion.swings.least_effort import least_effort
from pipeline.simulation.locomotion.swings.passive import passive
from pipeline.simulation.locomotion.swings.trial import PARTS, LegModel, SwingTrial
from pipeline.simulation.locomotion.ways.going import Going
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground
from pipeline.spec.cast import Creature

Planner = Callable[[SwingTrial, Ground, float, float], tuple[float, Array]]

PLANNERS: Mapping[str, Planner] = {"least-effort": least_effort, "passive": passive}
"""By the words of the language; `spline` needs none."""


@dataclass(frozen=True, eq=False)
class Asked:
    """A swing that is about to begin.

    Attributes:
        step: when it swings.
        start, end: (3,) tips [m].
        way: that the body has gone at its begin [m].
        drive: part of its speed at which the body goes.
        step_height: height of the arch on level ground [m].
    """

    step: Step
    start: Array
    end: Array
    way: float
    drive: float
    step_height: float


class SwingPlans:
    """Plans swings for a herd of whom some ask for it."""

    def __init__(self, kinds: Mapping[int, str], going: Going, ground: Ground) -> None:
        self.kinds = kinds
        self.going = going
        self.herd = going.herd
        self.ground = ground

    @staticmethod
    def of(
        cast: Sequence[tuple[int, Creature, Figure]], going: Going, ground: Ground
    ) -> SwingPlans | None:
        """Return the plans of a herd, None if all swing plainly."""
        kinds = {
            c: member.walk.swing
            for c, (_, member, _) in enumerate(cast)
            if member.walk is not None and member.walk.swing in PLANNERS
        }
        return SwingPlans(kinds, going, ground) if kinds else None

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

    def plan(self, leg: int, asked: Asked, height: float, stoop: Array) -> tuple[float, Array]:
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

    def trial(self, leg: int, asked: Asked, stoop: float) -> SwingTrial:
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
