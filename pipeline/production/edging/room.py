"""Room: walls with windows around a floor, panelling, curtains, a rug, and what stands along them.

It has no ceiling: the sky lights it from above, where no camera looks, and the sun comes in through
the windows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.production.edging.border import Border, Rows
from pipeline.production.edging.carpentry import Carpentry
from pipeline.production.edging.floor_plan import FloorPlan
from pipeline.production.edging.furnishing import FURNISHED, TOYS, Spot, furnish_bay
from pipeline.production.edging.rug import rug
from pipeline.production.edging.square import pots
from pipeline.production.scenery.expansion import Copies
from pipeline.production.scenery.prototype import Shape
from pipeline.simulation.spatial import Array

TALL, THICK = 3.15, 0.16
"""Height and thickness of walls [m]."""

BAY = 2.1
"""Width of wall for each window or shelf, about [m]."""

SILL, LINTEL, WIDE = 0.7, 2.4, 1.25
"""Heights of the lower and upper edge of windows, and their width [m]."""

HANGING = 0.235
"""Distance of curtains from the middle of the wall [m]."""

CURTAINS = ((0.58, 0.50, 0.38), (0.46, 0.17, 0.11), (0.36, 0.42, 0.36))
"""Linear colours of curtains."""

BUILT = (*FURNISHED, *TOYS, "white painted metal")
"""Materials that a room is made of."""

WALLS = ("wall", "wall sage", "wall blue")
"""Materials of walls, one for each room."""

PANEL = 0.58
"""Height of the panelling at the feet of the walls [m]."""


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
            # The walls that face the sun let it in, all but every third bay.
            sun = np.array([self.border.sun[0], self.border.sun[2]])
            faces = bays.outward @ sun > 0.25 * np.linalg.norm(sun)
            has_window |= faces & (np.arange(len(bays.places)) % 3 != 1)
        spans = self._spans(bays)
        for k in range(len(bays.places)):
            self._bay(bays.places[k], bays.heading[k], spans[k], window=bool(has_window[k]))
        self._curtains(bays.taken(has_window), rng)
        self._skirting(bays, spans)
        rug(self.plan, self._carpentry, self.border.seed)
        inner = self._bays(-0.24)
        for turn, k in enumerate(np.flatnonzero(~has_window).tolist()):
            spot = Spot(self.border, inner.places[k], float(inner.heading[k]), self.plan.height)
            furnish_bay(spot, turn, bool(self.border.is_free(spot.place[None], 1.5, 0.6)[0]), rng)
        for k in np.flatnonzero(has_window).tolist():
            if self.border.is_free(inner.places[k : k + 1], 0.7, 0.4)[0] and rng.uniform() < 0.5:
                pots(self.border, self._foot(inner.places[k], bays.heading[k], rng), rng)
        self._scattered_toys(rng)

    def _foot(self, place: Array, heading: float, rng: np.random.Generator) -> Array:
        """Return a point (1, 3) on the floor beside a curtain [m]."""
        aside = float(rng.choice((-1.0, 1.0))) * 0.78
        x, z = place + aside * np.array([np.cos(heading), -np.sin(heading)])
        return np.array([[x, self.plan.height, z]])

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
        wall = WALLS[self.border.seed % len(WALLS)]
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
        for side in (-1, 1):
            at = (side * (wide + 0.1) / 2, middle, THICK / 2)
            self._add("panelling", place, heading, at, (0.1, tall + 0.1, 0.03))
        self._add(
            "panelling", place, heading, (0, LINTEL + 0.06, THICK / 2), (wide + 0.24, 0.12, 0.05)
        )
        # It ends before the curtains.
        self._add("panelling", place, heading, (0, SILL, 0.1), (wide + 0.2, 0.035, 0.16))

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
            self._add("walnut", place, heading, (0, 2.52, HANGING), (WIDE + 0.75, 0.03, 0.03))

    def _skirting(self, bays: Rows, spans: Array) -> None:
        """Add skirting, panels below the windows and a cornice below the top of the walls."""
        for k in range(len(bays.places)):
            place, heading, span = bays.places[k], bays.heading[k], float(spans[k])
            inner = THICK / 2
            for up, high, out in (
                *((0.075, 0.15, 0.022), (PANEL / 2, PANEL, 0.008), (PANEL, 0.055, 0.045)),
                *((TALL - 0.06, 0.12, 0.06), (TALL - 0.15, 0.06, 0.03)),
            ):
                at = (0.0, up, inner + out / 2)
                self._add("panelling", place, heading, at, (span, high, out))
            count = max(round(span / 0.52), 1)
            for n in range(count):
                along, wide = ((n + 0.5) / count - 0.5) * span, span / count - 0.1
                at = (along, 0.5 * (PANEL + 0.12), inner + 0.02)
                self._add("panelling", place, heading, at, (wide, PANEL - 0.24, 0.026))

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
    deep = HANGING + 0.028 * np.sin(phase) * (0.6 + 0.4 * held)
    points = np.stack([along, 0.03 + 2.48 * up, deep], axis=-1)
    slope = 0.028 * 12.0 * np.pi * np.cos(phase) / 0.42
    normals = np.stack([side * slope, np.zeros_like(slope), np.ones_like(slope)], axis=-1)
    shades = color * (0.86 + 0.14 * np.sin(phase))[..., None]
    i, j = (a.ravel() for a in np.meshgrid(np.arange(columns - 1), np.arange(rows - 1)))
    a = j * columns + i
    faces = np.concatenate(
        [np.stack([a, a + 1, a + columns], -1), np.stack([a + 1, a + columns + 1, a + columns], -1)]
    )
    shape.add(points, normals, shades, faces if side < 0 else faces[:, ::-1], thin=True)
