"""Candidate view: a camera that could take a planned shot, and how well it would."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pipeline.production.camera.camera_path import CameraPath
from pipeline.simulation.spatial import Array
from render.config import Camera

LEAST_TURN = math.radians(30.0)
"""Angle from which the views of neighbouring shots differ [rad].

Source: Mascelli 1965.
"""

LEAST_STEP = 1.3
"""Ratio of the heights that two neighbouring shots show from which their sizes differ."""


@dataclass(frozen=True, eq=False)
class CandidateView:
    """A camera for a planned shot.

    Attributes:
        camera: its configuration.
        path: of the camera at the frames of the shot.
        towards: (3,) level unit direction from the target to the camera.
        height: of the world that the frame shows at the target [m].
        light: angle between camera and key light [rad]; None without one.
        cost: of its view and light, without what it does not show.
        lost_s: longest time in which the followed are blocked, cropped or out of the frame [s].
        lost_share: share of the shot in which they are.
    """

    camera: Camera
    path: CameraPath
    towards: Array
    height: float
    light: float | None
    cost: float
    lost_s: float
    lost_share: float

    def differs_from(self, other: CandidateView) -> bool:
        """Return whether a cut from one to the other is no jump cut."""
        ratio = max(self.height, other.height) / min(self.height, other.height)
        return self.turn_from(other) >= LEAST_TURN or ratio >= LEAST_STEP

    def turn_from(self, other: CandidateView) -> float:
        """Return the angle between two views about the vertical [rad]."""
        return math.acos(max(-1.0, min(1.0, float(self.towards @ other.towards))))
