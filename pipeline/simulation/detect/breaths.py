"""Breaths: creatures that breathe, quicker when they run.

At rest as often as their mass has it, 53.5 m^-0.26 times a minute; on the move as often as a
number of strides has it, if that is oftener.

Source: Sims 1987, 13.1.2; Stahl 1967 (rate by mass); Bramble and Carrier 1983 (by strides).
"""

from __future__ import annotations

from collections.abc import Iterator
from math import floor

from pipeline.simulation.detect.hearing import event_of_spell, fits
from pipeline.simulation.detect.scenery import Scenery, Seen, Solid
from pipeline.simulation.detect.spells import Spell
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.take import SoundEvent
from pipeline.spec.sound_thresholds import Breath, Detect

OUT = 0.4
"""Part of a breath in which it goes out, and is heard."""

FLOW = 0.6
"""Speed of the air at rest; in quick breaths more [m/s]."""


class Breaths:
    """Breaths of creatures."""

    def __init__(self, scenery: Scenery, detect: Detect) -> None:
        self.scenery = scenery
        self._breathers = [
            _Breather(scenery, name, figure, detect.breath)
            for name, figure in scenery.figures.items()
            if fits(name, detect.breath.who)
        ]
        self.idle = not self._breathers

    def look(self, seen: Seen) -> list[SoundEvent]:
        """See `Watch`."""
        found = [(one, spell) for one in self._breathers for spell in one.look(seen)]
        clock = self.scenery.clock
        return [event_of_spell(spell, "breath", one.mouth, clock) for one, spell in found]


class _Breather:
    """One creature that breathes.

    Attributes:
        mouth: the part that is heard: its head, or its body if it has none.
    """

    def __init__(self, scenery: Scenery, name: str, figure: Figure, words: Breath) -> None:
        own = [s for s in scenery.solids.values() if s.performer == name]
        heads = [s for s in own if s.part.startswith(f"{name}.head")]
        self.mouth: Solid = (heads or own)[-1 if heads else 0]
        mass = FigureMass(figure).mass_of(range(len(figure.skeleton.links)))
        self._rest = (words.per_minute or 53.5 * mass**-0.26) / 60.0
        self._strides, self._dt = words.strides, scenery.dt
        self._gait = scenery.channel(f"{name}.gait_phase")
        self._drawn, self._last_phase = 0.0, 0.0
        self._end = scenery.clock.rows - 1
        self._open: list[tuple[float, float, list[list[float]]]] = []

    def look(self, seen: Seen) -> Iterator[Spell]:
        """Yield the breaths that have ended."""
        rows = range(*seen.told.indices(len(seen.p)))
        for k in rows:
            row = seen.first + k
            rate = self._rate(0.0 if self._gait is None else float(seen.values[k, self._gait]))
            before = self._drawn
            if row > 0:
                self._drawn += rate * self._dt
            flow = FLOW * (rate / self._rest) ** 0.5
            values = [flow, *seen.p[k, self.mouth.node].tolist()]
            for _, _, kept in self._open:
                kept.append(values)
            if floor(self._drawn) > floor(before):
                since = (self._drawn - floor(self._drawn)) / (self._drawn - before)
                begin = row - since
                kept = [values] if begin == row else [values, values]
                self._open.append((begin, begin + OUT / (rate * self._dt), kept))
            yield from self._over(row)

    def _rate(self, phase: float) -> float:
        """Return how often a second it breathes now, given the phase of its gait."""
        gone = (phase - self._last_phase) % 1.0
        self._last_phase = phase
        # Nobody goes through half a cycle from row to row: that is a phase set back.
        strides = gone / self._dt if gone < 0.5 else 0.0
        return max(self._rest, strides / self._strides)

    def _over(self, row: int) -> Iterator[Spell]:
        while self._open and (self._open[0][1] <= row or row == self._end):
            begin, _, kept = self._open.pop(0)
            first = int(begin)
            yield Spell(0, begin, first, first + len(kept) - 1, kept[0][0], kept)
