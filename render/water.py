"""Water surface: level, waves and optics of the water in a shot.

The waves are a sum of travelling sines whose lengths, directions and phases follow from the
strength and the heading alone, so that any frame can be computed by itself. Long waves are
faster than short ones, as they are in deep water.

Source: J. Tessendorf, Simulating Ocean Water, 2001, section 3, for sums of waves by the
dispersion relation of deep water; C. Mobley, Light and Water, 1994, for absorption.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from render.color import linear
from render.config.water import Water

GRAVITY = 9.81
"""[m/s²]."""

REFRACTIVE_INDEX = 1.333
"""Of water."""

COUNT = 14
"""Number of waves."""

SHORTEST = 0.26
"""Length of the shortest wave [m]."""

_LONGEST, _LONGEST_PER_STRENGTH = 0.9, 11.0
_STEEPNESS = 0.26
"""Root of the mean squared slope at strength 1, a fresh wind."""

_SPREAD = 1.15
"""Directions of waves lie within this angle of the heading [rad]."""

_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)

_BACKSCATTER = 0.42
"""Share of light that deep water of colour 1 sends back."""


@dataclass(frozen=True)
class Wave:
    """One travelling sine, `amplitude * sin(k . p - speed * t + phase)`.

    Attributes:
        amplitude: [m].
        k: wave vector along x and z [rad/m].
        speed: angular [rad/s].
        phase: at time 0 [rad].
    """

    amplitude: float
    k: tuple[float, float]
    speed: float
    phase: float

    @property
    def length(self) -> float:
        """Distance of two crests [m]."""
        return 2.0 * math.pi / math.hypot(*self.k)

    def phase_at(self, time: float) -> float:
        """Return the phase at a time [s], 0 to 2 pi."""
        return (self.phase - self.speed * time) % (2.0 * math.pi)


@dataclass(frozen=True)
class WaterSurface:
    """The water of a shot; constant over a film.

    Attributes:
        level: mean height of the surface [m].
        waves: by length, the shortest first; empty for a mirror.
        extinction: by colour [1/m].
        albedo: share of light that deep water sends back, by colour.
        surf: share of the surface that the foam of breakers hides where it is thick.
    """

    level: float
    waves: tuple[Wave, ...]
    extinction: tuple[float, float, float]
    albedo: tuple[float, float, float]
    surf: float = 0.0

    @staticmethod
    def of(water: Water) -> WaterSurface:
        """Return the surface that an author describes."""
        color = linear(water.color).clip(0.004, 0.98)
        # What the colour lacks is absorbed sooner; the mean is what the author asks for.
        absorbed = np.log(color) / np.log(color).mean()
        extinction = math.log(10.0) / water.clarity * absorbed
        r, g, b = extinction.tolist()
        albedo = (_BACKSCATTER * color).tolist()
        waves = travelling_waves(water.waves, water.heading_deg)
        sent_back = (albedo[0], albedo[1], albedo[2])
        return WaterSurface(water.level, waves, (r, g, b), sent_back, water.surf)


def travelling_waves(strength: float, heading_deg: float) -> tuple[Wave, ...]:
    """Return the waves of a strength, 0 to 1, that travel in a heading."""
    if strength <= 0.0:
        return ()
    longest = _LONGEST + _LONGEST_PER_STRENGTH * strength**1.5
    steepness = _STEEPNESS * strength**1.3 * math.sqrt(2.0 / COUNT)
    heading = math.radians(heading_deg)
    waves = []
    for i in range(COUNT):
        # A little off the geometric series, or the sum would repeat.
        part = (i + 0.35 * math.sin(2.4 * i)) / (COUNT - 1)
        length = SHORTEST * (longest / SHORTEST) ** min(max(part, 0.0), 1.0)
        # Short waves run in all directions, long ones with the wind.
        turn = _SPREAD * (2.0 * ((i * _GOLDEN + 0.3) % 1.0) - 1.0) * (1.6 - part)
        number = 2.0 * math.pi / length
        k = number * math.cos(heading + turn), -number * math.sin(heading + turn)
        phase = 2.0 * math.pi * ((i * _GOLDEN * 7.0) % 1.0)
        waves.append(Wave(steepness / number, k, math.sqrt(GRAVITY * number), phase))
    return tuple(waves)
