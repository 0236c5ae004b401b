"""Track: a cart track or footpath over a meadow, along the ways of the cast or past the cast.

A long way is a cart track of two ruts with grass between them. Elsewhere a footpath goes by, from
the cameras into the depth of the picture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.production.scenery.clearings import Clearings
from pipeline.production.surroundings.lattice_noise import fractal, smoothstep
from pipeline.simulation.spatial import Array

LEAST = 5.0
"""Length of the ground that a cast uses from which a track is there [m]."""

LONG = 3.0
"""Length of that ground relative to its width from which a cast goes along the track."""

ASIDE_DEG = 24.0
"""Angle of a footpath to the view [degrees]."""

GAUGE = 0.72
"""Distance of a rut from the middle of a cart track [m]."""

RUT, PATH = (0.12, 0.42), (0.08, 0.52)
"""Distances from the middle of a rut or footpath up to which it is bare, and from which nothing
is [m]."""

STRIP = 0.35
"""Share of bare soil on the strip between two ruts."""

BEND, SWING = 24.0, 5.0
"""Size of the bends of a track, and how far it swings aside [m]."""


@dataclass(frozen=True)
class Track:
    """One track.

    Attributes:
        middle: x and z of a place on it [m].
        heading: about along which it goes there [rad].
        straight: distance from the middle over which it is straight [m].
        has_ruts: whether it is a cart track.
        seed: of its bends.
    """

    middle: tuple[float, float]
    heading: float
    straight: float
    has_ruts: bool
    seed: int

    @staticmethod
    def of(clearings: Clearings | None, ahead: Array, seed: int) -> Track | None:
        """Return the track of a cast, None where it stays on little ground.

        Args:
            clearings: of the cast.
            ahead: (2,) x and z of the direction in which the film looks.
            seed: of the scene.
        """
        if clearings is None:
            return None
        j, i = np.nonzero(clearings.distances == 0)
        spots = np.asarray(clearings.corner) + clearings.cell * np.stack([i, j], axis=-1)
        middle = 0.5 * (spots.min(axis=0) + spots.max(axis=0))
        if np.ptp(spots, axis=0).max() < LEAST:
            return None
        _, _, ways = np.linalg.svd(spots - spots.mean(axis=0), full_matrices=False)
        sizes = np.ptp((spots - spots.mean(axis=0)) @ ways.T, axis=0)
        has_ruts = bool(sizes[0] > LONG * sizes[1])
        if has_ruts:
            way, middle = ways[0], spots.mean(axis=0)
        else:
            turn = np.radians(ASIDE_DEG if seed % 2 else -ASIDE_DEG)
            c, s = np.cos(turn), np.sin(turn)
            way = np.array([[c, -s], [s, c]]) @ ahead
        heading = float(np.arctan2(way[1], way[0]))
        straight = 0.5 * float(sizes[0]) if has_ruts else 0.0
        return Track((float(middle[0]), float(middle[1])), heading, straight, has_ruts, seed)

    def bare(self, places: Array, uneven: Array) -> Array:
        """Return the share (N,) of bare soil at places (N, 2) [m], frayed by noise (N,)."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        x, z = (places - np.asarray(self.middle)).T
        along, aside = c * x + s * z, c * z - s * x
        beyond = np.maximum(np.abs(along) - self.straight, 0.0)
        at = np.stack([along / BEND, np.zeros_like(along)], axis=-1)
        bend = fractal(at, self.seed + 4190, 2) * smoothstep(0.0, BEND, beyond)
        apart = np.abs(aside - SWING * bend)
        if not self.has_ruts:
            return np.asarray(0.9 - 0.9 * smoothstep(*PATH, apart + 0.1 * uneven))
        ruts = 1.0 - smoothstep(*RUT, np.abs(apart - GAUGE) + 0.06 * uneven)
        strip = STRIP * (apart < GAUGE) * smoothstep(-0.4, 0.6, uneven)
        return np.asarray(np.maximum(ruts, strip))
