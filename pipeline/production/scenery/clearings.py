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

from pipeline.production.shots.skinning import Skin
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take
from pipeline.simulation.terrain.heightfield import surface_of_vertices

Mask = NDArray[np.bool_]

REACH = 2.5
"""Height below which a performer's parts keep the ground clear [m]."""

LOW = 0.12
"""Height below which grass stands in the way of what stays there [m]."""

STAYS = 0.5
"""Share of the moments for which something stays where no grass shall be."""

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

POINTS = 40
"""Vertices of a part that are looked at."""

OUTLINE_POINTS, ALL_POINTS = 400, 12_000
"""Most vertices of a part in which outlines are sought, and about how many of all parts."""


@dataclass(frozen=True, eq=False)
class Clearings:
    """Distances from all places where performers are during a take.

    Attributes:
        corner: x and z of the middle of the first cell [m].
        cell: side of a cell [m].
        distances: (rows along z, columns along x) uint8, in units of `UNIT`.
        covered: of the same shape, whether something stays there all the time.
    """

    corner: tuple[float, float]
    cell: float
    distances: NDArray[np.uint8]
    covered: NDArray[np.bool_]

    UNIT = 0.05

    @staticmethod
    def of(take: Take) -> Clearings | None:
        """Return the clearings of a take, None of one without visible performers."""
        if not take.parts:
            return None
        points = _low_points(take, POINTS)
        kept = [p for p in points if len(p)]
        if not kept:
            return None
        every = np.concatenate(kept)
        low, high = every[:, :2].min(axis=0) - BORDER, every[:, :2].max(axis=0) + BORDER
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
        distance = np.minimum(distance_transform_edt(~used) * cell / Clearings.UNIT, 255)
        return Clearings(
            (float(low[0]), float(low[1])),
            cell,
            distance.astype(np.uint8),
            (stays > STAYS * len(points)) | _enclosed(_outlines(take), low, used.shape, cell),
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


def _low_points(take: Take, each: int) -> list[Array]:
    """Return of moments of a take x, z and height over the ground (N, 3) of parts that are low."""
    skin = Skin.of(take).thinned(each)
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
