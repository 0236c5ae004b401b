"""Performer tracks: where the performers of a take are, how large and how lively, over time."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.camera_path import smoothed
from pipeline.production.camera.camera_target import ExtremePoints
from pipeline.simulation.row_storage import row_chunks
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take

SAMPLE_RATE = 12.0
"""Samples of the tracks a second."""

SMOOTHING_S = 0.15
"""Standard deviation of the filter of speeds, which takes out single steps [s]."""

STILL = 0.06
"""Speed below which a performer is still, relative to its radius [1/s]."""

LEAST_MOTION = 0.3
"""Displacement from which a body without joints acts, relative to its radius."""


@dataclass(frozen=True, eq=False)
class PerformerTracks:
    """P performers at S times.

    Attributes:
        names: of the performers.
        times: (S,) since the start of the film [s].
        centers: (S, P, 3) [m], NaN while they are not alive.
        velocities: (S, P, 3), smoothed [m/s].
        heights: (S, P) of their highest node over their lowest [m].
        activities: (S, P) mean speed of their nodes [m/s]; of many bodies, times the root of their
            number, by which they together are larger than one.
        motions: (P,) greatest displacement of a node, times the root of their number [m].
        radii: (P,) [m].
        jointed: (P,) whether each has joints.
        counts: (P,) nodes of each.
    """

    names: tuple[str, ...]
    times: Array
    centers: Array
    velocities: Array
    heights: Array
    activities: Array
    motions: Array
    radii: Array
    jointed: NDArray[np.bool_]
    counts: NDArray[np.int64]

    @staticmethod
    def of(take: Take) -> PerformerTracks:
        """Return the tracks of all performers that are visible in a take."""
        header = take.header
        names = tuple(dict.fromkeys(part.performer for part in take.parts))
        step = max(1, round(float(header.rate * header.samples) / SAMPLE_RATE))
        rows = np.arange(0, header.frames * header.samples, step)
        times = rows / float(header.rate * header.samples)
        shape = (len(rows), len(names))
        centers, heights = np.full((*shape, 3), np.nan), np.zeros(shape)
        activities, motions = np.zeros(shape), np.zeros(len(names))
        jointed = np.zeros(len(names), dtype=bool)
        counts = np.zeros(len(names), dtype=np.int64)
        for k, name in enumerate(names):
            own = np.array([i for i, n in enumerate(take.nodes) if n.performer == name], dtype=int)
            counts[k] = len(own)
            # The links of creatures hang on one another, those of people on their pelvis.
            jointed[k] = any(
                take.nodes[i].name == f"{name}.pelvis"
                or (
                    take.nodes[i].parent >= 0 and take.nodes[take.nodes[i].parent].performer == name
                )
                for i in own
            )
            places = np.array(take.positions[np.ix_(rows, own)], dtype=float)
            places[~take.alive[np.ix_(rows, own)]] = np.nan
            low, high = np.fmin.reduce(places, axis=1), np.fmax.reduce(places, axis=1)
            centers[:, k] = 0.5 * (low + high)
            heights[:, k] = np.nan_to_num(high[:, 1] - low[:, 1])
            span = np.nan_to_num(np.fmax.reduce(places, axis=0) - np.fmin.reduce(places, axis=0))
            motions[k] = np.linalg.norm(span, axis=-1).max(initial=0.0) * math.sqrt(len(own))
            if len(rows) > 1:
                speeds = np.linalg.norm(np.gradient(places, times, axis=0), axis=-1)
                activities[:, k] = np.nan_to_num(speeds).mean(axis=1)
                if not jointed[k]:
                    activities[:, k] *= math.sqrt(len(own))
        return PerformerTracks(
            names,
            times,
            centers,
            _velocities(centers, times),
            heights,
            activities,
            motions,
            _radii(take, names),
            jointed,
            counts,
        )

    def number(self, name: str) -> int:
        """Return the number of a performer."""
        return self.names.index(name)

    def actors(self) -> tuple[str, ...]:
        """Return the performers that act: those with joints, and bodies that move."""
        moved = self.motions > LEAST_MOTION * self.radii
        lively = moved | (self.activities > STILL * self.radii).any(axis=0) | self.jointed
        return tuple(name for name, acts in zip(self.names, lively, strict=True) if acts)

    def center(self, name: str, time: float) -> Array:
        """Return where a performer is at a time (3,) [m]."""
        return np.asarray(self.centers[self._sample(time), self.number(name)])

    def velocity(self, name: str, time: float) -> Array:
        """Return the velocity of a performer at a time (3,) [m/s]."""
        return np.asarray(self.velocities[self._sample(time), self.number(name)])

    def distance(self, one: str, other: str) -> Array:
        """Return the distance of the surfaces of two performers, taken as balls (S,) [m]."""
        a, b = self.number(one), self.number(other)
        apart = np.linalg.norm(self.centers[:, a] - self.centers[:, b], axis=-1)
        return np.asarray(apart - self.radii[a] - self.radii[b])

    def activity(self, name: str, start: float, end: float) -> float:
        """Return how lively a performer is between two times, relative to its radius [1/s]."""
        there = (self.times >= start) & (self.times <= end)
        k = self.number(name)
        return float(self.activities[there, k].mean() / self.radii[k]) if there.any() else 0.0

    def still_from(self, names: Collection[str]) -> float:
        """Return the time from which none of some performers moves any more [s]."""
        # Flames and flocks never rest; where somebody has joints, these tell the story.
        numbers = [self.number(name) for name in names]
        told = [k for k in numbers if self.jointed[k]] or numbers
        lively = (self.activities[:, told] > STILL * self.radii[told]).any(axis=1)
        moving = np.flatnonzero(lively)
        return float(self.times[moving[-1]]) if moving.size else 0.0

    def _sample(self, time: float) -> int:
        return int(np.abs(self.times - time).argmin())


def _velocities(centers: Array, times: Array) -> Array:
    result = np.zeros_like(centers)
    if len(times) < 2:
        return result
    sigma = SMOOTHING_S / (times[1] - times[0])
    for k in range(centers.shape[1]):
        there = np.isfinite(centers[:, k, 0])
        if there.sum() > 1:
            path = np.stack(
                [np.interp(times, times[there], c[there]) for c in centers[:, k].T], axis=-1
            )
            result[:, k] = smoothed(np.gradient(path, times, axis=0), sigma)
    return result


def _radii(take: Take, names: tuple[str, ...]) -> Array:
    """Return the median of half the diagonals of the boxes of performers (P,) [m]."""
    last = len(take.positions) - 1
    rows = np.unique(np.linspace(0, last, 5).round().astype(np.int64))
    extremes = ExtremePoints.of(take, lambda part: True)
    placed = extremes.placed(take, rows)
    radii = np.full(len(names), 1e-3)
    for k, name in enumerate(names):
        own = [i for i, owner in enumerate(extremes.owners) if owner == name]
        points = placed[:, own].reshape(len(rows), -1, 3)
        sizes = np.concatenate(
            [
                np.fmax.reduce(points[some], axis=1) - np.fmin.reduce(points[some], axis=1)
                for some in row_chunks(points)
            ]
        )
        there = np.isfinite(sizes).all(axis=-1)
        if there.any():
            radii[k] = max(1e-3, 0.5 * float(np.median(np.linalg.norm(sizes[there], axis=-1))))
    return radii
