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

GOODS = ((0.55, 0.19, 0.03), (0.42, 0.05, 0.03), (0.50, 0.40, 0.06), (0.12, 0.22, 0.05))
"""Linear colours of fruit."""

FRUIT_RADIUS, FRUITS = 0.055, 22
"""Radius of a fruit [m], and their number in a crate."""

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
        # Crates beside it.
        for x, z, size in ((-0.55, 0.3, 0.42), (0.54, -0.1, 0.36), (0.55, 0.42, 0.4)):
            at = self._at(x * long, 0.5 * size, z)
            turned = self.heading + self.rng.normal(0.0, 0.2)
            self.border.carpentry.add("edging weathered", at, (size, size, size), turned)

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
        crates = max(round(long / 0.55), 2)
        for k in range(crates):
            x = ((k + 0.5) / crates - 0.5) * (long - 0.1)
            for z in (-0.43, 0.11):
                self._add("weathered", (x, 0.86, z), (0.48, 0.13, 0.02))
            for side in (-0.24, 0.24):
                self._add("weathered", (x + side, 0.86, -0.16), (0.02, 0.13, 0.54))
            self._fruits(x, GOODS[(k + int(self.rng.integers(0, 2))) % len(GOODS)])

    def _fruits(self, middle: float, color: tuple[float, float, float]) -> None:
        """Add the fruit of one crate."""
        rng, n = self.rng, FRUITS
        aside = rng.uniform(-0.2, 0.2, n), rng.uniform(0.0, 0.05, n), rng.uniform(-0.22, 0.22, n)
        spots = np.array(
            [self._at(middle + x, 0.86 + y, z - 0.16) for x, y, z in zip(*aside, strict=True)]
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
