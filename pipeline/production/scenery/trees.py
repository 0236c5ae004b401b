"""Trees and shrubs: skeletons with bark and leaves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from pipeline.production.scenery.birch_bark import add_marks, bark_colors
from pipeline.production.scenery.branches import Skeleton, add_bark, grown
from pipeline.production.scenery.prototype import (
    UP,
    Color,
    Prototype,
    Shape,
    add_leaves,
    add_tubes,
    random_directions,
    unit,
)
from pipeline.simulation.spatial import Array


@dataclass(frozen=True)
class Crown:
    """A broad-leaved tree or shrub.

    Attributes:
        height: of the whole [m].
        trunk: height of the lowest branches relative to the whole.
        low: height of the foot of the crown relative to the whole.
        width: of the crown relative to the height.
        top: where the crown is widest: 0.5 in its middle, 0.8 near its top.
        stems: their number.
        foot: radius of the stem at the ground [m].
        attractors: points of free space.
        step: of growth [m].
        leaf: length of a leaf [m].
        leaf_wide: width of a leaf relative to its length.
        leaves: their number, nearby.
        color: of leaves, linear.
        young: colour of leaves at the outside of the crown.
        bark: its colour.
        sag: by which twigs hang.
        hollow: share of each lobe, from its middle, that stays without twigs.
        lobes: of the crown.
        tiers: storeys of the crown with air between them.
        lean: sidewards shift of the top relative to the height.
        escaped: share of shoots that stand out of the crown.
    """

    height: float
    trunk: float
    low: float
    width: float
    top: float
    stems: int
    foot: float
    attractors: int
    step: float
    leaf: float
    leaf_wide: float
    leaves: int
    color: Color
    young: Color
    bark: Color
    sag: float = 0.0
    hollow: float = 0.35
    lobes: int = 8
    tiers: int = 1
    lean: float = 0.0
    escaped: float = 0.0

    @property
    def is_shrub(self) -> bool:
        """Whether it branches from the ground."""
        return self.trunk < SHRUB


SHRUB = 0.1
"""Relative height of the lowest branches below which a plant is a shrub."""

CROWNS: dict[str, Crown] = {
    "oak": Crown(
        8.5, 0.20, 0.22, 1.05, 0.52, 1, 0.27, 900, 0.34, 0.175, 0.62, 15500,
        (0.108, 0.152, 0.036), (0.218, 0.268, 0.072), (0.115, 0.092, 0.068),
    ),
    "birch": Crown(
        9.5, 0.16, 0.20, 0.50, 0.42, 1, 0.10, 620, 0.32, 0.125, 0.72, 12500,
        (0.125, 0.170, 0.042), (0.258, 0.300, 0.088), (0.55, 0.53, 0.49),
        sag=0.22, hollow=0.1, lobes=12,
    ),
    "acacia": Crown(
        6.0, 0.27, 0.68, 1.55, 0.62, 1, 0.17, 800, 0.30, 0.12, 0.45, 12500,
        (0.108, 0.134, 0.046), (0.205, 0.224, 0.086), (0.135, 0.104, 0.076), hollow=0.1,
    ),
    "bush": Crown(
        1.5, 0.01, 0.0, 1.4, 0.40, 8, 0.020, 460, 0.11, 0.085, 0.58, 3900,
        (0.100, 0.142, 0.038), (0.205, 0.250, 0.074), (0.110, 0.086, 0.062), hollow=0.2, lobes=6,
        escaped=0.10,
    ),
    "scrub": Crown(
        0.7, 0.02, 0.06, 1.5, 0.6, 7, 0.0085, 300, 0.065, 0.042, 0.40, 1700,
        (0.115, 0.118, 0.064), (0.245, 0.232, 0.140), (0.130, 0.105, 0.078), hollow=0.1,
        escaped=0.06,
    ),
    "willow scrub": Crown(
        0.55, 0.02, 0.05, 1.8, 0.6, 7, 0.0075, 260, 0.06, 0.050, 0.36, 1500,
        (0.072, 0.095, 0.034), (0.215, 0.215, 0.095), (0.090, 0.068, 0.050), hollow=0.05,
    ),
}  # fmt: skip
"""Broad-leaved trees and shrubs."""

HABITS: dict[str, tuple[dict[str, float], ...]] = {
    "oak": (
        {},
        {"width": 1.2, "trunk": 0.16, "low": 0.16, "lobes": 10, "lean": 0.04},
        {"height": 9.4, "width": 0.82, "trunk": 0.24, "top": 0.58, "lobes": 9},
        {"width": 1.1, "top": 0.45, "lean": 0.10, "lobes": 7, "low": 0.26},
    ),
    "birch": (
        {},
        {"stems": 2, "width": 0.62, "lobes": 13},
        {"height": 10.4, "width": 0.40, "trunk": 0.22, "low": 0.28},
        {"height": 8.4, "lean": 0.12, "width": 0.55},
    ),
    "acacia": (
        {"width": 1.70, "low": 0.74, "lean": 0.05},
        {"tiers": 2, "low": 0.50, "width": 1.35, "height": 6.6, "lobes": 10},
        {"stems": 2, "width": 1.45, "low": 0.66, "lobes": 6, "hollow": 0.35},
        {"height": 5.0, "width": 1.05, "low": 0.50, "top": 0.72, "trunk": 0.2, "lean": 0.16},
    ),
    "bush": (
        {},
        {"width": 1.75, "height": 1.2, "lobes": 9},
        {"height": 1.8, "width": 1.0, "lean": 0.2, "lobes": 5},
        {"width": 1.5, "lobes": 4, "top": 0.55},
        {"height": 1.25, "width": 2.0, "lobes": 7, "lean": 0.15},
        {"height": 1.65, "lobes": 8, "hollow": 0.4},
    ),
}
"""What sets the variants of a species apart."""

LOBE, LOBE_FLAT = (0.24, 0.48), 0.74
"""Least and greatest radius of a lobe relative to the crown, and its height by its width."""

TIER = 0.42
"""Height of a storey of a crown relative to the distance to the next."""

BOUGH = (0.36, 0.82)
"""Least and greatest distance of the middle of a lobe from that of the crown."""

LEVELS = ((1.0, 1.0, 7, 2), (0.75, 1.2, 5, 1), (0.30, 2.1, 4, 1), (0.08, 4.6, 3, 1))
"""Levels of detail: share of the leaves, factor on their length, sides of branches, triangles of a
leaf."""

CALM = (1.0, 0.8, 0.45, 0.15)
"""Share of the differences between single leaves by level: far ones are smaller than a pixel, where
what is left of them is noise."""


def habit(kind: str, seed: int) -> Crown:
    """Return what the plant of a kind and seed is like."""
    varied = HABITS.get(kind, ({},))
    # Seeds of variants lie 101 apart.
    return replace(CROWNS[kind], **varied[(seed // 101) % len(varied)])  # type: ignore[arg-type]


def _envelope(config: Crown, rng: np.random.Generator, count: int) -> Array:
    """Return about `count` points (N, 3) in the lobes of a crown [m].

    Each bough carries a lobe of its own, larger or smaller and nearer to the trunk or farther out
    than the next; the sky is seen between them.
    """
    low, high = config.low * config.height, config.height
    k = np.arange(config.lobes)
    around = 2.39996 * k + rng.normal(0.0, 0.45, config.lobes)
    rise = np.linspace(-0.72, 0.92, config.lobes) + rng.normal(0.0, 0.12, config.lobes)
    rise = np.clip(rise, -0.85, 0.95)
    flat = np.sqrt(1.0 - rise**2)
    way = np.stack([flat * np.cos(around), rise, flat * np.sin(around)], axis=-1)
    radii = rng.uniform(*LOBE, config.lobes)
    middles = way * rng.uniform(*BOUGH, (config.lobes, 1))
    chosen = rng.choice(config.lobes, 2 * count, p=radii**2 / (radii**2).sum())
    within = rng.uniform(config.hollow**3, 1.0, 2 * count) ** (1.0 / 3.0)
    inside = (radii[chosen] * within)[:, None] * random_directions(rng, 2 * count)
    points = middles[chosen] + inside * [1.0, LOBE_FLAT, 1.0]
    points /= np.abs(points).max(axis=0)
    y = 0.5 * (points[:, 1] + 1.0)
    # The height at which the crown is widest is moved up or down.
    y = y ** (np.log(config.top) / np.log(0.5))
    flat_places = points[:, [0, 2]]
    if config.tiers > 1:
        # Each lobe belongs to a storey; the lower ones are smaller and stand to one side.
        storey = chosen % config.tiers
        below = (config.tiers - 1 - storey)[:, None] / (config.tiers - 1)
        y = (storey + TIER * y) / (config.tiers - 1 + TIER)
        turn = rng.uniform(0.0, 2.0 * np.pi)
        aside = np.array([np.cos(turn), np.sin(turn)])
        flat_places = flat_places * (1.0 - 0.42 * below) + 0.34 * below * aside
    if config.escaped:
        out = rng.uniform(1.0, 1.4, len(y)) * (rng.uniform(size=len(y)) < config.escaped)
        out = np.maximum(out, 1.0)
        y, flat_places = y * out, flat_places * (0.5 + 0.5 * out)[:, None]
    half = 0.5 * config.width * config.height
    crown = np.column_stack(
        [half * flat_places[:, 0], low + (high - low) * y, half * flat_places[:, 1]]
    )
    return np.asarray(crown[crown[:, 1] > low + 0.03][:count])


@lru_cache(maxsize=64)
def crown_skeleton(kind: str, seed: int) -> Skeleton:
    """Return the skeleton of a broad-leaved tree or shrub."""
    config = habit(kind, seed)
    rng = np.random.default_rng([seed, 71])
    attractors = _envelope(config, rng, config.attractors)
    top = config.trunk * config.height
    stems = []
    for k in range(config.stems):
        angle = 2 * np.pi * (k + rng.uniform()) / config.stems
        out = np.array([np.cos(angle), 0.0, np.sin(angle)])
        spread = 0.0 if config.stems == 1 else 0.16 * config.width * config.height
        end = 0.75 * top * UP + spread * out + 0.07 * top * rng.normal(size=3) * [1, 0, 1]
        if config.stems > 1:
            end = end + 0.25 * config.height * UP
        n = max(int(np.linalg.norm(end) / config.step), 2)
        t = np.linspace(0.0, 1.0, n)[:, None]
        sway = 0.04 * config.height * np.sin(2.5 * t + rng.uniform(0, 6)) * rng.normal(size=3)
        stems.append(end * t + sway * t * (1 - t) * [1, 0, 1] - 0.05 * (1 - t) * UP)
    skeleton = grown(stems, attractors, config.step, config.foot, sag=config.sag)
    return _leaning(skeleton, config, rng.uniform(0.0, 2.0 * np.pi)) if config.lean else skeleton


def _lean(config: Crown, height: Array, turn: float) -> Array:
    """Return shifts (N, 3) of what is at a height (N,) above the ground [m]."""
    way = np.array([np.cos(turn), 0.0, np.sin(turn)])
    up = np.maximum(height, 0.0)[:, None] / config.height
    return np.asarray(config.lean * config.height * up**1.3 * way)


def _leaning(skeleton: Skeleton, config: Crown, turn: float) -> Skeleton:
    """Return a skeleton whose top is shifted to one side."""
    nodes = skeleton.nodes + _lean(config, skeleton.nodes[:, 1], turn)
    above = np.maximum(skeleton.parents, 0)
    ways = np.where(skeleton.parents[:, None] < 0, skeleton.ways, unit(nodes - nodes[above]))
    return replace(skeleton, nodes=nodes, ways=ways)


def crown_tree(kind: str, seed: int, level: int) -> Prototype:
    """Return a broad-leaved tree or shrub at a level of detail."""
    config, skeleton = habit(kind, seed), crown_skeleton(kind, seed)
    share, long, sides, triangles = LEVELS[level]
    rng = np.random.default_rng([seed, 73, level])
    shape = Shape()
    if kind == "birch":
        bark = bark_colors(skeleton, config.foot, config.bark, rng)
        add_marks(shape, skeleton, config.foot, level, rng)
    else:
        light = 1.0 + 0.25 * rng.uniform(-1.0, 1.0, (len(skeleton.nodes), 1))
        bark = np.asarray(config.bark) * light
    tall, low = (0.03, 0.08, 0.2, 0.42), (0.1, 0.4, 0.8, 2.0)
    least = config.foot * (low if config.is_shrub else tall)[level]
    add_bark(shape, skeleton, bark, least, sides)
    # Leaves grow on thin twigs only.
    thin = np.flatnonzero(skeleton.radii < (0.6 if config.is_shrub else 0.2) * config.foot)
    count = max(round(config.leaves * share), 24)
    at = thin[rng.integers(0, len(thin), count)]
    size = config.leaf * long * rng.uniform(0.65, 1.2, count)
    back = rng.uniform(0.0, config.step, (count, 1)) * skeleton.ways[at]
    loose = 0.7 * config.step * rng.normal(size=(count, 3))
    # No leaf hangs in the air away from all twigs.
    loose *= np.minimum(1.0, config.step / np.linalg.norm(loose, axis=1, keepdims=True))
    base = skeleton.nodes[at] - back + loose
    middle = np.array([0.0, 0.5 * (config.low + 0.9) * config.height, 0.0])
    if config.is_shrub:
        middle = middle * [1, 0.5, 1]
    if config.lean:
        middle[[0, 2]] = skeleton.nodes[thin][:, [0, 2]].mean(axis=0)
    half = np.array([0.5 * config.width, 0.5 * (1 - config.low), 0.5 * config.width])
    out = (base - middle) / (half * config.height)
    depth = np.clip(np.linalg.norm(out, axis=-1), 0.0, 1.2)
    way = 0.6 * unit(out) + 0.8 * random_directions(rng, count) + [0.0, -0.25 - config.sag, 0.0]
    face = 0.6 * UP + random_directions(rng, count)
    lit = np.clip((depth - 0.25) / 0.75, 0.0, 1.0) * (0.75 + 0.25 * unit(out)[:, 1])
    color = np.asarray(config.color) + lit[:, None] * (
        np.asarray(config.young) - np.asarray(config.color)
    )
    color = color * (0.97 + CALM[level] * rng.uniform(-0.34, 0.34, (count, 1)))
    normals = unit(0.9 * unit(out) + 0.5 * CALM[level] * unit(face) + 0.25 * UP)
    wide = min(config.leaf_wide * (1.0, 1.1, 1.35, 1.6)[level], 1.0)
    add_leaves(shape, base, way, face, size, wide * size, color, normals, triangles=triangles)
    return shape.prototype()


def spruce(seed: int, level: int) -> Prototype:
    """Return a spruce: whorls of drooping branches with sprays of needles."""
    rng, shape = np.random.default_rng([seed, 79]), Shape()
    # Young ones are slim and clothed to the ground, old ones broad, gappy and bare below.
    age = (seed // 101 % 4) / 3.0
    height = 10.0 * (0.80 + 0.42 * age) * rng.uniform(0.95, 1.05)
    broad, bare, gaps = 0.165 + 0.085 * age, 0.02 + 0.12 * age**2, 0.05 + 0.20 * age
    whorls, each, sprays = ((34, 8, 11), (26, 7, 6), (16, 6, 3), (10, 6, 1))[level]
    t = (np.arange(whorls) + 0.5) / whorls
    at = height * (bare + (0.99 - bare) * t**0.92)
    length = broad * height * (1.0 - t) ** 0.82 * (1.0 - 0.25 * np.exp(-t / 0.05)) + 0.06
    around = 2 * np.pi * (np.arange(each) / each + 0.618 * np.arange(whorls)[:, None])
    around = around + rng.normal(0, 0.18, around.shape)
    length = length[:, None] * rng.uniform(0.62, 1.16, around.shape)
    # Some branches are broken or starved, more of them low down.
    starved = rng.uniform(size=around.shape) < gaps * (1.25 - t[:, None])
    length = np.where(starved, 0.45 * length, length)
    root = np.stack([np.zeros_like(around), at[:, None] + 0 * around, np.zeros_like(around)], -1)
    root = root + [0, 1, 0] * rng.normal(0, 0.35 * height / whorls, (*around.shape, 1))
    out = np.stack([np.cos(around), np.zeros_like(around), np.sin(around)], axis=-1)
    n = whorls * each
    root, out, length = root.reshape(n, 3), out.reshape(n, 3), length.reshape(n)
    droop = np.repeat(0.42 - 0.75 * t, each)
    along = np.linspace(0.12, 1.0, sprays + 1)[1:] if sprays > 1 else np.array([0.4])
    sway = along - 0.75 * along**2
    place = (
        root[:, None]
        + (length[:, None] * along)[..., None] * out[:, None]
        - (length[:, None] * (droop[:, None] * along - 0.22 * sway))[..., None] * UP
    )
    green, tip = np.array([0.094, 0.142, 0.062]), np.array([0.185, 0.240, 0.095])
    color = green + along[None, :, None] ** 2 * (tip - green)
    color = color * (0.975 + CALM[level] * rng.uniform(-0.225, 0.225, (n, 1, 1)))
    side = np.cross(out, UP)
    spread = (1.15, 1.15, 1.3, 1.7)[level] * length[:, None] * (1.1 - 0.72 * along)
    wide = (0.30, 0.42, 0.70, 1.5)[level]
    normals = unit(out + 0.75 * UP)
    for sign in (-1.0, 1.0):
        way = sign * side[:, None] + 0.85 * out[:, None] - [0.0, 0.3, 0.0]
        way = way + 0.18 * rng.normal(size=place.shape)
        _add_sprays(shape, place, way, 0.62 * spread, wide, color, normals)
    # The end of each branch.
    _add_sprays(
        shape, place[:, -1:], out[:, None], 0.3 * length[:, None], 0.5, color[:, -1:], normals
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
    shape: Shape, place: Array, way: Array, size: Array, wide: float, color: Array, normals: Array
) -> None:
    """Add sprays (N, S) of needles that grow from places (N, S, 3)."""
    n, s = place.shape[:2]
    lengths = np.broadcast_to(size, (n, s)).ravel()
    colors = np.broadcast_to(color, (n, s, 3)).reshape(-1, 3)
    shade = np.repeat(normals, s, axis=0)
    face = np.tile(UP, (n * s, 1))
    ways = np.broadcast_to(way, (n, s, 3)).reshape(-1, 3)
    add_leaves(shape, place.reshape(-1, 3), ways, face, lengths, wide * lengths, colors, shade)
