"""Border: where things may stand along a floor, and the plants among them: hedge, palms, trees.

Things stand where the cast does not go, and behind it: none comes between a camera and its target
or fills the foreground of a frame.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.production.edging.carpentry import Carpentry
from pipeline.production.edging.hedges import hedge_length, hedge_tops
from pipeline.production.edging.house_front import Front
from pipeline.production.edging.palms import palm
from pipeline.production.edging.plot import Plot
from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.expansion import Copies
from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.placement import Placed
from pipeline.production.scenery.species import KINDS
from pipeline.simulation.spatial import Array

Height = Callable[[Array], Array]
"""From places (N, 2) to the height of the ground (N,) [m]."""

FOREGROUND = 0.92
"""Share of the distance to the target up to which nothing may stand in a frame."""

LOW = 0.3
"""Height below which things may stand in the foreground [m]."""

CLEAR = 0.5
"""Distance from the cast, besides its own radius [m]."""


@dataclass(frozen=True, eq=False)
class Rows:
    """N places along the sides of a floor.

    Attributes:
        places: (N, 2) [m].
        heading: (N,) of the side [rad].
        outward: (N, 2) unit vectors away from the floor.
        number: (N,) of the side.
    """

    places: Array
    heading: Array
    outward: Array
    number: NDArray[np.int64]

    def taken(self, some: NDArray[np.bool_]) -> Rows:
        """Return some of them."""
        return Rows(self.places[some], self.heading[some], self.outward[some], self.number[some])


@dataclass(frozen=True, eq=False)
class Border:
    """Builds along a rectangle.

    Attributes:
        low: its first corner, x and z [m].
        high: the opposite one [m].
        height: of the ground.
        view: of the film.
        clearings: of the cast.
        seed: of the scene.
        detail: 1 for frames 1280 pixels wide.
        sun: unit vector towards it, None without one.
        carpentry: of wood and iron.
        stones: copies of stone.
        leaves: copies of hedges.
        placed: plants.
        plots: built ground.
        lanterns: (N, 3) places of the lights of street lamps [m], of each row of them.
        fronts: facades of the first row of houses, on which the weather leaves traces.
    """

    low: Array
    high: Array
    height: Height
    view: FilmView
    clearings: Clearings | None
    seed: int
    detail: float
    sun: tuple[float, float, float] | None = None
    carpentry: Carpentry = field(default_factory=Carpentry)
    stones: list[Copies] = field(default_factory=list)
    leaves: list[Copies] = field(default_factory=list)
    placed: list[Placed] = field(default_factory=list)
    plots: list[Plot] = field(default_factory=list)
    lanterns: list[Array] = field(default_factory=list)
    fronts: list[Front] = field(default_factory=list)

    def rows(self, out: float, spacing: float, tall: float, radius: float) -> Rows:
        """Return places where something may stand, at a distance from the floor.

        Args:
            out: beyond the rectangle, negative inside [m].
            spacing: from one to the next, about [m].
            tall: height of what stands there [m].
            radius: of it [m].
        """
        low, high = self.low - out, self.high + out
        corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
        places, headings, outward, number = [], [], [], []
        for k in range(4):
            start, end = corners[k], corners[(k + 1) % 4]
            length = float(np.linalg.norm(end - start))
            count = max(round(length / spacing), 1)
            t = (np.arange(count) + 0.5)[:, None] / count
            way = (end - start) / max(length, 1e-9)
            places.append(start + t * (end - start))
            headings.append(np.full(count, np.arctan2(-way[1], way[0])))
            outward.append(np.tile([way[1], -way[0]], (count, 1)))
            number.append(np.full(count, k))
        every = Rows(*(np.concatenate(part) for part in (places, headings, outward, number)))
        return every.taken(self.is_free(every.places, tall, radius))

    def is_free(self, places: Array, tall: float, radius: float) -> NDArray[np.bool_]:
        """Return at which places (N, 2) something may stand."""
        free = np.ones(len(places), bool)
        if self.clearings is not None:
            free &= self.clearings.distance(*places.T) > radius + CLEAR
        for plot in self.plots:
            free &= ~plot.holds(places, radius)
        points = self.points(places)
        heights, radii = np.full(len(places), tall), np.full(len(places), radius)
        free &= ~self.view.in_the_way(points, heights, radii)
        if tall < LOW:
            return free
        return free & ~self.view.in_the_foreground(points, heights, radii, FOREGROUND)

    def points(self, places: Array) -> Array:
        """Return places (N, 2) on the ground (N, 3)."""
        return np.stack([places[:, 0], self.height(places), places[:, 1]], axis=-1)

    def hedge(self, out: float, tall: float) -> None:
        """Add a clipped hedge."""
        rows = self.rows(out, 0.95, tall, 0.7)
        if not len(rows.places):
            return
        rng = np.random.default_rng([self.seed, 451])
        points = self.points(rows.places) - [0.0, 0.04, 0.0]
        points[:, [0, 2]] += rng.normal(0.0, 0.025, (len(points), 2))
        scales = np.array([1.0, tall, 1.0]) * rng.uniform(0.97, 1.05, (len(points), 3))
        scales[:, 1] *= hedge_tops(rows.places, self.seed)
        # Neighbours of unlike lightness would show where one ends.
        tints = rng.uniform(0.94, 1.06, (len(points), 1)) * np.ones(3)
        far = self.view.distances(points) / self.detail
        level = np.searchsorted([7.0, 17.0], far)
        variant = rng.integers(0, 4, len(points))
        heading = rows.heading + np.pi * rng.integers(0, 2, len(points))
        for k in np.unique(level):
            for v in range(4):
                some = (level == k) & (variant == v)
                if some.any():
                    self.leaves.append(
                        Copies(
                            *(hedge_length(v, int(k)), points[some], turns(heading[some])),
                            *(scales[some], tints[some]),
                        )
                    )

    def spans(self, rows: Rows, spacing: float, out: float) -> Array:
        """Return the distance (N,) from one place of `rows` to the next along each side."""
        sides = np.array([*(self.high - self.low), *(self.high - self.low)])[rows.number]
        sides = sides + 2.0 * out
        return np.asarray(sides / np.maximum(np.rint(sides / spacing), 1.0))

    def palms(self, out: float, spacing: float, size: float = 1.0) -> None:
        """Add palms; `size` is a factor on their sizes."""
        rng = np.random.default_rng([self.seed, 458, round(10 * out)])
        rows = self.rows(out, spacing, 7.0 * size, 1.3)
        n = len(rows.places)
        places = rows.places + rng.normal(0.0, 1.3, (n, 2))
        kept = self.is_free(places, 7.0 * size, 1.3)
        kept &= ~self.shades_the_cast(places, 7.5 * size, 2.2 * size)
        places = places[kept & (rng.uniform(size=n) < 0.8)]
        if not len(places):
            return
        points = self.points(places) - [0.0, 0.1, 0.0]
        level = (self.view.distances(points) / self.detail > 22.0).astype(int)
        variant = rng.integers(0, 4, len(points))
        scales = size * rng.uniform(0.6, 1.15, (len(points), 1)) * np.ones(3)
        headings = turns(rng.uniform(0, 2 * np.pi, len(points)))
        tints = rng.uniform(0.85, 1.15, (len(points), 1)) * np.ones(3)
        for k in (0, 1):
            for v in range(4):
                some = (level == k) & (variant == v)
                if some.any():
                    self.leaves.append(
                        Copies(palm(v, k), points[some], headings[some], scales[some], tints[some])
                    )

    def trees(self, kinds: tuple[str, ...], out: float, spacing: float, size: float) -> None:
        """Add a row of trees, none quite like the next, in whose shade the cast does not stand.

        Args:
            kinds: species, the first most often.
            out: distance from the floor [m].
            spacing: from one to the next, on average [m].
            size: factor on their sizes.
        """
        rng = np.random.default_rng([self.seed, 455, round(10 * out)])
        rows = self.rows(out, spacing, 8.0 * size, 1.2)
        n = len(rows.places)
        along = np.stack([np.cos(rows.heading), -np.sin(rows.heading)], axis=-1)
        places = rows.places + rng.uniform(-0.33, 0.33, (n, 1)) * spacing * along
        places += rng.uniform(-0.7, 2.2, (n, 1)) * rows.outward
        kind = np.minimum(rng.geometric(0.62, n) - 1, len(kinds) - 1)
        kept = (rng.uniform(size=n) < 0.82) & self.is_free(places, 8.0 * size, 1.2)
        kept &= ~self.shades_the_cast(places, 8.5 * size, 2.6 * size)
        for k, name in enumerate(kinds):
            some = places[kept & (kind == k)]
            if len(some):
                self.add_plants(name, self.points(some) - [0, 0.05, 0], size, rng)

    def shades_the_cast(self, places: Array, tall: float, radius: float) -> NDArray[np.bool_]:
        """Return which trees at places (N, 2) would shade where the cast is."""
        if self.sun is None or self.sun[1] <= 0.02 or self.clearings is None:
            return np.zeros(len(places), bool)
        low, high = self.clearings.extent
        slope = np.array([self.sun[0], self.sun[2]]) / self.sun[1]
        ground = places[:, None] - np.linspace(0.2, 1.0, 14)[:, None] * tall * slope
        beyond = np.hypot(
            *np.moveaxis(np.maximum(np.maximum(low - ground, ground - high), 0), -1, 0)
        )
        return np.asarray((beyond < radius).any(axis=1))

    def undergrowth(self, out: float, kinds: tuple[tuple[str, float, float], ...]) -> None:
        """Add plants in a ragged strip.

        Args:
            out: distance of its middle from the floor [m].
            kinds: species, with the distance from one to the next [m] and factors on their sizes.
        """
        for k, (kind, spacing, size) in enumerate(kinds):
            rng = np.random.default_rng([self.seed, 456, k, round(10 * out)])
            rows = self.rows(out, spacing, KINDS[kind].height * size, 0.3)
            n = len(rows.places)
            places = rows.places + rng.normal(0, 0.22, (n, 1)) * rows.outward
            places = places[rng.uniform(size=n) < 0.7 + 0.3 * np.sin(places.sum(axis=1) * 0.7)]
            if len(places):
                self.add_plants(kind, self.points(places), size, rng)

    def add_plants(self, kind: str, points: Array, size: float, rng: np.random.Generator) -> None:
        """Add plants of a species at points (N, 3)."""
        n = len(points)
        self.placed.append(
            Placed(
                *(kind, points, np.tile([0.0, 1.0, 0.0], (n, 1)), np.full((n, 3), 0.12)),
                *(self.view.distances(points), np.zeros(n), rng.uniform(size=(n, 4)), size),
            )
        )


def turns(heading: Array) -> Array:
    """Return rotations (N, 3, 3) about +Y."""
    c, s, o, one = np.cos(heading), np.sin(heading), np.zeros(len(heading)), np.ones(len(heading))
    return np.stack(
        [np.stack([c, o, s], -1), np.stack([o, one, o], -1), np.stack([-s, o, c], -1)], axis=1
    )
