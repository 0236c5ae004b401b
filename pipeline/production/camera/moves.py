"""Camera moves: progress of orbit, dolly, truck and crane at every frame of a cut."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.curves import ease
from pipeline.simulation.spatial import UP, Array, rotation, turn
from render.config import Camera, View
from render.config.camera_moves import Crane, Dolly, MoveEase, Orbit, Truck

VIEW_ANGLES: dict[View, tuple[float, float]] = {
    "three-quarter": (38.0, 10.0),
    "side": (90.0, 9.0),
    "front": (0.0, 10.0),
    "back": (180.0, 18.0),
    "top": (0.0, 89.0),
}
"""Azimuth from the heading, positive to the right, and elevation of each view [degrees]."""

ORBIT_SPEED_DEG = 12.0
"""Default speed of an orbit [degrees/s]."""

VIEW_ELEVATION_DEG = 10.0
"""Elevation of a view by angle [degrees]."""

MAX_ELEVATION = math.radians(85.0)
"""Highest elevation of an orbit; straight above, the frame has no upward direction [rad]."""


def view_angles(view: View | float | None) -> tuple[float, float]:
    """Return azimuth and elevation of a view by name or by angle [degrees]."""
    if isinstance(view, float | int):
        return float(view), VIEW_ELEVATION_DEG
    return VIEW_ANGLES[view or "three-quarter"]


@dataclass(frozen=True, eq=False)
class CameraMoves:
    """Motion of a camera relative to its target at F frames.

    Attributes:
        level: (F, 3) level direction from the target to the camera.
        across: (F, 3) direction to the right of the camera.
        elevation: (F,) of the camera [rad].
        distance: (F,) given distance [m]; None for an automatic one.
        nearer: (F,) displacement of the dolly towards the target [m].
        aside: (F,) displacement of the truck to the right [m].
        risen: (F,) displacement of the crane upward [m].
        height: (F,) over the ground below the target [m], instead of an elevation, or None.
        zoom: whether the field of view compensates the dolly.
    """

    level: Array
    across: Array
    elevation: Array
    distance: Array | None
    nearer: Array
    aside: Array
    risen: Array
    height: Array | None
    zoom: bool

    @staticmethod
    def of(cut: Camera, heading: Array, since: Array, seconds: float) -> CameraMoves:
        """Return the moves of a cut.

        Args:
            cut: its configuration.
            heading: (3,) of the target.
            since: (F,) time since its start [s].
            seconds: its duration [s].
        """
        azimuth, elevation = (math.radians(angle) for angle in view_angles(cut.view))
        if cut.elevation_deg is not None:
            elevation = math.radians(cut.elevation_deg)
        turned, risen = _orbit(cut.orbit, since, seconds)
        # Headings and orbits turn to the left about +Y, the azimuth of a view to the right.
        level = turn(rotation(UP, turned - azimuth), np.tile(heading, (len(since), 1)))
        raised = elevation + risen
        ends, nearer = _linear_move(cut.dolly, since, seconds)
        if ends is None and cut.distance is not None:
            ends = np.full(len(since), cut.distance)
        aside, trucked = _linear_move(cut.truck, since, seconds)
        height, craned = _linear_move(cut.crane, since, seconds)
        return CameraMoves(
            level=level,
            across=np.cross(UP, level),
            elevation=raised if cut.orbit is None else raised.clip(-MAX_ELEVATION, MAX_ELEVATION),
            distance=ends,
            nearer=nearer,
            aside=trucked if aside is None else aside,
            risen=craned,
            height=height,
            zoom=cut.dolly is not None and cut.dolly.zoom,
        )

    def turned(self, angle: float) -> CameraMoves:
        """Return the moves turned about the vertical through the target by an angle [rad]."""
        R = rotation(UP, angle)
        return replace(self, level=self.level @ R.T, across=self.across @ R.T)


def _orbit(orbit: Orbit | None, since: Array, seconds: float) -> tuple[Array, Array]:
    """Return azimuth and elevation of an orbit (F,) [rad]."""
    if orbit is None:
        return np.zeros_like(since), np.zeros_like(since)
    if orbit.from_deg is not None and orbit.to_deg is not None:
        s = _progress(orbit.ease or "in-out", since, seconds)
        turned = orbit.from_deg + s * (orbit.to_deg - orbit.from_deg)
    else:
        s = _progress(orbit.ease or "linear", since, seconds)
        turned = s * seconds * (ORBIT_SPEED_DEG if orbit.speed_deg is None else orbit.speed_deg)
    return np.radians(turned), np.radians(s * orbit.rise_deg)


def _linear_move(
    move: Dolly | Truck | Crane | None, since: Array, seconds: float
) -> tuple[Array | None, Array]:
    """Return the value of a move between two ends (F,) or None, and its displacement by speed."""
    if move is None:
        return None, np.zeros_like(since)
    if move.start is not None and move.end is not None:
        s = _progress(move.ease or "in-out", since, seconds)
        return move.start + s * (move.end - move.start), np.zeros_like(since)
    return None, _progress(move.ease or "linear", since, seconds) * seconds * (move.speed or 0.0)


def _progress(kind: MoveEase, since: Array, seconds: float) -> Array:
    """Return the progress of a move (F,): 0 at the start of the cut, 1 at its end."""
    s = np.clip(since / seconds, 0.0, 1.0)
    if kind == "in-out":
        return ease(s)
    if kind == "linear":
        return s
    # Halves of the in-out curve.
    return 2.0 * ease(0.5 * s) if kind == "in" else 2.0 * ease(0.5 + 0.5 * s) - 1.0
