"""Facade: the front of a house, and what tells it from the next: windows, rails, dormers, signs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.production.edging.carpentry import Carpentry
from pipeline.simulation.spatial import Array

BAY = 2.35
"""Width of wall for each window, about [m]."""

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


@dataclass(frozen=True, eq=False)
class Facade:
    """The front of a house, which faces a floor.

    Attributes:
        carpentry: to which it is added.
        place: middle of its foot, x and z [m].
        heading: of it [rad].
        size: width, and depth of the house away from the floor [m].
        storeys: their number.
        level: height of the threshold [m].
        foot: height of the lowest ground around [m].
        rng: of what differs from house to house.
        door: of its bays, from the left, which has the door.
    """

    carpentry: Carpentry
    place: Array
    heading: float
    size: tuple[float, float]
    storeys: int
    level: float
    foot: float
    rng: np.random.Generator
    door: int

    @property
    def bays(self) -> int:
        """Number of openings of a storey."""
        return bays(self.size[0])

    def add(
        self,
        material: str,
        at: tuple[float, float, float],
        size: tuple[float, float, float],
        lean: float = 0.0,
        top: tuple[float, float] = (1.0, 1.0),
    ) -> None:
        """Add a box by its place along, over and before the facade; see `Carpentry.add`."""
        self.carpentry.add(f"edging {material}", self.at(at), size, self.heading, lean, top)

    def at(self, place: tuple[float, float, float]) -> Array:
        """Return a point (3,) by its place along, over and before the facade [m]."""
        along, up, before = place
        c, s = np.cos(self.heading), np.sin(self.heading)
        x = self.place[0] + c * along + s * before
        z = self.place[1] - s * along + c * before
        return np.array([x, self.level + up, z])

    def rail(self, middle: float, foot: float, wide: float) -> None:
        """Add an iron rail before a tall window.

        Args:
            middle: of the window along the facade [m].
            foot: of the rail [m].
            wide: of the window [m].
        """
        long = wide + 0.24
        for up in (0.06, RAIL):
            self.add("iron", (middle, foot + up, 0.13), (long, 0.035, 0.03))
        count = round(long / BARS)
        for k in range(count + 1):
            at = middle + (k / count - 0.5) * long
            self.add("iron", (at, foot + 0.5 * RAIL, 0.13), (0.018, RAIL, 0.018))

    def dormers(self, plaster: str, eaves: float, pitch: float) -> None:
        """Add windows that stand out of the front of a roof, one in every other bay.

        Args:
            plaster: material of their walls.
            eaves: height of the top of the wall [m].
            pitch: rise of the roof per metre.
        """
        wide, high, deep = DORMER
        foot = eaves + DORMER_BACK * pitch
        bay = self.size[0] / self.bays
        for k in range(self.bays % 2, self.bays, 2):
            x = (k + 0.5) * bay - 0.5 * self.size[0]
            back = -DORMER_BACK - 0.5 * deep
            self.add(plaster, (x, foot + 0.5 * high - 0.2, back), (wide, high + 0.4, deep))
            self.add("window frame", (x, foot + 0.72, -DORMER_BACK), (0.86, 1.12, 0.08))
            for side in (-0.2, 0.2):
                self.add("pane", (x + side, foot + 0.72, -DORMER_BACK), (0.34, 1.0, 0.11))
            roof = (x, foot + high + 0.08, back + 0.1)
            self.add("tile dark", roof, (wide + 0.36, 0.1, deep + 0.5), 0.16)

    def gutter(self, eaves: float, out: float) -> None:
        """Add a gutter along the eaves and a pipe from it to the ground at one corner.

        Args:
            eaves: height of the lower edge of the roof [m].
            out: distance of that from the facade [m].
        """
        wide = self.size[0]
        self.add("zinc", (0.0, eaves - 0.03, out + 0.4 * PIPE), (wide + 0.1, PIPE, 1.2 * PIPE))
        side = 0.5 * wide - 0.55
        if self.rng.uniform() < 0.5:
            side = -side
        foot = self.foot - self.level
        self.add("zinc", (side, 0.5 * (eaves - 0.6 + foot), 0.17), (PIPE, eaves - 0.6 - foot, PIPE))
        self.add("zinc", (side, eaves - 0.35, 0.5 * out + 0.1), (PIPE, PIPE, out), -0.9)

    def sign(self, colour: str) -> None:
        """Add a board in a colour on an arm over the ground floor of a shop, beside its door."""
        wide = self.size[0]
        x = (self.door + float(self.rng.choice((0.0, 1.0)))) * wide / self.bays - 0.5 * wide
        x = float(np.clip(x, 0.4 - 0.5 * wide, 0.5 * wide - 0.4))
        self.add("iron", (x, 3.75, 0.55), (0.035, 0.035, 1.1))
        self.add("iron", (x, 3.6, 0.3), (0.025, 0.025, 0.65), -0.5)
        self.add(colour, (x, 3.3, 0.66), (0.045, 0.62, 0.74))
        self.add("awning white", (x, 3.3, 0.66), (0.055, 0.5, 0.6))
        self.add(colour, (x, 3.3, 0.66), (0.065, 0.22, 0.26))


def bays(wide: float) -> int:
    """Return the number of openings of a storey of a house of a width [m]."""
    return max(round(wide / BAY), 2)
