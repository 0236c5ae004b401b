"""Boings: creatures that push themselves off the ground.

A push ends where the body is fastest upward, for from there on only its weight acts on it. It
is one if the body then falls as what flies does, and not as what walks up a slope.

Source: Sims 1987, 13.1.2.
"""

from __future__ import annotations

from math import inf

from pipeline.simulation.detect.hearing import event_of_spell, fits
from pipeline.simulation.detect.scenery import Scenery, Seen
from pipeline.simulation.detect.spells import Spell
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.take import SoundEvent
from pipeline.spec.detect import Boing, Detect

AFTER = 0.08
"""How long what has pushed itself off flies at least [s]."""

FREE = 0.7
"""Part of its weight at which it falls at least in this time."""


class Boings:
    """Push-offs of creatures."""

    def __init__(self, scenery: Scenery, detect: Detect) -> None:
        self.scenery, self.words = scenery, detect.boing
        roots = [scenery.root(name) for name in scenery.figures if fits(name, self.words.who)]
        self._solids = [scenery.solids[root] for root in roots if root in scenery.solids]
        self.idle = not self._solids
        self._pushes = [_Push(self.words, scenery.dt) for _ in self._solids]

    def look(self, seen: Seen) -> list[SoundEvent]:
        """See `Watch`."""
        nodes = [solid.node for solid in self._solids]
        height = seen.p[:, nodes, 1]
        rises = seen.by_row((height[1:] - height[:-1]) / self.scenery.dt)
        p = seen.p[seen.told][:, nodes]
        events = []
        for i, (solid, push) in enumerate(zip(self._solids, self._pushes, strict=True)):
            for row, speed in enumerate(rises[:, i].tolist(), seen.first + seen.told.start):
                x, y, z = p[row - seen.first - seen.told.start, i].tolist()
                found = push.look(row, speed, [speed, x, y, z])
                if found is not None:
                    events.append(event_of_spell(found, "boing", solid, self.scenery.clock))
        return events


class _Push:
    """One creature: the greatest speed upward since it last was slow."""

    def __init__(self, words: Boing, dt: float) -> None:
        self._above, self._pause = words.above, words.pause / dt
        self._flight, self._fall = round(AFTER / dt), FREE * GRAVITY * dt
        self._top: tuple[int, float, list[float]] | None = None
        self._told = -inf

    def look(self, row: int, speed: float, values: list[float]) -> Spell | None:
        """Take in the speed upward at a row [m/s]; return the push that it shows to be one."""
        if self._top is None or speed >= self._top[1]:
            self._top = row, speed, values
            return None
        begin, top, kept = self._top
        if row - begin < max(self._flight, 1):
            return None
        # Next time it begins from here.
        self._top = row, speed, values
        flies = top - speed >= self._fall * (row - begin)
        if not flies or top < self._above or begin - self._told < self._pause:
            return None
        self._told = begin
        return Spell(0, float(begin), begin, begin, top, [kept])
