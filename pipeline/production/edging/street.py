"""Street: where houses stand along a floor, in rows or one by itself, and the pavement before them.

None stands in the way of cast or cameras, none is built where no camera looks, and none throws its
shade on the cast.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.edging.border import CLEAR, FOREGROUND, Border
from pipeline.production.edging.cords import pennants
from pipeline.production.edging.facade import WINDOWS, bays
from pipeline.production.edging.house import MIXES, PLASTERS, House, tall
from pipeline.production.edging.ivy import WIDTH as IVY_WIDTH
from pipeline.production.edging.ivy import ivy, nearest_height
from pipeline.production.edging.plot import Plot
from pipeline.production.edging.square import pots
from pipeline.production.scenery.expansion import Copies
from pipeline.production.scenery.prototype import UP
from pipeline.simulation.spatial import Array

DEEP = 8.0
"""Depth of a house [m]."""

ROWS, YARD = 3, 8.5
"""Rows of houses one behind the other, and the depth of the yards between two rows [m]."""

DECKED, TIED = 0.8, 3.75
"""Share of houses of a town with pennants in the sun, and the height of these [m]."""

PAVEMENT = 2.1
"""Depth of the pavement before a row of houses [m]."""

THRESHOLD = 0.3
"""Height of a door over the ground [m]."""

GAP = 0.3
"""Share of the houses that do not stand wall to wall with the one before."""

SCHOOL_WIDTH, HOUSE_WIDTH = 19.0, 10.5

TRODDEN = 1.2
"""Distance from the cast at which a path ends [m]."""

LONGEST_PATH = 32
"""Rows of slabs from a door."""

FENCE, PICKET = 5.2, 0.14
"""Distance of the fence of a school from its facade, and of its pickets from one another [m]."""

ATTIC = 0.9
"""Greatest height of the wall over the upper windows of a house in a row [m]."""

FLOWERY, CLIMBERS, DORMERS = 0.6, 0.5, 0.45
"""Shares of the houses with flowers on their sills, of corners where a plant climbs, and of roofs
with dormers."""

ALONG = (0.5, 0.38, 0.62, 0.25, 0.75, 0.12, 0.88, 0.0, 1.0)
"""Shares of a side at which a single house is tried."""


@dataclass(frozen=True, eq=False)
class Site:
    """Where a house may stand.

    Attributes:
        place: middle of the foot of its facade, x and z [m].
        outward: unit vector away from the floor.
        width: of the facade [m].
        storeys: their number.
    """

    place: Array
    outward: Array
    width: float
    storeys: int

    @property
    def along(self) -> Array:
        """Unit vector along the facade, to the right of who looks at it."""
        return np.array([-self.outward[1], self.outward[0]])

    @property
    def heading(self) -> float:
        """Of the facade [rad]."""
        return float(np.arctan2(-self.along[1], self.along[0]))

    def points(self, deep: float = DEEP) -> Array:
        """Return places (N, 2) all over it, at most 2.5 m apart."""
        across = np.linspace(-0.5, 0.5, max(int(self.width / 2.5), 2) + 1) * self.width
        back = np.linspace(0.0, deep, max(int(deep / 2.5), 1) + 1)
        u, v = (a.ravel()[:, None] for a in np.meshgrid(across, back))
        return np.asarray(self.place + u * self.along + v * self.outward)

    def plot(self, front: float) -> Plot:
        """Return its ground, with some before the facade [m]."""
        middle = self.place + 0.5 * (DEEP - front) * self.outward
        return Plot(middle, self.along, np.array([0.5 * self.width, 0.5 * (DEEP + front)]))


def rows_of_houses(border: Border, out: float) -> None:
    """Add rows of town houses along all sides where they may stand, and roofs behind them.

    Args:
        border: to which they are added.
        out: distance of the first facades from the floor [m].
    """
    for number in range(ROWS):
        _row(border, out + number * (DEEP + YARD), number)


def _row(border: Border, out: float, number: int) -> None:
    """Add a row of houses at a distance from the floor [m]; the first has a pavement."""
    rng = np.random.default_rng([border.seed, 461, *[number] * (number > 0)])
    before = -1
    for site in _sites(border, out, rng, number):
        wash = int(rng.integers(0, len(PLASTERS) - 1))
        # Neighbours have different colours.
        before = wash = wash + (wash >= before >= 0)
        one = np.random.default_rng(
            [border.seed, 462, *np.rint(100 * site.place).astype(int) & 65535]
        )
        if not _stands(border, site):
            continue
        ground = border.height(site.points(0.0))
        count = bays(site.width)
        level = float(ground.max()) + THRESHOLD
        is_shop = bool(one.uniform() < 0.5)
        house = House(
            *(border.carpentry, site.place, site.heading, (site.width, DEEP), site.storeys),
            *(level, _foot(border, site), one, int(one.integers(0, count)), is_shop),
            PLASTERS[wash],
            flowery=bool(one.uniform() < FLOWERY),
            attic=float(one.uniform(0.0, ATTIC)),
            mix=int(one.integers(0, len(MIXES))),
            windows=int(one.integers(0, len(WINDOWS))),
            has_dormers=bool(one.uniform() < DORMERS),
        )
        house.build()
        if number == 0:
            border.fronts.append(house.front)
            dress(border, house, one)
            if border.sun is not None and one.uniform() < DECKED:
                aside = 0.5 * site.width - 0.2
                start, end = house.at((-aside, TIED, 0.14)), house.at((aside, TIED, 0.14))
                pennants(border, start, end, one)
            _pavement(house, float(ground.max()) - level)
        border.plots.append(site.plot(PAVEMENT + 0.3))


def single_house(border: Border, out: float, floor: Array | None, *, is_school: bool) -> None:
    """Add one house, behind the floor as the cameras see it most.

    Args:
        border: to which it is added.
        out: distance of its facade from the floor [m].
        floor: (N, 3) of a floor that is not level: its door stands where that is highest.
        is_school: whether it is wide, with a turret.
    """
    rng = np.random.default_rng([border.seed, 463])
    best, most = None, 0.0
    width = SCHOOL_WIDTH if is_school else HOUSE_WIDTH
    count = bays(width)
    door = (count // 2 + 0.5) * width / count - 0.5 * width
    for outward, start, end in _sides(border, out):
        length = float(np.linalg.norm(end - start))
        spots = [share * length for share in ALONG]
        if floor is not None:
            spots = [_highest(floor, start, end) - door]
        for spot in spots:
            site = Site(start + spot * _way(start, end), outward, width, 2)
            # In the middle of a side it looks as if it were meant.
            seen = _seen(border, site)
            if floor is None:
                seen *= 1.0 - 0.3 * abs(spot / length - 0.5)
            if seen > most and _stands(border, site, is_near=floor is not None):
                best, most = site, seen
    if best is None:
        return
    level = float(border.height(best.points(0.0)).max()) + THRESHOLD
    if floor is not None:
        level = float(floor[:, 1].max())
    house = House(
        *(border.carpentry, best.place, best.heading, (width, DEEP), 2, level),
        *(_foot(border, best), rng, count // 2, False, "rose" if is_school else "cream"),
        shuttered=0.0 if is_school else 1.0,
        flowery=not is_school,
    )
    house.build()
    border.fronts.append(house.front)
    dress(border, house, rng)
    if is_school:
        house.turret()
    if floor is None:
        _garden(border, house, best, door, rng, is_school=is_school)
    border.plots.append(best.plot(0.4 if floor is not None else 2.0))


def dress(border: Border, house: House, rng: np.random.Generator) -> None:
    """Add what grows on a house: climbers at its corners, flowers on sills, pots at its door."""
    wide, tall_ = house.size[0], house.tall
    bay = wide / house.bays
    door = (house.door + 0.5) * bay - 0.5 * wide
    if house.flowers:
        points = np.array(house.flowers)
        for kind, part in (("poppy", points[::2]), ("daisy", points[1::2])):
            border.add_plants(kind, part, 0.62, rng)
    ground = np.array([house.at((door + side, 0.0, 0.42)) for side in (-0.95, 0.95)])
    ground[:, 1] = border.height(ground[:, [0, 2]])
    free = border.is_free(ground[:, [0, 2]], 0.6, 0.1)
    if house.level - house.foot < 1.0 and free.all():
        up = THRESHOLD - 0.21 if house.level > ground[:, 1].max() + 0.1 else 0.0
        pots(border, ground + up * UP, rng)
    c, s = np.cos(house.heading), np.sin(house.heading)
    turn = np.array([[[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]])
    for side in (-1.0, 1.0):
        if rng.uniform() > CLIMBERS:
            continue
        broad, high = rng.uniform(1.7, 2.4), rng.uniform(0.55, 0.95) * tall_
        at = house.at((side * (0.5 * wide - 0.42 * broad), 0.0, 0.02))
        at[1] = house.foot
        level = int(border.view.distances(at[None])[0] / border.detail > 14.0)
        high += house.level - house.foot
        own = nearest_height(high)
        size = np.array([[broad / IVY_WIDTH, high / own, 1.0]])
        shape = ivy(int(rng.integers(0, 4)), level, own)
        border.leaves.append(Copies(shape, at[None], turn, size, np.ones((1, 3))))


def _way(start: Array, end: Array) -> Array:
    return np.asarray((end - start) / np.linalg.norm(end - start))


def _sides(border: Border, out: float) -> list[tuple[Array, Array, Array]]:
    """Return the outward vector, first and last place of each side."""
    low, high = border.low - out, border.high + out
    a, b, c, d = low, np.array([high[0], low[1]]), high, np.array([low[0], high[1]])
    outward = ((0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0))
    return [
        (np.array(way), start, end)
        for way, start, end in zip(outward, (a, b, c, d), (b, c, d, a), strict=True)
    ]


def _sites(border: Border, out: float, rng: np.random.Generator, number: int) -> list[Site]:
    """Return the sites of houses side by side along all sides; those behind are taller."""
    sites = []
    for outward, start, end in _sides(border, out):
        length, at = float(np.linalg.norm(end - start)), 0.0
        while at < length:
            if rng.uniform() < GAP:
                # A lane, or a garden with trees.
                at += float(rng.uniform(3.0, 6.5))
            width = float(rng.uniform(6.0, 9.4))
            storeys = int(rng.choice((2, 2, 3, 3))) + (number > 0)
            place = start + (at + 0.5 * width) * _way(start, end)
            place = place + float(rng.uniform(0.0, 0.5)) * outward
            sites.append(Site(place, outward, width, storeys))
            at += width
    return sites


def _stands(border: Border, site: Site, *, is_near: bool = False) -> bool:
    """Return whether a house may stand on a site, and is seen."""
    if _seen(border, site) == 0.0:
        return False
    places = site.points()
    if border.clearings is not None:
        distance = border.clearings.distance(*places.T)
        if distance.min() < (CLEAR if is_near else CLEAR + 1.0):
            return False
    points = border.points(places)
    one: NDArray[np.float64] = np.ones(len(points))
    if border.view.in_the_way(points, one * (tall(site.storeys) + 3.0), 1.2 * one).any():
        return False
    if border.view.in_the_foreground(
        points, 2.0 * one, one, (0.36 if is_near else 0.8) * FOREGROUND
    ).any():
        return False
    return not border.shades_the_cast(places, tall(site.storeys) + 1.5, 0.2).any()


def _seen(border: Border, site: Site) -> float:
    """Return the share of the cameras' poses that see the facade."""
    view = border.view
    points = border.points(site.points(0.0)) + 2.5 * UP
    way = points[:, None] - view.eyes[None]
    distance = np.linalg.norm(way, axis=-1)
    apart = np.arccos(np.clip((way * view.ahead).sum(axis=-1) / distance, -1.0, 1.0))
    faces = (way[..., [0, 2]] @ site.outward) > 0.0
    return float(((apart < view.angles) & faces).mean())


def _foot(border: Border, site: Site) -> float:
    return float(border.height(site.points()).min()) - 0.1


def _highest(floor: Array, start: Array, end: Array) -> float:
    """Return where along a side the floor is highest [m]."""
    top = floor[floor[:, 1] > floor[:, 1].max() - 0.02][:, [0, 2]]
    return float(np.median((top - start) @ _way(start, end)))


def _pavement(house: House, up: float) -> None:
    """Add slabs before a house, a little over the ground, and a kerb."""
    wide = house.size[0]
    count = max(round(wide / 1.05), 1)
    for k in range(count):
        at = ((k + 0.5) / count - 0.5) * wide
        for row in range(2):
            deep = (PAVEMENT - 0.2) / 2
            lift = float(house.rng.normal(0.0, 0.006))
            house.add(
                ("hewn stone", "grey")[int(house.rng.uniform() < 0.3)],
                (at, up - 0.15 + lift, (row + 0.5) * deep),
                (wide / count - 0.012, 0.5, deep - 0.012),
            )
        kerb = (at, up - 0.17, PAVEMENT - 0.1)
        house.add("hewn stone", kerb, (wide / count - 0.02, 0.5, 0.2))


def _garden(
    border: Border,
    house: House,
    site: Site,
    door: float,
    rng: np.random.Generator,
    *,
    is_school: bool,
) -> None:
    """Add what is before a house on natural ground: plants, a path, the fence of a school."""
    _planting(border, site, rng)
    _path(border, house, site, door, rng)
    if is_school:
        _front_yard(border, site, door, rng)


def _planting(border: Border, site: Site, rng: np.random.Generator) -> None:
    """Add shrubs and flowers at the foot of a facade, but for its middle."""
    for kind, step, out, size in (
        *(("bush", 1.1, 1.0, 0.8), ("poppy", 0.5, 1.5, 1.1), ("tall grass", 0.45, 0.8, 0.9)),
    ):
        at = np.arange(-0.47, 0.48, step / site.width) * site.width
        at = at + rng.uniform(-0.4, 0.4, len(at)) * step
        at = at[(np.abs(at - at.mean()) > 2.6) & (rng.uniform(size=len(at)) < 0.8)]
        front = out + rng.normal(0.0, 0.18, len(at))
        places = site.place + at[:, None] * site.along - front[:, None] * site.outward
        places = places[border.is_free(places, 0.8, 0.4)]
        if len(places):
            border.add_plants(kind, border.points(places), size, rng)


def _front_yard(border: Border, site: Site, door: float, rng: np.random.Generator) -> None:
    """Add a picket fence with a gate before a school, and a tree at each side of its door."""
    along = np.arange(-0.5 * site.width - 3.0, 0.5 * site.width + 3.0, PICKET)
    along = along[np.abs(along - door) > 1.1]
    places = site.place + along[:, None] * site.along - FENCE * site.outward
    places = places[border.is_free(places, 1.0, 0.1)]
    if len(places):
        points = border.points(places)
        tall = 0.92 + rng.normal(0.0, 0.012, len(points))
        sizes = np.column_stack([np.full(len(points), 0.075), tall, np.full(len(points), 0.022)])
        border.carpentry.add(
            "edging weathered", points + 0.5 * tall[:, None] * UP, sizes, site.heading
        )
        back = 0.03 * np.array([site.outward[0], 0.0, site.outward[1]])
        for up in (0.28, 0.72):
            border.carpentry.add(
                "edging weathered",
                points + up * UP + back,
                (PICKET + 0.01, 0.07, 0.03),
                site.heading,
            )
    for side in (-0.36, 0.36):
        place = (site.place + side * site.width * site.along - 0.5 * FENCE * site.outward)[None]
        if border.is_free(place, 6.0, 2.5)[0] and not border.shades_the_cast(place, 6.0, 2.0)[0]:
            border.add_plants("birch", border.points(place), 0.62, rng)


def _path(border: Border, house: House, site: Site, door: float, rng: np.random.Generator) -> None:
    """Add a path of slabs from the door towards the floor, as far as nobody treads."""
    for k in range(LONGEST_PATH):
        out = 1.2 + 0.66 * k
        place = site.place + door * site.along - out * site.outward
        if border.clearings is None or border.clearings.distance(*place[:, None])[0] < TRODDEN:
            return
        up = float(border.height(place[None])[0]) - house.level
        for side in (-0.36, 0.36):
            at = (door + side + rng.normal(0, 0.02), up - 0.05, out + rng.normal(0, 0.02))
            house.add("hewn stone", at, (0.68, 0.14, 0.62))
        border.plots.append(Plot(place, site.along, np.array([0.75, 0.36])))
