"""Solid preview: solids as a small image by point splatting, for diagrams.

Every triangle that faces the eye is covered with points closer than the pixels, and a depth
buffer keeps the nearest one. That takes a second and needs no backend.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, cross, normalized

POINT_SPACING = 0.75
"""Distance of points on a triangle [pixels]."""

LIGHT = normalized(np.array([-0.45, 0.75, 0.6]))
"""Direction to the light; x to the right, y up, z to the eye."""

AMBIENT, SPECULAR = 0.42, 0.10
"""Brightness of unlit points, and of highlights."""

BACKGROUND = -1
"""Part number of the background."""

OUTLINE_DARKENING = 0.42
"""Darkening of the outlines of parts."""


@dataclass(frozen=True, eq=False)
class PreviewSolid:
    """A solid to draw.

    Attributes:
        vertices: (V, 3) x to the right, y down, z to the eye [pixels].
        faces: (F, 3), counter-clockwise from outside.
        color: (3,) 0 to 1.
        part: number of the part; outlines separate parts.
    """

    vertices: Array
    faces: NDArray[np.uint32]
    color: Array
    part: int


def render_preview(
    solids: Sequence[PreviewSolid], size: tuple[int, int], background: Array
) -> Array:
    """Return an image (height, width, 3), 0 to 1.

    Args:
        solids: to draw.
        size: width and height [pixels].
        background: (3,) its color.
    """
    width, height = size
    depth = np.full(width * height, -np.inf)
    picture = np.tile(background, (width * height, 1))
    parts = np.full(width * height, BACKGROUND)
    for solid in solids:
        points, normals = _points(solid)
        column, row = np.floor(points[:, 0]).astype(int), np.floor(points[:, 1]).astype(int)
        seen = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        pixel, z, normals = (row * width + column)[seen], points[seen, 2], normals[seen]
        before = depth.copy()
        np.maximum.at(depth, pixel, z)
        nearest = (z >= depth[pixel]) & (depth[pixel] > before[pixel])
        picture[pixel[nearest]] = _lit(solid.color, normals[nearest])
        parts[pixel[nearest]] = solid.part
    rim = _outlines(parts.reshape(height, width), depth.reshape(height, width))
    return picture.reshape(height, width, 3) * (1.0 - OUTLINE_DARKENING * rim[..., None])


def _points(solid: PreviewSolid) -> tuple[Array, Array]:
    """Return points that cover the triangles facing the eye, and their normals."""
    corners = solid.vertices[solid.faces.astype(int)]
    # y points down, which reverses the winding.
    face = cross(corners[:, 2] - corners[:, 0], corners[:, 1] - corners[:, 0])
    normals = np.zeros_like(solid.vertices)
    for k in range(3):
        np.add.at(normals, solid.faces[:, k].astype(int), face)
    normals = normalized(normals)
    facing = face[:, 2] > 0.0
    corners, of_corners = corners[facing], normals[solid.faces[facing].astype(int)]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max(axis=-1)
    counts = np.ceil(np.clip(sides, POINT_SPACING, 4000.0) / POINT_SPACING).astype(int)
    points, found = [np.zeros((0, 3))], [np.zeros((0, 3))]
    for n in np.unique(counts):
        i, j = (index.ravel() for index in np.indices((n + 1, n + 1)))
        inside = i + j <= n
        a, b = i[inside] / n, j[inside] / n
        weights = np.stack([1.0 - a - b, a, b], axis=-1)
        some = counts == n
        points.append((weights @ corners[some]).reshape(-1, 3))
        found.append((weights @ of_corners[some]).reshape(-1, 3))
    return np.concatenate(points), normalized(np.concatenate(found))


def _lit(color: Array, normals: Array) -> Array:
    """Return the colors (n, 3) of points with these normals."""
    # Normals have y down, the light up.
    towards = normals @ (LIGHT * [1.0, -1.0, 1.0])
    # Wrapped (half-Lambert) lighting leaves no side black.
    bright = AMBIENT + (1.0 - AMBIENT) * (0.5 + 0.5 * towards) ** 1.3
    highlight = SPECULAR * np.clip(towards, 0.0, 1.0) ** 24
    return np.clip(color * bright[:, None] + highlight[:, None], 0.0, 1.0)


def _outlines(parts: NDArray[np.int64], depth: Array) -> Array:
    """Return the pixels where one part ends in front of another, 0 or 1."""
    rim = np.zeros(parts.shape)
    for axis in (0, 1):
        for way in (1, -1):
            other, behind = np.roll(parts, way, axis=axis), np.roll(depth, way, axis=axis)
            rim[(parts != BACKGROUND) & (parts != other) & (depth > behind)] = 1.0
    return rim
