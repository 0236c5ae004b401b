"""Damped springs: points that follow moving goals late and swing on after them.

Between two rows the goal moves straight, and with e the position of the point relative to it, w its
speed relative to it,

    ë + 2ζω ė + ω² e = 0,

which is solved exactly from row to row: where the goal moves evenly the point has no lag, and where
its speed changes, w changes by as much. So a finer grid of rows shows the same motion more closely,
and no spring however stiff diverges.

Source: Lasseter 1987 for overlapping action and follow-through.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pipeline.simulation.curves import bounded
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import pitched_and_rolled
from pipeline.simulation.spatial import Array

# Frequency of a body on its legs, in frequencies of a pendulum as long as the body is high, and
# damping ratio.
SUSPENSION_FREQUENCY, SUSPENSION_DAMPING = 2.5, 0.55

# Pitch for an acceleration of 1 g, and greatest pitch [rad].
PITCH_PER_G, MAX_PITCH = 0.25, math.radians(3.5)

# Greatest height by which that moves hips, in leg lengths: those of a long body are far apart.
MAX_HIP_MOTION = 0.04

# Part of the springs' deflection that the height takes on, and greatest change of it in body
# heights.
SINK_FRACTION, MAX_SINK = 0.15, 0.02


@dataclass(frozen=True, eq=False)
class Oscillators:
    """M damped oscillators over a fixed time.

    Attributes:
        frequency: (M,) ω without damping [rad/s].
        damping: (M,) ratios ζ to the critical damping, less than 1.
        dt: the time [s].
    """

    frequency: Array
    damping: Array
    dt: float

    @cached_property
    def _terms(self) -> tuple[Array, Array, Array, Array]:
        """Position and speed after `dt` by both before: (M,) each."""
        fall = self.damping * self.frequency
        swing = self.frequency * np.sqrt(1.0 - self.damping**2)
        left = np.exp(-fall * self.dt)
        c, s = left * np.cos(swing * self.dt), left * np.sin(swing * self.dt) / swing
        return c + fall * s, s, -(self.frequency**2) * s, c - fall * s

    def step(self, e: Array, w: Array) -> tuple[Array, Array]:
        """Return positions and speeds (M, ...) after `dt`, without forces."""
        by_position, by_speed = self.matrices(e.ndim)
        position, speed = by_position * e + by_speed * w
        return position, speed

    def matrices(self, axes: int) -> tuple[Array, Array]:
        """Return how position and speed (2, M, ...) depend on position and on speed before."""
        a, b, c, d = (term.reshape(-1, *(1,) * (axes - 1)) for term in self._terms)
        return np.stack([a, c]), np.stack([b, d])


@dataclass(slots=True, eq=False)
class SpringFollower:
    """Points on springs, each behind its own goal; remembers the row before.

    Rows may be given in any portions, one after the other in time.

    Attributes:
        springs: M of them, over the time between two rows.
    """

    springs: Oscillators
    _goal: Array | None = field(default=None, init=False)
    _speed: Array | None = field(default=None, init=False)
    _state: Array | None = field(default=None, init=False)

    def follow(self, goals: Array) -> Array:
        """Return the points relative to their goals (n, M, ...); at rest in the very first row."""
        found = np.zeros_like(goals)
        if not len(goals):
            return found
        known = goals if self._goal is None else np.concatenate([self._goal[None], goals])
        self._goal = known[-1].copy()
        speeds = np.diff(known, axis=0) / self.springs.dt
        if not len(speeds):
            return found
        # The goals' speed before the first row is unknown: as after it.
        before = speeds[0] if self._speed is None else self._speed
        changes = np.diff(speeds, axis=0, prepend=before[None])
        by_position, by_speed = self.springs.matrices(goals.ndim - 1)
        state = np.zeros((2, *goals.shape[1:])) if self._state is None else self._state
        # A point at rest behind an evenly moving goal stays at rest.
        moves = bool(state.any() or changes.any())
        for row, change in enumerate(changes if moves else (), len(goals) - len(changes)):
            state = by_position * state[0] + by_speed * (state[1] - change)
            found[row] = state[0]
        self._state, self._speed = state, speeds[-1].copy()
        return found


class BodySuspension:
    """The bodies of a herd on their legs as on springs; remembers the row before.

    A body dips its nose when it brakes, lifts it when it speeds up, and sinks in after a step down.
    No step is planned for that, so it is small, and overstretched legs take it back.

    Attributes:
        tall: (C,) heights of the bodies [m].
        springs: under them.
    """

    def __init__(self, herd: Herd, dt: float) -> None:
        self.tall = herd.body_height
        frequency = SUSPENSION_FREQUENCY * np.sqrt(GRAVITY / np.maximum(self.tall, 1e-3))
        damping = np.full_like(frequency, SUSPENSION_DAMPING)
        self.springs = Oscillators(frequency, damping, dt)
        self._follower = SpringFollower(self.springs)
        self._most_pitch = np.full_like(frequency, MAX_PITCH)
        for c in range(len(frequency)):
            own = herd.owner == c
            if own.any():
                far = float(np.abs(herd.hips[own, 0]).max())
                most = MAX_HIP_MOTION * float(herd.legs.lengths[own].min())
                self._most_pitch[c] = min(MAX_PITCH, most / max(far, 1e-9))
        # A body that flies between its steps falls freely.
        self._sink = np.array([SINK_FRACTION if p.flight is None else 0.0 for p in herd.paces])

    def apply(self, R_WB: Array, p_WB: Array) -> None:
        """Move bodies on their springs.

        Args:
            R_WB: (n, C, 3, 3) at n rows; changed.
            p_WB: (n, C, 3) [m]; changed.
        """
        late = self._follower.follow(p_WB)
        behind = -(late * R_WB[..., :, 0]).sum(axis=-1)
        pull = behind * self.springs.frequency**2 / GRAVITY
        pitch = self._most_pitch * bounded(PITCH_PER_G * pull / self._most_pitch)
        turned = pitched_and_rolled(pitch.ravel(), np.zeros(pitch.size))
        R_WB[:] = R_WB @ turned.reshape(R_WB.shape)
        most = MAX_SINK * self.tall
        p_WB[..., 1] += most * bounded(self._sink * late[..., 1] / np.maximum(most, 1e-9))
