"""Palms: for terraces at a shore: coconut, date and fan palms."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pipeline.production.scenery.prototype import (
    UP,
    Color,
    Prototype,
    Shape,
    across,
    add_tubes,
    mixed,
    unit,
)
from pipeline.production.scenery.stones import icosphere
from pipeline.simulation.spatial import Array


@dataclass(frozen=True)
class Habit:
    """How a palm grows.

    Attributes:
        height: of the trunk [m].
        radius: of the trunk below the crown [m].
        lean: greatest distance of the crown from the foot, sidewards [m].
        scars: number of leaf scars along the trunk.
        boots: stubs of leaves around the trunk, 0 where it has shed them.
        fronds: their number.
        long: length of a frond [m].
        leaflet: length of the longest leaflet, or of a fan from its hub [m].
        rises: pitch of the youngest and of the oldest green frond at their foot [rad].
        bow: by how much fronds bend down to their tips [rad].
        dry: number of dry fronds that hang below.
        green: colour of old fronds, linear.
        young: colour of young ones.
        bark: colour of the trunk.
        is_fan: whether leaflets spread from one point.
    """

    height: float
    radius: float
    lean: float
    scars: int
    boots: int
    fronds: int
    long: float
    leaflet: float
    rises: tuple[float, float]
    bow: float
    dry: int
    green: Color
    young: Color
    bark: Color
    is_fan: bool = False


HABITS = (
    Habit(
        *(6.6, 0.115, 1.7, 62, 0, 25, 3.1, 0.85, (1.35, -0.45), 1.55, 4),
        *((0.105, 0.165, 0.040), (0.250, 0.290, 0.080), (0.26, 0.215, 0.165)),
    ),
    Habit(
        *(5.2, 0.20, 0.25, 36, 9, 38, 2.4, 0.50, (1.45, -0.55), 0.95, 7),
        *((0.110, 0.150, 0.060), (0.215, 0.245, 0.105), (0.20, 0.150, 0.105)),
    ),
    Habit(
        *(5.6, 0.14, 0.45, 52, 0, 34, 1.15, 0.95, (1.35, -0.60), 0.35, 12),
        *((0.095, 0.150, 0.045), (0.220, 0.265, 0.085), (0.21, 0.170, 0.125), True),
    ),
    Habit(
        *(5.4, 0.105, 2.3, 54, 0, 21, 2.7, 0.95, (1.25, -0.25), 1.75, 3),
        *((0.120, 0.175, 0.042), (0.265, 0.295, 0.085), (0.28, 0.235, 0.180)),
    ),
)
"""Coconut, date and fan palm, and a coconut palm bent by the wind."""

SCAR, LIP = (0.62, 0.92), 0.14
"""Least and greatest lightness of the lip below a scar, relative to the bark, and its share of the
way to the next."""

WORN, PATCH = (0.86, 1.12), 8
"""Least and greatest lightness of patches of bark, and their length, in rings."""

BOOT_OUT, BOOT_LONG, BOOT_DOWN = 0.24, 0.75, 1.1
"""How far the tip of a stub stands out relative to the radius of the trunk, and how far it reaches
above and below the row of the stub, in rows."""

DEAD = (0.29, 0.205, 0.115)
"""Linear colour of dry fronds."""

LEAFLETS, FAN_RAYS = (34, 22), (24, 15)
"""Leaflets on each side of a frond, and rays of a fan, by level of detail."""

FAN_HALF = 2.3
"""Angle of the outermost rays from the middle one of a fan [rad]."""


@lru_cache(maxsize=16)
def palm(seed: int, level: int) -> Prototype:
    """Return a palm at a level of detail; the habit goes by the seed."""
    habit = HABITS[seed % len(HABITS)]
    rng, shape = np.random.default_rng([seed, 491]), Shape()
    level = min(level, 1)
    crown = _add_trunk(shape, habit, rng, level)
    fronds = habit.fronds + habit.dry
    for k in range(fronds):
        age = min(k / max(habit.fronds - 1, 1), 1.0)
        is_dry = k >= habit.fronds
        heading = 2.39996 * k + rng.normal(0.0, 0.16)
        rise = habit.rises[0] + (habit.rises[1] - habit.rises[0]) * age**0.85
        rise = -1.05 + rng.normal(0.0, 0.15) if is_dry else rise + rng.normal(0.0, 0.1)
        color = mixed(habit.young, habit.green, np.array(age**0.7))
        color = mixed(color, DEAD, np.array(0.35 * rng.uniform() * (age > 0.8)))
        color = np.asarray(DEAD) * rng.uniform(0.7, 1.15) if is_dry else color
        color = color * rng.uniform(0.88, 1.12)
        # The youngest are still short, the dry ones have shrunk.
        long = habit.long * rng.uniform(0.88, 1.1) * (0.75 + 0.25 * min(4.0 * age, 1.0))
        long *= 0.72 if is_dry else 1.0
        spine = _spine(crown, heading, rise, habit.bow * (0.4 if is_dry else 1.0), long)
        add_tubes(
            *(shape, spine[:-1], spine[1:]),
            *(np.linspace(0.034, 0.012, len(spine) - 1), np.linspace(0.032, 0.008, len(spine) - 1)),
            *(np.tile(1.15 * color, (len(spine) - 1, 1)), 3),
        )
        add = _add_fan if habit.is_fan else _add_feather
        add(shape, rng, spine, heading, habit.leaflet * (0.8 if is_dry else 1.0), color, level)
    return shape.prototype()


def _add_trunk(shape: Shape, habit: Habit, rng: np.random.Generator, level: int) -> Array:
    """Add a trunk with scars or stubs of leaves, and return the place (3,) of the crown."""
    n = habit.scars
    # Leaves follow each other faster in good years.
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(0.6, 1.4, n))])[:, None]
    t = t / t[-1]
    if not habit.boots:
        # Each leaf leaves a narrow lip around the trunk.
        lips = t[:-1] + LIP * np.diff(t, axis=0)
        t, n = np.sort(np.concatenate([t, lips]), axis=0), 2 * n
    turn = rng.uniform(0.0, 2.0 * np.pi)
    lean = habit.lean * rng.uniform(0.6, 1.0) * np.array([np.cos(turn), 0.0, np.sin(turn)])
    # It sets out askew and straightens to the light.
    points = habit.height * t * UP + (1.45 * t - 0.45 * t**2.2) * lean
    radii = habit.radius * (1.0 + 0.35 * (1.0 - t[:, 0]) + 0.75 * np.exp(-t[:, 0] / 0.045))
    radii = radii * (1.0 + (0.025 if habit.boots else 0.01) * rng.normal(size=n + 1))
    ways = unit(np.diff(points, axis=0))
    rings = unit(np.concatenate([ways[:1], ways[:-1] + ways[1:], ways[-1:]]))
    tilt = 0.06 * rng.normal(size=(n + 1, 3))
    if habit.boots:
        # Between stubs it is dark all along.
        bark = np.asarray(habit.bark) * rng.uniform(0.88, 1.08, (n, 1))
        shades = np.stack([0.4 * bark, 0.4 * bark], axis=1)
    else:
        # A lip stands out at its upper edge, and both of its edges lie askew alike.
        tilt = np.repeat(tilt[::2], 2, axis=0)[: n + 1]
        radii = radii * np.resize([0.97, 1.03], n + 1)
        rings = unit(rings + tilt)
        # It weathers in long patches; the lips are dark below and worn pale above.
        knots = np.arange(0, n + PATCH, PATCH)
        worn = np.interp(np.arange(n), knots, rng.uniform(*WORN, len(knots)))
        bark = np.asarray(habit.bark) * worn[:, None]
        scar = rng.uniform(*SCAR, (n, 1))
        is_lip = (np.arange(n) % 2 == 0)[:, None]
        shades = np.stack(
            [np.where(is_lip, scar, 0.98) * bark, np.where(is_lip, 1.06, 1.0) * bark], axis=1
        )
    add_tubes(
        *(shape, points[:-1], points[1:], radii[:-1], radii[1:], shades, (18, 9)[level]),
        (unit(rings[:-1] + tilt[:-1]) if habit.boots else rings[:-1], rings[1:]),
    )
    if habit.boots:
        _add_boots(shape, habit, rng, points, rings, radii, level)
    crown = points[-1]
    vertices, faces = icosphere(1)
    sizes = np.array([1.25, 1.5, 1.25]) * habit.radius
    shape.add(crown + vertices * sizes, vertices, 0.8 * np.asarray(habit.bark), faces, thin=False)
    if not habit.is_fan and habit.lean > 1.0:
        for k in range(6):
            way = np.array([np.cos(k + turn), -0.75, np.sin(k + turn)])
            nut = crown + 0.24 * way * rng.uniform(0.8, 1.2)
            shape.add(
                nut + 0.105 * vertices, vertices, np.array([0.16, 0.15, 0.05]), faces, thin=False
            )
    return np.asarray(crown)


def _add_boots(
    shape: Shape,
    habit: Habit,
    rng: np.random.Generator,
    points: Array,
    rings: Array,
    radii: Array,
    level: int,
) -> None:
    """Add the stubs of leaves around a trunk: wedges whose tips stand out, row over row.

    Args:
        shape: to which they are added.
        habit: of the palm.
        rng: of their differences.
        points: (R, 3) in the middle of the trunk [m].
        rings: (R, 3) its directions there.
        radii: (R,) [m].
        level: of detail.
    """
    around = max(habit.boots - 2 * level, 5)
    rows = np.arange(1, len(points))
    row = np.repeat(rows, around) + rng.uniform(-0.25, 0.25, around * len(rows))
    # Each row stands in the gaps of the one below.
    angle = (np.tile(np.arange(around), len(rows)) + 0.5 * np.repeat(rows, around)) / around
    angle = 2.0 * np.pi * angle + rng.normal(0.0, 0.07, len(row))
    half = np.pi / around * rng.uniform(0.8, 1.05, len(row))
    stands = 1.0 + BOOT_OUT * rng.uniform(0.5, 1.3, len(row))
    knots = np.arange(len(points))

    def place(up: Array, aside: Array, out: Array) -> Array:
        middle, way = (
            np.stack([np.interp(row + up, knots, table[:, k]) for k in range(3)], axis=-1)
            for table in (points, rings)
        )
        u, w = across(unit(way))
        turned = angle + aside * half
        outwards = np.cos(turned)[:, None] * u + np.sin(turned)[:, None] * w
        return np.asarray(middle + (np.interp(row + up, knots, radii) * out)[:, None] * outwards)

    none, one = np.zeros(len(row)), np.ones(len(row))
    long = BOOT_LONG * rng.uniform(0.6, 1.3, len(row))
    corners = [
        place(-BOOT_DOWN * one, none, 0.98 * one),
        place(none, -one, 1.02 * one),
        place(none, one, 1.02 * one),
        place(long, -0.45 * one, stands),
        place(long, 0.45 * one, stands),
        place(0.3 * one, none, 0.9 * one),
    ]
    places = np.stack(corners, axis=1)
    axis = np.stack([np.interp(row, knots, points[:, k]) for k in range(3)], axis=-1)
    normals = places - axis[:, None]
    normals[:, 5] = rings[np.minimum(np.rint(row).astype(int), len(rings) - 1)]
    bark = np.asarray(habit.bark) * rng.uniform(0.75, 1.2, (len(row), 1))
    # Cut ends are pale and their edges grey, below they are in shade.
    tones = np.array([0.45, 0.8, 0.8, 1.15, 1.15, 0.3])[None, :, None] * bark[:, None]
    faces = np.array([[0, 2, 1], [1, 2, 4], [1, 4, 3], [3, 4, 5]])
    numbers = faces[None] + places.shape[1] * np.arange(len(places))[:, None, None]
    shape.add(places, normals, tones, numbers, thin=False)


def _spine(foot: Array, heading: float, rise: float, bow: float, long: float) -> Array:
    """Return points (9, 3) along the midrib of a frond that bends down to its tip [m]."""
    s = (np.arange(8) + 0.5) / 8
    # Upright fronds bow, hanging ones have done so.
    pitch = np.maximum(rise - bow * s**1.3 * (0.45 + 0.55 * np.cos(min(rise, 1.2))), -1.45)
    out = np.array([np.cos(heading), 0.0, np.sin(heading)])
    steps = long / 8 * (np.cos(pitch)[:, None] * out + np.sin(pitch)[:, None] * UP)
    return np.asarray(foot + np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)]))


def _add_feather(
    shape: Shape,
    rng: np.random.Generator,
    spine: Array,
    heading: float,
    longest: float,
    color: Array,
    level: int,
) -> None:
    """Add the leaflets on both sides of a midrib, which hang a little."""
    count = LEAFLETS[level]
    s = np.linspace(0.1, 0.995, count)
    at = s * (len(spine) - 1)
    knots = np.arange(len(spine))
    base = np.stack([np.interp(at, knots, spine[:, k]) for k in range(3)], axis=-1)
    ways = np.diff(spine, axis=0)
    along = unit(ways[np.minimum(at.astype(int), len(ways) - 1)])
    aside = np.array([-np.sin(heading), 0.0, np.cos(heading)])
    above = unit(np.cross(along, aside) * -1.0)
    above = above * np.where(above[:, 1:2] < 0.0, -1.0, 1.0)
    lengths = longest * np.sin(np.pi * (0.14 + 0.80 * s)) ** 0.65
    # Leaflets nearly touch where they begin.
    wide = 0.78 * np.linalg.norm(spine[-1] - spine[0]) / count
    ahead = (0.45 + 0.9 * s**2)[:, None]
    for sign in (-1.0, 1.0):
        vary = rng.normal(size=(count, 3))
        axes = unit(sign * aside + ahead * along + 0.28 * above + 0.10 * vary)
        size = (lengths * rng.uniform(0.85, 1.1, count))[:, None]
        middle = base + 0.5 * size * axes - 0.05 * size * UP
        tip = base + size * (0.94 * axes - (0.34 + 0.08 * vary[:, :1]) * UP)
        half = 0.5 * wide * along
        shade = color * rng.uniform(0.82, 1.2, (count, 1))
        # The two sides are a shallow roof.
        normal = unit(above + 0.35 * sign * aside + 0.12 * vary)
        if level:
            _add_blades(shape, [base - half, base + half, tip], shade, normal, [[0, 1, 2]])
        else:
            corners = [base - half, base + half, middle - 0.85 * half, middle + 0.85 * half, tip]
            _add_blades(shape, corners, shade, normal, [[0, 1, 3], [0, 3, 2], [2, 3, 4]])


def _add_fan(
    shape: Shape,
    rng: np.random.Generator,
    spine: Array,
    heading: float,
    longest: float,
    color: Array,
    level: int,
) -> None:
    """Add a fan of pleated rays at the end of a stalk."""
    count = FAN_RAYS[level]
    hub = spine[-1]
    ahead = unit(spine[-1] - spine[-3])
    aside = np.array([-np.sin(heading), 0.0, np.cos(heading)])
    above = unit(np.cross(aside, ahead))
    above = above if above[1] > 0.0 else -above
    angle = FAN_HALF * np.linspace(-1.0, 1.0, count)[:, None]
    rays = np.cos(angle) * ahead + np.sin(angle) * aside - 0.12 * above
    across = np.cos(angle) * aside - np.sin(angle) * ahead
    size = longest * (0.78 + 0.22 * np.cos(angle)) * rng.uniform(0.9, 1.08, (count, 1))
    half = 1.06 * FAN_HALF / count * 0.6 * size * across
    middle = hub + 0.6 * size * rays
    tip = hub + size * rays - (0.16 + 0.08 * rng.uniform(size=(count, 1))) * size * UP
    shade = color * rng.uniform(0.85, 1.15, (count, 1))
    pleat = np.where(np.arange(count) % 2, 0.5, -0.5)[:, None]
    normal = unit(above + pleat * across)
    corners = [np.tile(hub, (count, 1)), middle - half, middle + half, tip]
    _add_blades(shape, corners, shade, normal, [[0, 2, 1], [1, 2, 3]])


def _add_blades(
    shape: Shape, corners: list[Array], colors: Array, normals: Array, faces: list[list[int]]
) -> None:
    """Add N flat blades by their corners (N, 3), lighter at the last of them, their tip."""
    places = np.stack(corners, axis=1)
    light = np.array([*([0.92] * (len(corners) - 1)), 1.12])[None, :, None]
    numbers = np.array(faces)[None] + len(corners) * np.arange(len(places))[:, None, None]
    shape.add(
        places, normals[:, None] * np.ones((1, len(corners), 1)), colors[:, None] * light, numbers
    )
