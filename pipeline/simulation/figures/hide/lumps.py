"""Lumps of flesh: tapered ellipsoids whose smooth union is meshed once.

A lump is a segment with three radii at each end: along it, up and to the side. Lumps join in their
order by a polynomial smooth minimum, whose width each of them chooses, or are carved out.

Source: Quilez, "smooth minimum" (quadratic), and the first-order distance to an ellipsoid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.figures.solids import Solid, surface_nets
from pipeline.simulation.spatial import UP, Array, cross, normalized

FAR = 1e3
"""Value of the field where no lump is near [m]."""

SIDE = np.array([0.0, 0.0, 1.0])

TIGHT_CELLS = 2.0
"""Distance around lumps that is sampled beside their blend, in cells."""

PROBE_CELLS = 2.0
"""Cell of the mesh that tells how many triangles there will be, in that wanted."""

SETTLING, EVENED = 3, 0.5
"""Times that vertices are set on the surface, the last time without evening them out, and the share
of the way to their neighbours' mean that they go."""

MOST_SETTLING, LEAST_SLOPE, PROBE = 0.5, 0.3, 0.05
"""Longest step of a vertex, in cells, slope of the field below which it is not divided by, and
distance over which the slope is taken, in cells."""

BULGE_EXPONENT = np.log(0.5) / np.log(0.36)
"""Places the thickest point of a muscle at about a third of its length."""


@dataclass(frozen=True, eq=False)
class Lump:
    """A tapered ellipsoid.

    Attributes:
        a, b: (3,) ends [m].
        radii_a, radii_b: (3,) along, up and to the side at the ends [m].
        axes: (3, 3) rows along, up and to the side.
        blend: width of the smooth union with the lumps before [m].
        bulge: greatest thickness beyond a cone, as a fraction.
        carved: whether it is taken away from the lumps before.
    """

    a: Array
    b: Array
    radii_a: Array
    radii_b: Array
    axes: Array
    blend: float
    bulge: float = 0.0
    carved: bool = False

    def mirrored(self) -> Lump:
        """Return the lump on the other side of the body."""
        flip = np.array([1.0, 1.0, -1.0])
        return replace(self, a=self.a * flip, b=self.b * flip, axes=self.axes * flip)

    @property
    def reach(self) -> float:
        """Greatest distance of its surface from its segment [m]."""
        widest = max(float(self.radii_a.max()), float(self.radii_b.max()))
        return (1.0 + max(self.bulge, 0.0)) * widest

    def distance(self, points: Array) -> Array:
        """Return the approximate distances of points (..., 3), negative inside [m]."""
        span = self.b - self.a
        square = float((span * span).sum())
        away = points - self.a
        if square > 0.0:
            along = np.clip((away * span).sum(axis=-1) / square, 0.0, 1.0)[..., None]
            away = away - along * span
            radii = self.radii_a + along * (self.radii_b - self.radii_a)
            if self.bulge:
                swell = np.sin(np.pi * along**BULGE_EXPONENT)
                radii = radii * (1.0 + self.bulge * swell * np.array([0.0, 1.0, 1.0]))
        else:
            radii = self.radii_a
        scaled = (away @ self.axes.T) / radii
        inner = np.sqrt((scaled * scaled).sum(axis=-1))
        scaled = scaled / radii
        slope = np.sqrt((scaled * scaled).sum(axis=-1))
        least = float(min(self.radii_a.min(), self.radii_b.min()))
        return np.maximum(inner * (inner - 1.0) / np.maximum(slope, 1e-9), -least)


def axes_along(way: Array, up: Array = UP) -> Array:
    """Return axes (3, 3) along a way, up and to the side."""
    along = normalized(way)
    if abs(float((along * up).sum())) > 0.98:
        up = np.array([-1.0, 0.0, 0.0]) if along[1] > 0.0 else np.array([1.0, 0.0, 0.0])
    side = normalized(cross(along, up))
    return np.stack([along, cross(side, along), side])


def cone(
    a: Array,
    b: Array,
    r_a: tuple[float, float],
    r_b: tuple[float, float],
    blend: float,
    up: Array = UP,
    bulge: float = 0.0,
) -> Lump:
    """Return a tapered lump with elliptic cross-sections.

    Args:
        a: (3,) its first end [m].
        b: (3,) its second end [m].
        r_a: radii upward and to the side at `a` [m].
        r_b: the same at `b`.
        blend: width of its union [m].
        up: about (3,) the direction of the first radii.
        bulge: greatest thickness beyond a cone, as a fraction.
    """
    axes = (
        axes_along(b - a, up)
        if float(np.abs(b - a).max()) > 0.0
        else axes_along(up * 0 + [1, 0, 0], up)
    )
    radii = [np.array([0.5 * (up_r + side_r), up_r, side_r]) for up_r, side_r in (r_a, r_b)]
    return Lump(a, b, radii[0], radii[1], axes, blend, bulge)


def ball(
    at: Array, radii: Sequence[float], blend: float, axes: Array | None = None, carved: bool = False
) -> Lump:
    """Return an ellipsoid with radii along, up and to the side [m]."""
    frame = np.stack([np.array([1.0, 0.0, 0.0]), UP, SIDE]) if axes is None else axes
    return Lump(at, at, np.array(radii), np.array(radii), frame, blend, carved=carved)


def mesh_lumps(lumps: Sequence[Lump], cell: float) -> Solid:
    """Return the surface of the union of lumps.

    The grid has a layer of samples on the plane of symmetry.

    Args:
        lumps: in the order in which they join; the first is not carved.
        cell: distance between samples [m].
    """
    grown = [lump for lump in lumps if not lump.carved]
    low = np.min([np.minimum(g.a, g.b) - g.reach for g in grown], axis=0)
    high = np.max([np.maximum(g.a, g.b) + g.reach for g in grown], axis=0)
    margin = TIGHT_CELLS * cell + 0.25 * max(lump.blend for lump in grown)
    first = np.floor((low - margin) / cell).astype(int)
    last = np.ceil((high + margin) / cell).astype(int)
    axes = [np.arange(first[k], last[k] + 1) * cell for k in range(3)]
    values = np.full([len(axis) for axis in axes], FAR)
    for lump in lumps:
        reach = lump.reach + lump.blend + TIGHT_CELLS * cell
        start = np.floor((np.minimum(lump.a, lump.b) - reach) / cell).astype(int) - first
        stop = np.ceil((np.maximum(lump.a, lump.b) + reach) / cell).astype(int) - first + 1
        box = tuple(
            slice(max(int(s), 0), max(min(int(e), n), 0))
            for s, e, n in zip(start, stop, values.shape, strict=True)
        )
        if any(part.start >= part.stop for part in box):
            continue
        grid = np.stack(
            np.meshgrid(*(axes[k][box[k]] for k in range(3)), indexing="ij", sparse=False), axis=-1
        )
        values[box] = _joined(values[box], lump.distance(grid), lump)
    vertices, faces = surface_nets(values, first * cell, cell)
    return Solid(vertices, faces)


def union_distance(lumps: Sequence[Lump], points: Array) -> Array:
    """Return the approximate distances of points (..., 3) from the union of lumps [m]."""
    values = np.full(points.shape[:-1], FAR)
    for lump in lumps:
        values = _joined(values, lump.distance(points), lump)
    return values


def _joined(before: Array, distance: Array, lump: Lump) -> Array:
    """Return the field with one more lump."""
    sign = -1.0 if lump.carved else 1.0
    a, b = sign * before, distance
    near = np.maximum(lump.blend - np.abs(a - b), 0.0) / max(lump.blend, 1e-9)
    joined: Array = sign * (np.minimum(a, b) - 0.25 * lump.blend * near * near)
    return joined


def budgeted(lumps: Sequence[Lump], cell: float, most: int) -> Solid:
    """Return the union of lumps with at most about `most` triangles."""
    # The number of triangles goes by the area, which a coarse mesh tells in a tenth of the time.
    coarse = len(mesh_lumps(lumps, PROBE_CELLS * cell).faces) * PROBE_CELLS**2
    size = cell * max(1.0, float(np.sqrt(coarse / most)))
    return settled(mesh_lumps(lumps, size), lumps, size)


def settled(solid: Solid, lumps: Sequence[Lump], cell: float) -> Solid:
    """Return a mesh of a union of lumps with its vertices evened out and on the surface.

    Vertices of a surface net are means of crossings: where a limb is a few cells thick, it is
    stepped. Newton steps along the gradient of the field bring them to its zero.
    """
    places = solid.vertices.copy()
    a, b = (solid.faces[:, k].astype(int) for k in (slice(None), [1, 2, 0]))
    a, b = a.reshape(-1), b.reshape(-1)
    count = np.maximum(np.bincount(a, minlength=len(places)), 1)[:, None]
    probe = PROBE * cell
    first = value = union_distance(lumps, places)
    for k in range(SETTLING):
        slope = np.stack(
            [(union_distance(lumps, places + probe * axis) - value) / probe for axis in np.eye(3)],
            axis=-1,
        )
        square = np.maximum((slope * slope).sum(axis=-1), LEAST_SLOPE**2)[:, None]
        step = -value[:, None] / square * slope
        length = np.linalg.norm(step, axis=-1, keepdims=True)
        step *= np.minimum(1.0, MOST_SETTLING * cell / np.maximum(length, 1e-12))
        if k < SETTLING - 1:
            sums = np.stack([np.bincount(a, places[b, i], len(places)) for i in range(3)], axis=-1)
            even = EVENED * (sums / count - places)
            # Along the surface only: thin limbs would shrink to their bones.
            step += even - (even * slope).sum(axis=-1, keepdims=True) / square * slope
        places = places + step
        value = union_distance(lumps, places)
    # Where the field is flat, as on a bone, or turns within a cell, a step may lead astray.
    astray = np.abs(value) > np.abs(first)
    places[astray] = solid.vertices[astray]
    return Solid(places, solid.faces)
