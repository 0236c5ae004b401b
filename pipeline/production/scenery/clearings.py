"""Clearings: where the performers of a take are, so that nothing solid stands in their way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import (
    binary_closing,
    binary_dilation,
    binary_fill_holes,
    distance_transform_edt,
    map_coordinates,
)

from pipeline.production.scenery.hearths import Hearths
from pipeline.production.shots.skinning import Skin, spread_vertices, visible_parts
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Mesh, Take
from pipeline.simulation.terrain.heightfield import surface_of_vertices

Mask = NDArray[np.bool_]

REACH = 2.5
"""Height below which a performer's parts keep the ground clear [m]."""

LOW = 0.6
"""Height below which grass stands in the way of what stays there, such as a seat [m]."""

STAYS = 0.5
"""Share of the moments for which an outline stays that encloses bare ground."""

LINGERS = 0.3
"""Share of the moments for which something is where no grass shall be: it may have sat down."""

SCORCHED = 0.2
"""Width of the bare ground around a fire [m]."""

BORDER = 6.0
"""Distance around all performers up to which distances are known [m]."""

MAX_SIDE = 700
"""Cells along a side of the raster."""

LEAST_CELL = 0.06
MAX_MOMENTS = 400
UNDER = 0.6
"""Height below which an outline, as of a deck, keeps the ground clear that it encloses [m]."""

COARSE = 0.25
"""Side of the cells in which outlines are found [m], wider than the steps between their points."""

GAP = 2
"""Half of the widest gap between points that is no gap in what they are of [cells]."""

POINTS = 40
"""Vertices of a part that are looked at."""

OUTLINE_POINTS, ALL_POINTS = 400, 12_000
"""Most vertices of a part in which outlines are sought or which are spread over its faces, and
about how many of all parts."""

LARGE_FACE = 0.2
"""Side of a face over which points are spread [m]: a bench has vertices at its ends alone."""


@dataclass(frozen=True, eq=False)
class Clearings:
    """Distances from all places where performers are during a take.

    Attributes:
        corner: x and z of the middle of the first cell [m].
        cell: side of a cell [m].
        distances: (rows along z, columns along x) uint8, in units of `UNIT`.
        covered: of the same shape, whether something stays there for long, or burns there.
    """

    corner: tuple[float, float]
    cell: float
    distances: NDArray[np.uint8]
    covered: NDArray[np.bool_]

    UNIT = 0.05

    @staticmethod
    def of(take: Take, hearths: Hearths | None = None) -> Clearings | None:
        """Return the clearings of a take, None of one without visible performers.

        Args:
            take: of the performers.
            hearths: fires on the ground, None without any.
        """
        if not take.parts:
            return None
        points = _low_points(take, POINTS)
        kept = [p for p in points if len(p)]
        if not kept:
            return None
        fires = [] if hearths is None else [hearths.places]
        every = np.concatenate([*(moment[:, :2] for moment in kept), *fires])
        low, high = every.min(axis=0) - BORDER, every.max(axis=0) + BORDER
        cell = max(LEAST_CELL, float((high - low).max()) / MAX_SIDE)
        columns, rows = np.ceil((high - low) / cell).astype(int) + 1
        used = np.zeros((rows, columns), bool)
        stays = np.zeros((rows, columns), np.int32)
        for moment in kept:
            i, j = ((moment[:, :2] - low) / cell + 0.5).astype(int).T
            used[j, i] = True
            here = np.zeros_like(used)
            near = moment[:, 2] < LOW
            here[j[near], i[near]] = True
            stays += here
        scorched = _discs(hearths, low, used.shape, cell)
        used |= scorched
        distance = np.minimum(distance_transform_edt(~used) * cell / Clearings.UNIT, 255)
        return Clearings(
            (float(low[0]), float(low[1])),
            cell,
            distance.astype(np.uint8),
            binary_dilation(binary_closing(stays > LINGERS * len(points), iterations=GAP))
            | _enclosed(_outlines(take), low, used.shape, cell)
            | scorched,
        )

    def distance(self, x: Array, z: Array) -> Array:
        """Return the distances (N,) of places (N,) from all performers [m]."""
        spot = np.stack([(z - self.corner[1]) / self.cell, (x - self.corner[0]) / self.cell])
        found = map_coordinates(
            self.distances.astype(np.float32), spot, order=1, mode="constant", cval=255.0
        )
        return np.asarray(found * self.UNIT, float)

    def is_covered(self, x: Array, z: Array) -> NDArray[np.bool_]:
        """Return which places (N,) something stays on all the time."""
        spot = np.stack([(z - self.corner[1]) / self.cell, (x - self.corner[0]) / self.cell])
        found = map_coordinates(self.covered.astype(np.uint8), spot, order=0, mode="constant")
        return np.asarray(found > 0)

    @property
    def extent(self) -> Array:
        """Least and greatest x and z of the places where performers are, (2, 2) [m]."""
        j, i = np.nonzero(self.distances == 0)
        spots = np.array([[i.min(), j.min()], [i.max(), j.max()]], float)
        return np.asarray(self.corner) + self.cell * spots

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the clearings as arrays."""
        return {
            "clearing_grid": np.array([*self.corner, self.cell]),
            "clearing_distances": self.distances,
            "clearing_covered": self.covered.astype(np.uint8),
        }

    @staticmethod
    def of_arrays(arrays: Mapping[str, NDArray[Any]]) -> Clearings | None:
        """Return the clearings that `arrays` wrote, None if there are none.

        Raises:
            KeyError: an array is missing.
        """
        if "clearing_grid" not in arrays:
            return None
        x, z, cell = np.asarray(arrays["clearing_grid"]).tolist()
        covered = np.asarray(arrays["clearing_covered"]).astype(bool)
        return Clearings((x, z), cell, np.asarray(arrays["clearing_distances"]), covered)


def _enclosed(moments: list[Array], low: Array, shape: tuple[int, int], cell: float) -> Mask:
    """Return the cells (rows, columns) that an outline encloses which stays, even if it turns."""
    coarse = max(round(COARSE / cell), 1)
    stays = np.zeros((-(-shape[0] // coarse) + 2, -(-shape[1] // coarse) + 2), np.int32)
    for moment in moments:
        near = moment[moment[:, 2] < UNDER]
        i, j = (((near[:, :2] - low) / cell + 0.5).astype(int) // coarse + 1).T
        here = np.zeros_like(stays)
        here[j, i] = 1
        stays += here
    outline = binary_closing(stays > STAYS * len(moments))
    within = binary_dilation(binary_fill_holes(outline) & ~outline)[1:-1, 1:-1]
    fine = within.repeat(coarse, axis=0).repeat(coarse, axis=1)
    return np.asarray(fine[: shape[0], : shape[1]])


def _outlines(take: Take) -> list[Array]:
    """Return of moments of a take x, z and height (N, 3) of parts, dense enough for outlines."""
    return _low_points(take, max(POINTS, min(ALL_POINTS // len(take.parts), OUTLINE_POINTS)))


def _discs(hearths: Hearths | None, low: Array, shape: tuple[int, int], cell: float) -> Mask:
    """Return the cells (rows, columns) of fires and of the scorched ground around them."""
    covered = np.zeros(shape, bool)
    if hearths is None:
        return covered
    z, x = (np.arange(count) * cell + low[k] for count, k in zip(shape, (1, 0), strict=True))
    for (at_x, at_z), radius in zip(hearths.places, hearths.radii, strict=True):
        covered |= np.hypot(x[None] - at_x, z[:, None] - at_z) < radius + SCORCHED
    return covered


def _low_points(take: Take, each: int) -> list[Array]:
    """Return of moments of a take x, z and height over the ground (N, 3) of parts that are low."""
    parts = visible_parts(take)
    spread = max(POINTS, min(ALL_POINTS // max(len(parts), 1), OUTLINE_POINTS))
    meshes = [_with_points(take.meshes[part.seen], each, spread) for part in parts]
    skin = Skin.of_meshes(take, meshes)
    ground = surface_of_vertices(take.terrain.vertices, take.terrain.cells)
    rows = len(take.positions)
    stride = max(take.header.samples // 2, -(-rows // MAX_MOMENTS))
    result = []
    for row in range(0, rows, stride):
        p = skin.posed(take, float(row)).astype(float)
        height = p[:, 1] - ground.height(p[:, 0], p[:, 2])
        # Parts that are gone are collapsed in the origin.
        is_low = (height < REACH) & (p != 0.0).any(axis=1)
        result.append(np.stack([p[is_low, 0], p[is_low, 2], height[is_low]], axis=-1))
    return result


def _with_points(mesh: Mesh, most: int, spread: int) -> Mesh:
    """Return some vertices of a mesh and points all over its large faces.

    Args:
        mesh: of a part.
        most: vertices, about.
        spread: points over its large faces, about.
    """
    vertices = np.asarray(mesh.vertices, float)
    some = spread_vertices(vertices, most)
    points, owners = [vertices[some]], [some]
    corners = vertices[mesh.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max(axis=1)
    large = np.flatnonzero(longest > LARGE_FACE)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * float(np.linalg.norm(normals[large], axis=-1).sum())
    spacing = max(LEAST_CELL, float(np.sqrt(area / spread)))
    for k in large.tolist():
        count = max(int(longest[k] / spacing), 1)
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
        inside = i + j <= count
        share = np.stack([i[inside], j[inside], (count - i - j)[inside]], axis=-1) / count
        points.append(share @ corners[k])
        owners.append(np.full(len(share), int(mesh.faces[k, 0])))
    every, owner = np.concatenate(points), np.concatenate(owners)
    # Narrow faces, as of bevels, have many in one place.
    _, kept = np.unique(np.round(every / spacing), axis=0, return_index=True)
    return _bare(mesh, every[kept], owner[kept])


def _bare(mesh: Mesh, points: Array, owners: NDArray[np.int64]) -> Mesh:
    """Return a mesh of points (N, 3) that follow the nodes of its vertices `owners` (N,)."""
    return Mesh(points.astype(np.float32), mesh.faces, mesh.nodes[owners], mesh.weights[owners])
