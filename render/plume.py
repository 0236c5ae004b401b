"""Plume: flames or smoke that rise from a place, as the renderer is given them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal["flame", "smoke"]


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
