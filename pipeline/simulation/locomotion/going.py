"""Going: how far creatures have gone along their routes, and how they speed up and slow down.

A creature goes at a part of its speed, its drive. Slower, it takes shorter steps and takes
them more slowly: stride and cadence share the change, each by its root, as animals do.
It slows down uphill and downhill, and before the end of its route, so that it comes to
rest there; then its feet close up.

Source: Sims 1987, 3.2.3 and 10.1; Alexander 1989 for how stride and cadence grow with speed.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.body_path import BodyPath
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.route import Route, direction
from pipeline.simulation.spatial import Array

RISING, FALLING = 1.0, 0.6
"""Cycles in which the drive goes from nothing to all, and back."""

BRAKING = 0.3
"""Time in which a creature that finds no foothold comes to rest [s]."""

CREEP = 0.06
"""Drive at which the last bit of a route is gone."""

UPHILL, DOWNHILL = 0.9, 0.5
"""By how much a slope of 1 slows down, as a part of the time on level ground."""

LOOKS = 24
"""How often a second the slope is looked at, whatever the length of a step."""

CLOSING = 1.0
"""Cycles in which feet close up after the body has come to rest."""


class Going:
    """Progress of a herd.

    Attributes of the state:
        way, phase: (C,) way gone [m], and phase of the gait, whole cycles counted.
        drive: (C,) part of the asked speed at which it goes.
        throttle: (C,) the drive that is asked for on level ground.
        halted: (C,) whether it found no foothold.
        closed: (C,) phase at which its feet have closed up; infinite while it goes.
    """

    def __init__(self, herd: Herd, path: BodyPath, dt: float) -> None:
        self.herd = herd
        self.path = path
        self.dt = dt
        count = len(herd.names)
        self.way, self.phase = np.zeros((2, count))
        self.drive = np.where(herd.walks, 1.0, 0.0)
        self.throttle = np.ones(count)
        self.halted = np.zeros(count, dtype=bool)
        self.closed = np.full(count, np.inf)
        self._easy = np.ones(count)
        self._steps = self._looks = 0

    @property
    def gone(self) -> Array:
        """(2, C) way gone [m], and phase."""
        return np.stack([self.way, self.phase])

    @property
    def stride(self) -> Array:
        """(C,) way gone in a cycle at the present drive [m]."""
        result: Array = self.herd.stride * np.sqrt(self.drive)
        return result

    @property
    def arrived(self) -> NDArray[np.bool_]:
        """(C,) whether it has come to the end of its route."""
        result: NDArray[np.bool_] = np.isfinite(self.closed)
        return result

    def lead(self, c: int, route: Route) -> None:
        """Give a creature another way from where it is on.

        Args:
            c: who.
            route: the same as before up to where it is.
        """
        self.path.routes[c] = route
        if route.length > self.way[c] + 1e-9:
            self.closed[c] = np.inf

    def may_lift(self) -> NDArray[np.bool_]:
        """(C,) Return who may lift a foot."""
        return ~self.halted & self.herd.walks

    def advance(self, airborne: NDArray[np.bool_]) -> None:
        """Go on by one step.

        Args:
            airborne: (C,) who has a foot in the air, which is brought down in any case.
        """
        herd, dt = self.herd, self.dt
        length = np.array([route.length for route in self.path.routes])
        left = np.maximum(length - self.way, 0.0)
        looks = round(self._steps * dt * LOOKS, 6)
        if looks >= self._looks:
            self._easy = self._ease()
            self._looks = math.floor(looks) + 1
        self._steps += 1
        before = self.drive
        self._drive_on()
        cycles = np.where(herd.walks, dt / herd.cycle, 0.0)
        # The mean of both ends of the step: exact while the drive changes evenly.
        step = np.minimum(0.5 * (before + self.drive) * cycles * herd.stride, left)
        moving = self.drive > 0.0
        rate = np.where(moving, 0.5 * (np.sqrt(before) + np.sqrt(self.drive)), 0.0)
        # Feet in the air, and those that close up, go on when the body rests.
        closing = self.arrived & (self.phase < self.closed)
        rate = np.where(~moving & (airborne | closing), 1.0, rate)
        self.way = self.way + step
        self.phase = self.phase + rate * cycles
        there = herd.walks & ~self.arrived & (left - step <= 1e-9)
        self.closed = np.where(there, self.phase + CLOSING, self.closed)
        self.drive = np.where(there, 0.0, self.drive)

    def _drive_on(self) -> None:
        """Come nearer to the drive that is wanted."""
        herd, dt = self.herd, self.dt
        free = [route.free(s) for route, s in zip(self.path.routes, self.way, strict=True)]
        left = np.maximum(free, 0.0)
        stride = np.maximum(herd.stride, 1e-9)
        # From v² = 2 a d, braking at a = v / cycle.
        braked = np.sqrt(np.minimum(2.0 * left / stride, 1.0))
        wanted = np.maximum(np.minimum(self.throttle * self._easy, braked), CREEP)
        wanted = np.where(self.halted | self.arrived | ~herd.walks, 0.0, wanted)
        up, down = dt / (RISING * herd.cycle), dt / (FALLING * herd.cycle)
        down = np.where(self.halted, dt / BRAKING, down)
        self.drive = np.clip(wanted, self.drive - down, self.drive + up)

    def _ease(self) -> Array:
        """Return the drive (C,) that suits the slopes under the bodies."""
        herd = self.herd
        creatures = np.flatnonzero(herd.walks)
        result = np.ones(len(herd.names))
        if not len(creatures):
            return result
        xz, turned, _ = self.path.on_route(creatures, self.way[creatures])
        reach = herd.footprint[creatures, 0]
        ahead = reach[:, None] * direction(turned)
        height = self.path.ground.height
        before, behind = xz + ahead, xz - ahead
        rise = height(before[:, 0], before[:, 1]) - height(behind[:, 0], behind[:, 1])
        slope = rise / (2.0 * reach)
        slowed = 1.0 + UPHILL * np.maximum(slope, 0.0) + DOWNHILL * np.maximum(-slope, 0.0)
        result[creatures] = 1.0 / slowed
        return result
