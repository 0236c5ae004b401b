"""Herbs and litter: flowers, ferns, maize, succulents, fallen leaves and twigs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.production.scenery.prototype import (
    HEART,
    UP,
    Color,
    Prototype,
    Shape,
    across,
    add_blades,
    add_leaves,
    add_tubes,
    unit,
)
from pipeline.simulation.spatial import Array

STEM: tuple[Color, Color] = ((0.090, 0.130, 0.036), (0.235, 0.320, 0.105))

STEM_WIDTHS = 0.005, 0.010, 0.018
"""Widths of stems by level of detail, so that heads far away still stand on something [m]."""

TWIG_CROOK = 0.38
"""Deviation by which a fallen twig turns from piece to piece [rad]."""


@dataclass(frozen=True)
class Flower:
    """A flower.

    Attributes:
        height: of the stems [m].
        stems: their number.
        petals: of a head.
        petal: length of a petal [m].
        wide: width of a petal relative to its length.
        color: of the petals, linear.
        heart: colour of the middle.
        cup: how far petals stand up, 0 to 1.
        rosette: number of long leaves that lie around the foot.
        spread: distance of the stems from the foot [m].
    """

    height: float
    stems: int
    petals: int
    petal: float
    wide: float
    color: Color
    heart: Color
    cup: float = 0.15
    rosette: int = 0
    spread: float = 0.17


FLOWERS: dict[str, Flower] = {
    "daisy": Flower(0.15, 4, 11, 0.017, 0.42, (0.78, 0.77, 0.72), (0.66, 0.40, 0.02)),
    "buttercup": Flower(0.25, 4, 5, 0.014, 0.95, (0.82, 0.56, 0.015), (0.50, 0.38, 0.02), 0.7),
    "poppy": Flower(0.40, 5, 5, 0.031, 1.05, (0.66, 0.045, 0.016), (0.020, 0.015, 0.015), 1.25),
    "dandelion": Flower(
        *(0.16, 3, 16, 0.015, 0.34, (0.80, 0.50, 0.012), (0.72, 0.42, 0.01), 0.35),
        rosette=11,
        spread=0.035,
    ),
    "cornflower": Flower(0.42, 3, 9, 0.021, 0.50, (0.085, 0.125, 0.68), (0.12, 0.05, 0.35), 0.6),
}
"""Kinds of flowers."""


def flower(kind: str, seed: int, level: int) -> Prototype:
    """Return a group of flowers at a level of detail."""
    config, rng, shape = FLOWERS[kind], np.random.default_rng([seed, 29]), Shape()
    bends, level = _close(level)
    n = config.stems if level < 2 else max(config.stems // 2, 1)
    angle, out = rng.uniform(0, 2 * np.pi, n), np.sqrt(rng.uniform(size=n))
    out = config.spread * out
    roots = np.stack([out * np.cos(angle), np.zeros(n), out * np.sin(angle)], axis=-1)
    heights = config.height * rng.uniform(0.55, 1.15, n)
    tips = add_blades(
        *(shape, rng, roots, heights, 0.28 * heights, np.full(n, STEM_WIDTHS[level])),
        STEM,
        blunt=0.6,
    )
    lean = unit(tips - roots + rng.normal(0, 0.42 * config.height, (n, 3)))
    petals = config.petals if level == 0 else max(config.petals // 2, 3)
    wide = config.wide * (1.0 if level == 0 else 1.5)
    turn = 2 * np.pi * (np.arange(petals) + rng.uniform(size=(n, 1))) / petals
    u, w = across(lean)
    ray = np.cos(turn)[..., None] * u[:, None] + np.sin(turn)[..., None] * w[:, None]
    way = (ray + config.cup * lean[:, None]).reshape(-1, 3)
    size = np.full(len(way), config.petal) * rng.uniform(0.85, 1.1, len(way))
    light = rng.uniform(0.85, 1.05, (len(way), 1))
    face = np.repeat(lean, petals, axis=0)
    add_leaves(
        shape,
        np.repeat(tips, petals, axis=0),
        way,
        face,
        size,
        wide * size,
        np.asarray(config.color) * light,
        normals=unit(face + 0.5 * way),
        triangles=bends,
    )
    if level < 2:
        # The heart: four small leaves that make a button.
        quarter = 0.5 * np.pi * np.arange(4)[:, None]
        ray = np.cos(quarter) * u[:, None] + np.sin(quarter) * w[:, None]
        size = np.full(4 * n, 0.36 * config.petal)
        above = np.repeat(tips + 0.05 * config.petal * lean, 4, axis=0)
        heart = np.broadcast_to(config.heart, (4 * n, 3))
        add_leaves(
            *(shape, above, ray.reshape(-1, 3), np.repeat(lean, 4, axis=0), size, 1.2 * size, heart)
        )
    _add_foot(shape, rng, 0.35 * config.height, 7 if level == 0 else 3, bends)
    if config.rosette:
        _add_rosette(shape, rng, config.rosette if level == 0 else config.rosette // 2, bends)
    return shape.prototype()


def _close(level: int) -> tuple[int, int]:
    """Return the triangles of a leaf, and the level of all else, of a herb that may be close.

    The first level, for large plants near the camera, is the second with leaves that bend.
    """
    return (4 if level == 0 else 2), max(level - 1, 0)


def _add_foot(
    shape: Shape, rng: np.random.Generator, length: float, count: int, triangles: int = 2
) -> None:
    """Add leaves around the foot of a herb."""
    angle = rng.uniform(0, 2 * np.pi, count)
    way = np.stack([np.cos(angle), rng.uniform(0.4, 1.3, count), np.sin(angle)], axis=-1)
    base = 0.05 * rng.normal(size=(count, 3)) * [1, 0, 1]
    size = length * rng.uniform(0.5, 1.0, count)
    color = np.array([0.065, 0.11, 0.025]) * rng.uniform(0.7, 1.2, (count, 1))
    up = np.tile(UP, (count, 1))
    add_leaves(shape, base, way, up, size, 0.3 * size, color, triangles=triangles)


def _add_rosette(shape: Shape, rng: np.random.Generator, count: int, triangles: int) -> None:
    """Add long leaves that lie around the foot of a herb."""
    angle = 2.39996 * np.arange(count) + rng.uniform(-0.3, 0.3, count)
    way = np.stack([np.cos(angle), rng.uniform(0.08, 0.4, count), np.sin(angle)], axis=-1)
    base = 0.012 * unit(way) + 0.012 * UP
    size = rng.uniform(0.07, 0.14, count)
    color = np.array([0.130, 0.195, 0.050]) * rng.uniform(0.75, 1.25, (count, 1))
    up = np.tile(UP, (count, 1))
    add_leaves(shape, base, way, up, size, 0.27 * size, color, fold=0.25, triangles=triangles)


def clover(seed: int, level: int) -> Prototype:
    """Return a low patch of clover: leaves of three leaflets on stalks, and some round heads."""
    rng, shape = np.random.default_rng([seed, 67]), Shape()
    is_close, level = level == 0, max(level - 1, 0)
    n, heads, rays = ((44, 5, 14), (20, 4, 6), (8, 2, 3))[level]
    wide = (1.0, 1.35, 2.0)[level]
    angle, out = rng.uniform(0, 2 * np.pi, n + heads), np.sqrt(rng.uniform(size=n + heads))
    roots = 0.2 * np.stack([out * np.cos(angle), 0 * out, out * np.sin(angle)], axis=-1)
    heights = rng.uniform(0.03, 0.075, n + heads) * (1.0 - 0.4 * out**2)
    heights[n:] += 0.045
    width = np.full(n + heads, 0.003 * wide)
    tips = add_blades(
        *(shape, rng, roots, heights, 0.4 * heights, width, STEM), segments=1, blunt=0.6
    )
    turn = rng.uniform(0, 2 * np.pi, (n, 1)) + 2 * np.pi * np.arange(3) / 3
    way = np.stack([np.cos(turn), np.full_like(turn, 0.12), np.sin(turn)], axis=-1)
    face = np.repeat(UP + 0.3 * rng.normal(size=(n, 3)), 3, axis=0)
    size = np.repeat(0.017 * rng.uniform(0.7, 1.25, n) * wide, 3)
    color = np.array([0.110, 0.190, 0.052]) * rng.uniform(0.75, 1.25, (n, 1))
    add_leaves(
        *(shape, np.repeat(tips[:n], 3, axis=0), way.reshape(-1, 3), face),
        *(size, 0.92 * size, np.repeat(color, 3, axis=0)),
        triangles=HEART if is_close else 2 if level == 0 else 1,
    )
    ray = unit(rng.normal(size=(heads * rays, 3)) + 0.6 * UP)
    size = np.full(len(ray), 0.011 * (1.0 if level == 0 else 1.2))
    pale = np.array([0.70, 0.60, 0.58]) * rng.uniform(0.8, 1.1, (len(ray), 1))
    add_leaves(
        *(shape, np.repeat(tips[n:], rays, axis=0), ray, rng.normal(size=ray.shape)),
        *(size, 0.5 * wide * size, pale, ray),
    )
    return shape.prototype()


FERN_STALK = np.array([0.150, 0.140, 0.050])
"""Colour of the middle of a frond, linear."""

LOBES = 6
"""Pairs of lobes of a leaflet of a fern that is close."""


def _add_lobes(
    shape: Shape, bases: Array, way: Array, face: Array, size: Array, color: Array
) -> None:
    """Add N leaflets of a frond, each parted into lobes on both sides.

    Args:
        shape: to which they are added.
        bases: (N, 3) where leaflets begin [m].
        way: (N, 3) unit vectors along them.
        face: (N, 3) about their upper sides.
        size: (N,) lengths [m].
        color: (N, 3) linear.
    """
    t = (np.arange(LOBES) + 0.4) / LOBES
    across = unit(np.cross(way, face))
    start = bases[:, None] + (size[:, None] * t)[..., None] * way[:, None]
    # They hang down a little towards the tip.
    start = start - (0.16 * size[:, None] * t * t)[..., None] * UP
    long = 0.13 * size[:, None] * (1.15 - t) ** 0.8
    shades = np.repeat(color, LOBES, axis=0)
    normals = np.repeat(unit(face + 0.4 * UP), LOBES, axis=0)
    for sign in (-1.0, 1.0):
        ways = np.repeat(sign * across + 0.75 * way - 0.12 * UP, LOBES, axis=0)
        add_leaves(
            *(shape, start.reshape(-1, 3), ways, np.repeat(face, LOBES, axis=0)),
            *(long.reshape(-1), 0.5 * long.reshape(-1), shades, normals),
        )
    tip, short = start[:, -1], 0.2 * size
    add_leaves(shape, tip, way - 0.3 * UP, face, short, 0.4 * short, color, unit(face + 0.4 * UP))


def fern(seed: int, level: int) -> Prototype:
    """Return a fern: arching fronds with leaflets on both sides, that are parted again if close."""
    rng, shape = np.random.default_rng([seed, 31]), Shape()
    is_close, level = level == 0, max(level - 1, 0)
    fronds, each = ((15, 22), (13, 15), (8, 7))[level]
    for k in range(fronds):
        heading = 2 * np.pi * (k + rng.uniform(-0.3, 0.3)) / fronds
        length = 0.55 * rng.uniform(0.7, 1.1)
        ahead = np.array([np.cos(heading), 0.0, np.sin(heading)])
        t = (np.arange(each) + 0.6) / each
        # Up from the crown, then over in an arch, the inner ones later than the outer ones: fronds
        # of one height would be seen as a slab.
        rise, spread = rng.uniform(0.7, 1.35), rng.uniform(0.55, 1.1)
        out, up = spread * (0.24 * t + 0.56 * t * t), rise * t * (1.4 - 0.85 * t)
        rachis = length * (out[:, None] * ahead + up[:, None] * UP)
        along = unit(np.gradient(rachis, axis=0) if each > 1 else ahead[None])
        side = unit(np.cross(along, UP))
        face = np.cross(side, along)
        size = 0.30 * length * np.sin(np.pi * (0.12 + 0.88 * t) ** 0.75)
        green = np.array([0.165, 0.235, 0.062]) * rng.uniform(0.75, 1.2)
        color = green * (0.75 + 0.5 * t)[:, None]
        for sign in (-1.0, 1.0):
            way = sign * side + 0.45 * along - rng.uniform(0.1, 0.5) * UP
            if is_close:
                _add_lobes(shape, rachis, unit(way), face, size, color)
                continue
            wide = (0.15 if level == 0 else 0.20 if level == 1 else 0.42) * size
            add_leaves(shape, rachis, way, face, size, wide, color, unit(face + 0.4 * UP))
        if is_close:
            add_tubes(
                *(shape, np.vstack([np.zeros(3), rachis[:-1]]), rachis),
                *(0.007 * length * (1.0 - 0.8 * t), 0.007 * length * (1.0 - 0.8 * t)),
                np.tile(FERN_STALK, (each, 1)),
                4,
            )
        tip = rachis[-1:]
        add_leaves(shape, tip, along[-1:], face[-1:], size[-1:], 0.5 * size[-1:], color[-1:])
    return shape.prototype()


def heather(seed: int, level: int) -> Prototype:
    """Return a cushion of heather: twigs with tiny leaves and pale purple flowers."""
    rng, shape = np.random.default_rng([seed, 37]), Shape()
    n = (150, 60, 22)[level]
    angle, out = rng.uniform(0, 2 * np.pi, n), np.sqrt(rng.uniform(size=n))
    roots = 0.13 * np.stack([out * np.cos(angle), np.zeros(n), out * np.sin(angle)], axis=-1)
    heights = 0.27 * rng.uniform(0.6, 1.0, n) * (1.0 - 0.35 * out**2)
    width = np.full(n, (0.012, 0.02, 0.034)[level])
    tips = add_blades(
        *(shape, rng, roots, heights, 0.55 * heights * out, width),
        ((0.085, 0.078, 0.042), (0.180, 0.182, 0.088)),
        headings=angle,
        segments=1,
    )
    blooming = rng.uniform(size=n) < 0.6
    base = tips[blooming] - 0.25 * heights[blooming, None] * UP
    m = len(base)
    size = 0.3 * heights[blooming]
    color = np.array([0.34, 0.19, 0.28]) * rng.uniform(0.6, 1.2, (m, 1))
    way = UP + 0.4 * rng.normal(size=(m, 3))
    add_leaves(
        *(shape, base, way, rng.normal(size=(m, 3)), size, 0.16 * size * (1 + level), color),
        normals=np.tile(UP, (m, 1)),
    )
    return shape.prototype()


def succulent(seed: int, level: int) -> Prototype:
    """Return a rosette of thick, pointed leaves, as of an agave."""
    rng, shape = np.random.default_rng([seed, 41]), Shape()
    n = (34, 24, 12)[level]
    k = np.arange(n)
    angle = 2.39996 * k
    rise = np.linspace(0.25, 3.2, n)
    way = unit(np.stack([np.cos(angle), rise, np.sin(angle)], axis=-1))
    size = 0.42 * rng.uniform(0.85, 1.1, n) * (1.0 - 0.35 * k / n)
    color = np.array([0.125, 0.165, 0.105]) * rng.uniform(0.8, 1.15, (n, 1))
    base = 0.04 * way
    add_leaves(shape, base, way, np.tile(UP, (n, 1)), size, 0.26 * size, color, fold=0.35)
    return shape.prototype()


def maize(seed: int, level: int) -> Prototype:
    """Return a stalk of maize with long, hanging leaves and a tassel."""
    rng, shape = np.random.default_rng([seed, 43]), Shape()
    height = 1.9 * rng.uniform(0.85, 1.1)
    sides = (6, 4, 3)[level]
    stalk = np.array([[0.0, 0.0, 0.0], [0.02, 0.5 * height, 0.01], [0.03, height, -0.01]])
    radii = np.array([0.017, 0.014, 0.006])
    green = np.tile([0.13, 0.18, 0.05], (2, 1))
    add_tubes(shape, stalk[:-1], stalk[1:], radii[:-1], radii[1:], green, sides)
    n = (11, 9, 6)[level]
    at = np.linspace(0.12, 0.92, n) * height
    roots = np.stack([np.zeros(n), at, np.zeros(n)], axis=-1)
    headings = np.pi * np.arange(n) + rng.normal(0, 0.45, n)
    long = 1.05 * rng.uniform(0.75, 1.1, n) * np.sin(np.pi * np.linspace(0.3, 0.8, n))
    add_blades(
        *(shape, rng, roots, 0.5 * long, 0.95 * long, np.full(n, 0.075)),
        ((0.075, 0.120, 0.026), (0.135, 0.195, 0.045)),
        headings=headings,
        segments=(4, 3, 2)[level],
        variation=0.15,
    )
    tassel = np.tile(stalk[-1:], (6, 1))
    add_blades(
        *(shape, rng, tassel, np.full(6, 0.24), np.full(6, 0.1), np.full(6, 0.012)),
        ((0.30, 0.24, 0.10), (0.46, 0.36, 0.17)),
    )
    return shape.prototype()


def fallen_leaves(seed: int, level: int) -> Prototype:
    """Return leaves of autumn that lie within 0.6 m."""
    rng, shape = np.random.default_rng([seed, 53]), Shape()
    level = max(level - 1, 0)
    n = (22, 13, 6)[level]
    base = rng.normal(0, 0.17, (n, 3)) * [1, 0, 1] + [0, 0.008, 0]
    way = rng.normal(size=(n, 3)) * [1, 0.22, 1]
    face = UP + 0.35 * rng.normal(size=(n, 3))
    palette = np.array(
        [[0.17, 0.085, 0.034], [0.22, 0.130, 0.045], [0.12, 0.065, 0.032], [0.18, 0.070, 0.028]]
    )
    color = palette[rng.integers(0, 4, n)] * rng.uniform(0.6, 1.2, (n, 1))
    size = 0.038 * rng.uniform(0.6, 1.25, n) * (1.0, 1.3, 1.9)[level]
    bends = (4, 4, 2)[level]
    add_leaves(shape, base, way, face, size, 0.6 * size, color, fold=0.22, triangles=bends)
    return shape.prototype()


def twigs(seed: int, level: int) -> Prototype:
    """Return fallen twigs within 0.3 m: crooked, forked, and down on the ground at their ends.

    They are short, because a straight one would lie across the hollows of uneven ground.
    """
    rng, shape = np.random.default_rng([seed, 59]), Shape()
    n, steps, sides = (4, 3, 2)[level], (4, 3, 2)[level], (4, 3, 3)[level]
    color = np.array([0.085, 0.062, 0.043]) * rng.uniform(0.7, 1.4, (n, 1))
    r = 0.0035 * rng.uniform(0.5, 1.6, n)
    length = 0.22 * rng.uniform(0.4, 1.0, n)
    heading = rng.uniform(0.0, 2.0 * np.pi, n)
    at = rng.normal(0, 0.09, (n, 3)) * [1, 0, 1] + 0.3 * r[:, None] * UP
    arch = 0.10 * length * rng.uniform(0.0, 1.0, n)
    fork = int(rng.integers(1, steps)), rng.choice([-1.0, 1.0], n) * rng.uniform(0.5, 0.9, n)
    for k in range(steps):
        thick = r * (1.0 - 0.7 * np.array([k, k + 1])[:, None] / steps)
        heading = heading + TWIG_CROOK * rng.normal(size=n)
        share = 4.0 * (k + 1) / steps * (1.0 - (k + 1) / steps)
        end = at + (length / steps)[:, None] * _level(heading)
        end[:, 1] = 0.3 * r + arch * share
        add_tubes(shape, at, end, thick[0], thick[1], color, sides)
        if k == fork[0] and level < 2:
            tip = at + (0.4 * length)[:, None] * _level(heading + fork[1])
            tip[:, 1] = 0.2 * r
            add_tubes(shape, at, tip, 0.8 * thick[0], 0.3 * thick[0], color, sides)
        at = end
    return shape.prototype()


def _level(heading: Array) -> Array:
    """Return the level unit vectors (N, 3) of headings (N,)."""
    return np.stack([np.cos(heading), np.zeros_like(heading), np.sin(heading)], axis=-1)


def moss_cushion(seed: int, level: int) -> Prototype:
    """Return a low cushion of moss, of many tiny upright leaves."""
    rng, shape = np.random.default_rng([seed, 61]), Shape()
    n = (340, 120, 30)[level]
    angle, out = rng.uniform(0, 2 * np.pi, n), np.sqrt(rng.uniform(size=n))
    dome = 0.035 * (1.0 - out**2)
    roots: Array = np.stack(
        [0.15 * out * np.cos(angle), dome - 0.012, 0.15 * out * np.sin(angle)], axis=-1
    )
    size = rng.uniform(0.008, 0.017, n) * (1.0, 1.5, 2.4)[level]
    add_blades(
        *(shape, rng, roots, size, 0.5 * size, np.full(n, (0.006, 0.012, 0.03)[level])),
        ((0.090, 0.108, 0.032), (0.172, 0.202, 0.062)),
        segments=1,
        headings=angle,
    )
    return shape.prototype()
