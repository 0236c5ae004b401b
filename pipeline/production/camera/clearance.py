"""Surroundings: ground and bodies that a camera must not be in, nor behind."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.camera_path import Seen
from pipeline.production.camera.camera_target import SMOOTHING, Followed
from pipeline.production.camera.extreme_points import Outlines
from pipeline.production.camera.path_smoothing import envelope
from pipeline.production.shots.ground_mesh import RINGS, ground_meshes
from pipeline.simulation.row_storage import row_chunks
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take, TerrainRecord
from pipeline.simulation.terrain.heightfield import surface_of_vertices

LEAST = 0.03
"""Least height of any camera over the ground, more than the nearest thing it draws [m]."""

CLEARANCE = 0.12
"""Height over the ground of a camera that frames by itself, as a part of its distance."""

BIG = 0.6
"""Extent from which something can hide what is followed, as a part of its radius."""

STEEP = 1.2
"""How far a camera goes up to see over a thing, as a part of its distance; higher ones it bears."""


class Ground:
    """The ground as it is seen: the terrain, and the far field around it."""

    def __init__(self, terrain: TerrainRecord) -> None:
        self._terrain = terrain
        self._near = surface_of_vertices(terrain.vertices, terrain.cells)

    def height(self, places: Array) -> Array:
        """Return the height (...) of the ground at `places` (..., 3) [m].

        Beyond the terrain that of the highest corner around, for its triangles are wide there.
        """
        x, z = places[..., 0], places[..., 2]
        result = self._near.height(x, z)
        outside = ~self._near.inside(x, z)
        if outside.any():
            result = np.array(result)
            result[outside] = self._beyond(x[outside], z[outside])
        return result

    def _beyond(self, x: Array, z: Array) -> Array:
        rings, reach = self._far
        half = np.array(self._near.size) / 2.0
        g = np.stack(self._near.to_grid(x, z), axis=-1)
        out = (np.abs(g) - half).max(axis=-1)
        # On the ring nearest to the terrain, which all others are grown from.
        rim = g / (1.0 + out[:, None] / half)
        edge = np.stack(self._near.to_grid(rings[0, :, 0], rings[0, :, 2]), axis=-1)
        at = ((rim[:, None] - edge) ** 2).sum(axis=-1).argmin(axis=-1)
        outer = np.searchsorted(reach, out).clip(1, len(reach) - 1)
        around = (at[:, None] + [-1, 0, 1]) % len(edge)
        corners = [rings[ring[:, None], around, 1] for ring in (outer - 1, outer)]
        result: Array = np.maximum(*corners).max(axis=-1)
        return result

    @cached_property
    def _far(self) -> tuple[Array, Array]:
        """The rings (R, n, 3) of the far field, and how far out of the terrain each is (R,) [m]."""
        vertices = ground_meshes(self._terrain)[1].vertices.astype(float)
        rings = vertices.reshape(RINGS + 1, -1, 3)
        x, _ = self._near.to_grid(rings[..., 0], rings[..., 2])
        return rings, np.abs(x).max(axis=-1) - self._near.size[0] / 2.0

    def cleared(self, seen: Seen, rate: float, along: bool) -> Seen:
        """Return a camera of its author's that is nowhere in the ground.

        Args:
            seen: where it was put.
            rate: frames a second.
            along: whether its target goes up with it.
        """
        lift = self.height(seen.eye) + LEAST - seen.eye[:, 1]
        if lift.max() <= 0.0:
            return seen
        return seen.raised(envelope(np.maximum(lift, 0.0), SMOOTHING * rate), along)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What is around somebody who is followed.

    Attributes:
        ground: below all.
        low: (F, P, 3) lower corners of boxes around big things [m].
        high: (F, P, 3) upper corners [m].
        still: (P,) whether each stands still.
        rate: frames a second.
    """

    ground: Ground
    low: Array
    high: Array
    still: NDArray[np.bool_]
    rate: float

    @staticmethod
    def of(take: Take, ground: Ground, followed: Followed, rows: NDArray[np.int64]) -> Surroundings:
        """Return what is around `followed` at some rows."""
        outlines = Outlines.of(take, lambda part: part.performer not in followed.names)
        placed = outlines.placed(take, rows)
        if not placed.size:
            none = np.zeros((len(rows), 0, 3))
            return Surroundings(ground, none, none, np.zeros(0, bool), followed.rate)
        low = np.concatenate([placed[some].min(axis=2) for some in row_chunks(placed)])
        high = np.concatenate([placed[some].max(axis=2) for some in row_chunks(placed)])
        there = np.isfinite(low).all(axis=(0, 2))
        width = (high - low)[:, there][..., [0, 2]].mean(axis=(0, 2))
        big = np.flatnonzero(there)[width > BIG * followed.radius]
        still = (np.ptp(low[:, big], axis=0) < 1e-3).all(axis=-1)
        return Surroundings(ground, low[:, big], high[:, big], still, followed.rate)

    def cleared(self, seen: Seen) -> Seen:
        """Return a camera above the ground and all big things, and above what hides its target."""
        distance = np.linalg.norm(seen.target - seen.eye, axis=-1)
        lift = np.maximum.reduce(
            [self._over_ground(seen, distance), self._out_of(seen), self._over(seen, distance)]
        )
        if not lift.any():
            return seen
        return seen.raised(envelope(lift, SMOOTHING * self.rate))

    def _over_ground(self, seen: Seen, distance: Array) -> Array:
        least = np.zeros(len(distance))
        for part in np.linspace(0.0, 0.75, 16):
            # The line of sight at this part of the way from the eye to the target.
            p = seen.eye + part * (seen.target - seen.eye)
            room = CLEARANCE * distance * (1.0 - part)
            needed = self.ground.height(p) + room - p[:, 1]
            least = np.maximum(least, needed / (1.0 - part))
        return least

    def _out_of(self, seen: Seen) -> Array:
        """Return by how much (F,) the eye must rise to be in nothing."""
        eye = seen.eye[:, None]
        inside = ((eye > self.low - LEAST) & (eye < self.high + LEAST)).all(axis=-1)
        rise = np.where(inside, self.high[..., 1] + 2.0 * LEAST - eye[..., 1], 0.0)
        result: Array = rise.max(axis=-1, initial=0.0)
        return result

    def _over(self, seen: Seen, distance: Array) -> Array:
        """Return by how much (F,) the eye must rise to see over big things that stand still."""
        low, high = self.low[:, self.still], self.high[:, self.still]
        eye, way = seen.eye[:, None], (seen.target - seen.eye)[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = (low - eye) / way, (high - eye) / way
        near, far = np.fmin(a, b)[..., [0, 2]], np.fmax(a, b)[..., [0, 2]]
        first = near.max(axis=-1).clip(0.0)
        last = far.min(axis=-1)
        # What the target is in, or under, cannot be seen over.
        crossed = (first < last) & (last < 0.95)
        ends = np.stack([first, last], axis=-1).clip(0.0, 0.95)
        line = eye[..., 1:2] + ends * way[..., 1:2]
        hides = crossed & (line.min(axis=-1) < high[..., 1]) & (line.max(axis=-1) > low[..., 1])
        needed = ((high[..., 1:2] + LEAST - line) / (1.0 - ends)).max(axis=-1)
        # Summed up over the cut, so that it does not begin to climb and give up.
        worst = np.where(hides, needed / distance[:, None], 0.0).max(axis=0)
        rise = np.where(hides & (worst < STEEP), needed, 0.0)
        result: Array = rise.max(axis=-1, initial=0.0)
        return result
