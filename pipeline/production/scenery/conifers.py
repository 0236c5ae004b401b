"""Conifers: a spruce of branches that hang, with twigs of needles."""

from __future__ import annotations

import numpy as np

from pipeline.production.scenery.prototype import UP, Prototype, Shape, add_leaves, add_tubes, unit
from pipeline.production.scenery.trees import CALM
from pipeline.simulation.spatial import Array

TWIGS = ((0.20, 1.0), (0.26, -1.0), (0.48, 1.0), (0.54, -1.0), (0.72, 1.0), (0.78, -1.0))
"""Twigs of the second order on a spray: where they part, and to which side."""


def spruce(seed: int, level: int) -> Prototype:
    """Return a spruce: branches that hang and rise to their tips, with sprays of needles."""
    rng, shape = np.random.default_rng([seed, 79]), Shape()
    # Young ones are slim and clothed to the ground, old ones broad, gappy and bare below.
    age = (seed // 101 % 4) / 3.0
    height = 10.0 * (0.80 + 0.42 * age) * rng.uniform(0.95, 1.05)
    broad, bare, gaps = 0.165 + 0.085 * age, 0.02 + 0.12 * age**2, 0.05 + 0.13 * age
    n, sprays = ((290, 9), (270, 14), (150, 6), (76, 2))[level]
    # Branches stand in no storeys: whorls of one height would be seen as plates.
    t = (np.arange(n) + rng.uniform(0.0, 1.0, n)) / n
    at = height * (bare + (0.985 - bare) * t**0.92)
    around = 2.39996 * np.arange(n) + rng.normal(0.0, 0.35, n)
    length = broad * height * (1.0 - t) ** 0.82 * (1.0 - 0.25 * np.exp(-t / 0.05)) + 0.06
    length = length * rng.uniform(0.62, 1.16, n)
    # Some branches are broken or starved, more of them low down.
    length = np.where(rng.uniform(size=n) < gaps * (1.25 - t), 0.45 * length, length)
    root = np.stack([np.zeros(n), at, np.zeros(n)], axis=-1)
    out = np.stack([np.cos(around), np.zeros(n), np.sin(around)], axis=-1)
    droop = 0.42 - 0.75 * t + rng.normal(0.0, 0.07, n)
    along = np.linspace(0.12, 1.0, sprays + 1)[1:] if sprays > 1 else np.array([0.4])

    def on_branch(s: Array) -> Array:
        """Return places (n, S, 3) on branches, which hang and rise again to their tips."""
        fall = droop[:, None] * s - 0.22 * (s - 0.75 * s**2)
        return np.asarray(
            root[:, None]
            + (length[:, None] * s)[..., None] * out[:, None]
            - (length[:, None] * fall)[..., None] * UP
        )

    place = on_branch(along)
    green, tip = np.array([0.098, 0.142, 0.062]), np.array([0.205, 0.260, 0.100])
    color = green + along[None, :, None] ** 2 * (tip - green)
    color = color * (0.975 + CALM[level] * rng.uniform(-0.225, 0.225, (n, 1, 1)))
    side = np.cross(out, UP)
    spread = (1.15, 1.15, 1.3, 1.7)[level] * length[:, None] * (1.1 - 0.72 * along)
    spread = spread * rng.uniform(0.75, 1.2, spread.shape)
    wide = (0.16, 0.20, 0.30, 1.0)[level]
    normals = unit(out + 0.75 * UP)
    for sign in (-1.0, 1.0):
        way = sign * side[:, None] + 0.85 * out[:, None] - [0.0, 0.34, 0.0]
        way = unit(way + 0.2 * rng.normal(size=place.shape))
        twig = 0.62 * spread
        _add_sprays(shape, place, way, twig, wide, color, normals)
        # Twigs of the second order hang more; their tips make a ragged outline.
        for s, turn in TWIGS[: (4, 4, 6, 0)[level]]:
            inner = place + (s * twig)[..., None] * way
            fork = unit(0.9 * way + turn * unit(np.cross(way, UP)) - [0.0, 0.33, 0.0])
            fork = fork + 0.15 * rng.normal(size=place.shape)
            short = (0.56 - 0.42 * s) * twig
            slim, folded = (0.30, 0.22, 0.33, 0.0)[level], 2 if level == 0 else 1
            _add_sprays(shape, inner, fork, short, slim, color, normals, triangles=folded)
    # The end of each branch.
    last, tip_wide = 0.3 * length[:, None], (0.2, 0.22, 0.4, 0.5)[level]
    _add_sprays(shape, place[:, -1:], out[:, None], last, tip_wide, color[:, -1:], normals)
    if level < 2:
        wood = on_branch(np.linspace(0.0, 0.92, 4))
        thick = np.clip(0.022 * length, 0.006, 0.05)
        for k in range(3):
            add_tubes(
                *(shape, wood[:, k], wood[:, k + 1]),
                *(thick * (1.0 - 0.28 * k), thick * (0.72 - 0.28 * k)),
                *(np.tile([0.075, 0.055, 0.042], (n, 1)), 3),
            )
    sides = (8, 6, 4, 3)[level]
    trunk = height * np.linspace(-0.01, 0.96, 6)
    points = np.stack([0.012 * height * np.sin(trunk), trunk, 0 * trunk], axis=-1)
    radii = 0.016 * height * (1.03 - np.linspace(0.0, 1.0, 6))
    bark = np.tile([0.085, 0.062, 0.047], (5, 1))
    ways = np.tile(UP, (5, 1))
    add_tubes(shape, points[:-1], points[1:], radii[:-1], radii[1:], bark, sides, (ways, ways))
    return shape.prototype()


def _add_sprays(
    shape: Shape,
    place: Array,
    way: Array,
    size: Array,
    wide: float,
    color: Array,
    normals: Array,
    triangles: int = 2,
) -> None:
    """Add sprays (N, S) of needles that grow from places (N, S, 3)."""
    n, s = place.shape[:2]
    lengths = np.broadcast_to(size, (n, s)).ravel()
    colors = np.broadcast_to(color, (n, s, 3)).reshape(-1, 3)
    shade = np.repeat(normals, s, axis=0)
    face = np.tile(UP, (n * s, 1))
    ways = np.broadcast_to(way, (n, s, 3)).reshape(-1, 3)
    add_leaves(
        *(shape, place.reshape(-1, 3), ways, face, lengths, wide * lengths, colors, shade),
        triangles=triangles,
    )
