"""Joint limits of a person: how far its joints turn, for all rooms that move people.

Angles follow anatomy: flexion raises an arm forward, abduction raises it sideways, rotation turns
it inward, pronation turns the palm of an outstretched arm down.

Source: American Academy of Orthopaedic Surgeons 1965 for elbow, wrist and the order of size of the
    others. A shoulder turns farther here, for shoulder blades do not move; the limits of the spine
    are those of all its joints together.
"""

from __future__ import annotations

import math
from typing import NamedTuple

Vector = tuple[float, float, float]

ELBOW_BEND, KNEE_BEND = 150, 150
"""Greatest bend of elbows and knees from straight [degrees]."""

HINGE_LIMITS = {
    "waist_rotation": (-40, 40),
    "waist_flexion": (-15, 45),
    "waist_bend": (-25, 25),
    "neck_rotation": (-75, 75),
    "neck_flexion": (-45, 50),
    "neck_bend": (-35, 35),
    "shoulder_flexion": (-60, 185),
    "shoulder_abduction": (-60, 160),
    "shoulder_rotation": (-100, 115),
    "elbow_flexion": (0, ELBOW_BEND),
    "wrist_pronation": (-95, 95),
    "wrist_flexion": (-70, 75),
    "wrist_deviation": (-30, 30),
}
"""Smallest and largest angle of each hinge of trunk and arms [degrees]."""

MAX_SPINE_BEND = math.radians(60.0)
"""Bend between belly and chest, any way [rad]."""

MAX_PELVIS_TILT, MAX_SHOULDER_TILT = math.radians(22.0), math.radians(16.0)
"""Tilt of pelvis and shoulders on the spine [rad]."""

MAX_HEAD_TILT = math.radians(50.0)
"""Tilt of the neck on the shoulders, any way [rad]."""

MAX_NOD = math.radians(50.0)
"""Of a head on its neck [rad]."""

MAX_ANKLE_PITCH, LIMP_ANKLE_PITCH = math.radians(45.0), math.radians(110.0)
"""Pitch of an ankle that puts its sole down, and pitch beyond which it lets go [rad]."""


class ReachCone(NamedTuple):
    """Where a limb reaches and where its elbow or knee points, in the frame of the trunk.

    Attributes:
        axis: middle of the cone of directions from shoulder to hand or from hip to ankle.
        half_angle: of the cone [degrees].
        joint: direction in which the elbow or knee points with the limb along the axis.
        spread: how far the joint turns away from it to both sides [degrees].
    """

    axis: Vector
    half_angle: float
    joint: Vector
    spread: float


LEG_CONE = ReachCone((0.5, -0.85, 0.12), 88.0, (0.85, 0.5, 0.1), 35.0)
ARM_CONE = ReachCone((0.6, -0.25, 0.75), 115.0, (-0.6, -0.7, 0.45), 100.0)
"""Cones of the limbs of the right side."""
