"""Carriage: waist and neck, held by servos; the head turns to the hand, the waist sways.

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

FOLLOWS, SIDEWAYS, DOWN, UPWARD = 0.7, 0.9, 0.5, 0.4
"""Part of the way to the hand that the head turns (the eyes have the rest), and how far at most
to the sides, down and up [rad]."""

NEAR = 0.28
"""Nearer than this the head does not look at a hand: it would look down its own neck [m]."""

LAG, TRUNK_LAG = 0.16, 0.12
"""Time constants with which the head and the waist follow [s]."""


class TrunkController:
    """How a dancer holds its trunk and head.

    Args:
        sway: how far the waist sways [rad].
        beat: duration of a beat [s].
        start: of the first [s].
        gaze: whether the head turns to the hand.
    """

    def __init__(self, sway: float, beat: float, start: float, gaze: bool) -> None:
        self.sway, self.beat, self.start, self.gaze = sway, beat, start, gaze
        self.given = dict.fromkeys(TRUNK_JOINTS, 0.0)
        self._now = [0.0] * len(TRUNK_JOINTS)
        self._soon = [0.0] * len(TRUNK_JOINTS)

    def sways(self, sway: float, beat: float, start: float) -> None:
        """Sway with another beat from now on; arguments as at first."""
        self.sway, self.beat, self.start = sway, beat, start

    def control(
        self, now: float, h: float, eyes: Array, R: Array, hand: Array | None
    ) -> list[float]:
        """Return the angles of the six joints from now on.

        Args:
            now: [s].
            h: since the last call [s].
            eyes: (3,) place of the head [m].
            R: (9,) rotation of the chest.
            hand: (3,) at which it looks, None for nowhere [m].
        """
        wanted = [*self.given.values()]
        if self.sway and now >= self.start:
            phase = math.pi * (now - self.start) / self.beat
            fade = min((now - self.start) / self.beat, 1.0)
            wanted[2] += fade * self.sway * math.sin(phase)
            wanted[0] += 0.5 * fade * self.sway * math.sin(phase)
        if self.gaze and hand is not None:
            yaw, nod = _look(eyes.tolist(), R.tolist(), hand.tolist())
            wanted[3] += yaw
            wanted[4] += nod
        waist, neck = h / (TRUNK_LAG + h), h / (LAG + h)
        soon, angles = self._soon, self._now
        # Two lags in a row begin and end softly.
        for k, share in enumerate((waist, waist, waist, neck, neck, neck)):
            soon[k] += share * (wanted[k] - soon[k])
            angles[k] += share * (soon[k] - angles[k])
        return angles


def _look(eyes: list[float], R: list[float], hand: list[float]) -> tuple[float, float]:
    """Return how far the neck turns and nods to look at a hand [rad]."""
    d = [b - a for a, b in zip(eyes, hand, strict=True)]
    forward = R[0] * d[0] + R[3] * d[1] + R[6] * d[2]
    up = R[1] * d[0] + R[4] * d[1] + R[7] * d[2]
    right = R[2] * d[0] + R[5] * d[1] + R[8] * d[2]
    level = math.hypot(forward, right)
    if level < 1e-6:
        return 0.0, 0.0
    # What is beside or behind the head, or close to it, is not followed.
    ahead = max(forward, 0.0) / level
    close = min(max((level - 0.5 * NEAR) / NEAR, 0.0), 1.0)
    yaw = FOLLOWS * ahead * close * math.atan2(-right, max(forward, 0.15))
    nod = FOLLOWS * ahead * close * math.atan2(-up, max(level, 0.2))
    return min(max(yaw, -SIDEWAYS), SIDEWAYS), min(max(nod, -UPWARD), DOWN)
