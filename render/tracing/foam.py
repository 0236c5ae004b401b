"""Foam on water for Dr.Jit: at the edge of a shore, and of the breakers before it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.lights.lattice_noise import noise2
from render.water import WaterSurface

_CALM_DEPTH, _DEPTH_PER_HEIGHT = 0.011, 3.0
"""Depth in which foam lies at a shore [m], and relative to the mean height of the waves."""

_FROM, _SHARE_PER_HEIGHT, _MOST, _ALBEDO = 0.004, 16.0, 0.85, 0.6
"""Mean height of waves from which there is foam [m]: calm water has none; share of the surface that
foam hides where it is thick, for each metre beyond and at most; share of light that it sends
back."""

_UPRIGHT, _BESIDE = (0.45, 0.3), 0.25
"""Vertical component of the ground's normal at which foam begins, and its rise up to full foam; and
the share that is left in patches beside steeper ground."""

_CELLS = (0.31, 0.083)
"""Widths of patches and of bubbles of foam [m]."""

_BREAKER_DEPTH, _BREAKER_WANDER = 0.42, 0.8
"""Difference in depth between two lines of breakers [m], and how far they wander, in lines."""

_BREAKER_SPAN, _BREAKER_CREST, _BREAKER_TRAIL = 3.2, 0.09, 0.75
"""Depth from which waves break, in lines; width of the crest of foam, and of what it leaves behind,
in lines."""

_BREAKER_LENGTHS = (8.0, 3.1)
"""Lengths of the bends and of the gaps of a line of breakers [m]."""

_BREAKERS_FULL = 0.02
"""Mean height of waves beyond that of the first foam at which they break fully [m]."""

_BREAKER_PERIOD = 5.2
"""Time from one breaker to the next [s]."""


@dataclass
class Foam:
    """The foam of one water at one moment, opaque to recordings.

    Attributes:
        radiance: of it.
        depth: of the water up to which it lies at a shore [m].
        most: share of the surface that it hides where it is thick.
        surf: share that the foam of breakers hides where it is thick, None where none break.
        swash: phase of the wave with which it comes and goes, None on still water.
        breaking: time since a line of breakers began, in their period.
    """

    radiance: mi.Color3f
    depth: mi.Float
    most: mi.Float
    surf: mi.Float | None
    swash: mi.Float | None
    breaking: mi.Float

    @staticmethod
    def of(surface: WaterSurface, downwelling: Any) -> Foam:
        """Return the foam of a surface, before its waves move.

        Args:
            surface: of a shot.
            downwelling: (3,) irradiance of level ground by sun and sky.
        """
        height = math.sqrt(0.5 * sum(w.amplitude**2 for w in surface.waves))
        surf = surface.surf * min(max(height - _FROM, 0.0) / _BREAKERS_FULL, 1.0)
        radiance = _ALBEDO * np.asarray(downwelling) / np.pi
        made = Foam(
            mi.Color3f(radiance.tolist()),
            mi.Float(_CALM_DEPTH + _DEPTH_PER_HEIGHT * height),
            mi.Float(min(_SHARE_PER_HEIGHT * max(height - _FROM, 0.0), _MOST)),
            dr.opaque(mi.Float, surf) if surf > 0.0 else None,
            None,
            mi.Float(0.0),
        )
        dr.make_opaque(made.radiance, made.depth, made.most)
        return made

    def set_time(self, time: float, swash: mi.Float | None) -> None:
        """Move it to a time of the film [s], with the phase of a wave."""
        self.swash = swash
        self.breaking = dr.opaque(mi.Float, time / _BREAKER_PERIOD % 1.0)

    def share(self, p: Any, depth: Any, normal: Any) -> Any:
        """Return the share of the surface that foam hides where water is as deep as this [m].

        A ragged line of it lies at the edge and a broken one before that, and both come and go
        with the waves; farther out breakers roll in. Beside steep stones, where they would be two
        thin cords, a faint broken trace is left.

        Args:
            p: places on the surface [m].
            depth: of the water there [m].
            normal: of the ground below.
        """
        patches = noise2(p.x / _CELLS[0], p.z / _CELLS[0], 71)
        bubbles = noise2(p.x / _CELLS[1], p.z / _CELLS[1], 72)
        swash = mi.Float(0.0)
        if self.swash is not None:
            swash = dr.sin(self.swash + 5.0 * patches)
        part = depth / (self.depth * (0.55 + 0.7 * patches + 0.25 * swash))
        edge = 1.0 - dr.clip(part / 0.45, 0.0, 1.0)
        line = dr.clip(1.0 - dr.abs(part - 0.8) / 0.22, 0.0, 1.0)
        thick = edge + 0.75 * line * dr.clip(3.0 * patches - 0.9, 0.0, 1.0)
        thick *= 0.1 + 1.5 * patches * bubbles
        shore = dr.clip((normal.y - _UPRIGHT[0]) / _UPRIGHT[1], 0.0, 1.0)
        shore = dr.maximum(shore, _BESIDE * dr.clip(3.0 * patches - 1.0, 0.0, 1.0))
        share = self.most * dr.clip(thick, 0.0, 1.0)
        if self.surf is not None:
            # Breakers are seen from afar, where bubbles would be noise between pixels.
            broken = dr.clip(0.9 * self._breakers(p, depth), 0.0, 1.0)
            share = dr.maximum(share, self.surf * broken)
        return shore * share

    def _breakers(self, p: Any, depth: Any) -> Any:
        """Return how thick foam lies of waves that break where the ground rises.

        Each line has a sharp crest on the side of the shore and leaves a torn sheet behind, and
        runs from a depth to the edge, bent and with gaps.
        """
        bend = noise2(p.x / _BREAKER_LENGTHS[0], p.z / _BREAKER_LENGTHS[0], 73)
        gaps = noise2(p.x / _BREAKER_LENGTHS[1], p.z / _BREAKER_LENGTHS[1], 74)
        place = depth / _BREAKER_DEPTH + _BREAKER_WANDER * bend
        behind = place + self.breaking
        behind -= dr.floor(behind)
        crest = 1.0 - dr.clip(behind / _BREAKER_CREST, 0.0, 1.0)
        trail = 1.0 - dr.clip(behind / _BREAKER_TRAIL, 0.0, 1.0)
        breaks = dr.clip(1.5 - 1.5 * place / _BREAKER_SPAN, 0.0, 1.0)
        return breaks * (crest * dr.clip(4.0 * gaps - 0.8, 0.0, 1.6) + 0.5 * trail * gaps)
