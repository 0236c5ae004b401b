"""Floor plan: which part of a level terrain is floor, around all that the cast comes near."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.scenery.clearings import Clearings
from pipeline.production.surroundings.lattice_noise import fractal, hashed
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import TerrainRecord

MARGIN, MARGIN_OF_EXTENT = 1.9, 0.2
"""Floor around the cast [m], and relative to the extent of the places where it goes."""

LEAST_MARGIN, MOST_MARGIN = 2.5, 5.0

IN_ROOM, BEHIND_CAMERA = 1.7, 0.6
"""Floor of a room around cast and cameras [m]."""

NEAR = 0.9
"""Distance from the cast within which the floor is whole [m]."""

BROKEN = 1.7
"""Rows of slabs at the border that may be missing."""

LEVEL = 1e-6
"""Differences of height up to which a terrain is level [m]."""


@dataclass(frozen=True, eq=False)
class FloorPlan:
    """The floor of a level terrain, as a rectangle in the world of which pieces may be missing.

    Attributes:
        low: x and z of its first corner [m].
        high: x and z of the opposite one [m].
        ground: corners of the terrain, (2, 2) [m].
        height: of the floor [m].
        piece: side of a slab [m].
        kept: (rows along z, columns along x) slabs that are there.
        whole: of the same shape, slabs near the cast, which lie as they were laid.
        clearings: of the cast.
    """

    low: Array
    high: Array
    ground: Array
    height: float
    piece: float
    kept: NDArray[np.bool_]
    whole: NDArray[np.bool_]
    clearings: Clearings

    @staticmethod
    def of(
        terrain: TerrainRecord,
        clearings: Clearings | None,
        piece: float,
        seed: int,
        *,
        is_broken: bool,
        around: Array | None = None,
        wider: float = 0.0,
    ) -> FloorPlan | None:
        """Return the plan of a level floor along the axes of the world, None of any other.

        Args:
            terrain: of the take.
            clearings: of the cast, None without one.
            piece: side of a slab [m].
            seed: of the scene.
            is_broken: whether slabs at the border are missing.
            around: (N, 2) places that a room must have in it, None out of doors.
            wider: floor besides that around the cast out of doors [m].
        """
        flat, height = terrain.vertices[:, [0, 2]], terrain.vertices[:, 1]
        first = flat[1] - flat[0]
        if clearings is None or np.ptp(height) > LEVEL or abs(first[1]) > LEVEL or first[0] < 0:
            return None
        ground = np.array([flat.min(axis=0), flat.max(axis=0)], float)
        used = clearings.extent
        margin = np.clip(
            MARGIN + MARGIN_OF_EXTENT * (used[1] - used[0]).max(), LEAST_MARGIN, MOST_MARGIN
        )
        margin += wider
        if around is not None:
            used = np.array(
                [
                    np.minimum(used[0] - IN_ROOM, around.min(axis=0) - BEHIND_CAMERA),
                    np.maximum(used[1] + IN_ROOM, around.max(axis=0) + BEHIND_CAMERA),
                ]
            )
            margin = 0.0
        # Whole pieces, within the terrain.
        first_piece = np.maximum(
            np.floor((used[0] - margin) / piece), np.ceil(ground[0] / piece - 1e-6)
        )
        last_piece = np.minimum(
            np.ceil((used[1] + margin) / piece), np.floor(ground[1] / piece + 1e-6)
        )
        if (last_piece - first_piece < 3).any():
            return None
        low, high = first_piece * piece, last_piece * piece
        columns, rows = (last_piece - first_piece).astype(int)
        x = low[0] + piece * (np.arange(columns) + 0.5)
        z = low[1] + piece * (np.arange(rows) + 0.5)
        places = np.stack(np.meshgrid(x, z), axis=-1)
        near = clearings.distance(places[..., 0].ravel(), places[..., 1].ravel())
        near = near.reshape(rows, columns)
        whole = near < NEAR + 0.71 * piece
        kept = np.ones((rows, columns), bool)
        if is_broken:
            inward = np.minimum(places - low, high - places).min(axis=-1) / piece
            i, j = np.rint(places / piece - 0.5).astype(np.int32).transpose(2, 0, 1)
            chance = hashed(i, j, seed + 411) + 0.7 * fractal(places / 4.1, seed + 412, 3)
            kept = (inward > BROKEN * np.clip(chance, 0.0, 1.3)) | whole
        return FloorPlan(low, high, ground, float(height[0]), piece, kept, whole, clearings)

    @staticmethod
    def of_all(terrain: TerrainRecord, clearings: Clearings, piece: float) -> FloorPlan:
        """Return the plan of a terrain all of which is floor."""
        flat = terrain.vertices[:, [0, 2]]
        ground = np.array([flat.min(axis=0), flat.max(axis=0)], float)
        columns, rows = np.maximum(np.ceil((ground[1] - ground[0]) / piece).astype(int), 1)
        whole = np.ones((rows, columns), bool)
        low = float(terrain.vertices[:, 1].min())
        return FloorPlan(ground[0], ground[1], ground, low, piece, whole, whole, clearings)

    def beyond(self, places: Array) -> Array:
        """Return the distance (N,) of places (N, 2) from the rectangle [m], negative inside."""
        out = np.maximum(self.low - places, places - self.high)
        outside = np.hypot(*np.maximum(out, 0.0).T)
        return np.asarray(outside + np.minimum(out.max(axis=-1), 0.0))

    def has_piece(self, places: Array) -> NDArray[np.bool_]:
        """Return on which places (N, 2) a piece of the floor lies."""
        i, j = np.floor((places - self.low) / self.piece).astype(int).T
        rows, columns = self.kept.shape
        inside = (i >= 0) & (j >= 0) & (i < columns) & (j < rows)
        result = np.zeros(len(places), bool)
        result[inside] = self.kept[j[inside], i[inside]]
        return result

    def free(self, places: Array) -> Array:
        """Return the distances (N,) of places (N, 2) from the cast [m]."""
        return self.clearings.distance(places[:, 0], places[:, 1])
