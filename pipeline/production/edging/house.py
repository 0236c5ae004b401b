"""House: a facade of storeys with windows, a door, plinth and cornice, under a roof of tiles."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from pipeline.production.edging.facade import RAILED, WINDOWS, Facade
from pipeline.production.edging.glazing import GLAZINGS, SHOP_GLAZING, Glazing, dressing
from pipeline.production.edging.house_front import Front
from pipeline.production.surroundings.lattice_noise import hashed
from pipeline.simulation.spatial import Array

STOREY, GROUND_STOREY = 2.95, 3.35
"""Heights of storeys [m]."""

WALL = 0.34
"""Depth of the outer wall, in which the panes are set back [m]."""

DOORSTEP = 0.4
"""Height of a door over the ground before it, at most [m]: below begins a stone plinth."""

PITCH = 0.72
"""Rise of a roof per metre."""

EAVES = 0.42
"""By which a roof stands out over the facade [m]."""

COURSE, TILES = 0.34, 0.95
"""Height of a course of tiles along the slope, and width of those laid together [m]."""

PLASTERS = ("ochre", "rose", "cream", "grey", "sage", "white", "brick", "straw")
"""Washes of facades."""

WOODS = ("shutter green", "shutter blue", "shutter brown", "shutter grey")
"""Paints of shutters and doors."""

SURROUND, HINGE, BETWEEN = 0.14, 0.01, 0.06
"""Width of the stone beside an opening, distance of an open shutter from it, and least distance
of shutters of two windows [m]."""

ROOFS = ("tile red", "tile brown", "tile dark")
"""Tiles, mixed on each roof."""

MIXES = ((0.5, 0.35, 0.15), (0.12, 0.6, 0.28), (0.04, 0.2, 0.76))
"""Shares of the tiles, by the kind of a roof."""

AWNINGS = ("awning red", "awning green", "awning blue")


AT_HOME, BRIGHT = 0.42, 0.6
"""Share of the windows behind which there is light after dark, and of these that are bright."""


@dataclass(frozen=True)
class Opening:
    """A door or window, relative to the middle of its bay and the foot of its storey [m]."""

    wide: float
    low: float
    high: float
    kind: str


@dataclass(frozen=True, eq=False)
class House(Facade):
    """One house behind its facade.

    Attributes:
        is_shop: whether the ground floor has shop windows.
        plaster: material of its walls.
        shuttered: chance that its windows have shutters.
        flowery: whether there are boxes of flowers on its upper sills.
        attic: height of the wall over its upper windows [m].
        mix: of the tiles on its roof, of `MIXES`.
        windows: their measures, of `WINDOWS`.
        has_dormers: whether windows stand out of its roof.
        flowers: points (3,) at which flowers grow in them [m], once it is built.
        front: its walls that are exposed to rain, with sills and panes once it is built.
    """

    is_shop: bool = False
    plaster: str = "cream"
    shuttered: float = 0.65
    flowery: bool = False
    attic: float = 0.0
    mix: int = 0
    windows: int = 0
    has_dormers: bool = False
    flowers: list[Array] = field(default_factory=list)
    front: Front = field(init=False)

    def __post_init__(self) -> None:
        """Set what is exposed to rain, over the ground before the door."""
        foot = max(self.foot, self.level - DOORSTEP)
        size = (*self.size, self.tall + self.level - foot)
        object.__setattr__(self, "front", Front(self.place, self.heading, size, foot))

    @property
    def tall(self) -> float:
        """Height of the facade over the threshold [m]."""
        return tall(self.storeys) + self.attic

    def build(self) -> None:
        """Add all of it."""
        wide, deep = self.size
        wood = str(self.rng.choice(WOODS))
        has_shutters = bool(self.rng.uniform() < self.shuttered)
        # Behind the panes it is solid: nobody looks through to the other side.
        body = (0.0, 0.5 * self.tall, -0.5 * (deep + WALL))
        self.add(self.plaster, body, (wide, self.tall, deep - WALL))
        for storey in range(self.storeys):
            low = 0.0 if storey == 0 else GROUND_STOREY + STOREY * (storey - 1)
            high = GROUND_STOREY if storey == 0 else STOREY
            for bay in range(self.bays):
                opening = self._opening(storey, bay)
                middle = (bay + 0.5) * wide / self.bays - 0.5 * wide
                self._wall(middle, low, high, opening)
                self._window(middle, low, opening, wood, has_shutters and storey > 0)
        if self.attic > 0.0:
            middle, size = self.tall - 0.5 * self.attic, (wide, self.attic, WALL)
            self.add(self.plaster, (0.0, middle, -0.5 * WALL), size)
        self._gables(wide, deep)
        self._trim(wide, deep)
        self._steps()
        self.roof()
        if self.is_shop:
            self.sign(wood)

    def _opening(self, storey: int, bay: int) -> Opening:
        bay_wide = self.size[0] / self.bays
        if storey == 0 and bay == self.door:
            return Opening(1.15, 0.0, 2.55, "door")
        if storey == 0 and self.is_shop:
            return Opening(bay_wide - 0.5, 0.45, 2.5, "shop")
        wide, low, high = WINDOWS[self.windows]
        # Nobody looks in from the street, and the last storey is lower.
        low = max(low, 0.85) if storey == 0 else low
        last = storey == self.storeys - 1 and self.storeys > 2
        return Opening(wide, low, high - 0.2 * last + 0.15 * (storey == 0), "window")

    def _wall(self, middle: float, foot: float, tall: float, opening: Opening) -> None:
        """Add the wall around the opening of a bay."""
        wide = self.size[0] / self.bays
        pier = 0.5 * (wide - opening.wide)
        between = opening.high - opening.low
        for side in (-1.0, 1.0):
            at = middle + side * 0.5 * (opening.wide + pier)
            up = foot + 0.5 * (opening.low + opening.high)
            self.add(self.plaster, (at, up, -0.5 * WALL), (pier, between, WALL))
        for low, high in ((0.0, opening.low), (opening.high, tall)):
            if high > low:
                up = foot + 0.5 * (low + high)
                self.add(self.plaster, (middle, up, -0.5 * WALL), (wide, high - low, WALL))

    def _window(
        self, middle: float, foot: float, opening: Opening, wood: str, shutters: bool
    ) -> None:
        """Add frame, panes and surround of an opening."""
        wide, tall = opening.wide, opening.high - opening.low
        up = foot + 0.5 * (opening.low + opening.high)
        self._inside(middle, foot, opening, wood)
        # Surround, lintel and sill stand out of the wall.
        if self._glazing.has_surround or opening.kind != "window":
            top = foot + opening.high + 0.09
            for side in (-1.0, 1.0):
                at = (middle + side * 0.5 * (wide + SURROUND), up, 0.0)
                self.add("hewn stone", at, (SURROUND, tall, 0.08))
            self.add("hewn stone", (middle, top, 0.0), (wide + 0.34, 0.18, 0.12))
        if opening.kind != "door":
            self.add(
                "hewn stone", (middle, foot + opening.low - 0.05, 0.05), (wide + 0.36, 0.1, 0.24)
            )
            sill = foot + opening.low + self.level - self.front.foot
            self.front.sills.append((middle, sill, wide + 0.36))
            if opening.low < RAILED and opening.kind == "window":
                self.rail(middle, foot + opening.low, wide)
            elif foot > 0.0 and self.flowery and self.rng.uniform() < 0.75:
                self._flower_box(middle, foot + opening.low, wide)
        if opening.kind == "shop":
            self._awning(middle, foot + opening.high + 0.12, wide + 0.2)
        if shutters and self.rng.uniform() < 0.95:
            self._shutters(middle, up, wide, tall, wood)

    def _inside(self, middle: float, foot: float, opening: Opening, wood: str) -> None:
        """Add a door, or panes in their frame."""
        wide, tall = opening.wide, opening.high - opening.low
        up = foot + 0.5 * (opening.low + opening.high)
        if opening.kind == "door":
            self.add(wood, (middle, foot + 1.05, -0.2), (wide, 2.1, 0.06))
            for k in (-1, 1):
                for high, panel in ((0.55, 0.7), (1.5, 0.85)):
                    self.add(wood, (middle + 0.26 * k, foot + high, -0.16), (0.36, panel, 0.04))
            self.add("pane", (middle, foot + 2.33, -0.2), (wide, 0.4, 0.03))
            self.add("hewn stone", (middle, foot + 2.12, -0.18), (wide, 0.07, 0.1))
        else:
            pane = self._pane(middle, foot)
            self.add(pane, (middle, up, -0.27), (wide, tall, 0.02))
            low = foot + opening.low + self.level - self.front.foot
            self.front.panes.append((middle, low, wide, tall))
            glazing = self._glazing if opening.kind == "window" else SHOP_GLAZING
            boxes = glazing.bars(wide, tall, wood)
            if opening.kind == "window":
                hung = dressing(float(self.rng.uniform()), self.rng, wide, tall)
                # Light from within shines through it.
                light = pane.removesuffix("pane")
                boxes += [box._replace(material=light + box.material) for box in hung]
            for material, (along, over, before), size in boxes:
                at = (middle + along, foot + opening.low + over, before)
                self.add(material, at, size)

    @property
    def _glazing(self) -> Glazing:
        """How its windows are made; by its place, so that the rest of the house is the same."""
        place = np.rint(100.0 * self.place).astype(np.int32)
        (number,) = hashed(place[:1], place[1:], self.windows)
        return GLAZINGS[int(number * len(GLAZINGS))]

    def _pane(self, middle: float, foot: float) -> str:
        """Return the material of the panes of a window: somebody is at home behind some of them."""
        place = np.rint(100.0 * self.at((middle, foot, 0.0))).astype(np.int32)
        # By its place, so that the rest of the house is the same.
        (number,) = hashed(place[:1], place[2:], int(place[1]))
        if number >= AT_HOME:
            return "pane"
        return "lit pane" if number < BRIGHT * AT_HOME else "dim pane"

    def _flower_box(self, middle: float, sill: float, wide: float) -> None:
        """Add a box on a sill, and note where flowers grow in it."""
        self.add("shutter brown", (middle, sill + 0.08, 0.09), (wide - 0.06, 0.16, 0.17))
        for k in range(9):
            along = middle + (k / 8.0 - 0.5) * (wide - 0.16)
            self.flowers.append(self.at((along, sill + 0.13, 0.1)))

    def _shutters(self, middle: float, up: float, wide: float, tall: float, wood: str) -> None:
        """Add open shutters on both sides of a window, folded where the wall is narrow."""
        edge = 0.5 * wide + SURROUND + HINGE
        room = 0.5 * (self.size[0] / self.bays - BETWEEN) - edge
        count = next((n for n in (1, 2) if 0.4 * wide <= n * room), None)
        if count is None:
            return
        leaf, thick = min(0.5 * wide / count, room), 0.05 * count
        for side in (-1.0, 1.0):
            at = middle + side * (edge + 0.5 * leaf)
            self.add(wood, (at, up, 0.015 + 0.5 * thick), (leaf, tall, thick))
            for t in (-0.36, 0.0, 0.36):
                panel = (at, up + t * tall, 0.025 + thick)
                self.add(wood, panel, (leaf - min(0.12, 0.4 * leaf), 0.26 * tall, 0.03))

    def _awning(self, middle: float, up: float, wide: float) -> None:
        """Add a striped awning over a shop window."""
        cloth = AWNINGS[PLASTERS.index(self.plaster) % len(AWNINGS)]
        count = max(round(wide / 0.26), 3)
        for k in range(count):
            at = middle + ((k + 0.5) / count - 0.5) * wide
            stripe = cloth if k % 2 == 0 else "awning white"
            self.add(stripe, (at, up - 0.16, 0.62), (wide / count, 0.02, 1.3), 0.5)
            self.add(stripe, (at, up - 0.56, 1.19), (wide / count, 0.2, 0.015))

    def _gables(self, wide: float, deep: float) -> None:
        """Add windows at both ends, and one under the roof."""
        storeys = [GROUND_STOREY + STOREY * (k - 1) for k in range(1, self.storeys)]
        spots = [(up + 1.65, back) for up in storeys for back in (0.3, 0.7)]
        spots.append((self.tall + 0.9, 0.5))
        for side in (-0.5, 0.5):
            for up, part in spots:
                at = (side * (wide - 0.02), up, -part * deep)
                self.add("hewn stone", at, (0.10, 1.7, 1.2))
                self.add("window frame", at, (0.13, 1.45, 0.95))
                for k in (-0.22, 0.22):
                    pane = (at[0], up, at[2] + k)
                    self.add("pane", pane, (0.15, 1.36, 0.4))

    def _trim(self, wide: float, deep: float) -> None:
        """Add plinth, string courses and cornice."""
        below = self.level - self.foot
        gap = 0.6
        bay = wide / self.bays
        door = (self.door + 0.5) * bay - 0.5 * wide
        for low, high in ((-0.5 * wide, door - gap), (door + gap, 0.5 * wide)):
            at, part = 0.5 * (low + high), high - low
            if part > 0.0:
                self.add("hewn stone", (at, 0.2, 0.0), (part, 0.4, 0.14))
        self.add(
            "hewn stone",
            (0.0, -0.5 * below - 0.15, -0.5 * deep + 0.03),
            (wide + 0.08, below + 0.3, deep + 0.1),
        )
        # Quoins, long and short.
        courses = int((self.tall - 0.9) / 0.38)
        for k in range(courses):
            long = 0.46 if k % 2 else 0.3
            for side in (-1.0, 1.0):
                at = side * (0.5 * (wide - long) + 0.02)
                self.add("hewn stone", (at, 0.62 + 0.38 * k, -0.1), (long, 0.365, 0.26))
        for storey in range(1, self.storeys):
            up = GROUND_STOREY + STOREY * (storey - 1) + 0.05
            self.add("hewn stone", (0.0, up, 0.02), (wide, 0.14, 0.12))
        for up, high, out in ((-0.34, 0.12, 0.16), (-0.2, 0.16, 0.34), (-0.06, 0.12, 0.5)):
            self.add("hewn stone", (0.0, self.tall + up, 0.0), (wide + 0.04, high, out))

    def _steps(self) -> None:
        """Add steps before the door, where its threshold is over the ground."""
        bay = self.size[0] / self.bays
        middle = (self.door + 0.5) * bay - 0.5 * self.size[0]
        rise = self.level - self.foot
        count = round(rise / 0.17) if rise < 1.0 else 0
        for k in range(count):
            out = 0.32 * (k + 1) + 0.1
            up = -rise * k / max(count, 1)
            self.add(
                "hewn stone",
                (middle, 0.5 * (up - rise) - 0.1, 0.5 * out),
                (1.6 + 0.2 * k, up + rise + 0.2, out),
            )

    def roof(self) -> None:
        """Add gables, courses of tiles on both slopes, and a chimney."""
        wide, deep = self.size
        rise = 0.5 * deep * PITCH
        self.add(
            self.plaster,
            (0.0, self.tall + 0.5 * rise, -0.5 * deep),
            (wide, rise, deep),
            top=(1.0, 0.01),
        )
        lean = float(np.arctan(PITCH))
        along, down = np.cos(lean), np.sin(lean)
        length = 0.5 * deep / along + EAVES
        over = wide + 0.16
        self.add(
            "tile brown",
            (
                0.0,
                self.tall + rise - 0.5 * length * down + 0.05,
                -0.5 * deep - 0.5 * length * along,
            ),
            (over, 0.09, length),
            -lean,
        )
        courses, columns = round(length / COURSE), max(round(over / TILES), 2)
        for k in range(courses):
            at = (k + 0.5) / courses * length
            up = self.tall + rise - at * down + 0.07
            shift = 0.5 * (k % 2)
            edges = np.clip((np.arange(columns + 2) - shift) / columns, 0.0, 1.0)
            for left, right in pairwise(edges.tolist()):
                if right - left < 1e-6:
                    continue
                tile = str(self.rng.choice(ROOFS, p=MIXES[self.mix]))
                spot = (0.5 * (left + right) - 0.5) * over
                # Each course lies on the one below.
                self.add(
                    tile,
                    (spot, up, -0.5 * deep + at * along),
                    ((right - left) * over, 0.07, COURSE * 1.12),
                    lean - 0.10,
                )
        self.add("tile dark", (0.0, self.tall + rise + 0.1, -0.5 * deep), (over, 0.14, 0.26))
        self.gutter(self.tall - EAVES * down, EAVES * along)
        if self.has_dormers:
            self.dormers(self.plaster, self.tall, PITCH)
        chimney = float(self.rng.choice((-0.3, 0.28, 0.4))) * wide
        self.add("brick", (chimney, self.tall + rise, -0.62 * deep), (0.8, 2.0, 0.55))
        self.add("hewn stone", (chimney, self.tall + rise + 1.0, -0.62 * deep), (0.92, 0.1, 0.67))
        for side in (-0.2, 0.2):
            self.add(
                "tile red", (chimney + side, self.tall + rise + 1.2, -0.62 * deep), (0.2, 0.34, 0.2)
            )

    def turret(self) -> None:
        """Add a little tower with a bell on the ridge, and a clock below it."""
        rise = 0.5 * self.size[1] * PITCH
        up, back = self.tall + rise, -0.5 * self.size[1]
        self.add(self.plaster, (0.0, up + 0.3, back), (1.5, 1.8, 1.5))
        for x in (-0.62, 0.62):
            for z in (-0.62, 0.62):
                self.add("window frame", (x, up + 1.75, back + z), (0.18, 1.1, 0.18))
        self.add("pane", (0.0, up + 1.75, back), (0.45, 0.5, 0.45), top=(0.45, 0.45))
        self.add("window frame", (0.0, up + 2.32, back), (1.66, 0.12, 1.66))
        self.add("tile dark", (0.0, up + 3.1, back), (1.8, 1.5, 1.8), top=(0.03, 0.03))
        self.add("window frame", (0.0, up + 0.62, back + 0.76), (0.9, 0.9, 0.06))
        self.add("pane", (0.0, up + 0.75, back + 0.8), (0.05, 0.32, 0.03))
        self.add("pane", (0.11, up + 0.62, back + 0.8), (0.24, 0.05, 0.03))


def tall(storeys: int) -> float:
    """Return the height of a facade [m]."""
    return GROUND_STOREY + STOREY * (storeys - 1)
