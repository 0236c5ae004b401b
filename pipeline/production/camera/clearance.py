"""Clearance: keeps a camera above the ground, out of bodies, and in sight of its target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.camera_path import CameraPath, envelope
from pipeline.production.camera.camera_target import TARGET_SMOOTHING_S, CameraTarget, ExtremePoints
from pipeline.production.surroundings.land import Land
from pipeline.production.surroundings.rings import NEAR_GROWTH
from pipeline.simulation.row_storage import row_chunks
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take

MIN_HEIGHT = 0.03
"""Least height of any camera over the ground; beyond the near clipping plane [m]."""

GROUND_CLEARANCE = 0.12
"""Height of an automatic camera over the ground, relative to its distance."""

OBSTACLE_SIZE = 0.6
"""Extent from which a body can hide the target, relative to the target's radius."""

MAX_RISE = 1.2
"""Greatest rise to see over an obstacle, relative to the distance; higher ones are ignored."""


class VisibleGround:
    """The visible ground: the terrain, and the land around it."""

    def __init__(self, land: Land) -> None:
        self._land = land

    def height(self, places: Array) -> Array:
        """Return the height (...) of the ground at `places` (..., 3) [m].

        Outside the terrain, where triangles are wide, it is that of the highest place around.
        """
        x, z = places[..., 0], places[..., 2]
        near = self._land.field
        result = near.height(x, z)
        outside = ~near.inside(x, z)
        if outside.any():
            result = np.array(result)
            result[outside] = self._land_height(x[outside], z[outside])
        return result

    def _land_height(self, x: Array, z: Array) -> Array:
        g = np.stack(self._land.field.to_grid(x, z), axis=-1)
        step = 0.5 * NEAR_GROWTH * self._land.beyond(g)[:, None]
        around = [g + step * way for way in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))]
        return np.max([self._land.height_in_grid(p) for p in around], axis=0)

    def cleared(self, path: CameraPath, rate: float, *, with_target: bool) -> CameraPath:
        """Return the path of an author's camera raised above the ground.

        Args:
            path: of the camera.
            rate: frames per second.
            with_target: whether the target rises with the eye.
        """
        lift = self.height(path.eye) + MIN_HEIGHT - path.eye[:, 1]
        if lift.max() <= 0.0:
            return path
        smooth = envelope(np.maximum(lift, 0.0), TARGET_SMOOTHING_S * rate)
        return path.raised(smooth, with_target=with_target)


@dataclass(frozen=True, eq=False)
class Clearance:
    """Ground and obstacles around the target of a camera.

    Attributes:
        ground: below all.
        low: (F, P, 3) lower corners of the boxes of obstacles [m].
        high: (F, P, 3) upper corners [m].
        still: (P,) whether each stands still.
        rate: frames per second.
    """

    ground: VisibleGround
    low: Array
    high: Array
    still: NDArray[np.bool_]
    rate: float

    @staticmethod
    def of(
        take: Take, ground: VisibleGround, target: CameraTarget, rows: NDArray[np.int64]
    ) -> Clearance:
        """Return ground and obstacles around `target` at rows of the take."""
        extremes = ExtremePoints.of(take, lambda part: part.performer not in target.names)
        placed = extremes.placed(take, rows)
        if not placed.size:
            none = np.zeros((len(rows), 0, 3))
            return Clearance(ground, none, none, np.zeros(0, bool), target.rate)
        low = np.concatenate([placed[some].min(axis=2) for some in row_chunks(placed)])
        high = np.concatenate([placed[some].max(axis=2) for some in row_chunks(placed)])
        there = np.isfinite(low).all(axis=(0, 2))
        width = (high - low)[:, there][..., [0, 2]].mean(axis=(0, 2))
        big = np.flatnonzero(there)[width > OBSTACLE_SIZE * target.radius]
        still = (np.ptp(low[:, big], axis=0) < 1e-3).all(axis=-1)
        return Clearance(ground, low[:, big], high[:, big], still, target.rate)

    def cleared(self, path: CameraPath) -> CameraPath:
        """Return the path raised above the ground, out of obstacles and over those in its sight."""
        distance = np.linalg.norm(path.target - path.eye, axis=-1)
        lift = np.maximum.reduce(
            [
                self._rise_over_ground(path, distance),
                self._rise_out_of_obstacles(path),
                self._rise_over_obstacles(path, distance),
            ]
        )
        if not lift.any():
            return path
        return path.raised(envelope(lift, TARGET_SMOOTHING_S * self.rate))

    def _rise_over_ground(self, path: CameraPath, distance: Array) -> Array:
        least = np.zeros(len(distance))
        for part in np.linspace(0.0, 0.75, 16):
            # The line of sight at this fraction of the way from the eye to the target.
            p = path.eye + part * (path.target - path.eye)
            room = GROUND_CLEARANCE * distance * (1.0 - part)
            needed = self.ground.height(p) + room - p[:, 1]
            least = np.maximum(least, needed / (1.0 - part))
        return least

    def _rise_out_of_obstacles(self, path: CameraPath) -> Array:
        eye = path.eye[:, None]
        inside = ((eye > self.low - MIN_HEIGHT) & (eye < self.high + MIN_HEIGHT)).all(axis=-1)
        rise = np.where(inside, self.high[..., 1] + 2.0 * MIN_HEIGHT - eye[..., 1], 0.0)
        return rise.max(axis=-1, initial=0.0)

    def _rise_over_obstacles(self, path: CameraPath, distance: Array) -> Array:
        """Return the rise (F,) to see over still obstacles."""
        low, high = self.low[:, self.still], self.high[:, self.still]
        eye, way = path.eye[:, None], (path.target - path.eye)[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = (low - eye) / way, (high - eye) / way
        near, far = np.fmin(a, b)[..., [0, 2]], np.fmax(a, b)[..., [0, 2]]
        first = near.max(axis=-1).clip(0.0)
        last = far.min(axis=-1)
        # No rise clears an obstacle that encloses or covers the target.
        crossed = (first < last) & (last < 0.95)
        ends = np.stack([first, last], axis=-1).clip(0.0, 0.95)
        line = eye[..., 1:2] + ends * way[..., 1:2]
        hides = crossed & (line.min(axis=-1) < high[..., 1]) & (line.max(axis=-1) > low[..., 1])
        needed = ((high[..., 1:2] + MIN_HEIGHT - line) / (1.0 - ends)).max(axis=-1)
        # Decided over the whole cut, so that the camera does not start to climb and give up.
        worst = np.where(hides, needed / distance[:, None], 0.0).max(axis=0)
        rise = np.where(hides & (worst < MAX_RISE), needed, 0.0)
        return rise.max(axis=-1, initial=0.0)
