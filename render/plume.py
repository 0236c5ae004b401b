"""Plumes of flames or smoke, and puffs of dust, as the renderer is given them."""

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
