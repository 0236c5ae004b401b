"""Signed distance: solids as functions that are negative inside, and their smooth unions.

A body is an outline at a row of heights, as wide to the right as to the left, with different
depths ahead and behind.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pipeline.simulation.spatial import Array

HEM_ROUNDING = 0.012  # of the edge of a hem, in girths: sharper edges polygonise raggedly

Field = Callable[[Array], Array]
"""From places (n, 3) to (n,) approximate distances to the surface, negative inside [m]."""


def ellipsoid(centre: Sequence[float] | Array, radii: float | Sequence[float] | Array) -> Field:
    """Return an ellipsoid of `radii` along the axes around `centre` (3,) [m]."""
    origin, scale = np.asarray(centre, dtype=float), np.broadcast_to(radii, 3).astype(float)
    least = float(scale.min())

    def distance(places: Array) -> Array:
        return (_length((places - origin) / scale) - 1.0) * least

    return distance


def round_cone(
    a: Sequence[float] | Array,
    b: Sequence[float] | Array,
    r_a: float,
    r_b: float,
    flat: Sequence[float] = (1.0, 1.0, 1.0),
) -> Field:
    """Return a round cone between balls around `a` and `b` (3,), stretched by `flat` [m]."""
    scale = np.asarray(flat, dtype=float)
    start, along = np.asarray(a, dtype=float), np.asarray(b, dtype=float) - np.asarray(a)
    square, least = float((along * along).sum()), float(scale.min())

    def distance(places: Array) -> Array:
        offset = places - start
        s = np.clip((offset * along).sum(axis=-1) / square, 0.0, 1.0)
        radial = (offset - s[:, None] * along) / scale
        return (_length(radial) - (r_a + (r_b - r_a) * s)) * least

    return distance


def oval_stack(rows: Sequence[Sequence[float]] | Array, z: float = 0.0) -> Field:
    """Return the solid inside ovals at several heights, flat at both ends.

    Args:
        rows: (n, 5) from the lowest to the highest: height; middle of the oval along X; its reach
            ahead, behind, and to either side [m].
        z: of the middle of all ovals [m].
    """
    table = np.asarray(rows, dtype=float)
    heights, measures = table[:, 0], table[:, 1:]
    slopes = _monotone_slopes(heights, measures)

    def distance(places: Array) -> Array:
        y = np.clip(places[:, 1], heights[0], heights[-1])
        middle, ahead, behind, aside = _hermite(heights, measures, slopes, y).T
        x = places[:, 0] - middle
        depth = np.where(x > 0.0, ahead, behind)
        radius = np.hypot(x / depth, (places[:, 2] - z) / aside)
        side = (radius - 1.0) * np.minimum(depth, aside)
        cap = np.maximum(heights[0] - places[:, 1], places[:, 1] - heights[-1])
        return np.maximum(side, cap)

    return distance


def half_space(point: Sequence[float] | Array, normal: Sequence[float] | Array) -> Field:
    """Return the space behind a plane through `point` (3,) with a normal (3,)."""
    n = np.asarray(normal, dtype=float)
    n = n / np.sqrt((n * n).sum())
    p = np.asarray(point, dtype=float)

    def distance(places: Array) -> Array:
        return ((places - p) * n).sum(axis=-1)

    return distance


def smooth_union(fields: Sequence[Field], blend: float) -> Field:
    """Return the union of solids, rounded over `blend` where they meet [m]."""

    def distance(places: Array) -> Array:
        total = fields[0](places)
        for field in fields[1:]:
            total = _smooth_minimum(total, field(places), blend)
        return total

    return distance


def smooth_difference(solid: Field, knife: Field, blend: float) -> Field:
    """Return a solid without the inside of a knife, its edge rounded over `blend` [m]."""

    def distance(places: Array) -> Array:
        return -_smooth_minimum(-solid(places), knife(places), blend)

    return distance


def smooth_intersection(solid: Field, limit: Field, blend: float) -> Field:
    """Return a solid inside a limit, its edge rounded over `blend` [m]."""

    def distance(places: Array) -> Array:
        return -_smooth_minimum(-solid(places), -limit(places), blend)

    return distance


def offset_solid(solid: Field, by: float) -> Field:
    """Return a solid grown by a distance [m]."""

    def distance(places: Array) -> Array:
        return solid(places) - by

    return distance


OPENNESS_STEPS = 5
"""Distances along a normal at which the room before a surface is measured."""


def openness(solid: Field, places: Array, normals: Array, reach: float) -> Array:
    """Return how open the room before places of a surface is (n,), from 0 in a slit to 1.

    Over an open surface the distance to the solid grows as fast as that along the normal.

    Args:
        solid: with the surface.
        places: (n, 3) on it [m].
        normals: (n, 3).
        reach: farthest distance at which something closes it [m].

    Source: Evans 2006, ambient occlusion from distance fields.
    """
    blocked, total = np.zeros(len(places)), 0.0
    for k in range(1, OPENNESS_STEPS + 1):
        away = reach * k / OPENNESS_STEPS
        near = np.clip(1.0 - solid(places + away * normals) / away, 0.0, 1.0)
        blocked, total = blocked + 0.5**k * near, total + 0.5**k
    return 1.0 - blocked / total


def _smooth_minimum(a: Array, b: Array, blend: float) -> Array:
    """Return the smooth minimum: a quarter of `blend` below both where they are equal.

    Source: Quilez 2013, the quadratic one.
    """
    h = np.maximum(blend - np.abs(a - b), 0.0)
    return np.minimum(a, b) - h * h / (4.0 * blend)


def _length(v: Array) -> Array:
    return np.sqrt((v * v).sum(axis=-1))


def _monotone_slopes(x: Array, y: Array) -> Array:
    """Return slopes (n, m) at the knots of a cubic that never overshoots them.

    Source: Fritsch and Butland 1984: the harmonic mean of both sides, zero at an extremum.
    """
    rise = np.diff(y, axis=0) / np.diff(x)[:, None]
    before, after = rise[:-1], rise[1:]
    same = before * after > 0.0
    mean = 2.0 * before * after / np.where(same, before + after, 1.0)
    return np.concatenate([rise[:1], np.where(same, mean, 0.0), rise[-1:]])


def _hermite(x: Array, y: Array, slopes: Array, places: Array) -> Array:
    """Return (k, m) of a cubic through `y` (n, m) at `x` (n,), at places (k,)."""
    i = np.clip(np.searchsorted(x, places, side="right") - 1, 0, len(x) - 2)
    span = x[i + 1] - x[i]
    s = ((places - x[i]) / span)[:, None]
    span = span[:, None]
    return (
        (1.0 + 2.0 * s) * (1.0 - s) ** 2 * y[i]
        + s * (1.0 - s) ** 2 * span * slopes[i]
        + s * s * (3.0 - 2.0 * s) * y[i + 1]
        + s * s * (s - 1.0) * span * slopes[i + 1]
    )
