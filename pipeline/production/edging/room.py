"""Room: walls with windows around a floor, skirting, a rug, and the things of a children's room.

It has no ceiling: the sky lights it from above, where no camera looks, and the sun comes in through
the windows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.production.edging.border import Border, Rows
from pipeline.production.edging.carpentry import Carpentry
from pipeline.production.edging.floor_plan import FloorPlan
from pipeline.production.scenery.expansion import Copies
from pipeline.production.scenery.prototype import Shape
from pipeline.simulation.spatial import Array

TALL, THICK = 2.9, 0.16
"""Height and thickness of walls [m]."""

BAY = 2.1
"""Width of wall for each window or shelf, about [m]."""

SILL, LINTEL, WIDE = 0.75, 2.25, 1.25
"""Heights of the lower and upper edge of windows, and their width [m]."""

BOOKS = ("red cloth", "blue cloth", "green cloth", "yellow cloth", "leather", "white cloth")

TOYS = ("red plastic", "blue plastic", "yellow plastic", "pine", "green painted metal")

CURTAINS = ((0.50, 0.17, 0.10), (0.52, 0.38, 0.20), (0.22, 0.30, 0.20))
"""Linear colours of curtains."""

RUG = ("red cloth", "white cloth", "blue cloth")
"""Materials of the bands of a rug, from its border to its middle."""

MOTIF = 0.22
"""Distance between the diamonds along the border of a rug, about [m]."""

MEDALLION = ("red cloth", "yellow cloth", "red cloth", "leather", "white cloth", "blue cloth")
"""Materials of the medallion of a rug, from its outside."""

RUG_HEIGHT = 0.0025
"""Height of a rug over the floor: what stands on it sinks in as far [m]."""

BUILT = (*BOOKS, *TOYS, "white plaster", "oak", "walnut", "white painted metal")
"""Materials that a room is made of."""


@dataclass(frozen=True, eq=False)
class Room:
    """Builds a room around a floor.

    Attributes:
        plan: of its floor.
        border: of the floor, whose carpentry it adds to.
    """

    plan: FloorPlan
    border: Border

    def build(self) -> None:
        """Add walls, windows, skirting, rug and furniture."""
        rng = np.random.default_rng([self.border.seed, 481])
        bays = self._bays()
        has_window = np.arange(len(bays.places)) % 2 == 0
        if self.border.sun is not None:
            # All walls that face the sun let it in.
            sun = np.array([self.border.sun[0], self.border.sun[2]])
            has_window |= bays.outward @ sun > 0.25 * np.linalg.norm(sun)
        spans = self._spans(bays)
        for k in range(len(bays.places)):
            self._bay(bays.places[k], bays.heading[k], spans[k], window=bool(has_window[k]))
        self._curtains(bays.taken(has_window), rng)
        self._skirting(bays, spans)
        self._rug()
        inner = self._bays(-0.22)
        for k in np.flatnonzero(~has_window).tolist():
            place = inner.places[k : k + 1]
            if not self.border.is_free(place, 1.5, 0.75)[0]:
                continue
            kind = rng.integers(0, 3)
            if kind < 2:
                self._shelf(place[0], inner.heading[k], inner.outward[k], rng)
            else:
                self._chest(place[0], inner.heading[k], rng)
                self._picture(bays.places[k], bays.heading[k], bays.outward[k], rng)
        self._scattered_toys(rng)

    def _bays(self, out: float = THICK / 2) -> Rows:
        """Return the middles of the bays, counter-clockwise, none left out."""
        low, high = self.plan.low - out, self.plan.high + out
        corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
        sides = np.array([*(self.plan.high - self.plan.low)] * 2)
        places, heading, outward, number = [], [], [], []
        for k in range(4):
            start, end = corners[k], corners[(k + 1) % 4]
            count = max(round(sides[k] / BAY), 1)
            t = (np.arange(count) + 0.5)[:, None] / count
            way = (end - start) / np.linalg.norm(end - start)
            places.append(start + t * (end - start))
            heading.append(np.full(count, np.arctan2(-way[1], way[0])))
            outward.append(np.tile([way[1], -way[0]], (count, 1)))
            number.append(np.full(count, k))
        return Rows(*(np.concatenate(part) for part in (places, heading, outward, number)))

    def _spans(self, bays: Rows) -> Array:
        """Return the widths (N,) of the bays [m]."""
        sides = np.array([*(self.plan.high - self.plan.low)] * 2)[bays.number] + THICK
        return np.asarray(sides / np.bincount(bays.number)[bays.number])

    def _add(
        self,
        material: str,
        place: Array,
        heading: float,
        at: tuple[float, float, float],
        size: tuple[float, float, float],
    ) -> None:
        """Add a box at a place along, over and inward of a wall."""
        c, s = np.cos(heading), np.sin(heading)
        along, up, inward = at
        # A heading runs along the wall with the room on its left, seen from above.
        x = place[0] + c * along + s * inward
        z = place[1] - s * along + c * inward
        center = np.array([x, self.plan.height + up, z])
        self._carpentry.add(f"edging {material}", center, size, heading)

    @property
    def _carpentry(self) -> Carpentry:
        return self.border.carpentry

    def _bay(self, place: Array, heading: float, span: float, *, window: bool) -> None:
        """Add the wall of one bay."""
        wall = "wall"
        if not window:
            self._add(wall, place, heading, (0, TALL / 2, 0), (span, TALL, THICK))
            return
        wide = min(WIDE, span - 0.5)
        pier = (span - wide) / 2
        for side in (-1, 1):
            at = (side * (wide + pier) / 2, TALL / 2, 0.0)
            self._add(wall, place, heading, at, (pier, TALL, THICK))
        self._add(wall, place, heading, (0, SILL / 2, 0), (wide, SILL, THICK))
        self._add(wall, place, heading, (0, (LINTEL + TALL) / 2, 0), (wide, TALL - LINTEL, THICK))
        frame, white = 0.05, "white painted metal"
        tall, middle = LINTEL - SILL, (LINTEL + SILL) / 2
        for side in (-1, 0, 1):
            self._add(
                white, place, heading, (side * (wide - frame) / 2, middle, 0), (frame, tall, 0.06)
            )
        for up in (SILL + frame / 2, SILL + 0.66 * tall, LINTEL - frame / 2):
            self._add(white, place, heading, (0, up, 0), (wide, frame, 0.055))
        self._add("oak", place, heading, (0, SILL, 0.14), (wide + 0.14, 0.035, 0.24))

    def _curtains(self, bays: Rows, rng: np.random.Generator) -> None:
        """Add curtains that are drawn aside, and the rods on which they hang."""
        color = np.asarray(CURTAINS[int(rng.integers(0, len(CURTAINS)))])
        one = np.ones((1, 3))
        for place, heading in zip(bays.places, bays.heading, strict=True):
            foot = np.array([[place[0], self.plan.height, place[1]]])
            c, s = np.cos(heading), np.sin(heading)
            turn = np.array([[[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]])
            shape = Shape()
            for side in (-1.0, 1.0):
                _hang(shape, side, color, rng)
            self.border.leaves.append(Copies(shape.prototype(), foot, turn, one, one))
            self._add("walnut", place, heading, (0, 2.42, 0.14), (WIDE + 0.75, 0.03, 0.03))

    def _skirting(self, bays: Rows, spans: Array) -> None:
        """Add the boards at the feet of the walls and a rail below the windows."""
        for k in range(len(bays.places)):
            place, heading = bays.places[k], bays.heading[k]
            inner = THICK / 2 + 0.009
            self._add(
                "white painted metal", place, heading, (0, 0.065, inner), (spans[k], 0.13, 0.018)
            )
            self._add(
                "white painted metal", place, heading, (0, 0.62, inner), (spans[k], 0.05, 0.026)
            )

    def _rug(self) -> None:
        """Add a rug under the cast."""
        low, high = self.plan.clearings.extent
        middle, half = 0.5 * (low + high), 0.5 * (high - low) + 0.75
        room = np.minimum(self.plan.high - middle, middle - self.plan.low) - 0.5
        half = np.minimum(half, room)
        if (half < 0.4).any():
            return
        for k, cloth in enumerate(RUG):
            size = 2.0 * (half - (0.0, 0.16, 0.3)[k])
            up = self.plan.height + RUG_HEIGHT * (k + 1) / 3 - 0.005
            center = np.array([middle[0], up, middle[1]])
            self._carpentry.add(f"edging {cloth}", center, (size[0], 0.01, size[1]))
        self._motifs(middle, half - 0.42)

    def _motifs(self, middle: Array, half: Array) -> None:
        """Add a medallion, smaller ones in the corners, and a border of diamonds to the rug."""
        least = float(half.min())
        long = np.array([1.0, 0.0]) if half[0] > half[1] else np.array([0.0, 1.0])
        self._diamonds(middle[None], 0.62 * least, MEDALLION)
        beside = middle + np.array([[-1.0], [1.0]]) * long * 0.78 * least
        if (np.abs(beside - middle) + 0.26 * least < half).all():
            self._diamonds(beside, 0.2 * least, MEDALLION[2:])
        corners = middle + np.array([[i, j] for i in (-1, 1) for j in (-1, 1)]) * 0.8 * half
        self._diamonds(corners, 0.16 * least, MEDALLION[1:4])
        rim = []
        for axis in (0, 1):
            count = max(round(2.0 * half[axis] / MOTIF), 2)
            along = (np.arange(count + 1) / count - 0.5) * 2.0 * half[axis]
            for side in (-1.0, 1.0):
                spots = np.zeros((count + 1, 2))
                spots[:, axis], spots[:, 1 - axis] = along, side * (half[1 - axis] + 0.2)
                rim.append(middle + spots)
        self._diamonds(np.concatenate(rim), 0.055, ("blue cloth", "yellow cloth"))

    def _diamonds(self, spots: Array, half: float, cloths: tuple[str, ...]) -> None:
        """Add diamonds within diamonds at places (N, 2), the largest half as wide as `half` [m]."""
        for k, cloth in enumerate(cloths):
            up = self.plan.height + RUG_HEIGHT + 0.00025 * (k + 1) - 0.005
            centers = np.stack([spots[:, 0], np.full(len(spots), up), spots[:, 1]], axis=-1)
            wide = np.sqrt(2.0) * half * (1.0 - k / len(cloths)) ** 1.2
            self._carpentry.add(f"edging {cloth}", centers, (wide, 0.01, wide), np.pi / 4)

    def _shelf(
        self, place: Array, heading: float, outward: Array, rng: np.random.Generator
    ) -> None:
        """Add a shelf of books and toys."""
        del outward
        wide, deep, tall = 1.15, 0.3, 1.35
        for side in (-1, 1):
            self._add("pine", place, heading, (side * wide / 2, tall / 2, 0), (0.025, tall, deep))
        for k in range(4):
            up = 0.05 + k * (tall - 0.06) / 3
            self._add("pine", place, heading, (0, up, 0), (wide, 0.024, deep))
            at = -wide / 2 + 0.03
            while k < 3 and at < wide / 2 - 0.08:
                thick = rng.uniform(0.02, 0.055)
                high = rng.uniform(0.2, 0.34)
                if rng.uniform() < 0.8:
                    book = str(rng.choice(BOOKS))
                    spot = (at + thick / 2, up + 0.012 + high / 2, rng.uniform(-0.02, 0.04))
                    self._add(book, place, heading, spot, (thick, high, 0.2))
                at += thick + (0.004 if rng.uniform() < 0.85 else rng.uniform(0.05, 0.2))
        self._add("pine", place, heading, (0, tall / 2, -0.14), (wide, tall, 0.012))

    def _chest(self, place: Array, heading: float, rng: np.random.Generator) -> None:
        """Add a toy chest."""
        for k in range(3):
            self._add("oak", place, heading, (0, 0.07 + 0.14 * k, 0), (0.9, 0.134, 0.42))
        self._add("walnut", place, heading, (0, 0.44, 0), (0.96, 0.035, 0.46))
        for k in range(3):
            size = rng.uniform(0.09, 0.14)
            spot = (rng.uniform(-0.35, 0.35), 0.46 + size / 2, rng.uniform(-0.1, 0.1))
            turn = heading + rng.uniform(-0.5, 0.5)
            self._add(TOYS[k], place, turn, spot, (size, size, size))

    def _picture(
        self, place: Array, heading: float, outward: Array, rng: np.random.Generator
    ) -> None:
        """Add a picture on the wall: land under a sky."""
        del outward, rng
        inner = THICK / 2
        self._add("walnut", place, heading, (0, 1.45, inner + 0.012), (0.84, 0.64, 0.024))
        self._add("white cloth", place, heading, (0, 1.45, inner + 0.02), (0.74, 0.54, 0.016))
        self._add("blue cloth", place, heading, (0, 1.52, inner + 0.022), (0.6, 0.26, 0.016))
        self._add("green cloth", place, heading, (0, 1.32, inner + 0.022), (0.6, 0.14, 0.016))

    def _scattered_toys(self, rng: np.random.Generator) -> None:
        """Add building blocks that lie near the walls."""
        places = rng.uniform(self.plan.low + 0.4, self.plan.high - 0.4, (60, 2))
        free = self.border.is_free(places, 0.15, 0.15) & (self.plan.beyond(places) > -1.1)
        for k, place in enumerate(places[free][:26]):
            size = float(rng.uniform(0.06, 0.1))
            shape = (size * rng.choice([1.0, 1.0, 2.0]), size, size)
            self._add(TOYS[k % len(TOYS)], place, rng.uniform(0, 6.28), (0, size / 2, 0), shape)


def _hang(shape: Shape, side: float, color: Array, rng: np.random.Generator) -> None:
    """Add one curtain in folds, gathered at one side of a window in the middle.

    Args:
        shape: to which it is added.
        side: -1 or 1.
        color: linear.
        rng: of its folds.
    """
    columns, rows = 61, 9
    t, up = np.meshgrid(np.linspace(0.0, 1.0, columns), np.linspace(0.0, 1.0, rows))
    phase = 2.0 * np.pi * (6.0 * t + 0.35 * np.sin(5.0 * t + rng.uniform(0, 6)) + 0.12 * up)
    # It is held by a band at the height of the sill, and falls free below.
    held = 1.0 - 0.42 * np.exp(-(((up - 0.42) / 0.12) ** 2))
    along = side * (WIDE / 2 + 0.2 - 0.42 * t * held)
    deep = 0.14 + 0.028 * np.sin(phase) * (0.6 + 0.4 * held)
    points = np.stack([along, 0.03 + 2.38 * up, deep], axis=-1)
    slope = 0.028 * 12.0 * np.pi * np.cos(phase) / 0.42
    normals = np.stack([side * slope, np.zeros_like(slope), np.ones_like(slope)], axis=-1)
    shades = color * (0.86 + 0.14 * np.sin(phase))[..., None]
    i, j = (a.ravel() for a in np.meshgrid(np.arange(columns - 1), np.arange(rows - 1)))
    a = j * columns + i
    faces = np.concatenate(
        [np.stack([a, a + 1, a + columns], -1), np.stack([a + 1, a + columns + 1, a + columns], -1)]
    )
    shape.add(points, normals, shades, faces if side < 0 else faces[:, ::-1], thin=True)
