"""Broad-leaved trees and shrubs: skeletons with bark and shoots of leaves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pipeline.production.scenery.birch_bark import add_marks, bark_colors
from pipeline.production.scenery.branches import Skeleton, add_bark, grown
from pipeline.production.scenery.crown_habits import Crown, habit
from pipeline.production.scenery.prototype import (
    UP,
    Prototype,
    Shape,
    add_leaves,
    add_tubes,
    random_directions,
    unit,
)
from pipeline.simulation.spatial import Array

LOBE, LOBE_FLAT = (0.24, 0.48), 0.74
"""Least and greatest radius of a lobe relative to the crown, and its height by its width."""

TIER = 0.42
"""Height of a storey of a crown relative to the distance to the next."""

BOUGH = (0.36, 0.82)
"""Least and greatest distance of the middle of a lobe from that of the crown."""

LEVELS = ((1.0, 1.0, 7, 4), (1.0, 1.0, 5, 2), (0.85, 1.22, 4, 1), (0.11, 3.6, 3, 1))
"""Levels of detail: share of the leaves, factor on their length, sides of branches, triangles of a
leaf."""

FURROWED = 0.4
"""Radius relative to the foot from which the branches of near trees have furrows."""

SPRAY = (9, 7, 5, 2)
"""Leaves of a shoot by level of detail."""

SHOOT = 0.74
"""Distance between the leaves of a shoot relative to their length."""

OPENED = (0.9, 1.15)
"""Cosine and sine, not normalised, of the angle between a leaf and its shoot."""

INNER = (1.0, 1.3, 1.5, 1.6)
"""Length of leaves in the middle of a crown relative to those at its outside, by level: they are
seen as the ground of the others alone, and shut the gaps through which the sky would be seen."""

MASS = 0.65
"""Share of a lobe of the crown, and not of the whole, in the way its leaves face the light."""

CALM = (1.0, 0.8, 0.45, 0.15)
"""Share of the differences between single leaves by level: far ones are smaller than a pixel, where
what is left of them is noise."""


@dataclass(frozen=True, eq=False)
class Lobes:
    """The lobes of a crown: each bough carries a mass of leaves of its own.

    Attributes:
        middles: (L, 3) [m].
        radii: (L,) [m].
    """

    middles: Array
    radii: Array

    @staticmethod
    def around(points: Array, chosen: NDArray[np.int64]) -> Lobes:
        """Return the lobes of points (N, 3) that belong to the ones of their numbers (N,)."""
        groups = [points[chosen == k] for k in np.unique(chosen)]
        middles = np.array([group.mean(axis=0) for group in groups])
        # Points that fill a sphere lie at 0.77 of its radius, in the root mean square.
        spread = [
            np.sqrt(((group - middle) ** 2).sum(axis=1).mean()) / 0.77
            for group, middle in zip(groups, middles, strict=True)
        ]
        return Lobes(middles, np.maximum(spread, 1e-3))

    def out(self, places: Array) -> Array:
        """Return vectors (N, 3) from the nearest lobe to places (N, 3), relative to its radius."""
        apart = (places[:, None] - self.middles) / self.radii[:, None]
        nearest = np.linalg.norm(apart, axis=-1).argmin(axis=1)
        return np.asarray(apart[np.arange(len(places)), nearest])


def _envelope(
    config: Crown, rng: np.random.Generator, count: int
) -> tuple[Array, NDArray[np.int64]]:
    """Return about `count` points (N, 3) in the lobes of a crown [m], and numbers (N,) of these.

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
    some = np.flatnonzero(crown[:, 1] > low + 0.03)[:count]
    return crown[some], chosen[some]


@lru_cache(maxsize=64)
def grown_crown(kind: str, seed: int) -> tuple[Skeleton, Lobes]:
    """Return the skeleton of a broad-leaved tree or shrub, and the lobes of its crown."""
    config = habit(kind, seed)
    rng = np.random.default_rng([seed, 71])
    attractors, chosen = _envelope(config, rng, config.attractors)
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
    lobes = Lobes.around(attractors, chosen)
    if not config.lean:
        return skeleton, lobes
    turn = rng.uniform(0.0, 2.0 * np.pi)
    moved = lobes.middles + _lean(config, lobes.middles[:, 1], turn)
    return _leaning(skeleton, config, turn), replace(lobes, middles=moved)


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
    config, (skeleton, lobes) = habit(kind, seed), grown_crown(kind, seed)
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
    is_near = level <= 1 and not config.is_shrub and kind != "birch"
    furrowed = FURROWED * config.foot if is_near else np.inf
    add_bark(shape, skeleton, bark, least, sides, furrowed)
    # Leaves grow on shoots of thin twigs only.
    thin = np.flatnonzero(skeleton.radii < (0.6 if config.is_shrub else 0.2) * config.foot)
    each = SPRAY[level]
    shoots = max(round(config.leaves * share / each), 24)
    at = thin[rng.integers(0, len(thin), shoots)]
    foot = skeleton.nodes[at] - rng.uniform(0.0, config.step, (shoots, 1)) * skeleton.ways[at]
    middle = np.array([0.0, 0.5 * (config.low + 0.9) * config.height, 0.0])
    if config.is_shrub:
        middle = middle * [1, 0.5, 1]
    if config.lean:
        middle[[0, 2]] = skeleton.nodes[thin][:, [0, 2]].mean(axis=0)
    half = np.array([0.5 * config.width, 0.5 * (1 - config.low), 0.5 * config.width])
    out = (foot - middle) / (half * config.height)
    depth = np.clip(np.linalg.norm(out, axis=-1), 0.0, 1.2)
    hang = np.array([0.0, 0.1 - config.sag, 0.0])
    way = unit(0.55 * unit(out) + 0.45 * skeleton.ways[at] + 0.75 * random_directions(rng, shoots))
    way = unit(way + hang)
    leaf = config.leaf * long * rng.uniform(0.75, 1.15, shoots)
    leaf = leaf * (1.0 + (INNER[level] - 1.0) * np.clip(1.4 - 2.0 * depth, 0.0, 1.0))
    length = SHOOT * each * leaf
    if level < 2:
        # A shoot is wood too: leaves without one hang in the air.
        wood, ends = np.asarray(config.bark) * 0.8, foot + 0.9 * length[:, None] * way
        wide = np.full(shoots, 0.022 * config.leaf)
        add_tubes(shape, foot, ends, 1.6 * wide, wide, np.tile(wood, (shoots, 1)), 3)
    base, axis, face = _sprays(rng, foot, way, length, each)
    # A lobe is shaded as a mass: light on its top, dark where it rests on the next one.
    lobe = lobes.out(foot)
    mass = unit((1.0 - MASS) * unit(out) + MASS * lobe)
    deep = np.clip((np.linalg.norm(lobe, axis=-1) - 0.25) / 0.75, 0.0, 1.0)
    lit = np.clip((depth - 0.25) / 0.75, 0.0, 1.0) * (0.3 + 0.7 * deep)
    lit = lit * (0.75 + 0.25 * mass[:, 1])
    color = np.asarray(config.color) + lit[:, None] * (
        np.asarray(config.young) - np.asarray(config.color)
    )
    # Shoots differ from each other, and their leaves a little less.
    color = color * (0.97 + CALM[level] * rng.uniform(-0.22, 0.22, (shoots, 1)))
    color = np.repeat(color, each, axis=0)
    color = color * (1.0 + CALM[level] * rng.uniform(-0.16, 0.16, (len(color), 1)))
    size = np.repeat(leaf, each) * rng.uniform(0.72, 1.12, len(base))
    normals = unit(0.9 * np.repeat(mass, each, axis=0) + 0.6 * CALM[level] * unit(face) + 0.25 * UP)
    wide = min(config.leaf_wide * (1.0, 1.1, 1.35, 1.6)[level], 1.0) * size
    add_leaves(shape, base, axis, face, size, wide, color, normals, triangles=triangles)
    return shape.prototype()


def _sprays(
    rng: np.random.Generator, foot: Array, way: Array, length: Array, each: int
) -> tuple[Array, Array, Array]:
    """Return the feet, axes and faces of the leaves of N shoots, (N * each, 3) of each.

    They stand in turn on both sides of the shoot, in about one plane that faces up, and the last
    at its tip, as in beech, birch and most shade leaves.

    Args:
        rng: of their differences.
        foot: (N, 3) of the shoots [m].
        way: (N, 3) unit vectors along them.
        length: (N,) [m].
        each: leaves of a shoot.
    """
    n = len(foot)
    aside = unit(np.cross(way, UP) + 0.35 * rng.normal(size=(n, 3)))
    k = np.arange(each)
    s = ((k + 0.6) / max(each - 0.4, 1.0))[None, :, None] * np.ones((n, 1, 1))
    s = np.clip(s + rng.uniform(-0.3, 0.3, s.shape) / each, 0.05, 1.0)
    # The tips of shoots hang.
    bow = 0.22 * length[:, None, None] * s**2
    base = foot[:, None] + s * length[:, None, None] * way[:, None] - bow * UP
    sign = np.where((k + rng.integers(0, 2, (n, 1))) % 2, 1.0, -1.0)[..., None]
    is_last = (k == each - 1)[None, :, None]
    axis = OPENED[0] * way[:, None] + np.where(is_last, 0.0, OPENED[1]) * sign * aside[:, None]
    axis = unit(axis + 0.28 * rng.normal(size=axis.shape) - [0.0, 0.22, 0.0])
    face = np.cross(aside, way)
    face = np.where(face[:, 1:2] < 0.0, -face, face)[:, None] + 0.38 * rng.normal(size=axis.shape)
    return base.reshape(-1, 3), axis.reshape(-1, 3), face.reshape(-1, 3)
