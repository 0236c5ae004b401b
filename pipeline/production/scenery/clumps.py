"""Clumps: what is a single tree nearby stands for a few of them far away.

Far trees are thinned out, and single ones on the crest of a hill look like posts.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipeline.production.scenery.prototype import Prototype

FAR = 3
"""Level of detail from which a tree is a clump."""

LEAVES = (0.42, 0.25)
"""Share of the leaves of the first tree of a clump, and of each other."""

APART = (0.32, 0.62)
"""Least and greatest distance of the others from the first, relative to its height."""

SMALLER = (0.5, 0.92)
"""Least and greatest size of the others."""


def tree(make: Callable[[int, int], Prototype], count: int, seed: int, level: int) -> Prototype:
    """Return a tree at a level of detail, or a clump of `count` trees where it is far."""
    if level < FAR:
        return make(seed, level)
    rng = np.random.default_rng([seed, 83])
    trees = [make(seed + 101 * k, level) for k in range(count)]
    tall = float(trees[0].vertices[:, 1].max())
    turn = rng.uniform(0.0, 2.0 * np.pi)
    vertices, foliage, solid, first = [], [], [], 0
    for k, one in enumerate(trees):
        angle = turn + 2.39996 * k
        way = np.array([np.cos(angle), 0.0, np.sin(angle)])
        size = 1.0 if k == 0 else rng.uniform(*SMALLER)
        aside = 0.0 if k == 0 else tall * rng.uniform(*APART)
        vertices.append(one.vertices * size + aside * way)
        count_kept = max(round(LEAVES[min(k, 1)] * len(one.foliage)), 1)
        kept = np.linspace(0, len(one.foliage) - 1, count_kept).astype(int)
        foliage.append(one.foliage[kept] + first)
        solid.append(one.solid + first)
        first += len(one.vertices)
    return Prototype(
        np.concatenate(vertices).astype(np.float32),
        np.concatenate([one.normals for one in trees]),
        np.concatenate([one.colors for one in trees]),
        np.concatenate(foliage).astype(np.uint32),
        np.concatenate(solid).astype(np.uint32),
    )
