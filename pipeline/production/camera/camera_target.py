"""Camera target: the performers that a cut follows, and their path.

Named performers are always followed. Without names all are followed, except those that leave:
a performer is dropped when its distance from the rest exceeds `LEAVING_FACTOR` times the usual
distance at the start of the cut, unless most do. "The rest" is the median of all performers, or
the first of the cast if there are two; the usual distance is the median of their distances, or
the size of the largest if that is more. A performer that stays far away is kept.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.camera_path import smoothed
from pipeline.simulation.row_storage import allocate_rows, row_chunks
from pipeline.simulation.spatial import Array, matrix, normalized
from pipeline.simulation.take import UNSEEN, Mesh, Part, Take

TARGET_SMOOTHING_S = 0.45
"""Standard deviation of the filter of a target's path [s]."""

LEAVING_FACTOR = 4.0
"""Distance at which a performer is dropped, relative to the usual distance at the start."""

MIN_MEAN_HEADING = 0.25
"""Length of the mean of headings below which they have no common direction."""


DIRECTIONS: Array = np.array([v for v in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(v)])
"""Directions of the extreme vertices: to the faces, edges and corners of a cube.

They include all corners of a box, and a ball exceeds them by at most a tenth.
"""


@dataclass(frozen=True, eq=False)
class ExtremePoints:
    """Extreme points of P parts as they are seen, or of the pieces that follow different nodes.

    Attributes:
        nodes: (P,) that they follow.
        points: (P, 26, 3) relative to their nodes [m].
        owners: performer of each.
    """

    nodes: NDArray[np.int64]
    points: Array
    owners: tuple[str, ...]

    @staticmethod
    def of(take: Take, wanted: Callable[[Part], bool]) -> ExtremePoints:
        """Return the extreme points of the visible parts that satisfy `wanted`."""
        found = [
            (node, points, part.performer)
            for part in take.parts
            if part.seen != UNSEEN and wanted(part)
            for node, points in _extreme_points(take, take.meshes[part.seen])
        ]
        return ExtremePoints(
            np.array([node for node, _, _ in found], dtype=np.int64),
            np.array([points for _, points, _ in found]).reshape(-1, len(DIRECTIONS), 3),
            tuple(owner for _, _, owner in found),
        )

    def placed(self, take: Take, rows: NDArray[np.int64]) -> Array:
        """Return the points (F, P, 26, 3) in the world, NaN while not alive [m]."""
        scaled = [
            (j, take.scaled.index(n)) for j, n in enumerate(self.nodes) if n in set(take.scaled)
        ]
        points_W: Array = allocate_rows((len(rows), *self.points.shape), float)
        for some in row_chunks(points_W):
            which = np.ix_(rows[some], self.nodes)
            R, p = matrix(take.rotations[which]), take.positions[which]
            for j, n in scaled:
                R[:, j] *= take.scales[rows[some], n][:, None]
            points_W[some] = np.einsum("fpij,pcj->fpci", R, self.points) + p[:, :, None]
            points_W[some][~take.alive[which]] = np.nan
        return points_W


def _extreme_points(take: Take, mesh: Mesh) -> list[tuple[int, Array]]:
    """Return the extreme points (26, 3) of each piece of a mesh, relative to the node it follows.

    A vertex that follows two nodes belongs to the one with the greater weight.
    """
    rows = np.arange(len(mesh.nodes))
    nodes = mesh.nodes[rows, mesh.weights.argmax(axis=1)]
    extremes = []
    for node in np.unique(nodes):
        vertices = mesh.vertices[nodes == node].astype(float)
        outer = [int((vertices * direction).sum(axis=1).argmax()) for direction in DIRECTIONS]
        extremes.append((int(node), vertices[outer] - take.nodes[int(node)].rest))
    return extremes


@dataclass(frozen=True, eq=False)
class CameraTarget:
    """The performers that a cut follows, at F frames.

    Attributes:
        names: of the performers.
        place: (F, 3) centre, smoothed over time [m].
        points: (F, n, 3) extreme points [m].
        heading: (3,) mean level heading.
        rate: frames per second.
    """

    names: frozenset[str]
    place: Array
    points: Array
    heading: Array
    rate: float

    @property
    def velocity(self) -> Array:
        """Level velocity (F, 3), smoothed over some seconds [m/s]."""
        if len(self.place) < 2:
            return np.zeros_like(self.place)
        v = np.gradient(self.place, 1.0 / self.rate, axis=0)
        v[:, 1] = 0.0
        return smoothed(v, 2.0 * TARGET_SMOOTHING_S * self.rate)

    @property
    def radius(self) -> float:
        """Median radius [m]."""
        reach = [
            np.linalg.norm(self.points[some] - self.place[some, None], axis=-1).max(axis=-1)
            for some in row_chunks(self.points)
        ]
        return float(np.median(np.concatenate(reach)))


def follow(
    take: Take, names: str | tuple[str, ...] | None, rows: NDArray[np.int64]
) -> CameraTarget:
    """Return the performers called `names`, or all, at rows of the take."""
    rate = float(take.header.rate)
    cast = {part.performer for part in take.parts}
    wanted = cast if names is None else {names} if isinstance(names, str) else set(names)
    extremes = ExtremePoints.of(take, lambda part: part.performer in wanted)
    placed = extremes.placed(take, rows)
    if names is None and len(wanted) > 1:
        left = _leaving(placed, extremes.owners)
        if left:
            wanted = wanted - left
            placed = placed[:, [i for i, owner in enumerate(extremes.owners) if owner not in left]]
    points = placed.reshape(len(rows), -1, 3)
    place = smoothed(_centers(points), TARGET_SMOOTHING_S * rate)
    for some in row_chunks(points):
        # Performers that are not alive need no room.
        there = np.isfinite(points[some])
        if not there.all():
            points[some] = np.where(there, points[some], place[some, None])
    return CameraTarget(frozenset(wanted), place, points, _heading(take, wanted, rows), rate)


def _centers(points: Array) -> Array:
    """Return the centres (F, 3) of points (F, n, 3), interpolated where there are none."""
    centers = np.concatenate(
        [
            0.5 * (np.fmin.reduce(points[some], axis=1) + np.fmax.reduce(points[some], axis=1))
            for some in row_chunks(points)
        ]
    )
    there = np.isfinite(centers[:, 0])
    if not there.any():
        return np.zeros_like(centers)
    frames = np.arange(len(centers))
    return np.stack([np.interp(frames, frames[there], c[there]) for c in centers.T], axis=-1)


def _leaving(points: Array, owners: tuple[str, ...]) -> set[str]:
    """Return the performers that leave, by their extreme points (F, P, n, 3)."""
    cast = list(dict.fromkeys(owners))
    own = np.array([cast.index(owner) for owner in owners])
    paths = np.stack(
        [_centers(points[:, own == k].reshape(len(points), -1, 3)) for k in range(len(cast))],
        axis=1,
    )
    middle = np.median(paths, axis=1) if len(cast) > 2 else paths[:, 0]
    away = np.linalg.norm(paths - middle[:, None], axis=-1)
    sizes = np.fmax.reduce(points[0], axis=1) - np.fmin.reduce(points[0], axis=1)
    # Only of performers that are alive.
    size = float(np.fmax.reduce(sizes, axis=None, initial=0.0))
    usual = max(float(np.median(away[0])), size)
    farthest = away.max(axis=0)
    gone = (farthest > LEAVING_FACTOR * usual) & (farthest - away[0] > usual)
    return {cast[k] for k in np.flatnonzero(gone)} if 2 * gone.sum() <= len(cast) else set()


def _heading(take: Take, wanted: set[str], rows: NDArray[np.int64]) -> Array:
    """Return one heading (3,) for a whole cut; following each step, the camera would sway."""
    roots = [
        i
        for i, node in enumerate(take.nodes)
        if node.performer in wanted
        and (node.parent < 0 or take.nodes[node.parent].performer != node.performer)
    ]
    ahead = matrix(take.rotations[np.ix_(rows, np.array(roots))])[..., 0]
    for mean in (ahead.mean(axis=(0, 1)), ahead[0].mean(axis=0), ahead[0, 0]):
        mean = mean * [1.0, 0.0, 1.0]
        if np.linalg.norm(mean) > MIN_MEAN_HEADING:
            return normalized(mean)
    return np.array([1.0, 0.0, 0.0])
