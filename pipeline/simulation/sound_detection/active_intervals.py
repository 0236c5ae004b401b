"""Active intervals: times during which a level is high, by two thresholds and two durations.

An interval starts where a level exceeds its upper threshold, interpolated between rows. It ends
at the last row above the lower threshold, once the level has been below it for longer than a
pause. Intervals shorter than a minimum are dropped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import count

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.spec.sound_thresholds import SustainedCause


@dataclass(frozen=True, slots=True)
class ActiveInterval:
    """An interval of one level.

    Attributes:
        index: of the level.
        start: in rows.
        first: the last row not after the start.
        last: the last row.
        peak: the greatest level.
        values: of each row from the first to the last.
    """

    index: int
    start: float
    first: int
    last: int
    peak: float
    values: Sequence[Sequence[float]]


@dataclass(slots=True)
class _OpenInterval:
    start: float
    first: int
    last: int
    peak: float
    values: list[list[float]] = field(default_factory=list)


class IntervalTracker:
    """Finds the active intervals of N levels.

    Args:
        lower: (N,) thresholds that end an interval.
        upper: (N,) thresholds that start one, not below the lower ones.
        config: minimum duration and pause.
        dt: time from row to row [s].
    """

    def __init__(self, lower: Array, upper: Array, config: SustainedCause, dt: float) -> None:
        self._lower, self._upper = lower, upper
        self._least, self._pause = config.least / dt, config.pause / dt
        self._open: dict[int, _OpenInterval] = {}
        self._last_row: tuple[list[float], list[list[float]]] | None = None

    def update(
        self, first: int, levels: Array, values: Array, is_final: bool
    ) -> list[ActiveInterval]:
        """Add rows; return the intervals that have ended.

        Args:
            first: index of the first row.
            levels: (m, N).
            values: (m, N, E), kept for every row of an interval.
            is_final: whether no row follows.
        """
        if not len(levels):
            return []
        exceeding = np.flatnonzero((levels > self._upper).any(axis=0)).tolist()
        ended = list[ActiveInterval]()
        for i in sorted({*exceeding, *self._open}):
            ended += self._scan(i, first, levels[:, i].tolist(), values[:, i].tolist())
        self._last_row = levels[-1].tolist(), values[-1].tolist()
        if is_final:
            ended += [self._close(i) for i in sorted(self._open)]
        return [interval for interval in ended if interval.last - interval.start >= self._least]

    def _scan(
        self, i: int, first: int, levels: list[float], values: list[list[float]]
    ) -> list[ActiveInterval]:
        ended = list[ActiveInterval]()
        lower, upper = float(self._lower[i]), float(self._upper[i])
        previous = None
        if self._last_row is not None:
            previous = self._last_row[0][i], self._last_row[1][i]
        for row, level, value in zip(count(first), levels, values, strict=False):
            interval = self._open.get(i)
            if interval is None and level > upper:
                self._open[i] = _opened(row, level, value, previous, upper)
            elif interval is not None:
                interval.values.append(value)
                if level > lower:
                    interval.last, interval.peak = row, max(interval.peak, level)
                elif row - interval.last > self._pause:
                    ended.append(self._close(i))
            previous = level, value
        return ended

    def _close(self, i: int) -> ActiveInterval:
        done = self._open.pop(i)
        values = done.values[: done.last - done.first + 1]
        return ActiveInterval(i, done.start, done.first, done.last, done.peak, values)


def _opened(
    row: int,
    level: float,
    value: list[float],
    previous: tuple[float, list[float]] | None,
    upper: float,
) -> _OpenInterval:
    """Return an interval that starts at a row, or between it and the row before."""
    if previous is None:
        return _OpenInterval(float(row), row, row, level, [value])
    previous_level, previous_value = previous
    since = (level - upper) / (level - previous_level)
    return _OpenInterval(row - since, row - 1, row, level, [previous_value, value])
