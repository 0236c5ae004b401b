"""Facade: what tells one house of a street from the next: windows, rails, dormers, signs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from pipeline.production.edging.house import House

WINDOWS = (
    (1.02, 0.85, 2.45),
    (0.86, 0.62, 2.50),
    (1.32, 0.90, 2.35),
    (0.98, 0.10, 2.45),
)
"""Widths of windows, and heights of their lower and upper edges over the floor of a storey [m]."""

RAILED = 0.45
"""Height of a sill below which a window has a rail before it [m]."""

RAIL, BARS = 0.92, 0.11
"""Height of a rail and distance between its bars [m]."""

DORMER = (1.2, 1.5, 1.9)
"""Width, height over the roof at its front, and depth of a dormer [m]."""

DORMER_BACK = 1.25
"""Distance of the front of a dormer from the facade [m]."""

PIPE = 0.09
"""Thickness of gutters and pipes [m]."""


def add_rail(house: House, middle: float, foot: float, wide: float) -> None:
    """Add an iron rail on the sill before a tall window.

    Args:
        house: to which it is added.
        middle: of the window along the facade [m].
        foot: of the rail [m].
        wide: of the window [m].
    """
    long = wide + 0.24
    for up in (0.06, RAIL):
        house.add("iron", (middle, foot + up, 0.13), (long, 0.035, 0.03))
    count = round(long / BARS)
    for k in range(count + 1):
        at = middle + (k / count - 0.5) * long
        house.add("iron", (at, foot + 0.5 * RAIL, 0.13), (0.018, RAIL, 0.018))


def add_dormers(house: House, pitch: float) -> None:
    """Add windows that stand out of the front of a roof, one in every other bay.

    Args:
        house: to which they are added.
        pitch: rise of its roof per metre.
    """
    wide, high, deep = DORMER
    foot = house.tall + DORMER_BACK * pitch
    bay = house.size[0] / house.bays
    for k in range(house.bays % 2, house.bays, 2):
        x = (k + 0.5) * bay - 0.5 * house.size[0]
        back = -DORMER_BACK - 0.5 * deep
        house.add(house.plaster, (x, foot + 0.5 * high - 0.2, back), (wide, high + 0.4, deep))
        house.add("window frame", (x, foot + 0.72, -DORMER_BACK), (0.86, 1.12, 0.08))
        for side in (-0.2, 0.2):
            house.add("pane", (x + side, foot + 0.72, -DORMER_BACK), (0.34, 1.0, 0.11))
        roof = (x, foot + high + 0.08, back + 0.1)
        house.add("tile dark", roof, (wide + 0.36, 0.1, deep + 0.5), 0.16)


def add_gutter(house: House, out: float, drop: float) -> None:
    """Add a gutter along the eaves and a pipe from it to the ground at one corner.

    Args:
        house: to which they are added.
        out: distance of the eaves from the facade [m].
        drop: height of the top of the wall over the eaves [m].
    """
    wide, eaves = house.size[0], house.tall - drop
    house.add("zinc", (0.0, eaves - 0.03, out + 0.4 * PIPE), (wide + 0.1, PIPE, 1.2 * PIPE))
    side = 0.5 * wide - 0.55
    if house.rng.uniform() < 0.5:
        side = -side
    foot = house.foot - house.level
    house.add("zinc", (side, 0.5 * (eaves - 0.6 + foot), 0.17), (PIPE, eaves - 0.6 - foot, PIPE))
    house.add("zinc", (side, eaves - 0.35, 0.5 * out + 0.1), (PIPE, PIPE, out), -0.9)


def add_sign(house: House, colour: str) -> None:
    """Add a board on an arm over the ground floor of a shop, beside its door."""
    bay = house.size[0] / house.bays
    x = (house.door + float(house.rng.choice((0.0, 1.0)))) * bay - 0.5 * house.size[0]
    x = float(np.clip(x, 0.4 - 0.5 * house.size[0], 0.5 * house.size[0] - 0.4))
    house.add("iron", (x, 3.75, 0.55), (0.035, 0.035, 1.1))
    house.add("iron", (x, 3.6, 0.3), (0.025, 0.025, 0.65), -0.5)
    house.add(colour, (x, 3.3, 0.66), (0.045, 0.62, 0.74))
    house.add("awning white", (x, 3.3, 0.66), (0.055, 0.5, 0.6))
    house.add(colour, (x, 3.3, 0.66), (0.065, 0.22, 0.26))
