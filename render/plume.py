"""Plumes of flames or smoke, and puffs of dust, as the renderer is given them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Kind = Literal["flame", "smoke"]

SMOKE_WIDENING = 2.4
"""Growth of smoke on its way, in radii of its foot."""

PUFF_REACH = 2.2
"""Radii beyond which nothing is left of a puff."""


@dataclass(frozen=True)
class Plume:
    """Flames or smoke at one moment.

    Attributes:
        kind: whether it glows or scatters.
        p_WP: place that it rises from, in the world [m].
        radius: of that place [m].
        height: that it rises to [m].
        speed: of its rise [m/s].
        wind: along x and z, relative to the place [m/s].
        color: linear, of the light that it gives off or scatters.
        glow: radiance of the middle of flames; 0 for smoke.
        seed: of its noise.
    """

    kind: Kind
    p_WP: tuple[float, float, float]
    radius: float
    height: float
    speed: float
    wind: tuple[float, float]
    color: tuple[float, float, float]
    glow: float
    seed: int

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lowest and highest corner of a box around it, in the world (3,) [m]."""
        wide = self.radius * (1.8 if self.kind == "flame" else 1.8 * (1.0 + SMOKE_WIDENING))
        foot = np.array(self.p_WP)
        rise = max(self.speed, 0.05)
        drift = np.array([self.wind[0], 0.0, self.wind[1]]) * (self.height / rise)
        top = foot + drift + [0.0, self.height, 0.0]
        ends = np.stack([foot - [wide, 0.1 * wide, wide], foot + wide, top - wide, top + wide])
        ends[3, 1], ends[1, 1] = top[1], foot[1]
        return ends.min(axis=0), ends.max(axis=0)

    @property
    def bounding_sphere(self) -> tuple[float, float, float, float]:
        """Middle in the world and radius of a sphere around it [m]."""
        low, high = self.bounds
        x, y, z = (float(value) for value in 0.5 * (low + high))
        return x, y, z, float(0.5 * np.linalg.norm(high - low))


@dataclass(frozen=True)
class Puff:
    """A short-lived cloud of dust or spray at one moment.

    Attributes:
        p_WP: its middle, in the world [m].
        radius: at which its density has fallen to 1/e [m].
        depth: optical depth through its middle.
        color: linear, of the light that it scatters.
        seed: of its noise.
    """

    p_WP: tuple[float, float, float]
    radius: float
    depth: float
    color: tuple[float, float, float]
    seed: int

    @property
    def bounding_sphere(self) -> tuple[float, float, float, float]:
        """Middle in the world and radius of a sphere around it [m]."""
        return *self.p_WP, PUFF_REACH * self.radius
