"""Followed: what a cut keeps in the picture, and where that goes.

Who is named is kept, wherever he goes. Where nobody is named all are followed but those who
leave: who goes away to more than `LEAVES` times as far from the rest as is usual when the cut
begins is let go, unless most do. "The rest" is the median of all performers, or the first of
the cast where there are two; what is usual is the median of their distances, or the size of
the largest if that is more. Who is far away but stays there is kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.extreme_points import Outlines
from pipeline.production.camera.path_smoothing import smoothed
from pipeline.simulation.row_storage import row_chunks
from pipeline.simulation.spatial import Array, matrix, normalized
from pipeline.simulation.take import Take

SMOOTHING = 0.45
"""Standard deviation in time of a followed path [s]."""

LEAVES = 4.0
"""How far one goes to be let go, as a factor on how far is usual in the beginning."""

TURNED = 0.25
"""Length of the mean of headings below which they point nowhere in common."""


@dataclass(frozen=True, eq=False)
class Followed:
    """What a cut follows, at F frames.

    Attributes:
        names: of the performers.
        place: (F, 3) its middle, evened out over time [m].
        points: (F, n, 3) between which all of it is [m].
        heading: (3,) in which it goes on the whole, level.
        rate: frames a second.
    """

    names: frozenset[str]
    place: Array
    points: Array
    heading: Array
    rate: float

    @property
    def velocity(self) -> Array:
        """How fast it goes on the level (F, 3), over some seconds [m/s]."""
        if len(self.place) < 2:
            return np.zeros_like(self.place)
        v = np.gradient(self.place, 1.0 / self.rate, axis=0)
        v[:, 1] = 0.0
        return smoothed(v, 2.0 * SMOOTHING * self.rate)

    @property
    def radius(self) -> float:
        """Half of its usual extent [m]."""
        reach = [
            np.linalg.norm(self.points[some] - self.place[some, None], axis=-1).max(axis=-1)
            for some in row_chunks(self.points)
        ]
        return float(np.median(np.concatenate(reach)))


def follow(take: Take, names: str | tuple[str, ...] | None, rows: NDArray[np.int64]) -> Followed:
    """Return the performers called `names`, or all, at the rows of some frames."""
    rate = float(take.header.rate)
    cast = {part.performer for part in take.parts}
    wanted = cast if names is None else {names} if isinstance(names, str) else set(names)
    outlines = Outlines.of(take, lambda part: part.performer in wanted)
    placed = outlines.placed(take, rows)
    if names is None and len(wanted) > 1:
        left = _leavers(placed, outlines.owners)
        if left:
            wanted = wanted - left
            placed = placed[:, [i for i, owner in enumerate(outlines.owners) if owner not in left]]
    points = placed.reshape(len(rows), -1, 3)
    place = smoothed(_middles(points), SMOOTHING * rate)
    for some in row_chunks(points):
        # Who is not there needs no room.
        there = np.isfinite(points[some])
        if not there.all():
            points[some] = np.where(there, points[some], place[some, None])
    return Followed(frozenset(wanted), place, points, _heading(take, wanted, rows), rate)


def _middles(points: Array) -> Array:
    """Return the middles (F, 3) of points (F, n, 3), where there are any, and between."""
    middles = np.concatenate(
        [
            0.5 * (np.fmin.reduce(points[some], axis=1) + np.fmax.reduce(points[some], axis=1))
            for some in row_chunks(points)
        ]
    )
    there = np.isfinite(middles[:, 0])
    if not there.any():
        return np.zeros_like(middles)
    frames = np.arange(len(middles))
    return np.stack([np.interp(frames, frames[there], c[there]) for c in middles.T], axis=-1)


def _leavers(points: Array, owners: tuple[str, ...]) -> set[str]:
    """Return who leaves, of those whose outlines have `points` (F, P, n, 3)."""
    cast = list(dict.fromkeys(owners))
    own = np.array([cast.index(owner) for owner in owners])
    paths = np.stack(
        [_middles(points[:, own == k].reshape(len(points), -1, 3)) for k in range(len(cast))],
        axis=1,
    )
    middle = np.median(paths, axis=1) if len(cast) > 2 else paths[:, 0]
    away = np.linalg.norm(paths - middle[:, None], axis=-1)
    sizes = np.fmax.reduce(points[0], axis=1) - np.fmin.reduce(points[0], axis=1)
    # Of who is there already.
    size = float(np.fmax.reduce(sizes, axis=None, initial=0.0))
    usual = max(float(np.median(away[0])), size)
    farthest = away.max(axis=0)
    gone = (farthest > LEAVES * usual) & (farthest - away[0] > usual)
    return {cast[k] for k in np.flatnonzero(gone)} if 2 * gone.sum() <= len(cast) else set()


def _heading(take: Take, wanted: set[str], rows: NDArray[np.int64]) -> Array:
    """Return one heading (3,) for a whole cut: a camera that turned with every step would sway."""
    roots = [
        i
        for i, node in enumerate(take.nodes)
        if node.performer in wanted
        and (node.parent < 0 or take.nodes[node.parent].performer != node.performer)
    ]
    ahead = matrix(take.rotations[np.ix_(rows, np.array(roots))])[..., 0]
    for mean in (ahead.mean(axis=(0, 1)), ahead[0].mean(axis=0), ahead[0, 0]):
        mean = mean * [1.0, 0.0, 1.0]
        if np.linalg.norm(mean) > TURNED:
            return normalized(mean)
    return np.array([1.0, 0.0, 0.0])
