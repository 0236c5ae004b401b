"""Give: how a body gives on its legs, beside what its gait and its way make it do.

It hangs on its legs as on a spring: it dips its nose when the creature brakes and lifts it
when it speeds up, and sinks in a little after a step down. No step is planned for that, so
it is kept small, and legs that would be overstretched take it back.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.curves import bounded
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.body_motion.damped_springs import Oscillators, Trailing
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import pitched_and_rolled
from pipeline.simulation.spatial import Array

STIFF = 2.5
"""Frequency, in that of a pendulum as long as the body is high."""

DAMPING = 0.55

LEANS = 0.25
"""Pitch for an acceleration of 1 g [rad]."""

SINKS = 0.15
"""Part of what the spring would give that the height takes on."""

MOST_LEAN = math.radians(3.5)

MOST_SINK = 0.02
"""Of the body's height."""


class BodySuspension:
    """How the bodies of a herd give; remembers the row before.

    Attributes:
        tall: (C,) heights of the bodies [m].
        springs: on which they hang.
    """

    def __init__(self, herd: Herd, dt: float) -> None:
        self.tall = herd.body_height
        frequency = STIFF * np.sqrt(GRAVITY / np.maximum(self.tall, 1e-3))
        self.springs = Oscillators(frequency, np.full_like(frequency, DAMPING), dt)
        self._trailing = Trailing(self.springs)
        # Who flies between its steps falls freely: nothing of that is to be softened.
        self._sinks = np.array([SINKS if pace.flight is None else 0.0 for pace in herd.paces])

    def apply(self, R_WB: Array, p_WB: Array) -> None:
        """Let bodies give.

        Args:
            R_WB: (n, C, 3, 3) at n rows; changed.
            p_WB: (n, C, 3) [m]; changed.
        """
        late = self._trailing.follow(p_WB)
        behind = -(late * R_WB[..., :, 0]).sum(axis=-1)
        pull = behind * self.springs.frequency**2 / GRAVITY
        lean = MOST_LEAN * bounded(LEANS * pull / MOST_LEAN)
        R_WB[:] = R_WB @ pitched_and_rolled(lean.ravel(), np.zeros(lean.size)).reshape(R_WB.shape)
        most = MOST_SINK * self.tall
        p_WB[..., 1] += most * bounded(self._sinks * late[..., 1] / np.maximum(most, 1e-9))
