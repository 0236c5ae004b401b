"""Proportions: where the joints of a person lie and what its segments weigh, by its height."""

from __future__ import annotations

from dataclasses import dataclass

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
"""The sixteen places that a person's segments join; "hand" is the wrist, "foot" the ankle.

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
        height: of the crown over the sole [m].
        mass: [kg].
        ankle: height of the ankle.
        knee: height of the knee.
        hip: height of the hips.
        spine: height of the joint between belly and chest.
        shoulder: height of the shoulders.
        head: height of the middle of the head.
        hips: half the distance of the hips' joints.
        shoulders: half the distance of the shoulders' joints.
        upper_arm: its length.
        forearm: its length, elbow to wrist.
        hand: its length, wrist to fingertips.
        foot: its length, heel to toe.
        head_size: height of the head, chin to crown.

    Source: Winter 2009, figure 4.1, for grown-ups; a child of six is about six heads high, with
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
    shoulders: float = 0.115
    upper_arm: float = 0.186
    forearm: float = 0.146
    hand: float = 0.108
    foot: float = 0.152
    head_size: float = 0.130

    def rest(self) -> Array:
        """Return (16, 3) where the joints are [m], standing at the origin, arms hanging.

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
    shoulders=0.118,
    upper_arm=0.175,
    forearm=0.140,
    hand=0.110,
    foot=0.155,
    head_size=0.180,
)

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
"""Fraction of the whole that each segment weighs, of each limb one.

Source: Winter 2009, table 4.1.
"""
