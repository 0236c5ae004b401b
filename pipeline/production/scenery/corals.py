"""Corals and sponges: what stands on the bed of warm water between weeds."""

from __future__ import annotations

import numpy as np

from pipeline.production.scenery.branches import add_bark, grown
from pipeline.production.scenery.prototype import (
    UP,
    Color,
    Prototype,
    Shape,
    add_tubes,
    mixed,
    random_directions,
    unit,
)
from pipeline.production.scenery.stones import icosphere, rough, surface_normals
from pipeline.simulation.spatial import Array

STAGHORN: tuple[Color, Color] = ((0.62, 0.34, 0.20), (0.85, 0.74, 0.58))
TABLE: tuple[Color, Color] = ((0.34, 0.24, 0.12), (0.82, 0.76, 0.50))
FANS: tuple[tuple[Color, Color], ...] = (
    ((0.50, 0.12, 0.30), (0.78, 0.30, 0.46)),
    ((0.62, 0.40, 0.06), (0.90, 0.78, 0.24)),
    ((0.66, 0.24, 0.06), (0.92, 0.56, 0.26)),
)
BRAIN: tuple[Color, Color] = ((0.30, 0.22, 0.08), (0.78, 0.66, 0.30))
SPONGE: tuple[Color, Color] = ((0.50, 0.22, 0.40), (0.85, 0.60, 0.72))
"""Linear colours of each kind: of its foot or furrows, and of its tips or ridges. Fans, whose
shapes are alike, are of unlike ones."""

HALVINGS = (4, 3, 2)
"""Of the sphere of a brain coral, by level."""

SIDES = (7, 5, 3)
"""Of branches and tubes, by level."""

FURROWS = 17.0
"""Furrows of a brain coral by twice its radius."""


def coral(seed: int, level: int) -> Prototype:
    """Return a coral about half a metre high, of a kind that the seed decides."""
    make = (_staghorn, _brain, _fan, _table, _sponge)[seed % 5]
    return make(np.random.default_rng([seed, 97]), seed, level)


def _staghorn(rng: np.random.Generator, seed: int, level: int) -> Prototype:
    """Return a thicket of branches with pale tips."""
    way = random_directions(rng, 900) * rng.uniform(0.3, 1.0, (900, 1))
    space = way[way[:, 1] > 0.05] * [0.38, 0.5, 0.38]
    return _branched(space, rng, level, STAGHORN, foot=0.085, step=0.036)


def _fan(rng: np.random.Generator, seed: int, level: int) -> Prototype:
    """Return a fan of twigs in one upright plane, which faces the current."""
    space = rng.uniform([-0.42, 0.08, -0.03], [0.42, 0.72, 0.03], (1500, 3))
    inside = (space[:, 0] / 0.42) ** 2 + ((space[:, 1] - 0.38) / 0.36) ** 2 < 1.0
    colors = FANS[seed // 5 % len(FANS)]
    return _branched(space[inside], rng, level, colors, foot=0.045, step=0.024)


def _table(rng: np.random.Generator, seed: int, level: int) -> Prototype:
    """Return twigs that spread to a plate on a stalk."""
    out, turn = 0.46 * np.sqrt(rng.uniform(0.0, 1.0, 1500)), rng.uniform(0.0, 2.0 * np.pi, 1500)
    # The plate is a shallow bowl, not quite round.
    out *= 1.0 + 0.16 * np.sin(2.0 * turn + seed) + 0.1 * np.sin(5.0 * turn)
    up = 0.27 + 0.22 * out**2 + rng.uniform(-0.02, 0.02, 1500)
    space = np.stack([out * np.cos(turn), up, out * np.sin(turn)], axis=-1)
    stalk = np.stack([np.zeros(12), np.linspace(0.06, 0.27, 12), np.zeros(12)], axis=-1)
    return _branched(np.vstack([space, stalk]), rng, level, TABLE, foot=0.05, step=0.026)


def _branched(
    space: Array,
    rng: np.random.Generator,
    level: int,
    colors: tuple[Color, Color],
    *,
    foot: float,
    step: float,
) -> Prototype:
    """Return branches that fill a space of points (N, 3) [m]."""
    stem = np.linspace([0.0, -0.03, 0.0], [0.0, 0.06, 0.0], 4)
    skeleton = grown([stem], space, step, foot, reach=12.0)
    out = np.linalg.norm(skeleton.nodes, axis=-1)
    shade = mixed(*colors, np.clip(out / out.max(), 0.0, 1.0) ** 2)
    shade = shade * rng.uniform(0.85, 1.15, (len(shade), 1))
    shape = Shape()
    add_bark(shape, skeleton, shade, (0.0, 0.08, 0.2)[level] * foot, SIDES[level])
    return shape.prototype()


def _brain(rng: np.random.Generator, seed: int, level: int) -> Prototype:
    """Return a dome with furrows that wind."""
    vertices, faces = icosphere(HALVINGS[level])
    wind = rough(2.2 * vertices, seed, 2)
    ridge = 0.5 + 0.5 * np.sin(FURROWS * (wind + 0.25 * vertices[:, 0]))
    vertices = vertices * (1.0 + 0.12 * rough(1.1 * vertices, seed + 3, 2))[:, None]
    vertices = vertices * (1.0 + 0.035 * ridge)[:, None] * [0.3, 0.24, 0.28]
    color = mixed(*BRAIN, ridge) * (0.6 + 0.4 * (vertices[:, 1:2] > 0.0))
    shape = Shape()
    lifted = vertices + 0.06 * UP
    shape.add(lifted, surface_normals(lifted, faces), color, faces, thin=False)
    return shape.prototype()


def _sponge(rng: np.random.Generator, seed: int, level: int) -> Prototype:
    """Return a cluster of tubes that widen to dark mouths."""
    shape, sides = Shape(), SIDES[level] + 3
    count = int(rng.integers(4, 8))
    for k in range(count):
        angle = 2.39996 * k
        out = np.array([np.cos(angle), 0.0, np.sin(angle)])
        tall, wide = rng.uniform(0.22, 0.6), rng.uniform(0.035, 0.055)
        t = np.linspace(0.0, 1.0, 6)[:, None]
        points = 0.05 * k**0.5 * out + tall * (t * UP + 0.28 * t**2 * out) - 0.03 * UP
        radii = wide * (0.75 + 0.35 * t[:, 0] + 0.08 * np.sin(9.0 * t[:, 0] + k))
        shades = mixed(*SPONGE, t[:, 0] ** 2) * rng.uniform(0.85, 1.15)
        ways = unit(np.gradient(points, axis=0))
        colors = np.stack([shades[:-1], shades[1:]], axis=1)
        rings = (ways[:-1], ways[1:])
        add_tubes(shape, points[:-1], points[1:], radii[:-1], radii[1:], colors, sides, rings)
        # The mouth goes down inside, and is dark.
        inner = np.stack([shades[-1:], 0.15 * shades[-1:]], axis=1)
        down = points[-1:] - 0.12 * tall * ways[-1:]
        lip = (ways[-1:], ways[-1:])
        add_tubes(shape, points[-1:], down, radii[-1:], 0.35 * radii[-1:], inner, sides, lip)
    return shape.prototype()
