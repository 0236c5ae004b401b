"""Trunk control: servos of waist and neck; the head follows the hand, the waist sways.

Source: Matarić, Zordan and Mason 1998, sections 5 and 7.2 (head gaze).
"""

from __future__ import annotations

import math

from pipeline.simulation.spatial import Array

TRUNK_JOINTS = (
    *("waist_rotation", "waist_flexion", "waist_bend"),
    *("neck_rotation", "neck_flexion", "neck_bend"),
)
"""The first six joints of a torso."""

HEAD_SHARE = 0.7
"""Fraction of the gaze angle that the head turns; the eyes turn the rest."""

YAW_LIMIT, NOD_LIMIT, LIFT_LIMIT = 0.9, 0.5, 0.4
"""Largest head angles sideways, down and up [rad]."""

GAZE_DISTANCE = 0.28
"""Distance of a hand below which the head stops following it [m]; it would face its own chest."""

NECK_LAG, WAIST_LAG = 0.16, 0.12
"""Time constants of neck and waist [s]."""


class TrunkController:
    """Servo targets of waist and neck.

    Args:
        sway: amplitude of the waist's sway [rad].
        beat: duration of a beat [s].
        start: time of the first beat [s].
        gaze: whether the head follows the hand.
    """

    def __init__(self, sway: float, beat: float, start: float, gaze: bool) -> None:
        self.sway, self.beat, self.start, self.gaze = sway, beat, start, gaze
        self.base_angles = dict.fromkeys(TRUNK_JOINTS, 0.0)
        self._angles = [0.0] * len(TRUNK_JOINTS)
        self._filtered = [0.0] * len(TRUNK_JOINTS)

    def set_sway(self, sway: float, beat: float, start: float) -> None:
        """Changes amplitude [rad], beat [s] and first beat [s] of the sway."""
        self.sway, self.beat, self.start = sway, beat, start

    def control(
        self, now: float, h: float, eyes: Array, R: Array, hand: Array | None
    ) -> list[float]:
        """Returns the target angles of the six joints [rad].

        Args:
            now: time [s].
            h: time since the last call [s].
            eyes: (3,) position of the head [m].
            R: (9,) rotation of the chest.
            hand: (3,) gaze target [m]; None for none.
        """
        target = [*self.base_angles.values()]
        if self.sway and now >= self.start:
            phase = math.pi * (now - self.start) / self.beat
            fade = min((now - self.start) / self.beat, 1.0)
            target[2] += fade * self.sway * math.sin(phase)
            target[0] += 0.5 * fade * self.sway * math.sin(phase)
        if self.gaze and hand is not None:
            yaw, nod = _gaze_angles(eyes.tolist(), R.tolist(), hand.tolist())
            target[3] += yaw
            target[4] += nod
        waist, neck = h / (WAIST_LAG + h), h / (NECK_LAG + h)
        filtered, angles = self._filtered, self._angles
        # Two first-order lags in series start and stop smoothly.
        for k, share in enumerate((waist, waist, waist, neck, neck, neck)):
            filtered[k] += share * (target[k] - filtered[k])
            angles[k] += share * (filtered[k] - angles[k])
        return angles


def _gaze_angles(eyes: list[float], R: list[float], hand: list[float]) -> tuple[float, float]:
    """Returns yaw and nod of the neck that face a hand [rad]."""
    d = [b - a for a, b in zip(eyes, hand, strict=True)]
    forward = R[0] * d[0] + R[3] * d[1] + R[6] * d[2]
    up = R[1] * d[0] + R[4] * d[1] + R[7] * d[2]
    right = R[2] * d[0] + R[5] * d[1] + R[8] * d[2]
    level = math.hypot(forward, right)
    if level < 1e-6:
        return 0.0, 0.0
    # Targets beside, behind or close to the head are not followed.
    ahead = max(forward, 0.0) / level
    close = min(max((level - 0.5 * GAZE_DISTANCE) / GAZE_DISTANCE, 0.0), 1.0)
    yaw = HEAD_SHARE * ahead * close * math.atan2(-right, max(forward, 0.15))
    nod = HEAD_SHARE * ahead * close * math.atan2(-up, max(level, 0.2))
    return min(max(yaw, -YAW_LIMIT), YAW_LIMIT), min(max(nod, -LIFT_LIMIT), NOD_LIMIT)
