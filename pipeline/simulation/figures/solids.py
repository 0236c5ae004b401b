"""Solids: closed triangle surfaces, in the creation frame.

Links are rings of vertices in sequence. A body is the smooth union of round cones along its
connections, polygonised once by surface nets: one vertex a cell that the surface crosses, at the
mean of its crossings with the cell's edges; one quadrilateral for each crossed edge of the grid.
This is smoother and has better triangles than marching cubes.

Source: Gibson 1998 (naive surface nets, without relaxation).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, cross, normalized

RING_VERTICES = 16
"""Vertices around a link: with smooth normals more are not visible."""

BODY_CELLS = 56
"""Cells along the longest side of a body's grid."""

BLEND_REACH = 6.0
"""Distance from a bone beyond which it does not shape the body, in widths of the blend."""

DEEPEST = 600.0
"""Depth inside a bone, in widths of the blend, beyond which it makes no difference: the exponential
of a little more overflows, as of the middle of a ball among many that are far smaller."""

BODY_FLATNESS = 0.78
"""Height of an insect's body, in its width."""


def surface_nets(values: Array, low: Array, cell: float) -> tuple[Array, NDArray[np.uint32]]:
    """Return vertices (V, 3) and faces (F, 3) of the zero surface of sampled values.

    Args:
        values: (n_x, n_y, n_z) samples, negative inside; positive on the whole border.
        low: (3,) place of the first sample.
        cell: distance between samples.
    """
    inside = values < 0.0
    corners = [np.array(c) for c in itertools.product((0, 1), repeat=3)]
    edges = [(a, b) for a, b in itertools.combinations(range(8), 2) if _is_edge(corners, a, b)]
    shape = tuple(n - 1 for n in values.shape)
    many = sum(_corner_values(inside.view(np.uint8), corner, shape) for corner in corners)
    active = (many > 0) & (many < len(corners))
    sampled = [_corner_values(values, corner, shape)[active] for corner in corners]
    total, count = np.zeros((len(sampled[0]), 3)), np.zeros(len(sampled[0]))
    for a, b in edges:
        v_a, v_b = sampled[a], sampled[b]
        crossed = (v_a < 0.0) != (v_b < 0.0)
        t = np.where(crossed, v_a / np.where(crossed, v_a - v_b, 1.0), 0.0)
        total += crossed[:, None] * (corners[a] + t[:, None] * (corners[b] - corners[a]))
        count += crossed
    number = np.full(shape, -1, dtype=np.int64)
    number[active] = np.arange(len(count))
    place = np.argwhere(active) + total / count[:, None]
    faces = [_quads(inside, number, axis) for axis in range(3)]
    return low + place * cell, np.concatenate(faces).astype(np.uint32)


def _corner_values(field: NDArray[Any], corner: Array, shape: tuple[int, ...]) -> NDArray[Any]:
    """Return the values of a field at one corner of all cells."""
    i, j, k = corner
    return field[i : i + shape[0], j : j + shape[1], k : k + shape[2]]


def _is_edge(corners: list[Array], a: int, b: int) -> bool:
    return bool(np.abs(corners[a] - corners[b]).sum() == 1)


def _quads(inside: NDArray[np.bool_], number: NDArray[np.int64], axis: int) -> NDArray[np.int64]:
    """Return two triangles for each crossed edge of the grid along `axis`."""
    inside, number = np.moveaxis(inside, axis, 0), np.moveaxis(number, axis, 0)
    # The four cells around an edge exist where the edge is not on the border.
    near = inside[:-1, 1:-1, 1:-1]
    far = inside[1:, 1:-1, 1:-1]
    i, j, k = np.nonzero(near != far)
    a, b = number[i, j, k], number[i, j + 1, k]
    c, d = number[i, j + 1, k + 1], number[i, j, k + 1]
    # Bringing the second axis to the front mirrors the grid, and with it the winding.
    outward = near[i, j, k] != (axis == 1)
    quads = np.where(outward[:, None], np.stack([a, b, c, d], -1), np.stack([a, d, c, b], -1))
    return quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


@dataclass(frozen=True, eq=False)
class Solid:
    """A closed surface.

    Attributes:
        vertices: (V, 3) in the creation frame [m].
        faces: (F, 3), counter-clockwise from outside.
    """

    vertices: Array
    faces: NDArray[np.uint32]


def join_solids(solids: Sequence[Solid]) -> Solid:
    """Return several solids as one."""
    starts = np.cumsum([0, *(len(solid.vertices) for solid in solids)])
    faces = [solid.faces + start for solid, start in zip(solids, starts, strict=False)]
    return Solid(
        np.concatenate([solid.vertices for solid in solids]),
        np.concatenate(faces).astype(np.uint32),
    )


def loft(rings: Array, ends: Array) -> Solid:
    """Return the surface through rings of vertices, closed to a point at both ends.

    Args:
        rings: (n, m, 3) in sequence along X, each running from Y to Z [m].
        ends: (2, 3) the points before the first ring and after the last [m].
    """
    n, m, _ = rings.shape
    return Solid(np.concatenate([rings.reshape(-1, 3), ends]), _lofted_faces(n, m))


@cache
def _lofted_faces(n: int, m: int) -> NDArray[np.uint32]:
    """Return the faces of `n` rings of `m` vertices followed by two points."""
    i = np.arange(n - 1)[:, None] * m
    k = np.arange(m)
    a, b = i + k, i + (k + 1) % m
    sides = np.stack([a, b, a + m, b, b + m, a + m], axis=-1).reshape(-1, 3)
    first, last = n * m, n * m + 1
    k_next = (k + 1) % m
    start = np.stack([np.full(m, first), k_next, k], axis=-1)
    end = np.stack([np.full(m, last), k, k_next], axis=-1)
    end[:, 1:] += (n - 1) * m
    faces = np.concatenate([sides, start, end]).astype(np.uint32)
    # Shared by many solids.
    faces.setflags(write=False)
    return faces


def revolve(axis_places: Array, radii: Array) -> Solid:
    """Return the surface of revolution about X.

    Args:
        axis_places: (n,) ascending along X [m]; the first and last ring are closed to a point.
        radii: (n,) [m].
    """
    angle = np.arange(RING_VERTICES) * (2 * np.pi / RING_VERTICES)
    ring = np.stack([np.zeros(RING_VERTICES), np.cos(angle), np.sin(angle)], axis=-1)
    rings = ring * radii[:, None, None]
    rings[..., 0] = axis_places[:, None]
    # The poles continue the profile's curve to the axis.
    ends = [[axis_places[0] - radii[0] * 0.12, 0, 0], [axis_places[-1] + radii[-1] * 0.12, 0, 0]]
    return loft(rings, np.array(ends))


def ball_solid(centre: Array, radius: float) -> Solid:
    """Return a sphere."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 14)[1:-1]
    solid = revolve(radius * np.sin(angle), radius * np.cos(angle))
    return Solid(solid.vertices + centre, solid.faces)


def body_solid(
    points: Array, radii: Array, bones: list[tuple[int, int]], flatness: float = 1.0
) -> Solid:
    """Return the smooth union of round cones along `bones`.

    Args:
        points: (n, 3) nodes in the creation frame [m].
        radii: (n,) of the solid at the nodes [m].
        bones: pairs of nodes; a body of a single node is a ball.
        flatness: height, in the width.
    """
    bones = bones or [(0, 0)]
    blend = float(np.median(radii)) * 0.35
    # A smooth union of n solids swells by up to blend ln n where all of them meet.
    margin = float(radii.max()) * 1.1 + blend * (1.0 + np.log(len(bones)))
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    cell = float((high - low).max()) / BODY_CELLS
    counts = np.ceil((high - low) / cell).astype(int) + 1
    x, y, z = (low[k] + cell * np.arange(counts[k]) for k in range(3))
    # Flattened about the body's own middle.
    middle = points[:, 1].mean()
    y = middle + (y - middle) / flatness
    # Smooth minimum by log-sum-exp, which does not depend on the order of the bones. Beyond a few
    # widths of the blend a bone adds nothing, so only its neighbourhood is evaluated.
    total = np.zeros(counts)
    for a, b in bones:
        reach = float(max(radii[a], radii[b])) + BLEND_REACH * blend
        box = _cells_near(points[[a, b]], reach, low, cell, total.shape)
        near = (x[box[0]], y[box[1]], z[box[2]])
        cone = _round_cone(near, points[a], points[b], radii[a], radii[b])
        total[box] += np.exp(np.minimum(-cone / blend, DEEPEST))
    distance = -blend * np.log(np.maximum(total, 1e-300))
    vertices, faces = surface_nets(distance, low, cell)
    return Solid(vertices, faces)


def _cells_near(
    ends: Array, reach: float, low: Array, cell: float, counts: tuple[int, ...]
) -> tuple[slice, ...]:
    """Return the part of a grid within `reach` of the box around `ends` [m].

    Flattening stretches the grid along y, which only makes the part larger than needed.
    """
    first = np.floor((ends.min(axis=0) - reach - low) / cell).astype(int)
    last = np.ceil((ends.max(axis=0) + reach - low) / cell).astype(int) + 1
    return tuple(
        slice(max(int(a), 0), min(int(b), n)) for a, b, n in zip(first, last, counts, strict=True)
    )


def _round_cone(
    axes: tuple[Array, Array, Array], a: Array, b: Array, r_a: float, r_b: float
) -> Array:
    """Return the approximate distance from the round cone between two balls [m].

    Args:
        axes: (n_x,), (n_y,), (n_z,) coordinates of a grid [m]: sums along the axes cost a fraction
            of evaluating point by point.
        a: (3,) centre of the first ball [m].
        b: (3,) of the second.
        r_a: radius of the first [m].
        r_b: of the second.
    """
    ab = b - a
    square = float(ab @ ab)
    x, y, z = (axes[k] - a[k] for k in range(3))
    away = _axis_sums(x * x, y * y, z * z)
    if square == 0.0:
        return np.sqrt(away) - r_a
    dot = _axis_sums(x * ab[0], y * ab[1], z * ab[2])
    along = np.clip(dot / square, 0.0, 1.0)
    away -= along * (2.0 * dot - along * square)
    result = np.sqrt(np.maximum(away, 0.0)) - (r_a + (r_b - r_a) * along)
    return result


def _axis_sums(x: Array, y: Array, z: Array) -> Array:
    """Return the sums of one number of each axis (n_x, n_y, n_z)."""
    return x[:, None, None] + y[:, None] + z


def vertex_normals(vertices: Array, faces: NDArray[np.uint32]) -> Array:
    """Return the unit normals (V, 3) of a surface."""
    a, b, c = (vertices[faces[:, k].astype(int)] for k in range(3))
    n = cross(b - a, c - a)
    corners = faces.T.ravel().astype(int)
    sums = [np.bincount(corners, np.tile(n[:, k], 3), len(vertices)) for k in range(3)]
    return normalized(np.stack(sums, axis=-1))
