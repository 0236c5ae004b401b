"""Surroundings: what limbs keep clear of, the ground and solids whose motion is known.

The distance of a point from a solid is that from the outermost of its tangent planes in fixed
directions, where planes that are nearly as far count too: inside and outside it is smooth, so that
limbs that are pushed away move smoothly.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, normalized, turn, turn_inverse
from pipeline.simulation.terrain import Ground

GROUND = "ground"
"""Name of the terrain among the things to avoid."""

RING = 24
"""Directions of the planes around each solid's y axis."""

ROUNDING = 0.01
"""Radius over which the edges of a solid are rounded, in its size."""


GROUND_REACH = 2.0
"""Height above the ground, in its reach, below which a point may come near a slope beside it."""


def _directions() -> Array:
    """Return unit vectors (d, 3): along axes and diagonals, and around y."""
    corners = np.array([v for v in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(v)])
    angles = np.arange(RING) * (2.0 * np.pi / RING)
    ring = np.stack([np.sin(angles), np.zeros(RING), np.cos(angles)], axis=-1)
    unit = corners / np.linalg.norm(corners, axis=-1, keepdims=True)
    return np.unique(np.round(np.concatenate([unit, ring]), 12), axis=0)


DIRECTIONS = _directions()


@dataclass(frozen=True, eq=False)
class MovingSolid:
    """A convex solid whose pose is known at all times.

    Attributes:
        name: of the member.
        support: (d,) how far it extends along `DIRECTIONS`, in its own frame [m].
        size: of its longest extent [m].
        pose_at: position (n, 3) [m] and rotation (n, 3, 3) in the world at times (n,) [s].
    """

    name: str
    support: Array
    size: float
    pose_at: Callable[[Array], tuple[Array, Array]]

    @staticmethod
    def of(
        name: str, corners: Array, pose_at: Callable[[Array], tuple[Array, Array]]
    ) -> MovingSolid:
        """Return the solid with these corners (v, 3), relative to its own frame [m]."""
        support = (corners @ DIRECTIONS.T).max(axis=0)
        return MovingSolid(name, support, float(np.ptp(corners, axis=0).max()), pose_at)

    def gaps(self, times: Array, points: Array) -> tuple[Array, Array]:
        """Return the distances (n, m) of points (n, m, 3) [m], and directions away (n, m, 3)."""
        p, R = self.pose_at(times)
        x = turn_inverse(R[:, None], points - p[:, None])
        beyond = x @ DIRECTIONS.T - self.support
        most = beyond.max(axis=-1, keepdims=True)
        share = np.exp((beyond - most) / (ROUNDING * self.size))
        share /= share.sum(axis=-1, keepdims=True)
        away = turn(R[:, None], share @ DIRECTIONS)
        length = np.linalg.norm(away, axis=-1, keepdims=True)
        return most[..., 0], away / np.maximum(length, 1e-9)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """The ground, if it is to be avoided, and solids.

    Attributes:
        ground: None where it does not matter.
        solids: that do not bear the limbs.
    """

    ground: Ground | None
    solids: Sequence[MovingSolid] = ()

    def only(self, names: Collection[str]) -> Surroundings:
        """Return those that are named, `GROUND` among them."""
        solids = tuple(solid for solid in self.solids if solid.name in names)
        return Surroundings(self.ground if GROUND in names else None, solids)

    def near(self, times: Array, places: Array, reach: float) -> Surroundings:
        """Return what comes within `reach` of places (n, 3) [m]."""
        ground = self.ground
        if ground is not None:
            # A slope may come nearer than what is straight below.
            gap = places[:, 1] - ground.height(places[:, 0], places[:, 2])
            ground = ground if float(gap.min()) < 1.5 * reach else None
        solids = [
            solid
            for solid in self.solids
            if float(np.linalg.norm(places - solid.pose_at(times)[0], axis=-1).min())
            < reach + solid.size
        ]
        return Surroundings(ground, tuple(solids))

    def within(self, times: Array, places: Array, reach: Array) -> NDArray[np.bool_]:
        """Return whether anything comes within `reach` (l,) of places (n, l, 3) [m], (n, l)."""
        near = np.zeros(places.shape[:2], dtype=bool)
        if self.ground is not None:
            height = self.ground.height(places[..., 0], places[..., 2])
            near |= places[..., 1] - height < GROUND_REACH * reach
        for solid in self.solids:
            p, _ = solid.pose_at(times)
            near |= np.linalg.norm(places - p[:, None], axis=-1) < reach + solid.size
        return near

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to avoid."""
        return self.ground is None and not self.solids

    def gaps(self, times: Array, points: Array) -> tuple[Array, Array]:
        """Return distances (n, o, m) of points (n, m, 3) [m], and directions away (n, o, m, 3)."""
        found = [solid.gaps(times, points) for solid in self.solids]
        if self.ground is not None:
            height, normal = self.ground.surface(points[..., 0], points[..., 2])
            # Up a wall leads out sooner than away from it, and high above one is not near it.
            upward = normalized(normal + np.array([0.0, 1.0, 0.0]))
            found.append(((points[..., 1] - height) * upward[..., 1], upward))
        gap = np.stack([gap for gap, _ in found], axis=1)
        return gap, np.stack([away for _, away in found], axis=1)


@dataclass(frozen=True, eq=False)
class LimbSamples:
    """Points of a limb that keep clear, on its links.

    Attributes:
        columns: (m,) number of the joint, within the limb, that moves each.
        places: (m, 3) in the creation frame [m].
        radii: (m,) of the limb there [m].
    """

    columns: NDArray[np.int64]
    places: Array
    radii: Array
