"""Dancing legs: hips that sway over planted feet, carrying the simulated torso along.

The torso is simulated on a pelvis that stands still. Its sway is small and slow, so that its
inertia is left out: the whole torso is carried by the motion of the pelvis, and legs of two links
reach from the hips to the feet. Each dancer has a stance and a style of its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from pipeline.simulation.people.proportions import JOINTS, Proportions
from pipeline.simulation.spatial import Array, cross, heading, normalized, rotation

REFERENCE_SWAY = math.radians(4.0)
"""Sway of the waist at which hips move as in the measures below [rad]."""

SHIFT, DIP = 0.021, 0.011
"""Amplitude of the pelvis aside, and its fall between two beats, per body height."""

ROLL, YAW = math.radians(4.5), math.radians(4.0)
"""By how much the hip of the loaded leg rises, and comes forward [rad]."""

HEEL_LIFT = math.radians(16.0)
"""By how much the heel of the other leg rises [rad]."""

CROUCH = 0.0022
"""By how much a dancer's knees are bent at least, as a fall of the pelvis, per body height."""

BALL = 0.42
"""Place of the ball of a foot ahead of its ankle, in its length."""

FADE_TIME, LAG = 0.35, 0.07
"""Time constants of the strength of the sway, and of what follows the beat [s]."""

SIDES = (("r", 1.0), ("l", -1.0))


@dataclass(frozen=True, slots=True)
class DancingStyle:
    """Stance and style of one dancer.

    Attributes:
        size: factor on the sway of the hips.
        bounce: factor on the fall between two beats.
        lead: by how much its hips are ahead of the beat [rad] of a cycle of two beats.
        turnout: of the right and the left foot, outward [rad].
        apart: by how much each foot is outward of the hip, per body height.
        stagger: by how much the right foot is ahead, and the left behind, per body height.
    """

    size: float = 1.0
    bounce: float = 1.0
    lead: float = 0.0
    turnout: tuple[float, float] = (0.0, 0.0)
    apart: float = 0.0
    stagger: float = 0.0


def draw_style(rng: np.random.Generator) -> DancingStyle:
    """Return a random style."""
    right, left = np.radians(rng.uniform(6.0, 20.0, 2)).tolist()
    return DancingStyle(
        size=float(rng.uniform(0.75, 1.25)),
        bounce=float(rng.uniform(0.7, 1.3)),
        lead=float(rng.uniform(-0.4, 0.4)),
        turnout=(right, left),
        apart=float(rng.uniform(0.004, 0.020)),
        stagger=float(rng.uniform(-0.016, 0.016)),
    )


@dataclass(frozen=True, slots=True)
class HipMotion:
    """Where the pelvis is, and what the heels do.

    Attributes:
        shift: of the pelvis to the right, per body height.
        dip: fall of the pelvis, per body height.
        roll: about X [rad].
        yaw: about Y [rad].
        right: lift of the right heel [rad].
        left: lift of the left heel [rad].
    """

    shift: float = 0.0
    dip: float = 0.0
    roll: float = 0.0
    yaw: float = 0.0
    right: float = 0.0
    left: float = 0.0


class DancingLegs:
    """Pelvis and legs of one dancer, in the frame in which it stands.

    Args:
        person: proportions of the dancer.
        style: its stance and style.
    """

    def __init__(self, person: Proportions, style: DancingStyle) -> None:
        self.style = style
        self._height = person.height
        self._rest = dict(zip(JOINTS, person.rest(), strict=True))
        self._foot = person.foot * person.height
        self._strength = 0.0
        self._filtered = self.motion = HipMotion()

    def advance(self, dt: float, since: float, beat: float, sway: float) -> None:
        """Advance by a world step.

        Args:
            dt: its duration [s].
            since: time since the first beat [s].
            beat: duration of a beat [s].
            sway: amplitude of the waist's sway, 0 for hips that come to rest [rad].
        """
        wanted = sway / REFERENCE_SWAY if since >= 0.0 else 0.0
        self._strength += dt / (FADE_TIME + dt) * (wanted - self._strength)
        aim = self._aim(math.pi * since / beat + self.style.lead)
        # Two first-order lags in series start and stop smoothly, as those of the trunk do.
        self._filtered = _lagged(self._filtered, aim, dt)
        self.motion = _lagged(self.motion, self._filtered, dt)

    def _aim(self, phase: float) -> HipMotion:
        """Return the motion at a phase of a cycle of two beats [rad]."""
        size = self.style.size * self._strength
        right = size * math.sin(phase)
        return HipMotion(
            shift=SHIFT * right,
            dip=DIP * self.style.bounce * self._strength * math.cos(phase) ** 2,
            roll=-ROLL * right,
            yaw=YAW * right,
            right=HEEL_LIFT * max(-right, 0.0),
            left=HEEL_LIFT * max(right, 0.0),
        )

    def carry(self) -> tuple[Array, Array]:
        """Return the rotation (3, 3) and the translation (3,) [m] of pelvis and torso.

        They take places at rest, p, to R p + t.
        """
        motion, pelvis = self.motion, self._rest["pelvis"]
        R = heading(motion.yaw) @ rotation(np.array([1.0, 0.0, 0.0]), motion.roll)
        moved = self._height * np.array([0.0, -motion.dip - CROUCH, motion.shift])
        return R, pelvis + moved - R @ pelvis

    def legs(self) -> dict[str, tuple[Array, Array]]:
        """Return the rotation (3, 3) and the place (3,) [m] of each frame of the legs."""
        R, t = self.carry()
        found = dict[str, tuple[Array, Array]]()
        for k, (side, outward) in enumerate(SIDES):
            hip = R @ self._rest[f"hip_{side}"] + t
            turned = heading(-outward * self.style.turnout[k])
            lift = self.motion.right if side == "r" else self.motion.left
            R_foot, ankle = self._foot_pose(side, outward, turned, lift)
            thigh, shin = self._lengths(side)
            knee, ankle = _bent_knee(hip, ankle, turned[:, 0], thigh, shin)
            for name, start, end in (("thigh", hip, knee), ("shin", knee, ankle)):
                found[f"{name}_{side}"] = _hanging(end - start, turned[:, 2]), start
            found[f"foot_{side}"] = R_foot, ankle
        return found

    def _foot_pose(
        self, side: str, outward: float, turned: Array, lift: float
    ) -> tuple[Array, Array]:
        """Return the rotation of a foot and the place of its ankle, pitched about its ball."""
        style, h = self.style, self._height
        flat = self._rest[f"foot_{side}"] + h * np.array(
            [outward * style.stagger, 0.0, outward * style.apart]
        )
        ball = flat + turned @ np.array([BALL * self._foot, -flat[1], 0.0])
        R = turned @ rotation(np.array([0.0, 0.0, 1.0]), -lift)
        return R, ball + R @ (turned.T @ (flat - ball))

    def _lengths(self, side: str) -> tuple[float, float]:
        hip, knee, ankle = (self._rest[f"{joint}_{side}"] for joint in ("hip", "knee", "foot"))
        return float(np.linalg.norm(knee - hip)), float(np.linalg.norm(ankle - knee))


def _lagged(state: HipMotion, aim: HipMotion, dt: float) -> HipMotion:
    share = dt / (LAG + dt)
    return HipMotion(
        *(
            getattr(state, f.name) + share * (getattr(aim, f.name) - getattr(state, f.name))
            for f in fields(HipMotion)
        )
    )


def _bent_knee(
    hip: Array, ankle: Array, ahead: Array, thigh: float, shin: float
) -> tuple[Array, Array]:
    """Return the knee (3,), and the ankle (3,) as far as the leg reaches [m]."""
    reach = ankle - hip
    distance = min(float(np.sqrt(reach @ reach)), (1.0 - 1e-6) * (thigh + shin))
    along = normalized(reach)
    forward = normalized(ahead - (ahead @ along) * along)
    # Law of cosines at the hip.
    cosine = (thigh**2 + distance**2 - shin**2) / (2.0 * thigh * distance)
    sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
    return hip + thigh * (cosine * along + sine * forward), hip + distance * along


def _hanging(along: Array, right: Array) -> Array:
    """Return the frame (3, 3) that hangs along a direction, with Z nearest to `right`."""
    y = -normalized(along)
    x = normalized(cross(y, right))
    return np.stack([x, y, cross(x, y)], axis=-1)
