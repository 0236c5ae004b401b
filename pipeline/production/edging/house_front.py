"""House front: the walls and panes of a house that are seen from the street, as cells with colours.

What weather leaves on plaster and what is behind panes both vary over a facade, so its sides are
subdivided and their vertices coloured.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.production.edging.carpentry import subdivide_sides
from pipeline.simulation.spatial import Array
from render.shot import Mesh


@dataclass(frozen=True, eq=False)
class Front:
    """The walls of a house that are exposed to rain.

    Attributes:
        place: middle of the foot of its facade, x and z [m].
        heading: of it [rad].
        size: width, depth, and height of the wall over its foot [m].
        foot: height of the ground before its door, about [m].
        sills: (N, 3) middles of sills along the facade, their heights over its foot, and their
            widths [m].
        panes: (N, 4) middles along, heights of the lower edges, widths and heights [m].
    """

    place: Array
    heading: float
    size: tuple[float, float, float]
    foot: float
    sills: list[tuple[float, float, float]] = field(default_factory=list)
    panes: list[tuple[float, float, float, float]] = field(default_factory=list)

    def local(self, points: Array) -> Array:
        """Return points (N, 3) along, over the foot of, and before the facade [m]."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        x, z = points[:, 0] - self.place[0], points[:, 2] - self.place[1]
        return np.column_stack([c * x - s * z, points[:, 1] - self.foot, s * x + c * z])

    def shows(self, local: Array) -> Array:
        """Return whether points (N, 3) of its own frame are on its facade or its gable walls."""
        wide, deep, _ = self.size
        along, before = np.abs(local[:, 0]), local[:, 2]
        is_aside = (along > 0.5 * wide - 0.05) & (before > 0.05 - deep)
        is_facade = before > -0.3
        # The next house begins where this one ends.
        return np.asarray((is_aside | is_facade) & (along < 0.5 * wide + 0.01) & (before < 0.3))

    @property
    def key(self) -> tuple[int, int]:
        """Numbers by which it is told from its neighbours."""
        x, z = (np.rint(100.0 * self.place).astype(int) & 65535).tolist()
        return x, z


def covered(
    mesh: Mesh, fronts: Sequence[Front], cell: float, color: Callable[[Front, Array], Array]
) -> Mesh:
    """Return a mesh with a cover that each front gives to its points (N, 3), as (N, 4)."""
    middles = mesh.vertices.reshape(-1, 4, 3).mean(axis=1).astype(float)
    is_seen = np.zeros(len(middles), bool)
    for front in fronts:
        is_seen |= front.shows(front.local(middles))
    mesh = subdivide_sides(mesh, cell, is_seen)
    cover = np.zeros((len(mesh.vertices), 4), np.float32)
    points = mesh.vertices.astype(float)
    for front in fronts:
        local = front.local(points)
        own = np.flatnonzero(front.shows(local))
        if len(own):
            cover[own] = color(front, local[own])
    return replace(mesh, cover=cover)
