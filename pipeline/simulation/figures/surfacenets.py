"""Surface nets: the zero surface of a sampled function, as triangles.

One vertex a cell that the surface crosses, at the mean of its crossings with the
cell's edges; one quadrilateral for each crossed edge of the grid. Smoother and with
better triangles than marching cubes, and short enough to be read.

Source: Gibson 1998 (naive variant: no relaxation).
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array


def surface_nets(values: Array, low: Array, cell: float) -> tuple[Array, NDArray[np.uint32]]:
    """Return vertices (V, 3) and faces (F, 3) of the surface where `values` are zero.

    Args:
        values: (n_x, n_y, n_z) samples, negative inside; positive on the whole border.
        low: (3,) place of the first sample.
        cell: distance between samples.
    """
    inside = values < 0.0
    corners = [np.array(c) for c in itertools.product((0, 1), repeat=3)]
    edges = [(a, b) for a, b in itertools.combinations(range(8), 2) if _beside(corners, a, b)]
    shape = tuple(n - 1 for n in values.shape)
    many = sum(_at(inside.view(np.uint8), corner, shape) for corner in corners)
    active = (many > 0) & (many < len(corners))
    sampled = [_at(values, corner, shape)[active] for corner in corners]
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


def _at(field: NDArray[Any], corner: Array, shape: tuple[int, ...]) -> NDArray[Any]:
    """Return what a field is at one corner of all cells."""
    i, j, k = corner
    return field[i : i + shape[0], j : j + shape[1], k : k + shape[2]]


def _beside(corners: list[Array], a: int, b: int) -> bool:
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
