"""Proportions: places of a person's joints, masses of its segments, and its measures in metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.spatial import Array

JOINTS = (
    "pelvis",
    "spine",
    "shoulders",
    "head",
    "shoulder_l",
    "shoulder_r",
    "elbow_l",
    "elbow_r",
    "hand_l",
    "hand_r",
    "hip_l",
    "hip_r",
    "knee_l",
    "knee_r",
    "foot_l",
    "foot_r",
)
"""The sixteen joints of a person's segments; "hand" is the wrist, "foot" the ankle.

Source: Horswill 2008, figure 2.
"""

SEGMENTS = {
    "belly": ("pelvis", "spine"),
    "chest": ("spine", "shoulders"),
    "head": ("shoulders", "head"),
    "yoke": ("shoulder_l", "shoulder_r"),
    "pelvis": ("hip_l", "hip_r"),
    "upper_arm_l": ("shoulder_l", "elbow_l"),
    "upper_arm_r": ("shoulder_r", "elbow_r"),
    "forearm_l": ("elbow_l", "hand_l"),
    "forearm_r": ("elbow_r", "hand_r"),
    "thigh_l": ("hip_l", "knee_l"),
    "thigh_r": ("hip_r", "knee_r"),
    "shin_l": ("knee_l", "foot_l"),
    "shin_r": ("knee_r", "foot_r"),
}
"""The thirteen links, from one joint to the next. Source: Horswill 2008."""


@dataclass(frozen=True, slots=True)
class Proportions:
    """A person's measures as fractions of its height, and its weight.

    Attributes:
        height: of the crown above the sole [m].
        mass: [kg].
        ankle: height of the ankle.
        knee: height of the knee.
        hip: height of the hips.
        spine: height of the joint between belly and chest.
        shoulder: height of the shoulders.
        head: height of the middle of the head.
        hips: half the distance of the hip joints.
        shoulders: half the distance of the shoulder joints.
        upper_arm: length.
        forearm: length, elbow to wrist.
        hand: length, wrist to fingertips.
        foot: length, heel to toe.
        head_size: height of the head, chin to crown.

    Source: Winter 2009, figure 4.1, for adults; a child of six is about six heads high, with
        shorter legs.
    """

    height: float
    mass: float
    ankle: float = 0.039
    knee: float = 0.285
    hip: float = 0.530
    spine: float = 0.640
    shoulder: float = 0.818
    head: float = 0.930
    hips: float = 0.055
    shoulders: float = 0.103
    upper_arm: float = 0.186
    forearm: float = 0.146
    hand: float = 0.108
    foot: float = 0.152
    head_size: float = 0.130

    def rest(self) -> Array:
        """Return (16, 3) the joints [m], standing at the origin, arms hanging.

        X is forward, Y up and Z to the right, as in a figure's frame.
        """
        elbow = self.shoulder - self.upper_arm
        wrist = elbow - self.forearm
        middle = {"pelvis": self.hip, "spine": self.spine, "shoulders": self.shoulder}
        middle["head"] = self.head
        aside = {
            "shoulder": (self.shoulder, self.shoulders),
            "elbow": (elbow, self.shoulders),
            "hand": (wrist, self.shoulders),
            "hip": (self.hip, self.hips),
            "knee": (self.knee, self.hips),
            "foot": (self.ankle, self.hips),
        }
        rest = np.zeros((len(JOINTS), 3))
        for k, name in enumerate(JOINTS):
            if name in middle:
                rest[k, 1] = middle[name]
            else:
                stem, side = name.split("_")
                height, half = aside[stem]
                rest[k] = (0.0, height, half if side == "r" else -half)
        return rest * self.height


ADULT = Proportions(height=1.72, mass=68.0)

CHILD = Proportions(
    height=1.15,
    mass=20.5,
    ankle=0.045,
    knee=0.270,
    hip=0.485,
    spine=0.600,
    shoulder=0.785,
    head=0.905,
    hips=0.062,
    shoulders=0.107,
    upper_arm=0.175,
    forearm=0.140,
    hand=0.110,
    foot=0.155,
    head_size=0.180,
)

BACK_DEPTH, TRUNK_BREADTH = 0.056, 0.09
"""Depth of a clothed back behind the spine, and half the breadth of a trunk, in heights."""

BUILDS = {"adult": ADULT, "child": CHILD}
"""Proportions by the name of a build."""

SEGMENT_MASSES = {
    "head": 0.081,
    "trunk": 0.497,
    "upper_arm": 0.028,
    "forearm": 0.016,
    "hand": 0.006,
    "thigh": 0.100,
    "shin": 0.0465,
    "foot": 0.0145,
}
"""Fraction of the body's mass in each segment, of each limb one.

Source: Winter 2009, table 4.1.
"""

PALM_FRACTION = 0.45
"""Place of the centre of the palm, as a fraction of the distance from wrist to fingertips."""

GIRTH_FACTORS = {"slim": 0.93, "medium": 1.0, "sturdy": 1.09}
"""Girths by stature."""


WAIST, WAIST_REACH, NARROWED = 0.628, 0.055, 0.10
"""Height of a narrow waist in an adult's, its reach up and down, and by how much it is narrower."""


@dataclass(frozen=True)
class BodyMeasures:
    """Measures of one person, for the meshes of its body and clothes.

    Outlines are given as fractions of an adult's height (`ADULT`), and fitted to others between the
    same landmarks: soles, ankles, knees, hips, waist, shoulders, chin and crown.

    Attributes:
        proportions: of the person.
        stoutness: girth as a fraction of the usual one for its weight.
        is_curved: whether it has a bust and a narrow waist once it is grown up.
    """

    proportions: Proportions
    stoutness: float
    is_curved: bool = False

    @cached_property
    def girth(self) -> float:
        """Factor from an adult's breadths, as fractions of its height, to metres [m]."""
        own, grown = self.proportions, ADULT
        dense = own.mass / own.height**3 / (grown.mass / grown.height**3)
        return self.stoutness * own.height * float(np.sqrt(dense))

    @property
    def childish(self) -> float:
        """Size of the head: 0 an adult's, 1 that of a child of six."""
        part = self.proportions.head_size
        return float(np.clip((part - ADULT.head_size) / 0.05, 0.0, 1.0))

    @property
    def curves(self) -> float:
        """How much there is of bust and waist, from 0 to 1."""
        return (1.0 - self.childish) if self.is_curved else 0.0

    def level(self, fraction: float) -> float:
        """Return the height of an adult's landmark at a fraction of its height [m]."""
        return float(self.levels(np.array([fraction]))[0])

    def levels(self, fractions: Array) -> Array:
        """Return the heights (n,) of landmarks at fractions (n,) of an adult's height [m]."""
        own = np.interp(fractions, _landmarks(ADULT), _landmarks(self.proportions))
        return own * self.proportions.height

    @property
    def hips(self) -> float:
        """Half the distance of the hips [m]."""
        return self.proportions.hips * self.proportions.height

    @property
    def shoulders(self) -> float:
        """Half the distance of the shoulders [m]."""
        return self.proportions.shoulders * self.proportions.height

    def outline(self, rows: Sequence[Sequence[float]], breadth: float | Array = 1.0) -> Array:
        """Return the rows of an `oval_stack` in metres.

        Args:
            rows: (n, 5) as fractions of an adult's height.
            breadth: factor of the reach to either side, of all rows or (n,) of each.
        """
        table = np.array(rows, dtype=float)
        table[:, 0] = self.levels(table[:, 0])
        table[:, 1:] *= self.girth
        table[:, 4] *= breadth
        return table

    @property
    def hip_breadth(self) -> float:
        """Width of the pelvis for the girth, relative to an adult's."""
        return self.hips / (ADULT.hips * self.girth / self.stoutness)

    def waisted(self, rows: Sequence[Sequence[float]]) -> Array:
        """Return the breadth factor (n,) of the rows of an outline, narrower at a narrow waist."""
        levels = np.array([row[0] for row in rows])
        narrow = NARROWED * self.curves * np.exp(-(((levels - WAIST) / WAIST_REACH) ** 2))
        return np.asarray(1.0 - narrow)

    @property
    def shoulder_breadth(self) -> float:
        """Width of the chest for the girth, relative to an adult's."""
        return self.shoulders / (ADULT.shoulders * self.girth / self.stoutness)


def _landmarks(p: Proportions) -> list[float]:
    return [0.0, p.ankle, p.knee, p.hip, p.spine, p.shoulder, 1.0 - p.head_size, 1.0]
