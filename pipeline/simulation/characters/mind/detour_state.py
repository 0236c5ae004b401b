"""Detour state: progress of a walk, and ways round what holds it up."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from pipeline.simulation.characters.visibility_route import Route

STALL_TIME, DETOUR_TIME = 1.6, 3.5  # without progress before a detour, and of the detour [s]


@dataclass
class DetourState:
    """Progress of a walk, and the way round all obstacles where it gets no farther.

    Attributes:
        nearest: least distance to the goal so far [m].
        progress_time: when it was reached [s].
        forced: way round all obstacles in a detour, 0 before the first.
        forced_until: end of the detour [s].
        route: of the walk.
    """

    nearest: float = math.inf
    progress_time: float = 0.0
    forced: float = 0.0
    forced_until: float = -1.0
    route: Route = field(default_factory=Route)

    def update_progress(self, left: float, now: float) -> None:
        """Note the remaining way [m], and force a detour if it does not shrink."""
        if left < self.nearest - 0.1 or left > self.nearest + 3.0:
            self.nearest, self.progress_time = left, now
        if now - self.progress_time > STALL_TIME and now > self.forced_until:
            self.forced = -self.forced if self.forced else 1.0
            self.forced_until = now + DETOUR_TIME
            self.progress_time, self.nearest = now + DETOUR_TIME, math.inf
