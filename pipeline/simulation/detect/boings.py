"""Boings: creatures that push themselves off the ground.

A push ends where the body is fastest upward, for from there on only its weight acts on it. It
is one if the body then falls as what flies does, and not as what walks up a slope, and if the
feet come along, as they do not with who gets up.

Source: Sims 1987, 13.1.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from math import inf

import numpy as np

from pipeline.simulation.detect.hearing import event_of_spell, fits
from pipeline.simulation.detect.scenery import Scenery, Seen, Solid
from pipeline.simulation.detect.spells import Spell
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.take import SoundEvent
from pipeline.spec.sound_thresholds import Boing, Detect

AFTER = 0.08
"""How long what has pushed itself off flies at least [s]."""

FREE = (0.7, 1.5)
"""Parts of its weight between which it falls in this time; what falls quicker is held back."""

ALONG = 0.5
"""Part of the way of its body that its lowest joint goes up at least in this time."""

NEAR = 2.0
"""Rows within which the last foot leaves the ground."""


class Boings:
    """Push-offs of creatures; those who are carried are not heard."""

    def __init__(self, scenery: Scenery, detect: Detect) -> None:
        self.scenery, self.words = scenery, detect.boing
        roots = [scenery.root(name) for name in scenery.figures if fits(name, self.words.who)]
        free = [n for n in roots if n in scenery.solids and scenery.nodes[n].parent < 0]
        self._pushes = [_Push(scenery, scenery.solids[n], self.words) for n in free]
        self.idle = not self._pushes

    def look(self, seen: Seen) -> list[SoundEvent]:
        """See `Watch`."""
        clock = self.scenery.clock
        found = [(push, spell) for push in self._pushes for spell in push.look(seen)]
        return [event_of_spell(spell, "boing", push.solid, clock) for push, spell in found]


class _Push:
    """One creature: the greatest speed upward since it last was slow.

    Attributes:
        solid: its body.
    """

    def __init__(self, scenery: Scenery, solid: Solid, words: Boing) -> None:
        self.solid, self._dt = solid, scenery.dt
        own = [i for i, n in enumerate(scenery.nodes) if n.performer == solid.performer]
        self._own = np.array(own, dtype=np.int64)
        self._above, self._pause = words.above, words.pause / self._dt
        self._flight = max(round(AFTER / self._dt), 1)
        self._top: _Moment | None = None
        self._told, self._stood = -inf, False

    def look(self, seen: Seen) -> Iterator[Spell]:
        """Yield the pushes that have become known."""
        body = seen.p[:, self.solid.node]
        rises = seen.by_row((body[1:, 1] - body[:-1, 1]) / self._dt).tolist()
        lowest = seen.p[seen.told][:, self._own, 1].min(axis=1).tolist()
        places = body[seen.told].tolist()
        rows = count(seen.first + seen.told.start)
        lifts = seen.lifts.get(self.solid.performer, ())
        for row, rise, low, place in zip(rows, rises, lowest, places, strict=False):
            push = self._goes_on(_Moment(row, rise, low, place), lifts)
            if push is not None:
                begin = max(_near(push.row, lifts), default=float(push.row))
                values = [[push.rise, *push.place]]
                yield Spell(0, begin, int(begin), int(begin), push.rise, values)

    def _goes_on(self, now: _Moment, lifts: Sequence[float]) -> _Moment | None:
        """Take in a row; return the moment of the push that it shows to be one.

        Args:
            now: the row.
            lifts: rows at which contacts say that a foot leaves the ground.
        """
        top = self._top
        # In one flight there is one push: the speed upward has to come up again.
        self._stood = self._stood or now.rise < 0.5 * self._above
        if not self._stood:
            return None
        if top is None or now.rise >= top.rise:
            self._top = now
            return None
        rows = now.row - top.row
        lifted = bool(_near(top.row, lifts))
        if rows < self._flight and not lifted:
            return None
        # The next one begins from here.
        self._top = now
        soon = top.row - self._told < self._pause
        if top.rise < self._above or soon or not (lifted or self._flies(top, now)):
            return None
        self._told, self._stood, self._top = top.row, False, None
        return top

    def _flies(self, top: _Moment, now: _Moment) -> bool:
        """Tell whether a creature falls from one moment to another, and its feet come along."""
        fall = (top.rise - now.rise) / (GRAVITY * self._dt * (now.row - top.row))
        along = now.low - top.low >= ALONG * (now.place[1] - top.place[1])
        return FREE[0] <= fall <= FREE[1] and along


def _near(row: int, lifts: Sequence[float]) -> list[float]:
    """Return when feet left the ground about a row, in rows."""
    return [lift for lift in lifts if abs(lift - row) <= NEAR]


@dataclass(frozen=True, slots=True)
class _Moment:
    """A creature at a row: its speed upward, its lowest joint, and where its body is."""

    row: int
    rise: float
    low: float
    place: list[float]
