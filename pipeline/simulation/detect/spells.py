"""Spells: times during which something is quick, by two thresholds and two times.

A spell begins where a level goes over its upper threshold, between two rows if need be. It
ends at the last row over the lower one, once it has been under it for longer than a pause.
Spells that are shorter than the least are none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import count

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.spec.sound_thresholds import Lasting


@dataclass(frozen=True, slots=True)
class Spell:
    """Something was quick.

    Attributes:
        thing: its number.
        begin: when, in rows.
        first: the last row that is not after the begin.
        last: the last row of it.
        top: the greatest level.
        values: of the thing at each row from the first to the last.
    """

    thing: int
    begin: float
    first: int
    last: int
    top: float
    values: Sequence[Sequence[float]]


@dataclass(slots=True)
class _Open:
    begin: float
    first: int
    last: int
    top: float
    values: list[list[float]] = field(default_factory=list)


class Spells:
    """The spells of N things.

    Args:
        lower: (N,) thresholds that end a spell.
        upper: (N,) thresholds that begin one, none under its lower one.
        words: how long spells and pauses are.
        dt: time from row to row [s].
    """

    def __init__(self, lower: Array, upper: Array, words: Lasting, dt: float) -> None:
        self.lower, self.upper = lower, upper
        self._least, self._pause = words.least / dt, words.pause / dt
        self._open: dict[int, _Open] = {}
        self._before: tuple[list[float], list[list[float]]] | None = None

    def look(self, first: int, level: Array, values: Array, final: bool) -> list[Spell]:
        """Take in rows that follow the last ones; return the spells that have ended.

        Args:
            first: number of the first row.
            level: (m, N).
            values: (m, N, E) to be kept of every row of a spell.
            final: whether no row follows.
        """
        if not len(level):
            return []
        stirs = np.flatnonzero((level > self.upper).any(axis=0)).tolist()
        ended = list[Spell]()
        for thing in sorted({*stirs, *self._open}):
            ended += self._scan(thing, first, level[:, thing].tolist(), values[:, thing].tolist())
        self._before = level[-1].tolist(), values[-1].tolist()
        if final:
            ended += [self._ended(thing) for thing in sorted(self._open)]
            self._open.clear()
        return [spell for spell in ended if spell.last - spell.begin >= self._least]

    def _scan(
        self, thing: int, first: int, level: list[float], values: list[list[float]]
    ) -> list[Spell]:
        ended = list[Spell]()
        lower, upper = float(self.lower[thing]), float(self.upper[thing])
        before = None
        if self._before is not None:
            before = self._before[0][thing], self._before[1][thing]
        for row, now, kept in zip(count(first), level, values, strict=False):
            spell = self._open.get(thing)
            if spell is None and now > upper:
                self._open[thing] = _begun(row, now, kept, before, upper)
            elif spell is not None:
                spell.values.append(kept)
                if now > lower:
                    spell.last, spell.top = row, max(spell.top, now)
                elif row - spell.last > self._pause:
                    ended.append(self._ended(thing))
                    del self._open[thing]
            before = now, kept
        return ended

    def _ended(self, thing: int) -> Spell:
        spell = self._open[thing]
        values = spell.values[: spell.last - spell.first + 1]
        return Spell(thing, spell.begin, spell.first, spell.last, spell.top, values)


def _begun(
    row: int,
    now: float,
    kept: list[float],
    before: tuple[float, list[float]] | None,
    upper: float,
) -> _Open:
    """Return a spell that begins at a row or on the straight way there."""
    if before is None:
        return _Open(float(row), row, row, now, [kept])
    level, values = before
    since = (now - upper) / (now - level)
    return _Open(row - since, row - 1, row, now, [values, kept])
