"""Sub-steps: how finely a step has to be cut so that nothing sinks too deep into anything.

What hits something at speed v sinks in by v/ω, where ω h is given: more quickly means
shorter sub-steps and harder springs. Nothing sinks in by more than `DEEPEST` of its own
half thickness then, and within a sub-step nothing moves by more than ω h times that, so
nothing can pass through anything.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.impact_law import STIFFNESS
from pipeline.simulation.dynamics.pushing import Pushers
from pipeline.simulation.dynamics.rigid import Bodies, Build, State, dot
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField

LONGEST = 1.0 / 900.0
"""A sub-step [s]."""

MOST = 2000
"""Sub-steps of one step."""

DEEPEST = 0.5
"""How far things sink in at most, as a part of their least distance from middle to face."""

CALM = 24
"""Steps for which sub-steps stay as short as they were: a spring that turns soft under load
takes energy away."""


class Substeps:
    """Counts the sub-steps that each step needs."""

    def __init__(
        self, builds: Sequence[Build], pushers: Sequence[Array], field: HeightField, step: float
    ) -> None:
        bodies = Bodies.of(builds)
        self.reach, self.thin = bodies.reach, bodies.thin
        self.far = np.array([np.linalg.norm(corners, axis=1).max() for corners in pushers])
        self.field = field
        self.step = step
        self.least = math.ceil(step / LONGEST)
        self._recent = deque([self.least], maxlen=CALM)

    def count(self, state: State, moves: NDArray[np.bool_], pushers: Pushers) -> int:
        """Return the sub-steps of the step to come.

        Args:
            state: of the bodies.
            moves: (N,) which of them are awake.
            pushers: who push them.
        """
        need = self.least
        if moves.any() or len(pushers.speed):
            speed = np.where(moves, self._speeds(state), 0.0) + self._pushed(state, pushers)
            stiffness = float((speed / self.thin).max()) / DEEPEST
            need = min(max(math.ceil(self.step * stiffness / STIFFNESS), self.least), MOST)
        self._recent.append(need)
        return max(self._recent)

    def _speeds(self, state: State) -> Array:
        """Return how fast bodies (N,) are, or will be when they have fallen to the ground."""
        turning = np.sqrt(dot(state.w, state.w)) * self.reach
        above = state.p[:, 1] - self.field.height(state.p[:, 0], state.p[:, 2]) - self.thin
        falling = 2.0 * GRAVITY * np.maximum(above, 0.0)
        result: Array = turning + np.sqrt(dot(state.v, state.v) + falling)
        return result

    def _pushed(self, state: State, pushers: Pushers) -> Array:
        """Return the speeds (N,) of who may push each in this step or the next."""
        if not len(pushers.speed):
            return np.zeros(len(self.reach))
        arm = state.p[:, None] - pushers.begin[:, :3]
        gap = np.sqrt(dot(arm, arm)) - self.reach[:, None] - self.far
        near = gap < 2.0 * self.step * pushers.speed
        result: Array = np.where(near, pushers.speed, 0.0).max(axis=1)
        return result
