"""Step batch: planned steps as arrays, and where their bodies will be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.gaits.pace_schedule import StepTiming
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.locomotion.routes.speed_forecast import SpeedForecast
from pipeline.simulation.locomotion.swing.swing_trajectory import quickness
from pipeline.simulation.spatial import Array, turn

# Fractions of a stance at which reach is checked.
STANCE_FRACTIONS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])

# Part of the swing after the stance in which the foot has hardly left its place, see `ease`; quick
# feet leave it at once, and one that rolls over its toe is farthest behind its hip before.
LIFT_LAG, SOLE_LAG = 0.25, 0.12

# How far behind their places at rest feet with soles stand in a run, in the lengths of the soles:
# a runner comes down nearer to the body than a walker.
SOLE_BEHIND = 0.5

MID_STANCE = len(STANCE_FRACTIONS) // 2


@dataclass(frozen=True, eq=False)
class StepRequest:
    """A foot that needs a foothold.

    Attributes:
        leg: its number.
        distance: that its body has gone at `phase` [m].
        phase: of the gait, whole cycles counted.
        timing: of the swing and the stance.
        speed_fraction: of the body.
        present: (3,) its tip; None for a foot that is placed at the start [m].
        forecast: where its body will be if its speed changes; None if it hardly does.
        lowering: of the body for the foot's present place, and for the other feet [m].
        room: greatest lowering at which the other legs do not fold too far [m].
    """

    leg: int
    distance: float
    phase: float
    timing: StepTiming
    speed_fraction: float = 1.0
    present: Array | None = None
    forecast: SpeedForecast | None = None
    lowering: tuple[float, float] = (0.0, 0.0)
    room: float = math.inf

    @property
    def key(self) -> tuple[float, ...]:
        """All that decides where a step at an even speed, without lowering, comes down."""
        present = () if self.present is None else self.present.tolist()
        timing = self.timing.swing, self.timing.stance
        return (self.distance, self.phase, self.speed_fraction, *timing, *present)


@dataclass(frozen=True, eq=False)
class Stances:
    """Where N bodies are during the stances of planned steps.

    Attributes:
        R: (N, m, 3, 3) and
        p: (N, m, 3), from touchdown until the foot has left the ground again [m].
        lift_R: (N, 3, 3) and
        lift_p: (N, 3), at lift-off [m].
        neutral: (N, 2) neutral places of the feet in the middle of their stances [m].
    """

    R: Array
    p: Array
    lift_R: Array
    lift_p: Array
    neutral: Array


@dataclass(frozen=True, eq=False)
class StepBatch:
    """N step requests as arrays (N,); see `StepRequest` and `StepTiming`."""

    legs: NDArray[np.int64]
    owner: NDArray[np.int64]
    distance: Array
    phase: Array
    speed_fraction: Array
    forecast: NDArray[np.object_]
    up: Array
    swing: Array
    stance: Array

    @staticmethod
    def of(herd: Herd, requests: Sequence[StepRequest]) -> StepBatch:
        """Collect requests of legs of a herd."""
        legs = np.array([r.leg for r in requests])
        rows = [
            (r.distance, r.phase, r.speed_fraction, t.up, t.swing, t.stance)
            for r, t in ((r, r.timing) for r in requests)
        ]
        distance, phase, fraction, *timing = np.array(rows).T
        forecast = np.empty(len(rows), dtype=object)
        forecast[:] = [request.forecast for request in requests]
        return StepBatch(legs, herd.owner[legs], distance, phase, fraction, forecast, *timing)

    def rows(self, rows: NDArray[np.int64]) -> StepBatch:
        """Return the steps in some rows."""
        return StepBatch(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))

    def body_poses(self, trajectory: BodyTrajectory, phases: Array) -> tuple[Array, Array]:
        """Return R_WB (N, m, 3, 3) and p_WB (N, m, 3) [m] at later phases (N, m)."""
        gone = trajectory.paces.distances(self.owner, self.phase, phases)
        gone = gone * np.sqrt(self.speed_fraction)[:, None]
        distances, fractions = self.distance[:, None] + gone, np.ones(phases.shape)
        for i, forecast in enumerate(self.forecast):
            if forecast is not None:
                distances[i] = forecast.distance(phases[i])
                fractions[i] = forecast.fraction(phases[i])
        creature = np.repeat(self.owner, phases.shape[1])
        R, p = trajectory.pose(creature, distances.ravel(), phases.ravel(), fractions.ravel())
        return R.reshape(*phases.shape, 3, 3), p.reshape(*phases.shape, 3)

    def stances(self, trajectory: BodyTrajectory) -> Stances:
        """Return where the bodies are during the stances, if they go on as they go."""
        stance = self.stance[:, None]
        soles = trajectory.herd.soles[self.legs]
        quick = quickness(self.swing)
        lag = np.where(soles > 0.0, SOLE_LAG, LIFT_LAG) * (1.0 - quick) * self.swing
        end = stance + lag[:, None]
        parts = np.concatenate([stance * STANCE_FRACTIONS, end], axis=1)
        phases = (self.up + self.swing)[:, None] + parts
        R, p = self.body_poses(trajectory, np.concatenate([phases, self.up[:, None]], axis=1))
        middle = R[:, MID_STANCE], p[:, MID_STANCE]
        neutral = neutral_positions(trajectory, self.legs, phases[:, MID_STANCE], *middle)
        behind = SOLE_BEHIND * quick * soles * np.minimum(self.speed_fraction, 1.0)
        neutral -= behind[:, None] * R[:, MID_STANCE][:, [0, 2], 0]
        return Stances(R[:, :-1], p[:, :-1], R[:, -1], p[:, -1], neutral)


def neutral_positions(
    trajectory: BodyTrajectory, legs: NDArray[np.int64], phase: Array, R: Array, p: Array
) -> Array:
    """Return the neutral places (N, 2) [m] of feet below bodies at R (N, 3, 3), p (N, 3)."""
    herd, owner = trajectory.herd, trajectory.herd.owner[legs]
    height, lateral_offset = (
        trajectory.paces.value(name, owner, phase) for name in ("body_height", "lateral_offset")
    )
    x, z = herd.rest[legs].T
    rest = trajectory.without_rocking(
        owner, phase, np.stack([x, -height, z + lateral_offset], axis=-1)
    )
    return (p + turn(R, rest))[:, [0, 2]]
