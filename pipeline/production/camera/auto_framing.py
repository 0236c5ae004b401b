"""Automatic framing: a camera that keeps its target in the frame, with lead room.

It looks at the centre of the target, smoothed over time in both directions, so that it neither
lags nor bounces. Without a given distance it stands where the target fits into every frame, and
moves back slowly where performers spread. A target that moves across the frame has more room
ahead than behind.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pipeline.production.camera.camera_path import CameraPath, envelope, smoothed
from pipeline.production.camera.camera_target import TARGET_SMOOTHING_S, CameraTarget
from pipeline.production.camera.clearance import Clearance
from pipeline.production.camera.moves import CameraMoves
from pipeline.simulation.curves import bounded, hinge
from pipeline.simulation.row_storage import row_chunks
from pipeline.simulation.spatial import UP, Array
from render.config import Camera

LEAD_ROOM = 0.1
"""Offset of a moving target from the centre, as a fraction of the frame."""

LEAD_SPEED = 0.12
"""Speed at which that offset is nearly reached [frame widths or heights per second]."""


@dataclass(frozen=True, slots=True)
class _DistanceFit:
    """Search of the distance at which the target fits into the frame.

    Attributes:
        margin: room around the target, as a factor on its extent.
        max_iterations: corrections of the distance.
        tolerance: relative correction at which the iteration ends.
        smoothing_s: standard deviation of the filter of the distance [s].
        min_level_share: least level share of the distance of a camera on a crane.
        least: distance from the target [m].
    """

    margin: float = 1.12
    max_iterations: int = 12
    tolerance: float = 1e-3
    smoothing_s: float = 0.8
    min_level_share: float = 0.4
    least: float = 0.05


FIT = _DistanceFit()


@dataclass(frozen=True, eq=False)
class AutoFraming:
    """A cut whose camera frames automatically.

    Attributes:
        cut: its configuration.
        followed: what it keeps in the frame.
        target: (F, 3) what it looks at, before lead room [m].
        moves: orbit, dolly, truck and crane.
        clearance: from ground and obstacles.
        aspect: width by height of the frame.
        fov_deg: (F,) vertical field of view, before any zoom [degrees].
    """

    cut: Camera
    followed: CameraTarget
    target: Array
    moves: CameraMoves
    clearance: Clearance
    aspect: float
    fov_deg: Array

    def path(self) -> CameraPath:
        """Return the path at the given distance, or at the one that fits."""
        if self.moves.distance is not None:
            return self._stand(self._outside(self.moves.distance - self.moves.nearer))
        away = np.ones(len(self.target))
        for _ in range(FIT.max_iterations):
            before, away = away, self._smooth(self._fitting(away))
            if np.abs(away / before - 1.0).max() < FIT.tolerance:
                break
        return self._stand(away)

    def _outside(self, distance: Array) -> Array:
        """Return a distance (F,) at which the camera is outside the target."""
        if self.moves.height is not None:
            return np.maximum(distance, FIT.least)
        towards = np.cos(self.moves.elevation)[:, None] * self.moves.level
        towards = towards + np.sin(self.moves.elevation)[:, None] * UP
        nearest = np.empty(len(distance))
        for some in row_chunks(self.followed.points):
            relative = self.followed.points[some] - self.target[some, None]
            nearest[some] = np.einsum("fnk,fk->fn", relative, towards[some]).max(axis=-1)
        least = max(float(nearest.max()), 0.0) + FIT.least
        return least + hinge(distance - least, FIT.least)

    def _smooth(self, needed: Array) -> Array:
        """Return a smooth distance (F,) that is nowhere less than needed."""
        rate, nearer = self.followed.rate, self.moves.nearer
        if nearer.any():
            # Keeps the motion of the dolly: the needed distance only offsets it.
            return (needed + nearer).max() - nearer
        return envelope(needed, FIT.smoothing_s * rate)

    def _fitting(self, distance: Array) -> Array:
        """Return the distance (F,) at which the target fits, estimated from another one."""
        path = self._stand(distance)
        # From the actual path, because a camera raised over a hill looks down more steeply.
        factor = _fit_factor(self.followed.points, path, self.aspect)
        # The distance without the crane, whose height is given, from the triangle with the
        # needed distance.
        risen, slope = self._risen, np.sin(self._elevation)
        away = factor * np.sqrt(distance * (distance + 2.0 * risen * slope) + risen**2)
        flat = np.sqrt(np.maximum(away**2 - (risen * np.cos(self._elevation)) ** 2, 0.0))
        return np.maximum(flat - risen * slope, FIT.min_level_share * away)

    def _stand(self, distance: Array) -> CameraPath:
        """Return the path at a distance (F,) from the target."""
        moves = self.moves
        if self.cut.view == "top":
            up = np.tile(self.followed.heading, (len(distance), 1))
            offset = distance[:, None] * UP
            path = CameraPath(self.target + offset, self.target, up, self._zoomed(distance))
            return self._with_lead(path)
        rise = distance * np.sin(self._elevation) + self._risen
        back = distance * np.cos(self._elevation)
        offset = back[:, None] * moves.level + moves.aside[:, None] * moves.across
        offset = offset + rise[:, None] * UP
        up = np.tile(UP, (len(distance), 1))
        path = CameraPath(self.target + offset, self.target, up, self._zoomed(distance))
        return self.clearance.cleared(self._with_lead(path))

    def _with_lead(self, path: CameraPath) -> CameraPath:
        """Return the path shifted by the lead room."""
        if self.cut.look_at is not None:
            return path
        shift = lead_offset(self.followed.velocity, path, self.cut.lead, self.aspect)
        return replace(path, eye=path.eye + shift, target=path.target + shift)

    def _zoomed(self, distance: Array) -> Array:
        if not self.moves.zoom:
            return self.fov_deg
        half = np.tan(np.radians(self.fov_deg) / 2.0) * distance[0] / distance
        return np.degrees(2.0 * np.arctan(half)).clip(1.0, 150.0)

    @cached_property
    def _risen(self) -> Array:
        """Height of the crane over the camera without it (F,) [m]."""
        if self.moves.height is None:
            return self.moves.risen
        sigma = TARGET_SMOOTHING_S * self.followed.rate
        below = smoothed(self.clearance.ground.height(self.target)[:, None], sigma)[:, 0]
        return self.moves.height + below - self.target[:, 1]

    @property
    def _elevation(self) -> Array:
        """Elevation of the camera without a crane (F,) [rad]."""
        given = self.moves.height is not None
        return np.zeros_like(self.moves.elevation) if given else self.moves.elevation


def _fit_factor(points: Array, path: CameraPath, aspect: float) -> Array:
    """Return the factor (F,) on the distance at which `points` (F, n, 3) just fit."""
    ahead, right, upward = path.axes
    away = np.linalg.norm(path.target - path.eye, axis=-1)
    tan = path.tangent[:, None]
    most = np.empty(len(away))
    for some in row_chunks(points):
        relative = points[some] - path.target[some, None]
        wide = np.abs(np.einsum("fnk,fk->fn", relative, right[some])) / (tan[some] * aspect)
        high = np.abs(np.einsum("fnk,fk->fn", relative, upward[some])) / tan[some]
        # A point nearer to the camera than the target needs that much more distance.
        needed = FIT.margin * np.maximum(wide, high)
        needed -= np.einsum("fnk,fk->fn", relative, ahead[some])
        most[some] = needed.max(axis=-1) / away[some]
    return most.clip(0.1, 1e6)


def lead_offset(velocity: Array, path: CameraPath, lead: float | None, aspect: float) -> Array:
    """Return the offset (F, 3) of the camera's target for lead room [m].

    It lies in the image plane along the projected motion and grows with its speed: a still
    target is centred.

    Args:
        velocity: (F, 3) of the target [m/s].
        path: of the camera, without lead room.
        lead: fraction of the frame; None for `LEAD_ROOM`.
        aspect: width by height of the frame.
    """
    _, right, upward = path.axes
    high = 2.0 * path.tangent * np.linalg.norm(path.target - path.eye, axis=-1)
    across = np.einsum("fk,fk->f", velocity, right) / (high * aspect)
    along = np.einsum("fk,fk->f", velocity, upward) / high
    speed = np.hypot(across, along) / LEAD_SPEED
    slope = np.divide(bounded(speed), speed, out=np.ones_like(speed), where=speed > 1e-9)
    part = (LEAD_ROOM if lead is None else lead) / LEAD_SPEED * slope
    sideways = (part * across * high * aspect)[:, None] * right
    return sideways + (part * along * high)[:, None] * upward
