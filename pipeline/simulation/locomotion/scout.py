"""Scout: looks ahead, so that a creature stops before ground that it cannot go over.

For each leg the footholds are tried that it would need while its body brakes, and before
the body the ground must not rise higher than its belly. Where that fails the way ends
before, and the creature comes to rest there as at the end of any route.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.locomotion.footholds import Footholds
from pipeline.simulation.locomotion.going import Going
from pipeline.simulation.locomotion.paces import Step

PLAIN = 0.15
"""How far from the surface that bodies follow ground may lie to be plain, in leg lengths."""

NOSE = np.linspace(0.0, 1.0, 4)
"""Places looked at before the body, in the way that is new."""


@dataclass(frozen=True)
class Barrier:
    """What ends a way.

    Attributes:
        way: after which the body has to rest [m].
        cause: in words.
    """

    way: float
    cause: str


class Scout:
    """Looks ahead for the creatures of a herd."""

    def __init__(self, footholds: Footholds, going: Going) -> None:
        self.footholds = footholds
        self.going = going
        self.herd = footholds.herd
        self.path = footholds.path
        legs, count = len(self.herd.owner), len(self.herd.names)
        self._seen = np.full(legs, -math.inf)
        self._clear = np.zeros(count)

    def before(self, leg: int) -> Barrier | None:
        """Look for what bars the way of a leg from the start: then it is best not to set out."""
        phase = float(np.mod(self.herd.up[leg], 1.0))
        stride = float(self.going.full[self.herd.owner[leg]])
        barrier = self.ahead(leg, phase * stride, phase, first=0)
        if barrier is None:
            return None
        near = barrier.way < self.going.braking[self.herd.owner[leg]] + stride
        return Barrier(0.0, barrier.cause) if near else barrier

    def ahead(self, leg: int, way: float, phase: float, first: int = 1) -> Barrier | None:
        """Look for what bars the way of a leg that lifts.

        Args:
            leg: which.
            way: that its body has gone [m].
            phase: of the gait at that, whole cycles counted.
            first: the first of its next swings that is not planned yet.
        """
        c = int(self.herd.owner[leg])
        stride, step = float(self.going.full[c]), self.path.paces.step(leg, phase)
        braking = float(self.going.braking[c])
        middle = way + (step.swing + 0.5 * step.stance) * stride
        cycles = 1 + math.ceil(braking / stride)
        end = self.path.routes[c].length
        for k in range(first, cycles + 1):
            there = middle + k * stride
            if there <= self._seen[leg] + 0.5 * stride or there > end:
                continue
            later = replace(step, up=phase + k)
            if not self._stands(leg, there, way + k * stride, later):
                # One stride before it the leg stood well; no nearer than brakes allow.
                return Barrier(max(there - stride, way + braking), "no foothold ahead")
            self._seen[leg] = there
        return self._wall(c, way, braking)

    def _stands(self, leg: int, middle: float, way: float, step: Step) -> bool:
        """Tell whether there is a foothold for a stance whose middle is after `middle` [m]."""
        c, herd = int(self.herd.owner[leg]), self.herd
        xz, turned, _ = self.path.on_route(np.array([c]), np.array([middle]))
        cos, sin = math.cos(float(turned[0])), math.sin(float(turned[0]))
        along, across = herd.rest[leg]
        place = xz[0] + [along * cos + across * sin, across * cos - along * sin]
        footing = self.path.footing
        if footing.allows(c, place[:1], place[1:])[0]:
            if footing.is_level(c):
                return True
            surface, _ = footing.surface(np.array([c]), place[None, :1], place[None, 1:])
            height = self.path.ground.height(place[0], place[1])
            if abs(float(height - surface[0, 0])) < PLAIN * herd.legs.lengths[leg]:
                return True
        return self.footholds.later(leg, way, step) is not None

    def _wall(self, c: int, way: float, braking: float) -> Barrier | None:
        """Return what is too high for the belly on the way that has not been seen yet."""
        nose = float(self.herd.footprint[c, 0])
        last = way + braking + float(self.going.full[c])
        first = max(self._clear[c], way)
        if last <= first:
            return None
        places = first + (last - first) * NOSE
        xz, _, _ = self.path.on_route(np.full(len(places), c), places + nose)
        high = self.path.footing.barred(c, xz[:, 0], xz[:, 1])
        if not high.any():
            self._clear[c] = last
            return None
        before = float(places[max(int(np.argmax(high)) - 1, 0)])
        return Barrier(max(before, way + braking), "the ground ahead is higher than its belly")
