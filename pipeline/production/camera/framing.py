"""Framing: a camera that finds its own place, so that who is followed is well in the picture.

It looks at the middle of its performers, smoothed over time in both directions, so that it
neither lags nor shares their bounce. Where it is not told its distance it stands so far that
they are in the picture at every frame, and it goes back slowly where they spread apart. Who
moves across the picture has more room ahead than behind.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pipeline.production.camera.camera_path import Seen
from pipeline.production.camera.camera_target import SMOOTHING, Followed
from pipeline.production.camera.clearance import Surroundings
from pipeline.production.camera.lead_room import ahead_of
from pipeline.production.camera.moves import Moves
from pipeline.production.camera.path_smoothing import envelope, smoothed
from pipeline.simulation.curves import hinge
from pipeline.simulation.row_storage import row_chunks
from pipeline.simulation.spatial import UP, Array
from render.config import Camera

MARGIN = 1.12
"""Room left around performers, as a factor on their extent."""

FITTINGS = 12
"""How often the distance is corrected at most until performers are in the picture."""

FITTED = 1e-3
"""Correction, as a part of the distance, after which it is not corrected again."""

SLOWNESS = 0.8
"""Standard deviation in time of a distance that grows with what is followed [s]."""

FLATTEST = 0.4
"""Least part of the distance that a camera on a crane stands away on the level."""

NEAREST = 0.05
"""Least distance from what is followed [m]."""


@dataclass(frozen=True, eq=False)
class Framing:
    """A cut whose camera finds its own place.

    Attributes:
        cut: its words.
        followed: what it keeps in view.
        target: (F, 3) what it looks at, before any lead [m].
        moves: how it goes about that.
        around: what it keeps clear of.
        aspect: width by height of the picture.
        fov_deg: (F,) vertical field of view, before any zoom [degrees].
    """

    cut: Camera
    followed: Followed
    target: Array
    moves: Moves
    around: Surroundings
    aspect: float
    fov_deg: Array

    def seen(self) -> Seen:
        """Return where the camera is, with its distance as told or as chosen."""
        if self.moves.distance is not None:
            return self._stand(self._outside(self.moves.distance - self.moves.nearer))
        away = np.ones(len(self.target))
        for _ in range(FITTINGS):
            before, away = away, self._even(self._fitting(away))
            if np.abs(away / before - 1.0).max() < FITTED:
                break
        return self._stand(away)

    def _outside(self, distance: Array) -> Array:
        """Return a distance (F,) at which the camera is not in what it follows."""
        if self.moves.height is not None:
            return np.maximum(distance, NEAREST)
        towards = np.cos(self.moves.elevation)[:, None] * self.moves.level
        towards = towards + np.sin(self.moves.elevation)[:, None] * UP
        nearest = np.empty(len(distance))
        for some in row_chunks(self.followed.points):
            relative = self.followed.points[some] - self.target[some, None]
            nearest[some] = np.einsum("fnk,fk->fn", relative, towards[some]).max(axis=-1)
        least = max(float(nearest.max()), 0.0) + NEAREST
        result: Array = least + hinge(distance - least, NEAREST)
        return result

    def _even(self, needed: Array) -> Array:
        """Return a distance (F,) that changes smoothly, as a dolly asks, and is never too short."""
        rate, nearer = self.followed.rate, self.moves.nearer
        if nearer.any():
            # Its own motion alone: what is needed changes nothing in it.
            result: Array = (needed + nearer).max() - nearer
            return result
        return envelope(needed, SLOWNESS * rate)

    def _fitting(self, distance: Array) -> Array:
        """Return the distance (F,) at which all is in the picture, judged from another one."""
        seen = self._stand(distance)
        # Judged on what is seen, because a camera that is raised over a hill looks down more
        # steeply than it was asked to.
        factor = _too_near(self.followed.points, seen, self.aspect)
        # What is chosen is its distance without the crane, whose height is given: the other
        # sides of a triangle with the distance that is needed.
        risen, slope = self._risen, np.sin(self._elevation)
        away = factor * np.sqrt(distance * (distance + 2.0 * risen * slope) + risen**2)
        flat = np.sqrt(np.maximum(away**2 - (risen * np.cos(self._elevation)) ** 2, 0.0))
        return np.maximum(flat - risen * slope, FLATTEST * away)

    def _stand(self, distance: Array) -> Seen:
        """Return a camera that stands at `distance` (F,) from its target."""
        moves = self.moves
        if self.cut.view == "top":
            up = np.tile(self.followed.heading, (len(distance), 1))
            offset = distance[:, None] * UP
            seen = Seen(self.target + offset, self.target, up, self._zoomed(distance))
            return self._leading(seen)
        rise = distance * np.sin(self._elevation) + self._risen
        back = distance * np.cos(self._elevation)
        offset = back[:, None] * moves.level + moves.aside[:, None] * moves.across
        offset = offset + rise[:, None] * UP
        up = np.tile(UP, (len(distance), 1))
        seen = Seen(self.target + offset, self.target, up, self._zoomed(distance))
        return self.around.cleared(self._leading(seen))

    def _leading(self, seen: Seen) -> Seen:
        """Return a camera moved so that there is room ahead of who goes across the picture."""
        if self.cut.look_at is not None:
            return seen
        shift = ahead_of(self.followed.velocity, seen, self.cut.lead, self.aspect)
        return replace(seen, eye=seen.eye + shift, target=seen.target + shift)

    def _zoomed(self, distance: Array) -> Array:
        if not self.moves.zoom:
            return self.fov_deg
        half = np.tan(np.radians(self.fov_deg) / 2.0) * distance[0] / distance
        zoomed: Array = np.degrees(2.0 * np.arctan(half)).clip(1.0, 150.0)
        return zoomed

    @cached_property
    def _risen(self) -> Array:
        """How high a crane is over where its camera would be (F,) [m]."""
        if self.moves.height is None:
            return self.moves.risen
        sigma = SMOOTHING * self.followed.rate
        below = smoothed(self.around.ground.height(self.target)[:, None], sigma)[:, 0]
        risen: Array = self.moves.height + below - self.target[:, 1]
        return risen

    @property
    def _elevation(self) -> Array:
        """Of the camera without a crane (F,) [rad]."""
        given = self.moves.height is not None
        return np.zeros_like(self.moves.elevation) if given else self.moves.elevation


def _too_near(points: Array, seen: Seen, aspect: float) -> Array:
    """Return by which factor (F,) a camera has to stand back to have `points` (F, n, 3) in view.

    Less than one where it may come nearer.
    """
    ahead, right, upward = seen.axes
    away = np.linalg.norm(seen.target - seen.eye, axis=-1)
    tan = seen.tangent[:, None]
    most = np.empty(len(away))
    for some in row_chunks(points):
        relative = points[some] - seen.target[some, None]
        wide = np.abs(np.einsum("fnk,fk->fn", relative, right[some])) / (tan[some] * aspect)
        high = np.abs(np.einsum("fnk,fk->fn", relative, upward[some])) / tan[some]
        # What stands nearer to the camera than its target needs that much more distance.
        needed = MARGIN * np.maximum(wide, high)
        needed -= np.einsum("fnk,fk->fn", relative, ahead[some])
        most[some] = needed.max(axis=-1) / away[some]
    return most.clip(0.1, 1e6)
