"""Fence: posts and split rails on natural ground, grey from the weather."""

from __future__ import annotations

import numpy as np

from pipeline.production.edging.border import Border
from pipeline.production.scenery.prototype import UP
from pipeline.simulation.spatial import Array

SPACING = 2.3
"""Distance from post to post, about [m]."""

TALL = 1.15
"""Height of the posts [m]."""

RAILS = (0.38, 0.68, 0.98)
"""Heights of the rails [m]."""

MISSING = 0.08
"""Share of the rails that have fallen."""


def stand_fence(border: Border, out: float, material: str) -> None:
    """Add a fence at a distance from the cast's ground [m], of a material by name."""
    rng = np.random.default_rng([border.seed, 461])
    low, high = border.low - out, border.high + out
    corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    for k in range(4):
        start, end = corners[k], corners[(k + 1) % 4]
        count = max(round(float(np.linalg.norm(end - start)) / SPACING), 1)
        places = start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start)
        places = places + rng.normal(0.0, 0.09, places.shape)
        tall = TALL * rng.uniform(0.9, 1.12, len(places))
        points = border.points(places)
        stands = border.is_free(places, TALL, 0.15)
        sides = rng.uniform(0.085, 0.13, (len(places), 2))
        posts = np.column_stack([sides[:, 0], tall + 0.3, sides[:, 1]])
        turns, leans = rng.uniform(0.0, np.pi, len(places)), rng.normal(0.0, 0.035, len(places))
        for j in np.flatnonzero(stands):
            foot = points[j] + (0.5 * tall[j] - 0.15) * UP
            border.carpentry.add(material, foot, posts[j], float(turns[j]), float(leans[j]))
        for height in RAILS:
            ups = height + rng.normal(0.0, 0.03, len(places))
            lies = rng.uniform(size=count) > MISSING
            thick = rng.uniform([0.075, 0.045], [0.11, 0.07], (count, 2))
            for j in np.flatnonzero(stands[:-1] & stands[1:] & lies):
                first, second = points[j] + ups[j] * UP, points[j + 1] + ups[j + 1] * UP
                _add_rail(border, material, (first, second), thick[j])


def _add_rail(border: Border, material: str, ends: tuple[Array, Array], thick: Array) -> None:
    """Add a rail from end to end, which goes on a little beyond the posts."""
    first, second = ends
    way = second - first
    flat = float(np.hypot(way[0], way[2]))
    heading, rise = float(np.arctan2(way[0], way[2])), float(np.arctan2(way[1], flat))
    size = (thick[1], thick[0], float(np.hypot(flat, way[1])) + 0.2)
    border.carpentry.add(material, 0.5 * (first + second), size, heading, -rise)
