"""Time estimate: how long a stage still takes, from the pace of its own work.

What comes before the first thing is done says nothing about the others: scenes are built and
kernels compiled in that time. The latest half of the measured work decides, so that an estimate
follows a film that becomes slower on the way.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field

MIN_COUNTS = 3
"""Reports of progress before the first estimate; the first of them starts the measurement."""

MIN_MEASURED = 1.0
"""Measured time before the first estimate [s]."""


@dataclass(slots=True)
class TimeEstimate:
    """Time left of one stage.

    Attributes:
        total: number of things to do.
        done: number of things done.
        pace: time per thing [s], None before it is known.
    """

    total: int
    done: int = 0
    pace: float | None = None
    _times: list[float] = field(default_factory=list)
    _counts: list[int] = field(default_factory=list)

    def measure(self, done: int, now: float) -> None:
        """Adds a report of progress.

        Args:
            done: number of things done.
            now: time of the report on any steady clock [s].
        """
        self.done = done
        self._times.append(now)
        self._counts.append(done)
        times, counts = self._times, self._counts
        if len(times) < MIN_COUNTS or now - times[0] < MIN_MEASURED:
            return
        # At least the last two intervals.
        middle = bisect_left(counts, (counts[0] + done) / 2.0)
        first = min(middle, len(times) - MIN_COUNTS)
        if counts[-1] > counts[first]:
            self.pace = (now - times[first]) / (counts[-1] - counts[first])

    def set_pace(self, done: int, now: float, pace: float | None) -> None:
        """Adds a report of progress whose pace was measured elsewhere [s per thing]."""
        self.done = done
        self._times.append(now)
        if pace is not None:
            self.pace = pace

    def left(self, now: float) -> float | None:
        """Returns the time left [s], None before it is known."""
        if self.pace is None:
            return None
        since = now - self._times[-1]
        # The thing under way may take longer than the pace, but is not done yet.
        return max(self.pace * (self.total - self.done) - since, 0.0)
