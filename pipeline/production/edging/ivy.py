"""Ivy: climbing plants on walls, grown at the size that they have."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pipeline.production.scenery.branches import Skeleton, add_bark, grown
from pipeline.production.scenery.prototype import (
    UP,
    Prototype,
    Shape,
    add_leaves,
    mixed,
    random_directions,
    unit,
)
from pipeline.production.scenery.stones import rough
from pipeline.production.surroundings.lattice_noise import smoothstep
from pipeline.simulation.spatial import Array

WIDTH = 2.2
"""Of a plant at scale 1 [m]."""

HEIGHTS = (3.0, 4.5, 6.5, 9.0)
"""Heights at which plants are grown. Others are scaled from the nearest, which hardly stretches
leaves."""

STEM = (0.09, 0.066, 0.046)
"""Linear colour of runners."""

OLD, GREEN, YOUNG = (0.030, 0.062, 0.020), (0.062, 0.125, 0.028), (0.17, 0.235, 0.06)
"""Linear colours of leaves in the shade, in the light, and at the tips of runners."""

LEAVES = (420, 180)
"""Leaves on a square metre of what is grown over, by level of detail."""

LENGTHS = (0.115, 0.165)
"""Mean lengths of leaves by level of detail [m]."""

STEP, SPREAD = 0.13, 0.085
"""Step by which runners grow, and deviation of leaves from them [m]."""

PILLOW, PILLOW_SIZE = 0.20, 0.55
"""Thickness of the pillows that leaves make, and their breadth [m]."""


def nearest_height(high: float) -> float:
    """Return the height of `HEIGHTS` that is nearest to another one [m]."""
    return min(HEIGHTS, key=lambda own: abs(np.log(own / high)))


@lru_cache(maxsize=32)
def ivy(seed: int, level: int, high: float) -> Prototype:
    """Return a plant before a wall that faces +z, from its foot at the origin.

    Args:
        seed: of its form.
        level: of detail, 0 or 1.
        high: height [m].
    """
    rng, shape = np.random.default_rng([seed, 437, level]), Shape()
    runners = _runners(rng, seed, high)
    add_bark(shape, runners, np.tile(STEM, (len(runners.nodes), 1)), (0.006, 0.03)[level], 4)
    _add_foliage(shape, runners, rng, seed, level, high)
    return shape.prototype()


def _runners(rng: np.random.Generator, seed: int, high: float) -> Skeleton:
    """Return runners, which fan out and climb in the plane of the wall."""
    count = int(110 * WIDTH * high)
    x, y = rng.uniform(-0.5, 0.5, count) * WIDTH, rng.uniform(0.0, high, count)
    # Patches of the wall stay bare, more of them high up and at both sides.
    gaps = rough(np.column_stack([1.1 * x, 0.9 * y, 0.0 * x]), seed, 3)
    kept = gaps + 0.75 - 0.5 * y / high - 1.6 * (x / WIDTH) ** 2 > 0.0
    space = np.column_stack([x, y, np.zeros(count)])[kept]
    stems = [
        np.linspace([side, -0.1, 0.0], [1.6 * side, 0.4, 0.0], 4)
        for side in rng.uniform(-0.16, 0.16, 3) * WIDTH
    ]
    return grown(stems, space, STEP, 0.022, reach=7.0)


def _add_foliage(
    shape: Shape, runners: Skeleton, rng: np.random.Generator, seed: int, level: int, high: float
) -> None:
    """Add leaves in pillows along runners, like shingles: each hangs over the one below."""
    nodes = runners.nodes
    grown_over = len(np.unique(np.floor(nodes[:, :2] / 0.25), axis=0)) * 0.25**2
    n = int(LEAVES[level] * grown_over)
    # Runners are clothed most near the foot, and least at their tips.
    reach = np.clip(nodes[:, 1] / high, 0.0, 1.0)
    weight = 1.0 - 0.6 * reach**2
    at = rng.choice(len(nodes), n, p=weight / weight.sum())
    x, y = (nodes[at, :2] + rng.normal(0.0, SPREAD, (n, 2))).T
    y = np.maximum(y, 0.02)
    pillow = _pillow(x, y, seed)
    depth = np.sqrt(rng.uniform(0.0, 1.0, n))
    out = 0.02 + (0.25 + 0.75 * pillow) * PILLOW * depth
    steep = np.stack([_pillow(x + 0.05, y, seed), _pillow(x, y + 0.05, seed)]) - pillow
    swell = unit(np.column_stack([*(-1.6 * PILLOW * steep / 0.05), np.ones(n)]))
    way = 0.45 * random_directions(rng, n) + [0.0, -0.9, 0.25] + 0.3 * swell
    face = 0.45 * random_directions(rng, n) + swell + 0.35 * UP
    lit = smoothstep(0.35, 1.0, depth) * (0.45 + 0.55 * pillow)
    young = smoothstep(0.80, 1.0, rng.uniform(0.0, 1.0, n)) * depth**2 * 0.8
    color = mixed(mixed(OLD, GREEN, lit), YOUNG, young) * rng.uniform(0.75, 1.25, (n, 1))
    size = LENGTHS[level] * rng.uniform(0.55, 1.2, n)
    add_leaves(
        *(shape, np.column_stack([x, y, out]), way, face, size, 0.92 * size, color),
        swell + 0.5 * unit(face),
        triangles=(4, 2)[level],
    )


def _pillow(x: Array, y: Array, seed: int) -> Array:
    """Return the thickness (n,) of the foliage at places of the wall, 0 to 1."""
    points = np.column_stack([x, y, np.zeros(len(x))]) / PILLOW_SIZE
    return np.asarray(smoothstep(-0.5, 0.6, rough(points, seed + 11, 2)))
