"""Task progress: for how long a person has come no nearer to what it does."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from pipeline.simulation.spatial import Array

STEP_FORWARD = 0.03  # by which it comes nearer at least [m]
STEP_ASIDE = 0.4  # by which a walker gets on at least that does not come nearer [m]


@dataclass
class TaskProgress:
    """The least distance to a goal so far, and the time since it fell.

    Attributes:
        least: distance so far [m].
        time: since it fell, or since a walker has got on otherwise [s].
        idle_time: since it fell [s].
        free_time: since others last held up a walker [s].
        place: (2,) from which a walker has to get on; None before the start [m].
    """

    least: float = math.inf
    time: float = 0.0
    idle_time: float = 0.0
    free_time: float = math.inf
    place: tuple[float, float] | None = field(default=None)

    def update(self, distance: float, dt: float, at: Array | None = None) -> float:
        """Return for how long there is no progress [s].

        Args:
            distance: left to the goal [m].
            dt: time since the last update [s].
            at: (2,) the place of a walker, who may get on without coming nearer [m].
        """
        self.time, self.idle_time = self.time + dt, self.idle_time + dt
        if distance < self.least - STEP_FORWARD:
            self.least, self.time, self.idle_time = distance, 0.0, 0.0
        if at is not None:
            here = float(at[0]), float(at[1])
            if self.place is None or math.dist(here, self.place) > STEP_ASIDE:
                self.place, self.time = here, 0.0
        return self.time
