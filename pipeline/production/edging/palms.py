"""Palms: for terraces at a shore."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pipeline.production.scenery.prototype import Prototype, Shape, add_leaves, add_tubes, unit

HEIGHT = 6.2
"""Of the trunk of a palm at scale 1 [m]."""

FRONDS, LONG, LEAFLETS = 32, 2.6, (30, 15)
"""Number of fronds, their length [m], and leaflets on each side by level of detail."""

BARK, GREEN, YELLOW, DEAD = (
    *((0.17, 0.135, 0.10), (0.060, 0.098, 0.026), (0.180, 0.215, 0.060), (0.20, 0.15, 0.085)),
)


@lru_cache(maxsize=16)
def palm(seed: int, level: int) -> Prototype:
    """Return a palm that leans a little, at a level of detail."""
    rng, shape = np.random.default_rng([seed, 491]), Shape()
    t = np.linspace(0.0, 1.0, 15)[:, None]
    lean = rng.normal(0.0, 0.7, 2)
    points = np.concatenate([lean[0] * t**1.7, HEIGHT * t, lean[1] * t**1.7], axis=1)
    radii = (0.17 - 0.07 * t[:, 0]) * (1.0 + 0.5 * np.exp(-t[:, 0] / 0.03))
    # Rings of old leaf bases.
    radii = radii * (1.0 + 0.05 * (np.arange(15) % 2))
    bark = np.asarray(BARK) * rng.uniform(0.8, 1.2, (14, 1))
    ways = unit(np.diff(points, axis=0))
    ends = np.concatenate([ways[:1], ways]), np.concatenate([ways, ways[-1:]])
    add_tubes(
        *(shape, points[:-1], points[1:], radii[:-1], radii[1:], bark, (9, 6)[min(level, 1)]),
        (unit(ends[0][:-1] + ends[1][:-1]), unit(ends[0][1:] + ends[1][1:])),
    )
    crown = points[-1]
    count = LEAFLETS[min(level, 1)]
    for k in range(FRONDS):
        age = k / FRONDS
        heading = 2.39996 * k + rng.normal(0, 0.12)
        out = np.array([np.cos(heading), 0.0, np.sin(heading)])
        rise = 1.15 - 1.6 * age + rng.normal(0, 0.08)
        s = np.linspace(0.0, 1.0, count + 1)[:, None]
        length = LONG * rng.uniform(0.85, 1.1)
        spine = crown + length * (
            s * (np.cos(0.6 * rise) * out)
            + np.array([0.0, 1.0, 0.0]) * (rise * s * 0.55 - 0.62 * s**2)
        )
        color = np.asarray(GREEN) + (1.0 - age) * 0.6 * (np.asarray(YELLOW) - np.asarray(GREEN))
        if age > 0.86:
            color = np.asarray(DEAD)
        add_tubes(
            *(shape, spine[:-1], spine[1:], np.full(count, 0.018), np.full(count, 0.014)),
            *(np.tile(0.9 * color, (count, 1)), 3),
        )
        side = np.cross(out, [0.0, 1.0, 0.0])
        reach = 0.62 * np.sin(np.pi * (0.12 + 0.83 * s[1:, 0])) ** 0.7
        for way in (-1.0, 1.0):
            axes = way * side + 0.75 * out + np.array([0.0, -0.35, 0.0])
            axes = axes + 0.14 * rng.normal(size=(count, 3))
            shades = color * rng.uniform(0.8, 1.25, (count, 1))
            face = np.tile([0.0, 1.0, 0.0], (count, 1))
            add_leaves(
                *(
                    shape,
                    spine[1:],
                    axes,
                    face,
                    reach,
                    np.full(count, (0.085, 0.14)[min(level, 1)]),
                ),
                shades,
                triangles=2 if level == 0 else 1,
            )
    return shape.prototype()
