"""Camera moves: where orbit, dolly, truck and crane have come to at every frame of a cut."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.curves import ease
from pipeline.simulation.spatial import UP, Array, rotation, turn
from render.config import Camera, View
from render.config.camera_moves import Crane, Dolly, MoveEase, Orbit, Truck

VIEWS: dict[View, tuple[float, float]] = {
    "three-quarter": (38.0, 10.0),
    "side": (90.0, 9.0),
    "front": (0.0, 10.0),
    "back": (180.0, 18.0),
    "top": (0.0, 89.0),
}
"""Where a view looks from: azimuth from the heading, to the right, and elevation [degrees]."""

ORBIT_SPEED = 12.0
"""Of an orbit that is not told how fast it turns [degrees/s]."""

HIGHEST = math.radians(85.0)
"""To where an orbit rises: straight above, the picture has no top of its own [rad]."""


@dataclass(frozen=True, eq=False)
class Moves:
    """How the camera of a cut moves about its target, at F frames.

    Attributes:
        level: (F, 3) level direction from the target to the camera.
        across: (F, 3) to the right, as the camera sees it.
        elevation: (F,) of the camera [rad].
        distance: (F,) that the words ask for [m]; None where it is to be chosen.
        nearer: (F,) by how much a dolly has come nearer [m].
        aside: (F,) by how much a truck has gone to the right [m].
        risen: (F,) by how much a crane has risen [m].
        height: (F,) over the ground below the target [m], instead of an elevation; None if not.
        zoom: whether a dolly zooms against itself.
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
    def of(cut: Camera, heading: Array, since: Array, seconds: float) -> Moves:
        """Return the moves of a cut.

        Args:
            cut: its words.
            heading: (3,) of what it follows.
            since: (F,) time since it began [s].
            seconds: how long it is [s].
        """
        azimuth, elevation = (math.radians(angle) for angle in VIEWS[cut.view or "three-quarter"])
        if cut.elevation_deg is not None:
            elevation = math.radians(cut.elevation_deg)
        turned, risen = _orbit(cut.orbit, since, seconds)
        # Headings and orbits turn to the left about +Y, the azimuth of a view to the right.
        level = turn(rotation(UP, turned - azimuth), np.tile(heading, (len(since), 1)))
        raised = elevation + risen
        ends, nearer = _straight(cut.dolly, since, seconds)
        if ends is None and cut.distance is not None:
            ends = np.full(len(since), cut.distance)
        aside, trucked = _straight(cut.truck, since, seconds)
        height, craned = _straight(cut.crane, since, seconds)
        return Moves(
            level=level,
            across=np.cross(UP, level),
            elevation=raised if cut.orbit is None else raised.clip(-HIGHEST, HIGHEST),
            distance=ends,
            nearer=nearer,
            aside=trucked if aside is None else aside,
            risen=craned,
            height=height,
            zoom=cut.dolly is not None and cut.dolly.zoom,
        )


def _orbit(words: Orbit | None, since: Array, seconds: float) -> tuple[Array, Array]:
    """Return how far an orbit has turned and risen (F,) [rad]."""
    if words is None:
        return np.zeros_like(since), np.zeros_like(since)
    if words.from_deg is not None and words.to_deg is not None:
        s = _progress(words.ease or "in-out", since, seconds)
        turned = words.from_deg + s * (words.to_deg - words.from_deg)
    else:
        s = _progress(words.ease or "linear", since, seconds)
        turned = s * seconds * (ORBIT_SPEED if words.speed_deg is None else words.speed_deg)
    return np.radians(turned), np.radians(s * words.rise_deg)


def _straight(
    words: Dolly | Truck | Crane | None, since: Array, seconds: float
) -> tuple[Array | None, Array]:
    """Return where a move is between its ends (F,), None if it has none, and how far it went."""
    if words is None:
        return None, np.zeros_like(since)
    if words.start is not None and words.end is not None:
        s = _progress(words.ease or "in-out", since, seconds)
        return words.start + s * (words.end - words.start), np.zeros_like(since)
    return None, _progress(words.ease or "linear", since, seconds) * seconds * (words.speed or 0.0)


def _progress(kind: MoveEase, since: Array, seconds: float) -> Array:
    """Return the part of a move (F,) that is done: 0 when it begins, 1 when its cut ends."""
    s = np.clip(since / seconds, 0.0, 1.0)
    if kind == "in-out":
        return ease(s)
    if kind == "linear":
        return s
    # Halves of the same path, as fast in the middle of it as on the whole elsewhere.
    return 2.0 * ease(0.5 * s) if kind == "in" else 2.0 * ease(0.5 + 0.5 * s) - 1.0
