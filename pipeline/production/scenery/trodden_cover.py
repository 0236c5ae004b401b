"""Trodden cover: grasses and herbs on which performers tread, which bend from moment to moment.

They are few, and belong to what moves; all else that grows stands still, in an acceleration
structure that is never rebuilt.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.production.scenery.expansion import Copies, copies, gathered_meshes, triangle_counts
from pipeline.production.scenery.placement import Placed
from pipeline.production.scenery.plant_bend import bent, wind_bends
from pipeline.production.scenery.species import KINDS
from pipeline.production.scenery.treads import Treads
from pipeline.simulation.spatial import Array
from render.shot import Mesh

BUDGET = 60_000
"""Triangles of a wide frame that may bend; the nearest to the camera do."""

SPREAD, SPREAD_OF_HEIGHT = 0.5, 0.15
"""Distance beyond a tread over which a plant gives way to foot and leg, as parts of its radius and
its height."""

SEEN = 14.0
"""Distance from the camera up to which bending is seen, in frames 1280 pixels wide [m]."""


def split_trodden(
    every: Sequence[Placed], treads: Treads, detail: float
) -> tuple[list[Placed], list[Placed]]:
    """Return what stands still, and what performers tread on near the camera."""
    chosen = [_trodden(placed, treads, detail) for placed in every]
    counts = [triangle_counts(p.taken(some), detail) for p, some in zip(every, chosen, strict=True)]
    far = np.concatenate(
        [np.zeros(0), *(p.distances[some] for p, some in zip(every, chosen, strict=True))]
    )
    weight = np.concatenate([np.zeros(0, np.int64), *counts])
    order = np.argsort(far, kind="stable")
    within = np.cumsum(weight[order]) <= BUDGET * detail**1.5
    limit = far[order[within]].max() if within.any() else -1.0
    still, trodden = [], []
    for placed, some in zip(every, chosen, strict=True):
        moves = some & (placed.distances <= limit)
        still.append(placed.taken(~moves))
        if moves.any():
            trodden.append(placed.taken(moves))
    return still, trodden


def _trodden(placed: Placed, treads: Treads, detail: float) -> NDArray[np.bool_]:
    """Return which things (N,) of a species are trodden on where it is seen."""
    species = KINDS[placed.name]
    result = np.zeros(len(placed.points), bool)
    if not species.bends:
        return result
    near = np.flatnonzero(placed.distances < SEEN * detail)
    reach = SPREAD * species.radius + SPREAD_OF_HEIGHT * species.height
    widths = np.full(len(near), reach * placed.size * species.sizes[1])
    plants, _ = treads.near(placed.points[near][:, [0, 2]], widths)
    result[near[plants]] = True
    return result


@dataclass(frozen=True, eq=False)
class TroddenCover:
    """N plants that bend.

    Attributes:
        meshes: of the upright plants.
        offsets: (V, 3) of the vertices of each mesh from their roots [m].
        owners: (V,) numbers of the plants, for each mesh.
        points: (N, 3) roots [m].
        tall: (N,) [m].
        plants: (P,) numbers of plants beside treads.
        treads: (P,) numbers of these treads.
        flat: (P, 2) bends of plants that lie flat [rad].
        all_treads: of the take.
        wind: near the ground, along x and z [m/s].
    """

    meshes: tuple[Mesh, ...]
    offsets: tuple[NDArray[np.float32], ...]
    owners: tuple[NDArray[np.int64], ...]
    points: Array
    tall: Array
    plants: NDArray[np.int64]
    treads: NDArray[np.int64]
    flat: Array
    all_treads: Treads
    wind: tuple[float, float]

    @staticmethod
    def of(
        trodden: Sequence[Placed], treads: Treads, wind: tuple[float, float], detail: float
    ) -> TroddenCover | None:
        """Return the cover of placed plants that performers tread on, None without any."""
        groups: list[Copies] = [copy for placed in trodden for copy in copies(placed, detail)]
        if not groups:
            return None
        meshes, owners = gathered_meshes([(copy, "scenery solid") for copy in groups])
        points = np.concatenate([copy.points for copy in groups])
        tall = np.concatenate([copy.tall for copy in groups])
        widths = SPREAD * np.concatenate([copy.radii for copy in groups]) + SPREAD_OF_HEIGHT * tall
        plants, numbers = treads.near(points[:, [0, 2]], widths)
        angle = np.concatenate([np.arctan2(c.turns[:, 2, 0], c.turns[:, 0, 0]) for c in groups])
        aside = np.stack([np.cos(angle), np.sin(angle)], axis=-1)[plants]
        flat = treads.bends(points[plants][:, [0, 2]], numbers, widths[plants], aside)
        roots = points.astype(np.float32)
        return TroddenCover(
            tuple(replace(m, name=m.name.replace("scenery", "trodden")) for m in meshes),
            tuple(m.vertices - roots[own] for m, own in zip(meshes, owners, strict=True)),
            tuple(owners),
            *(points, tall, plants, numbers, flat, treads, wind),
        )

    def dressed(self, dress: Callable[[Mesh], Mesh]) -> TroddenCover:
        """Return it with meshes that are changed in colour."""
        return replace(self, meshes=tuple(dress(mesh) for mesh in self.meshes))

    def at(self, row: float) -> tuple[Mesh, ...]:
        """Return its meshes at a row of the take, with fraction."""
        time = row / self.all_treads.rate
        bends = wind_bends(self.points[:, [0, 2]], self.wind, time)
        pressed = self.flat * self.all_treads.pressed(row)[self.treads, None]
        pushed, most = np.zeros_like(bends), np.zeros(len(bends))
        np.add.at(pushed, self.plants, pressed)
        np.maximum.at(most, self.plants, np.linalg.norm(pressed, axis=-1))
        # Between two feet a plant bends as far as the nearer one bends it.
        length = np.maximum(np.linalg.norm(pushed, axis=-1), 1e-9)
        bends += pushed * np.minimum(1.0, most / length)[:, None]
        roots, tall, singles = (a.astype(np.float32) for a in (self.points, self.tall, bends))
        return tuple(
            replace(mesh, vertices=roots[own] + bent(offsets, tall[own], singles[own]))
            for mesh, offsets, own in zip(self.meshes, self.offsets, self.owners, strict=True)
        )
