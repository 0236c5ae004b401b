"""Going: how far creatures have gone along their routes, and how they speed up and slow down.

A creature goes at a part of its speed, its drive. Slower, it takes shorter steps and takes
them more slowly: stride and cadence share the change, each by its root, as animals do.
It slows down uphill and downhill, and before the end of its route, so that it comes to
rest there; then its feet close up.

Source: Sims 1987, 3.2.3 and 10.1; Alexander 1989 for how stride and cadence grow with speed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.body_motion.gaze import LookTarget
from pipeline.simulation.locomotion.gaits.moods import MoodSchedule
from pipeline.simulation.locomotion.gaits.pace import Pace
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.locomotion.routes.route import Route, heading_vector
from pipeline.simulation.spatial import Array

RISING, FALLING = 1.0, 0.6
"""Cycles in which the drive goes from nothing to all, and back."""

SLOWLY, EASES = 0.1, 2.0
"""Part of its speed with which who has rested sets out, and in how many cycles it comes to all
of it: its feet are where they rest, and not where they would be had it come walking."""

BRAKING = 0.3
"""Least time in which a creature that finds no foothold comes to rest [s]."""

SOFT = 3.0
"""Deceleration of who finds no foothold, if its feet can wait that long [m/s²]."""

HARD = 4.0
"""Greatest deceleration of who comes to rest where it meant to [m/s²]."""

SHOWS = 0.08
"""Cycles after which bodies show a change of the drive, twice over."""

ALIKE = 1e-5
"""Difference between drives that does not show."""

CREEP = 0.02
"""Drive at which the last bit of a route is gone."""

UPHILL, DOWNHILL = 0.9, 0.5
"""By how much a slope of 1 slows down, as a part of the time on level ground."""

SLOPE_SAMPLES_PER_SECOND = 8
"""How often a second the slope is looked at, whatever the length of a step."""

CLOSING_CYCLES = 1.0
"""Cycles in which feet close up after the body has come to rest."""


class RouteProgress:
    """Progress of a herd.

    Attributes of the state:
        gone: (2, C) way gone [m], and phase of the gait, whole cycles counted.
        drive: (C,) part of the asked speed at which it goes.
        vigour: (C,) the drive as bodies show it in how they bounce and rock: it has no corners.
        throttle: (C,) the drive that is asked for on level ground.
        halted: (C,) whether it found no foothold.
        closed: (C,) phase at which its feet have closed up; infinite while it goes.
        cycle, full: (C,) duration [s] and length [m] of a cycle at full drive.
        braking: (C,) way on which it comes to rest from its full speed [m].
        looks: what creatures are told to look at; the others look where they go.
    """

    def __init__(self, herd: Herd, path: BodyTrajectory, manners: MoodSchedule, dt: float) -> None:
        self.herd = herd
        self.path = path
        self.paces = path.paces
        self.manners = manners
        self.dt = dt
        count = len(herd.names)
        self.gone = np.zeros((2, count))
        self.drive = np.where(herd.walks, 1.0, 0.0)
        self.vigour = self._yielding = self.drive.copy()
        self.throttle = np.ones(count)
        self.halted = np.zeros(count, dtype=bool)
        self.closed = np.full(count, np.inf)
        self.cycle, self.full = herd.cycle.copy(), herd.stride.copy()
        self.looks: Mapping[int, LookTarget] = {}
        self._cycles = np.where(herd.walks, dt / herd.cycle, 0.0)
        self._changing: dict[int, float] = {}
        self._stops: dict[int, float] = {}
        # Phases at which those set out that have rested, minus infinity of all others.
        self._since = np.full(count, -np.inf)
        self._sets_out = False
        self._steps = self._looks = 0
        self._easy = np.ones(count)
        self._steady: Array | None = None
        self._consider()

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self._steps * self.dt

    @property
    def way(self) -> Array:
        """(C,) way gone [m]."""
        result: Array = self.gone[0]
        return result

    @property
    def phase(self) -> Array:
        """(C,) phase of the gait, whole cycles counted."""
        result: Array = self.gone[1]
        return result

    @property
    def may_rest(self) -> bool:
        """Whether anybody rests, or may come to rest at the end of its route."""
        return self._ends is not None

    @property
    def stride(self) -> Array:
        """(C,) way gone in a cycle at the present drive [m]."""
        result: Array = self.full * np.sqrt(self.drive)
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
        if self.halted[c]:
            return
        self.path.lead(c, route)
        if route.length > self.way[c] + 1e-9:
            if self.arrived[c]:
                self._since[c], self._sets_out = self.phase[c], True
            self.closed[c] = np.inf
        self._consider()

    def let(self, c: int, throttle: float) -> None:
        """Let a creature go at another drive."""
        self.throttle[c] = throttle
        self._consider()

    def take_on(self, c: int, pace: Pace) -> None:
        """Let a creature go over to another pace, as fast as that is meant to be."""
        self._changing[c] = self.paces.change(c, pace, float(self.phase[c]))
        self.let(c, 1.0)

    def changes(self, c: int) -> bool:
        """Return whether a creature is going over to another pace."""
        return c in self._changing

    def _keep_pace(self) -> None:
        """Go on at the paces of the moment while some change."""
        for c, end in list(self._changing.items()):
            at = self.phase[c : c + 1]
            self.cycle[c] = self.paces.number("cycle", c, at)[0]
            self.full[c] = self.paces.number("stride", c, at)[0]
            self._cycles[c] = self.dt / self.cycle[c]
            if self.phase[c] >= end:
                del self._changing[c]
        self._consider()

    def stopping(self, c: int) -> tuple[float, float]:
        """Return the shortest and the longest way on which who is stuck comes to rest [m]."""
        v = float(self.drive[c] * self.full[c] / self.cycle[c])
        nearest = 0.5 * BRAKING * v
        return nearest, max(nearest, 0.5 * v * v / SOFT)

    def halt(self, c: int, room: float = 0.0) -> None:
        """Let a creature come to rest for good within `room` [m]: it has no foothold."""
        way, drive = float(self.way[c]), max(float(self.drive[c]), CREEP)
        route = self.path.routes[c]
        self.lead(c, route.upto(min(way + room, route.length)))
        self.halted[c] = True
        self._stops[c] = room / (drive * drive)
        self._consider()

    def set_out(self, part: Array) -> None:
        """Begin at a part (C,) of the drive that creatures would come with."""
        self.drive = self.drive * part
        self.vigour = self._yielding = self.drive.copy()

    def stay(self, c: int) -> None:
        """Let a creature that has not set out stay where it is for good."""
        self.path.lead(c, self.path.routes[c].upto(float(self.way[c])))
        self.drive[c] = self.vigour[c] = self._yielding[c] = 0.0
        self._consider()

    def may_lift(self) -> NDArray[np.bool_]:
        """(C,) Return who may lift a foot."""
        return ~self.halted & self.herd.walks

    def advance(self, airborne: NDArray[np.bool_]) -> None:
        """Go on by one step.

        Args:
            airborne: (C,) who has a foot in the air, which is brought down in any case.
        """
        looks = round(self._steps * self.dt * SLOPE_SAMPLES_PER_SECOND, 6)
        if looks >= self._looks:
            self._easy = self._ease()
            self._looks = math.floor(looks) + 1
            self._consider()
        self._steps += 1
        if self._changing:
            self._keep_pace()
        if self._steady is not None:
            self.gone = self.gone + self._steady
            return
        before = self.drive
        wish = self._wish if self._ends is None else np.minimum(self._wish, self._braked())
        self.drive, step, rate = self._onward(before, self._eased(wish, self.phase))
        if self._sets_out:
            self._since[self.phase >= self._since + EASES] = -np.inf
            self._sets_out = bool(np.isfinite(self._since).any())
        self._show()
        if self._ends is not None:
            step, rate = self._near_the_end(step, rate, airborne)
        progress = np.stack([step, rate * self._cycles])
        self.gone = self.gone + progress
        settled = (before == self._wish).all() and (self.vigour == self.drive).all()
        if self._ends is None and not self._changing and settled:
            self._steady = progress

    def _show(self) -> None:
        """Let bodies show a change of the drive, smoothly: as two lags, one after the other."""
        part = -np.expm1(-self._cycles / SHOWS)
        self._yielding = self._yielding + part * (self.drive - self._yielding)
        vigour = self.vigour + part * (self._yielding - self.vigour)
        near = np.maximum(np.abs(self.drive - vigour), np.abs(self.drive - self._yielding)) < ALIKE
        self.vigour = np.where(near, self.drive, vigour)
        self._yielding = np.where(near, self.drive, self._yielding)

    def foreseen(self) -> Iterator[tuple[Array, Array]]:
        """Yield what `gone` and `drive` will be after each step up to the next look at slopes.

        That is so for who neither is told otherwise nor brakes.
        """
        gone, drive = self.gone, self.drive
        wish = self._wish if self._ends is None else np.minimum(self._wish, 1.0)
        for _ in range(
            math.ceil(self._looks / (self.dt * SLOPE_SAMPLES_PER_SECOND) - self._steps - 1e-6)
        ):
            drive, step, rate = self._onward(drive, self._eased(wish, gone[1]))
            gone = gone + np.stack([step, rate * self._cycles])
            yield gone, drive

    def _eased(self, wish: Array, phase: Array) -> Array:
        """Return the drive (C,) wished for of those, too, who set out."""
        if not self._sets_out:
            return wish
        result: Array = np.minimum(wish, SLOWLY + (phase - self._since) / EASES)
        return result

    def _onward(self, before: Array, wish: Array) -> tuple[Array, Array, Array]:
        """Return the drive after a step, the way gone in it [m], and the rate of the phase (C,)."""
        drive = np.minimum(np.maximum(wish, before - self._falls), before + self._rises)
        # The mean of both ends of the step: exact while the drive changes evenly.
        mean = 0.5 * (before + drive)
        rate = 0.5 * (np.sqrt(before) + np.sqrt(drive))
        return drive, mean * self._cycles * self.full, rate

    def _consider(self) -> None:
        """Work out the drive that is wanted, and what else stays as it is for a while."""
        herd, dt = self.herd, self.dt
        self._steady = None
        rests = self.arrived | ~herd.walks
        self._wish = np.where(rests, 0.0, np.maximum(self.throttle * self._easy, CREEP))
        v = np.maximum(self.full / self.cycle, 1e-9)
        # From v² = 2 a d, braking at a = v / cycle, and no harder than `HARD`.
        self.braking = v * v / (2.0 * np.minimum(v / self.cycle, HARD))
        for c, stop in self._stops.items():
            self.braking[c] = stop
        self._rises = dt / (RISING * self.cycle)
        # Who is stuck has a way to brake on that was made for it.
        self._falls = np.where(self.halted, 1.0, dt / (FALLING * self.cycle))
        self._bound = [c for c, route in enumerate(self.path.routes) if not route.goes_straight]
        length = np.array([route.length for route in self.path.routes])
        # None while all go on for ever, which most do.
        self._ends = length if (herd.walks & (np.isfinite(length) | self.halted)).any() else None

    def _braked(self) -> Array:
        """Return the greatest drive (C,) from which all come to rest where they have to."""
        left = np.full(len(self.way), np.inf)
        for c in self._bound:
            left[c] = max(self.path.routes[c].free(float(self.way[c])), 0.0)
        drive = np.sqrt(np.minimum(left / np.maximum(self.braking, 1e-9), 1.0))
        result: Array = np.where(self.arrived, 0.0, np.maximum(drive, CREEP))
        return result

    def _near_the_end(
        self, step: Array, rate: Array, airborne: NDArray[np.bool_]
    ) -> tuple[Array, Array]:
        """Return way and rate of the phase (C,) of this step, where some come to rest."""
        assert self._ends is not None
        left = np.maximum(self._ends - self.way, 0.0)
        step = np.minimum(step, left)
        # Feet in the air, and those that close up, go on when the body rests.
        closing = self.arrived & ~self.halted & (self.phase < self.closed)
        rests = self.drive == 0.0
        rate = np.where(rests, np.where(airborne | closing, 1.0, 0.0), rate)
        there = self.herd.walks & ~self.arrived & (left - step <= 1e-9)
        if there.any():
            self.closed = np.where(
                there, self.phase + rate * self._cycles + CLOSING_CYCLES, self.closed
            )
            self.drive = np.where(there, 0.0, self.drive)
            self._consider()
        return step, rate

    def _ease(self) -> Array:
        """Return the drive (C,) that suits the slopes under the bodies."""
        herd = self.herd
        creatures = np.flatnonzero(herd.walks)
        result = np.ones(len(herd.names))
        if not len(creatures):
            return result
        xz, turned, _ = self.path.on_route(creatures, self.way[creatures])
        reach = herd.footprint[creatures, 0]
        ahead = reach[:, None] * heading_vector(turned)
        ends = np.stack([xz + ahead, xz - ahead], axis=1)
        # Not the ground itself: no single stone slows down.
        height, _ = self.path.footing.surface(creatures, ends[..., 0], ends[..., 1])
        rise = height[:, 0] - height[:, 1]
        slope = rise / (2.0 * reach)
        slowed = 1.0 + UPHILL * np.maximum(slope, 0.0) + DOWNHILL * np.maximum(-slope, 0.0)
        result[creatures] = 1.0 / slowed
        return result
