"""Stall: a table of fruit in crates under a roof of cloth, of which no two are alike."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pipeline.production.edging.border import Border
from pipeline.production.scenery.expansion import Copies
from pipeline.production.scenery.prototype import UP, Prototype, Shape
from pipeline.production.scenery.stones import icosphere
from pipeline.simulation.spatial import Array

CLOTHS = ("awning red", "awning green", "awning blue")

GOODS = (
    (0.58, 0.20, 0.03),
    (0.42, 0.04, 0.03),
    (0.55, 0.42, 0.06),
    (0.16, 0.30, 0.05),
    (0.15, 0.04, 0.12),
    (0.50, 0.26, 0.14),
)
"""Linear colours of fruit."""

FRUIT_RADIUS, FRUITS, HEAP = 0.05, 46, 0.11
"""Radius of a fruit [m], their number in a crate, and how high they are heaped [m]."""

UPTURNED = 0.26
"""Height of the upturned crates on which others stand on the ground [m]."""

BACK_ROW = 0.16
"""How much higher the crates of the second row stand than those of the first [m]."""

RIDGED, STRIPED = 0.55, 0.6
"""Shares of the stalls whose roof has a ridge, and whose cloth has stripes."""

STRIPE = 0.25
"""Width of a stripe [m]."""

RIDGE_ROOF = ((-0.45, 2.42, 1.04, 0.5), (0.45, 2.42, 1.04, -0.5))
SHED_ROOF = ((0.0, 2.4, 1.95, 0.24),)
"""Slopes of a roof: how far back and how high their middles are, how deep they are [m], how steep
[rad]."""

RIDGE_HEMS, SHED_HEMS = ((-0.9, 2.09), (0.9, 2.09)), ((-0.94, 2.09),)
"""Hems of the cloth: how far back and how high they hang [m]."""


@dataclass(frozen=True, eq=False)
class Stall:
    """Where a stall is built.

    Attributes:
        border: to which it is added.
        foot: (3,) middle of its ground [m].
        heading: of its length [rad].
        back: (3,) unit vector away from its buyers.
        rng: of what differs from stall to stall.
    """

    border: Border
    foot: Array
    heading: float
    back: Array
    rng: np.random.Generator

    def build(self) -> None:
        """Add all of it."""
        long = float(self.rng.uniform(2.0, 3.0))
        cloth = str(self.rng.choice(CLOTHS))
        has_ridge, is_striped = self.rng.uniform(size=2) < (RIDGED, STRIPED)
        self._roof(long, cloth, has_ridge=bool(has_ridge), is_striped=bool(is_striped))
        self._table(long - 0.4, "awning white" if is_striped else "weathered")
        # Crates on the ground before it and beside it.
        for x, z in ((-0.42, -0.86), (0.12, -0.9), (-0.58, 0.3), (0.57, -0.1)):
            self._add("weathered", (x * long, 0.5 * UPTURNED, z), (0.44, UPTURNED, 0.4))
            self._crate(x * long, UPTURNED, z)

    def _at(self, along: float, up: float, back: float) -> Array:
        way = np.array([np.cos(self.heading), 0.0, -np.sin(self.heading)])
        return np.asarray(self.foot + along * way + up * UP + back * self.back)

    def _add(
        self,
        material: str,
        at: tuple[float, float, float],
        size: tuple[float, float, float],
        lean: float = 0.0,
    ) -> None:
        """Add a box by its place along, over and behind the foot; see `Carpentry.add`."""
        self.border.carpentry.add(f"edging {material}", self._at(*at), size, self.heading, lean)

    def _roof(self, long: float, cloth: str, *, has_ridge: bool, is_striped: bool) -> None:
        """Add posts and the cloth over them."""
        lift = float(self.rng.uniform(-0.12, 0.2))
        for x in (0.12 - 0.5 * long, 0.5 * long - 0.12):
            for z, up in ((-0.7, 2.2 + lift), (0.7, (2.2 if has_ridge else 2.55) + lift)):
                self._add("weathered", (x, 0.5 * up, z), (0.06, up, 0.06))
        count = round(long / STRIPE)
        wide = long / count
        for k in range(count):
            x = ((k + 0.5) / count - 0.5) * long
            stripe = "awning white" if k % 2 and is_striped else cloth
            for z, up, deep, steep in RIDGE_ROOF if has_ridge else SHED_ROOF:
                self._add(stripe, (x, up + lift, z), (wide, 0.015, deep), steep)
            for z, up in RIDGE_HEMS if has_ridge else SHED_HEMS:
                self._add(stripe, (x, up + lift, z), (wide, 0.18, 0.012))

    def _table(self, long: float, skirt: str) -> None:
        """Add a table with a skirt before it and crates of fruit on it."""
        self._add("weathered", (0.0, 0.78, 0.0), (long, 0.05, 1.0))
        high = float(self.rng.uniform(0.25, 0.68))
        self._add(skirt, (0.0, 0.77 - 0.5 * high, -0.48), (long - 0.02, high, 0.015))
        self._add("weathered", (0.0, 0.8 + 0.5 * BACK_ROW, 0.26), (long - 0.04, BACK_ROW, 0.44))
        crates = max(round(long / 0.52), 2)
        for k in range(crates):
            x = ((k + 0.5) / crates - 0.5) * (long - 0.08)
            self._crate(x, 0.805, -0.24)
            self._crate(x, 0.805 + BACK_ROW, 0.26)

    def _crate(self, x: float, up: float, z: float) -> None:
        """Add a crate whose bottom is this high, with fruit heaped in it."""
        for side in (-0.21, 0.21):
            self._add("weathered", (x, up + 0.06, z + side), (0.46, 0.12, 0.016))
            self._add("weathered", (x + 1.07 * side, up + 0.06, z), (0.016, 0.12, 0.42))
        color = GOODS[int(self.rng.integers(0, len(GOODS)))]
        rng, n = self.rng, FRUITS
        # A heap is highest in its middle.
        aside = rng.uniform(-1.0, 1.0, (n, 2))
        high = up + 0.07 + HEAP * np.prod(1.0 - aside**2, axis=1) * rng.uniform(0.7, 1.0, n)
        spots = np.array(
            [
                self._at(x + 0.18 * along, y, z + 0.17 * back)
                for (along, back), y in zip(aside, high, strict=True)
            ]
        )
        tints = np.array(color) * rng.uniform(0.8, 1.2, (n, 1))
        scales = FRUIT_RADIUS * rng.uniform(0.85, 1.1, (n, 1)) * np.ones(3)
        upright = np.tile(np.eye(3), (n, 1, 1))
        self.border.leaves.append(Copies(_fruit(), spots, upright, scales, tints))


@lru_cache(maxsize=1)
def _fruit() -> Prototype:
    vertices, faces = icosphere(1)
    shape = Shape()
    shape.add(vertices, vertices, np.full(3, 0.9), faces, thin=False)
    return shape.prototype()
