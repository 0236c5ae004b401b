"""Stonework: dry-stone walls and kerbs along a floor."""

from __future__ import annotations

import numpy as np

from pipeline.production.edging.border import Border, turns
from pipeline.production.edging.masonry import wall_stone
from pipeline.production.scenery.expansion import Copies
from pipeline.production.scenery.prototype import UP
from pipeline.simulation.spatial import Array


def wall(border: Border, out: float, tall: float) -> None:
    """Add a dry-stone wall, lower here and there."""
    rng = np.random.default_rng([border.seed, 452])
    core = border.rows(out, 0.6, tall, 0.35)
    if len(core.places):
        # Small stones fill the inside, so that nobody sees through.
        sizes = np.tile([0.8, 0.6 * tall, 0.24], (len(core.places), 1))
        middles = border.points(core.places) + 0.26 * tall * UP
        add_stones(border, middles, sizes, core.heading, rng, light=0.45)
    places, heights, lengths, headings, depths = [], [], [], [], []
    courses = max(round(tall / 0.15), 1)
    for course in range(courses):
        top = course == courses - 1
        rows = border.rows(
            out, (0.31, 0.38, 0.27, 0.34)[course % 4] if not top else 0.44, tall, 0.35
        )
        n = len(rows.places)
        along = np.stack([np.cos(rows.heading), -np.sin(rows.heading)], axis=-1)
        slid = rng.uniform(-0.1, 0.1, (n, 1))
        at = rows.places + slid * along + rng.normal(0, 0.012, (n, 1)) * rows.outward
        # Weather and sheep have taken stones from the top.
        worn = np.sin(at[:, 0] * 0.9 + border.seed) + np.sin(at[:, 1] * 1.1 + 2.0 * border.seed)
        stands = course < courses - 1 - np.clip(worn - 0.9, 0.0, 1.0) * 2.2
        places.append(at[stands])
        heights.append(np.full(stands.sum(), (course + 0.45) * tall / courses))
        lengths.append(rng.uniform(0.24, 0.5, stands.sum()))
        headings.append((rows.heading + rng.normal(0, 0.07, n))[stands])
        depths.append(np.full(stands.sum(), 0.46 - 0.14 * course / courses))
    place = np.concatenate(places)
    if not len(place):
        return
    points = border.points(place)
    points[:, 1] += np.concatenate(heights) + rng.normal(0, 0.018, len(points)) - 0.03
    high = tall / courses * rng.uniform(0.85, 1.55, len(points))
    scales = np.stack([np.concatenate(lengths), high, np.concatenate(depths)], axis=-1)
    add_stones(border, points, scales, np.concatenate(headings), rng)


def kerb(border: Border, out: float, level: float) -> None:
    """Add long hewn stones around a floor of slabs at a height [m], a little over it."""
    rng = np.random.default_rng([border.seed, 453])
    rows = border.rows(out, 0.9, 0.1, 0.0)
    n = len(rows.places)
    if not n:
        return
    spans = border.spans(rows, 0.9, out)
    points = np.stack([rows.places[:, 0], np.full(n, level - 0.1), rows.places[:, 1]], axis=-1)
    points[:, 1] += rng.normal(0.012, 0.005, n)
    points[:, [0, 2]] += rng.normal(0.0, 0.006, (n, 1)) * rows.outward
    sizes = np.column_stack([spans - rng.uniform(0.006, 0.02, n), np.full((n, 2), (0.22, 0.18))])
    turned = rows.heading + rng.normal(0.0, 0.004, n)
    border.carpentry.add("edging hewn stone", points, sizes, turned)


def add_stones(
    border: Border,
    points: Array,
    scales: Array,
    heading: Array,
    rng: np.random.Generator,
    light: float = 1.0,
) -> None:
    """Add stones by their middles (N, 3), sizes (N, 3), headings (N,) and their lightness."""
    far = border.view.distances(points) / border.detail
    across = np.where(far < 5.0, 7, np.where(far < 14.0, 4, 3))
    variant = rng.integers(0, 7, len(points))
    tints = rng.uniform(0.6, 1.35, (len(points), 1)) * rng.normal(light, 0.05, (len(points), 3))
    turned = heading + np.pi * rng.integers(0, 2, len(points))
    for k in np.unique(across):
        for v in range(7):
            some = (across == k) & (variant == v)
            if some.any():
                border.stones.append(
                    Copies(
                        *(wall_stone(v, int(k)), points[some], turns(turned[some])),
                        *(scales[some], tints[some]),
                    )
                )
