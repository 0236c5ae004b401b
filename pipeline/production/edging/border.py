"""Border: what stands along a floor: hedge, dry-stone wall, railing, planters, benches, trees.

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
from pipeline.production.edging.masonry import lantern, wall_stone
from pipeline.production.edging.palms import palm
from pipeline.production.edging.plot import Plot
from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.expansion import Copies
from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.placement import Placed
from pipeline.production.scenery.prototype import UP, Shape, add_tubes
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

LANTERN_COLORS = ((0.80, 0.22, 0.08), (0.85, 0.52, 0.12), (0.82, 0.72, 0.50), (0.70, 0.12, 0.10))
"""Linear colours of paper lanterns."""


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
                            *(hedge_length(v, int(k)), points[some], _turns(heading[some])),
                            *(scales[some], tints[some]),
                        )
                    )

    def wall(self, out: float, tall: float) -> None:
        """Add a dry-stone wall, lower here and there."""
        rng = np.random.default_rng([self.seed, 452])
        core = self.rows(out, 0.6, tall, 0.35)
        if len(core.places):
            # Small stones fill the inside, so that nobody sees through.
            sizes = np.tile([0.8, 0.6 * tall, 0.24], (len(core.places), 1))
            middles = self.points(core.places) + 0.26 * tall * UP
            self.add_stones(middles, sizes, core.heading, rng, light=0.45)
        places, heights, lengths, headings, depths = [], [], [], [], []
        courses = max(round(tall / 0.15), 1)
        for course in range(courses):
            top = course == courses - 1
            rows = self.rows(
                out, (0.31, 0.38, 0.27, 0.34)[course % 4] if not top else 0.44, tall, 0.35
            )
            n = len(rows.places)
            along = np.stack([np.cos(rows.heading), -np.sin(rows.heading)], axis=-1)
            slid = rng.uniform(-0.1, 0.1, (n, 1))
            at = rows.places + slid * along + rng.normal(0, 0.012, (n, 1)) * rows.outward
            # Weather and sheep have taken stones from the top.
            worn = np.sin(at[:, 0] * 0.9 + self.seed) + np.sin(at[:, 1] * 1.1 + 2.0 * self.seed)
            stands = course < courses - 1 - np.clip(worn - 0.9, 0.0, 1.0) * 2.2
            places.append(at[stands])
            heights.append(np.full(stands.sum(), (course + 0.45) * tall / courses))
            lengths.append(rng.uniform(0.24, 0.5, stands.sum()))
            headings.append((rows.heading + rng.normal(0, 0.07, n))[stands])
            depths.append(np.full(stands.sum(), 0.46 - 0.14 * course / courses))
        place = np.concatenate(places)
        if not len(place):
            return
        points = self.points(place)
        points[:, 1] += np.concatenate(heights) + rng.normal(0, 0.018, len(points)) - 0.03
        high = tall / courses * rng.uniform(0.85, 1.55, len(points))
        scales = np.stack([np.concatenate(lengths), high, np.concatenate(depths)], axis=-1)
        self.add_stones(points, scales, np.concatenate(headings), rng)

    def kerb(self, out: float) -> None:
        """Add a row of long, low stones, sunk to different depths."""
        rng = np.random.default_rng([self.seed, 453])
        rows = self.rows(out, 0.62, 0.1, 0.2)
        n = len(rows.places)
        if not n:
            return
        points = self.points(rows.places) + np.column_stack(
            [np.zeros(n), rng.normal(0.02, 0.02, n), np.zeros(n)]
        )
        scales = rng.uniform([0.5, 0.16, 0.18], [0.68, 0.22, 0.24], (n, 3))
        self.add_stones(points, scales, rows.heading + rng.normal(0, 0.04, n), rng)

    def add_stones(
        self,
        points: Array,
        scales: Array,
        heading: Array,
        rng: np.random.Generator,
        light: float = 1.0,
    ) -> None:
        """Add stones by their middles (N, 3), sizes (N, 3), headings (N,) and their lightness."""
        far = self.view.distances(points) / self.detail
        across = np.where(far < 5.0, 7, np.where(far < 14.0, 4, 3))
        variant = rng.integers(0, 7, len(points))
        tints = rng.uniform(0.72, 1.2, (len(points), 1)) * rng.normal(light, 0.03, (len(points), 3))
        turned = heading + np.pi * rng.integers(0, 2, len(points))
        for k in np.unique(across):
            for v in range(7):
                some = (across == k) & (variant == v)
                if some.any():
                    self.stones.append(
                        Copies(
                            *(wall_stone(v, int(k)), points[some], _turns(turned[some])),
                            *(scales[some], tints[some]),
                        )
                    )

    def rim(self, material: str, level: float) -> None:
        """Add a beam around a deck, a little over its boards, and a skirt below it."""
        rows = self.rows(0.06, 1.6, 0.1, 0.1)
        spans = self._spans(rows, 1.6, 0.06)
        points = np.stack(
            [rows.places[:, 0], np.full(len(rows.places), level), rows.places[:, 1]], -1
        )
        sizes = np.column_stack(
            [spans - 0.004, np.full(len(spans), 0.16), np.full(len(spans), 0.12)]
        )
        self.carpentry.add(material, points - [0.0, 0.03, 0.0], sizes, rows.heading)

    def _spans(self, rows: Rows, spacing: float, out: float) -> Array:
        """Return the distance (N,) from one place of `rows` to the next along each side."""
        sides = np.array([*(self.high - self.low), *(self.high - self.low)])[rows.number]
        sides = sides + 2.0 * out
        return np.asarray(sides / np.maximum(np.rint(sides / spacing), 1.0))

    def railing(self, level: float, material: str) -> None:
        """Add posts with a handrail and two lower rails."""
        rows = self.rows(-0.12, 1.5, 1.0, 0.12)
        if not len(rows.places):
            return
        spans = self._spans(rows, 1.5, -0.12)
        base = np.stack(
            [rows.places[:, 0], np.full(len(rows.places), level), rows.places[:, 1]], -1
        )
        along = np.stack(
            [np.cos(rows.heading), np.zeros(len(base)), -np.sin(rows.heading)], axis=-1
        )
        for side in (-0.5, 0.5):
            posts = base + side * spans[:, None] * along + [0.0, 0.5, 0.0]
            self.carpentry.add(material, posts, (0.085, 1.02, 0.085), rows.heading)
            self.carpentry.add(material, posts + 0.525 * UP, (0.12, 0.03, 0.12), rows.heading)
        for up, high, deep in ((0.96, 0.045, 0.11), (0.66, 0.05, 0.03), (0.36, 0.05, 0.03)):
            sizes = np.column_stack([spans, np.full(len(spans), high), np.full(len(spans), deep)])
            self.carpentry.add(material, base + up * UP, sizes, rows.heading)

    def festoon(self, level: float, spacing: float) -> None:
        """Add poles along a railing with cords between them, on which paper lanterns hang."""
        rng = np.random.default_rng([self.seed, 457])
        rows = self.rows(-0.12, spacing, 2.6, 0.2)
        if not len(rows.places):
            return
        spans = self._spans(rows, spacing, -0.12)[:, None, None]
        base = np.stack(
            [rows.places[:, 0], np.full(len(rows.places), level), rows.places[:, 1]], -1
        )
        along = np.stack(
            [np.cos(rows.heading), np.zeros(len(base)), -np.sin(rows.heading)], axis=-1
        )
        t = np.linspace(-0.5, 0.5, 13)[:, None]
        sag = np.concatenate([0.0 * t, 2.5 - 0.42 * (1.0 - 4.0 * t**2), 0.0 * t], axis=1)
        cords = base[:, None] + spans * t * along[:, None] + sag
        shape = Shape()
        add_tubes(
            *(shape, cords[:, :-1].reshape(-1, 3), cords[:, 1:].reshape(-1, 3)),
            *(np.full(12 * len(base), 0.008), np.full(12 * len(base), 0.008)),
            *(np.tile([0.05, 0.04, 0.03], (12 * len(base), 1)), 4),
        )
        feet = (cords[:, [0, -1]] * [1.0, 0.0, 1.0] + [0.0, level, 0.0]).reshape(-1, 3)
        count = len(feet)
        add_tubes(
            *(shape, feet, feet + 2.58 * UP, np.full(count, 0.035), np.full(count, 0.025)),
            *(np.tile([0.16, 0.11, 0.07], (count, 1)), 7),
        )
        one, here = np.ones((1, 3)), np.zeros((1, 3))
        self.leaves.append(Copies(shape.prototype(), here, np.eye(3)[None], one, one))
        for k in (2, 5, 8, 11):
            points = cords[:, k] - [0.0, 0.12, 0.0]
            tints = np.array(LANTERN_COLORS)[rng.integers(0, len(LANTERN_COLORS), len(points))]
            size = rng.uniform(0.22, 0.3, (len(points), 1)) * [1.0, 0.85, 1.0]
            self.leaves.append(Copies(lantern(), points, _turns(rows.heading), size, tints))

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
        turns = _turns(rng.uniform(0, 2 * np.pi, len(points)))
        tints = rng.uniform(0.85, 1.15, (len(points), 1)) * np.ones(3)
        for k in (0, 1):
            for v in range(4):
                some = (level == k) & (variant == v)
                if some.any():
                    self.leaves.append(
                        Copies(palm(v, k), points[some], turns[some], scales[some], tints[some])
                    )

    def planters(self, out: float, spacing: float, material: str, level: float) -> None:
        """Add boxes of boards with bushes and flowers."""
        rows = self.rows(out, spacing, 0.9, 0.55)
        n = len(rows.places)
        if not n:
            return
        rng = np.random.default_rng([self.seed, 454])
        base = np.stack([rows.places[:, 0], np.full(n, level), rows.places[:, 1]], -1)
        long, deep, tall = 1.05, 0.46, 0.42
        self._box_of_boards(material, base, rows.heading, (long, tall, deep))
        self.carpentry.add(
            "edging dark soil",
            base + (tall - 0.06) * UP,
            (long - 0.08, 0.06, deep - 0.08),
            rows.heading,
        )
        along = np.stack([np.cos(rows.heading), np.zeros(n), -np.sin(rows.heading)], axis=-1)
        for side in (-0.3, 0.02, 0.31):
            foot = base + side * along * rng.uniform(0.8, 1.2, (n, 1)) + [0.0, tall - 0.12, 0.0]
            self.add_plants("bush", foot, 0.38, rng)
        for kind in ("poppy", "daisy", "meadow grass", "meadow grass"):
            for side in (-0.42, -0.15, 0.15, 0.42):
                foot = base + (side + rng.normal(0, 0.06, (n, 1))) * along + [0, tall - 0.04, 0]
                foot[:, [0, 2]] += rng.normal(0, 0.09, (n, 2))
                self.add_plants(kind, foot, 1.0, rng)

    def _box_of_boards(
        self, material: str, base: Array, heading: Array, size: tuple[float, float, float]
    ) -> None:
        """Add boxes whose sides are three boards one over another."""
        long, tall, deep = size
        side = np.stack([np.sin(heading), np.zeros(len(base)), np.cos(heading)], axis=-1)
        along = np.stack([np.cos(heading), np.zeros(len(base)), -np.sin(heading)], axis=-1)
        board = tall / 3.0
        for k in range(3):
            up = [0.0, board * (k + 0.5), 0.0]
            for way in (-0.5, 0.5):
                self.carpentry.add(
                    material, base + way * deep * side + up, (long, board - 0.006, 0.025), heading
                )
                self.carpentry.add(
                    material, base + way * long * along + up, (0.025, board - 0.006, deep), heading
                )
        for a in (-0.5, 0.5):
            for b in (-0.5, 0.5):
                corner = base + a * long * along + b * deep * side + [0.0, 0.5 * tall + 0.015, 0.0]
                self.carpentry.add(material, corner, (0.06, tall + 0.03, 0.06), heading)

    def benches(self, out: float, spacing: float) -> None:
        """Add park benches that face the floor."""
        rows = self.rows(out, spacing, 0.9, 0.9)
        n = len(rows.places)
        if not n:
            return
        base = self.points(rows.places)
        heading = rows.heading
        back = np.stack([rows.outward[:, 0], np.zeros(n), rows.outward[:, 1]], axis=-1)
        along = np.stack([np.cos(heading), np.zeros(n), -np.sin(heading)], axis=-1)
        for k in range(4):
            slat = base + (-0.16 + 0.11 * k) * back + [0.0, 0.45, 0.0]
            self.carpentry.add("edging weathered", slat, (1.6, 0.03, 0.09), heading)
        for k in range(3):
            slat = base + (0.25 + 0.03 * k) * back + [0.0, 0.58 + 0.12 * k, 0.0]
            self.carpentry.add("edging weathered", slat, (1.6, 0.09, 0.028), heading)
        for side in (-0.62, 0.62):
            foot = base + side * along
            self.carpentry.add(
                "edging iron", foot - 0.14 * back + [0, 0.21, 0], (0.05, 0.46, 0.05), heading
            )
            self.carpentry.add(
                "edging iron", foot + 0.24 * back + [0, 0.42, 0], (0.05, 0.88, 0.05), heading
            )
            self.carpentry.add(
                "edging iron", foot + 0.05 * back + [0, 0.42, 0], (0.05, 0.04, 0.42), heading
            )

    def lamps(self, out: float, spacing: float) -> None:
        """Add lamp posts of cast iron with a lantern each."""
        rows = self.rows(out, spacing, 3.6, 0.25)
        if not len(rows.places):
            return
        base = self.points(rows.places)
        iron = "edging iron"
        for up, wide, high in (
            *((0.12, 0.34, 0.3), (0.4, 0.22, 0.3), (1.75, 0.09, 2.6), (2.6, 0.16, 0.06)),
            *((3.08, 0.14, 0.08), (3.56, 0.40, 0.05)),
        ):
            self.carpentry.add(iron, base + up * UP, (wide, high, wide), rows.heading)
        self.carpentry.add(
            iron, base + 3.68 * UP, (0.40, 0.22, 0.40), rows.heading, top=(0.15, 0.15)
        )
        self.carpentry.add(
            "edging curtained pane", base + 3.33 * UP, (0.24, 0.42, 0.24), rows.heading
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


def _turns(heading: Array) -> Array:
    """Return rotations (N, 3, 3) about +Y."""
    c, s, o, one = np.cos(heading), np.sin(heading), np.zeros(len(heading)), np.ones(len(heading))
    return np.stack(
        [np.stack([c, o, s], -1), np.stack([o, one, o], -1), np.stack([-s, o, c], -1)], axis=1
    )
