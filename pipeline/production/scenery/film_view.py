"""Film view: what the cameras of a film see, and from how near."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pipeline.simulation.spatial import Array
from render.shot import CameraPose

MAX_POSES = 120
"""Poses of a film that are looked at."""

MARGIN_DEG = 4.0
"""Beyond the edge of the frame [degrees]: shutters and lenses see a little more."""

AROUND = 7.0
"""Distance within which all is kept, seen or not, because it casts shadows [m]."""

SIGHT_RADIUS = 0.3
"""Radius around the line of sight to the target that is kept free [m]."""

FEET = 0.05
"""Height over the ground down to which a target is to be seen past shrubs and stones [m]."""

BESIDE = 0.7
"""How much wider at the target the sight past shrubs and stones is [m]."""

TALLEST = 0.25
"""By how much shrubs may be higher than their species are as a rule [m]."""

MAX_STEP = 15.0
"""Longest step between two poses that adds to the way; longer ones are cuts [m]."""

CHUNK = 1 << 21
"""Pairs of places and poses that are looked at together."""

UNDERFOOT = 0.06
"""Usual height up to which a plant may stand before a target [m]: moss and the like, without which
the ground would show bare there."""


@dataclass(frozen=True, eq=False)
class FilmView:
    """Poses of the cameras of a film.

    Attributes:
        eyes: (P, 3) [m].
        targets: (P, 3) [m].
        axes: (P, 3, 3) unit vectors to the right, up and ahead, as rows.
        half: (P, 2) angles from the middle of the frame to its sides and to its top [rad].
    """

    eyes: Array
    targets: Array
    axes: Array
    half: Array

    @staticmethod
    def of(poses: Sequence[CameraPose], aspect: float) -> FilmView:
        """Return the view of a film by its poses and the width of its frame by the height."""
        some = poses[:: -(-len(poses) // MAX_POSES)]
        eyes = np.array([pose.p_WC for pose in some], float)
        targets = np.array([pose.p_WT for pose in some], float)
        axes = np.array([pose.axes for pose in some], float)
        half = np.tan(np.radians([pose.fov_deg for pose in some]) / 2.0)
        return FilmView(eyes, targets, axes, np.arctan(half[:, None] * [aspect, 1.0]))

    @property
    def ahead(self) -> Array:
        """Unit vectors (P, 3) from the eyes to their targets."""
        return np.asarray(self.axes[:, 2])

    @cached_property
    def angles(self) -> Array:
        """Angles (P,) from there to beyond the corners of the frame [rad]."""
        corner = np.arctan(np.linalg.norm(np.tan(self.half), axis=-1))
        return np.asarray(corner + np.radians(MARGIN_DEG))

    def sees(self, points: Array, radii: Array) -> NDArray[np.bool_]:
        """Return which things (N,) any camera has in its frame, or nearly so.

        Args:
            points: (N, 3) their middles [m].
            radii: (N,) [m].
        """
        result = np.zeros(len(points), bool)
        half = self.half + np.radians(MARGIN_DEG)
        sine, cosine = np.sin(half), np.cos(half)
        step = max(CHUNK // len(self.eyes), 1)
        for start in range(0, len(points), step):
            part = slice(start, start + step)
            way = points[part, None] - self.eyes[None]
            aside, up, ahead = (np.einsum("npk,pk->np", way, self.axes[:, k]) for k in range(3))
            aside, up = np.abs(aside), np.abs(up)
            radius = radii[part, None]
            inside = aside * cosine[:, 0] - ahead * sine[:, 0] < radius
            inside &= up * cosine[:, 1] - ahead * sine[:, 1] < radius
            result[part] = (inside & (ahead > -radius)).any(axis=1)
        return result

    @property
    def path_length(self) -> float:
        """Length of the way of the cameras over the ground, cuts left out [m]."""
        steps = np.linalg.norm(np.diff(self.eyes[:, [0, 2]], axis=0), axis=-1)
        return float(steps[steps < MAX_STEP].sum())

    def tile_distances(self, centers: Array, radii: Array, around: float = AROUND) -> Array:
        """Return how near (T,) tiles come to a camera that sees them; infinite where none does.

        Args:
            centers: (T, 3) [m].
            radii: (T,) [m].
            around: distance within which tiles count as seen [m].
        """
        result = np.full(len(centers), np.inf)
        step = max(CHUNK // len(self.eyes), 1)
        for start in range(0, len(centers), step):
            part = slice(start, start + step)
            way = centers[part, None] - self.eyes[None]
            distance = np.linalg.norm(way, axis=-1)
            near = np.maximum(distance - radii[part, None], 0.0)
            cosine = (way * self.ahead).sum(axis=-1) / np.maximum(distance, 1e-9)
            apart = np.arccos(np.clip(cosine, -1.0, 1.0))
            wide = np.arcsin(np.clip(radii[part, None] / np.maximum(distance, 1e-9), 0.0, 1.0))
            seen = (apart < self.angles + wide) | (near < around)
            result[part] = np.where(seen, near, np.inf).min(axis=1)
        return result

    def distances(self, points: Array) -> Array:
        """Return the distances (N,) of points (N, 3) from the nearest camera [m]."""
        return np.asarray(cKDTree(self.eyes).query(points, workers=1)[0])

    def in_the_way(
        self,
        points: Array,
        heights: Array,
        radii: Array,
        *,
        hides: bool = False,
        grows: bool = False,
    ) -> NDArray[np.bool_]:
        """Return which things (N,) would stand before a camera's target.

        Args:
            points: (N, 3) feet of the things [m].
            heights: (N,) [m].
            radii: (N,) [m].
            hides: whether they must not stand before the feet of the target, either.
            grows: whether they are plants, of which low ones stand in nobody's way.
        """
        result = np.zeros(len(points), bool)
        far = float(np.linalg.norm(self.targets - self.eyes, axis=-1).max())
        close = np.flatnonzero(self.distances(points) < far + radii + heights)
        lines = self.targets - self.eyes
        flat = lines[:, [0, 2]]
        squares = np.maximum((flat * flat).sum(axis=-1), 1e-9)
        step = max(CHUNK // len(self.eyes), 1)
        for start in range(0, len(close), step):
            some = close[start : start + step]
            way = points[some, None][..., [0, 2]] - self.eyes[None][..., [0, 2]]
            t = np.clip((way * flat).sum(axis=-1) / squares, 0.0, 0.95)
            apart = np.linalg.norm(way - t[..., None] * flat, axis=-1)
            sight = self.eyes[:, 1] + t * lines[:, 1]
            top = (points[some, 1] + heights[some])[:, None]
            if hides:
                ground = points[some, 1][:, None] + FEET
                sight = np.minimum(sight, ground + (1.0 - t) * (self.eyes[:, 1] - ground)) - TALLEST
            free = SIGHT_RADIUS + (BESIDE * t if hides else 0.0)
            blocks = (apart < radii[some, None] + free) & (top > sight - 0.1)
            if grows:
                blocks &= (heights[some] > UNDERFOOT)[:, None]
            # Nothing may touch the lens, from whichever side.
            eye = np.abs(0.5 * (points[some, 1][:, None] + top) - self.eyes[:, 1])
            lens = (np.hypot(np.linalg.norm(way, axis=-1), eye)) < 0.3 + np.hypot(
                radii[some], 0.5 * heights[some]
            )[:, None]
            result[some] = (blocks | lens).any(axis=1)
        return result

    def in_the_foreground(
        self, points: Array, heights: Array, radii: Array, share: float
    ) -> NDArray[np.bool_]:
        """Return which things (N,) a frame would show nearer than its target.

        Args:
            points: (N, 3) feet of the things [m].
            heights: (N,) [m].
            radii: (N,) [m].
            share: of the distance to the target up to which they are nearer.
        """
        middle = points + np.array([0.0, 0.5, 0.0]) * heights[:, None]
        size = np.hypot(radii, 0.5 * heights)
        result = np.zeros(len(points), bool)
        depth = np.linalg.norm(self.targets - self.eyes, axis=-1)
        step = max(CHUNK // len(self.eyes), 1)
        for start in range(0, len(points), step):
            part = slice(start, start + step)
            way = middle[part, None] - self.eyes[None]
            distance = np.linalg.norm(way, axis=-1)
            along = (way * self.ahead).sum(axis=-1)
            apart = np.arccos(np.clip(along / np.maximum(distance, 1e-9), -1.0, 1.0))
            wide = np.arcsin(np.clip(size[part, None] / np.maximum(distance, 1e-9), 0.0, 1.0))
            seen = apart < self.angles + wide
            result[part] = (seen & (along - size[part, None] < share * depth)).any(axis=1)
        return result
