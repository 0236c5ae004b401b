"""Hedges: lengths of hedge clipped some weeks ago, as shapes to be copied."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

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
from pipeline.production.surroundings.lattice_noise import fractal, smoothstep
from pipeline.simulation.spatial import Array

INNER, LEAF, YOUNG = (0.120, 0.178, 0.048), (0.172, 0.245, 0.062), (0.300, 0.365, 0.110)
"""Linear colours of leaves deep inside, at the face, and of new growth."""

BODY = (0.030, 0.044, 0.018)
"""Of the dark inside, where branches and shade are."""

LENGTH, HEIGHT, DEPTH = 1.0, 1.0, 0.74
"""Of one length of hedge at scale 1 [m]."""

BODY_SHARE = (0.76, 0.42)
"""Height and depth of the inside relative to the whole."""

OVERLAP = 0.09
"""By which shoots reach over the next length, so that no joint shows [m]."""

SHOOTS = ((325, 11, 0.074, 2), (212, 8, 0.108, 2), (150, 5, 0.20, 1))
"""Shoots, leaves on each, length of a leaf [m] and its triangles by level of detail."""

SHOOT = 0.17
"""Length of a shoot [m]."""

AT_ENDS = 0.2
"""Share of shoots that close both ends, which are within the next length but for the last one."""

BEYOND = 0.2
"""How far an end stands out over a length, so that leaves cover the dark inside [m]."""

ESCAPED = 0.05
"""Share of shoots that have outgrown the clipped face."""

TOP_WIDTHS, TOP_RISES = (5.2, 1.5), (0.13, 0.055)
"""Sizes of the waves of the top along a hedge [m], and how high they are relative to it."""


def hedge_tops(places: Array, seed: int) -> Array:
    """Return factors (N,) on the height of a hedge at places (N, 2), alike for neighbours."""
    waves = [
        rise * fractal(places / width, seed + 4190 + k, 2)
        for k, (width, rise) in enumerate(zip(TOP_WIDTHS, TOP_RISES, strict=True))
    ]
    return np.asarray(1.0 + np.clip(sum(waves), -0.2, 0.22))


@lru_cache(maxsize=16)
def hedge_length(seed: int, level: int) -> Prototype:
    """Return a length of hedge along x from its middle."""
    rng, shape = np.random.default_rng([seed, 433, level]), Shape()
    shoots, each, leaf, triangles = SHOOTS[min(level, len(SHOOTS) - 1)]
    _add_body(shape)
    feet, out, deep = _shoots(rng, seed, shoots)
    lean = unit(0.8 * out + 0.55 * random_directions(rng, shoots) + 0.35 * UP)
    fresh = rng.uniform(size=shoots) ** 2 * smoothstep(0.16, 0.0, deep)
    fresh = np.maximum(fresh, (deep < -0.03).astype(float))
    # Leaves stand along each shoot, the youngest at its tip.
    part = np.tile((np.arange(each) + 0.5) / each, shoots)
    foot, way, wide = (np.repeat(a, each, axis=0) for a in (feet, lean, out))
    base = foot + SHOOT * part[:, None] * way + 0.028 * rng.normal(size=foot.shape)
    axes = 0.55 * way + 0.9 * random_directions(rng, len(base)) + [0.0, -0.05, 0.0]
    lit = smoothstep(0.20, -0.02, np.repeat(deep, each) - 0.09 * part)
    color = mixed(mixed(INNER, LEAF, lit), YOUNG, 0.85 * np.repeat(fresh, each) * part)
    color = color * rng.uniform(0.82, 1.18, (len(base), 1))
    normals = unit(0.8 * wide + 0.7 * random_directions(rng, len(base)) + 0.25 * UP)
    lengths = leaf * rng.uniform(0.65, 1.2, len(base)) * (1.1 - 0.35 * part)
    face = 0.7 * wide + 0.4 * UP + 0.8 * random_directions(rng, len(base))
    add_leaves(
        *(shape, base, axes, face, lengths, 0.6 * lengths, color, normals), triangles=triangles
    )
    return shape.prototype()


def _shoots(rng: np.random.Generator, seed: int, count: int) -> tuple[Array, Array, Array]:
    """Return feet (N, 3) [m], ways out (N, 3) and depths below the face (N,) [m] of shoots."""
    half_depth = 0.5 * DEPTH
    # Around the section: up one face, over the top, down the other.
    girth = 2.0 * HEIGHT + DEPTH
    s = rng.uniform(0.0, girth, count)
    x = rng.uniform(-0.5 * LENGTH - OVERLAP, 0.5 * LENGTH + OVERLAP, count)
    zero, one = np.zeros(count), np.ones(count)
    side = np.where(s < HEIGHT, -1.0, 1.0)
    is_top = (s >= HEIGHT) & (s < HEIGHT + DEPTH)
    y = np.where(is_top, HEIGHT, np.where(s < HEIGHT, s, girth - s))
    z = np.where(is_top, s - HEIGHT - half_depth, side * half_depth)
    # Shoulders are round and the foot is narrower.
    near_top = smoothstep(0.72, 1.0, y / HEIGHT)
    near_side = smoothstep(0.45, 1.0, np.abs(z) / half_depth)
    out = np.where(
        is_top[:, None],
        np.stack([zero, one, 0.9 * near_side * np.sign(z)], axis=-1),
        np.stack([zero, 0.9 * near_top, side], axis=-1),
    )
    out = unit(out)
    y = y - 0.11 * near_side * is_top
    z = z * (1.0 - 0.14 * near_top * ~is_top) * (0.88 + 0.12 * smoothstep(0.0, 0.5, y))
    is_end = rng.uniform(size=count) < AT_ENDS
    end = np.where(x < 0.0, -1.0, 1.0)
    x = np.where(is_end, (0.5 * LENGTH + BEYOND) * end, x)
    # Few, so that they are spread evenly: Roberts 2018.
    spread = np.outer(np.cumsum(is_end), (0.7549, 0.5698)) % 1.0
    y = np.where(is_end, spread[:, 0] * HEIGHT, y)
    z = np.where(is_end, 0.85 * (2.0 * spread[:, 1] - 1.0) * half_depth, z)
    out = np.where(is_end[:, None], np.stack([end, 0.3 * near_top, zero], axis=-1), out)
    faces = np.stack([x, y, z], axis=-1)
    lumps = 0.07 * rough(2.3 * faces + 10.0 * seed, seed, 2)
    # Ends meet those of the next length.
    lumps = lumps * (1.0 - np.clip(2.0 * np.abs(x) / LENGTH, 0.0, 1.0) ** 4)
    deep = rng.uniform(0.0, 0.17, count) - lumps
    deep = np.where(rng.uniform(size=count) < ESCAPED, deep - 0.14, deep)
    feet = faces - (deep + 0.6 * SHOOT)[:, None] * out
    feet[:, 1] = np.maximum(feet[:, 1], 0.03)
    return feet, out, deep


def _add_body(shape: Shape) -> None:
    """Add the inside, through which nobody sees; it goes on in the next length."""
    high, deep = BODY_SHARE[0] * HEIGHT, 0.5 * BODY_SHARE[1] * DEPTH
    rising = np.array([[0.8, 0.0], [1.0, 0.45], [0.9, 0.86], [0.55, 1.0]]) * [deep, high]
    section = np.concatenate([rising * [-1.0, 1.0], rising[::-1]])
    n = len(section)
    ends = [np.column_stack([np.full(n, x), section[:, 1], section[:, 0]]) for x in (-0.54, 0.54)]
    out = np.column_stack([np.zeros(n), section[:, 1] - 0.5 * high, 2.0 * section[:, 0]])
    k = np.arange(n - 1)
    quads = np.concatenate([np.stack([k, k + 1, k + n + 1], 1), np.stack([k, k + n + 1, k + n], 1)])
    caps: list[NDArray[np.int64]] = [
        np.stack([np.full(n - 2, a), a + k[1:], a + k[1:] + 1], axis=1) for a in (0, n)
    ]
    shape.add(
        *(np.concatenate(ends), np.concatenate([out, out]), np.asarray(BODY)),
        np.concatenate([quads, *caps]),
        thin=False,
    )
