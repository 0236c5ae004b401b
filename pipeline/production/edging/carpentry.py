"""Carpentry: boxes of boards and posts in the world, each with its grain along its longest side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from render.shot import Mesh

_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_SIDES = np.array(
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
)
"""Corners of the sides of a box, counter-clockwise from outside."""

PATTERN_STEP = np.array([0.6180, 0.4142, 0.7321])
"""Offset between the patterns of two boxes [m]."""


class Carpentry:
    """Collects boxes by material."""

    def __init__(self) -> None:
        self._boxes: dict[str, list[tuple[Array, Array]]] = {}

    def add(
        self,
        material: str,
        centers: Array,
        sizes: Array | tuple[float, ...],
        heading: Array | float = 0.0,
        lean: float = 0.0,
        top: tuple[float, float] = (1.0, 1.0),
    ) -> None:
        """Add boxes.

        Args:
            material: of them, by name.
            centers: (N, 3) or (3,) [m].
            sizes: (N, 3) or (3,) along their own axes [m].
            heading: (N,) or one, turn about +Y [rad].
            lean: turn about their own first axis [rad].
            top: factors on length and depth at their tops, which taper roofs and gables.
        """
        centers = np.atleast_2d(np.asarray(centers, float))
        n = len(centers)
        sizes = np.broadcast_to(np.asarray(sizes, float), (n, 3))
        angle = np.broadcast_to(np.asarray(heading, float), (n,))
        tapered = np.where(_CORNERS[:, 1:2] > 0.0, [top[0], 1.0, top[1]], 1.0)
        local = (tapered * _CORNERS)[None] * sizes[:, None]
        c, s = np.cos(lean), np.sin(lean)
        tipped = local @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
        c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
        x, y, z = np.moveaxis(tipped, -1, 0)
        world = np.stack([c * x + s * z, y, c * z - s * x], axis=-1) + centers[:, None]
        # The longest side is the first of the pattern.
        order = np.argsort(-sizes, axis=1, kind="stable")
        rest = np.take_along_axis(local, order[:, None].repeat(8, axis=1), axis=2)
        self._boxes.setdefault(material, []).append((world, rest))

    @property
    def materials(self) -> tuple[str, ...]:
        """Names of all materials."""
        return tuple(sorted(self._boxes))

    def meshes(self) -> tuple[Mesh, ...]:
        """Return one mesh for each material."""
        return tuple(self._mesh(material) for material in self.materials)

    def _mesh(self, material: str) -> Mesh:
        world, rest = (np.concatenate([box[k] for box in self._boxes[material]]) for k in (0, 1))
        rest = rest + PATTERN_STEP * np.arange(len(rest))[:, None, None]
        # Each side has corners of its own, because its edges are sharp.
        points = world[:, _SIDES].reshape(-1, 3).astype(np.float32)
        first = 4 * np.arange(len(points) // 4)[:, None]
        faces: NDArray[np.int64] = np.concatenate(
            [first + np.array([0, 1, 2]), first + np.array([0, 2, 3])]
        )
        return Mesh(
            material,
            points,
            faces.astype(np.uint32),
            material,
            smooth=False,
            rest=rest[:, _SIDES].reshape(-1, 3).astype(np.float32),
        )


def subdivide_sides(mesh: Mesh, cell: float, is_divided: Array) -> Mesh:
    """Return a mesh of four-cornered sides with those divided that are larger than a cell.

    Args:
        mesh: of Q sides, four vertices each.
        cell: its breadth, at most [m].
        is_divided: (Q,) whether a side is.
    """
    assert mesh.rest is not None
    corners, rest = mesh.vertices.reshape(-1, 4, 3), mesh.rest.reshape(-1, 4, 3)
    # Of a side that tapers the longer of two opposite edges counts.
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=-1)
    edges = np.maximum(edges[:, :2], edges[:, 2:])
    counts = np.where(is_divided[:, None], np.maximum(np.ceil(edges / cell), 1), 1).astype(int)
    points: list[Array] = []
    rests: list[Array] = []
    faces: list[Array] = []
    first = 0
    for count in np.unique(counts, axis=0):
        own = (counts == count).all(axis=1)
        m, n = (int(value) for value in count)
        grid = np.meshgrid(np.arange(m + 1) / m, np.arange(n + 1) / n, indexing="ij")
        s, t = (share.ravel() for share in grid)
        weights = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=-1)
        points.append(np.einsum("kc,qcx->qkx", weights, corners[own]).reshape(-1, 3))
        rests.append(np.einsum("kc,qcx->qkx", weights, rest[own]).reshape(-1, 3))
        i, j = (index.ravel() for index in np.meshgrid(np.arange(m), np.arange(n), indexing="ij"))
        a, b = i * (n + 1) + j, (i + 1) * (n + 1) + j
        quads = np.concatenate([np.stack([a, b, b + 1], -1), np.stack([a, b + 1, a + 1], -1)])
        starts = first + (m + 1) * (n + 1) * np.arange(int(own.sum()))
        faces.append((starts[:, None, None] + quads).reshape(-1, 3))
        first += len(points[-1])
    return replace(
        mesh,
        vertices=np.concatenate(points).astype(np.float32),
        faces=np.concatenate(faces).astype(np.uint32),
        rest=np.concatenate(rests).astype(np.float32),
    )
