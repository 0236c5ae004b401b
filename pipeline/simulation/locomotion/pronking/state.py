"""State: how one pronker is just now."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking import spin
from pipeline.simulation.locomotion.pronking.attitude import FREE, Steering, Turning, turned
from pipeline.simulation.locomotion.pronking.course import Course
from pipeline.simulation.locomotion.pronking.pronker import Pronker
from pipeline.simulation.locomotion.pronking.spin import Quaternion
from pipeline.simulation.locomotion.pronking.swing import Swing
from pipeline.simulation.spatial import Array

Phase = Literal[
    "standing", "crouching", "flight", "landing", "pushing", "rising", "straightening", "fallen"
]
"""Those of Sims 1987, ch. 11, and what comes before the first jump and after the last: a body
that stands, sinks for half the way into its crouch, rises and comes to a stop."""

SUPPORT = ("landing", "pushing")

FALLING = np.array([0.0, -GRAVITY, 0.0])
"""Acceleration of what nothing carries [m/s²]."""


@dataclass(eq=False)
class State:
    """One pronker.

    Attributes:
        phase: that it is in.
        time: since the start of the film [s].
        p: (3,) centre of mass [m].
        v: (3,) its velocity [m/s].
        a: (3,) its acceleration, constant within the phase [m/s²].
        turning: attitude and angular velocity.
        steering: what turns it.
        until: when the phase ends, unless something happens before [s].
        tips: (n, 3) feet that are down [m].
        down: (n,) which are.
        released: (n,) which came off the ground before the others, and no longer carry.
        swing: how the others move.
        floor: height of the ground that it lands on or stands on [m].
        goal: height of the body above that, at which the landing is to end [m].
        first: height of the centre of mass at which the first foot touched [m].
        facing, going: where it is to look and to jump next [rad].
        course: which jumps it is to make.
        jumps: how often it has left the ground.
        hits: how often its body struck the ground in this phase.
        armed: whether its body was clear of the ground in this phase.
        saturated: whether its legs gave all they have since the last lift-off.
        flight: how long the jump that it pushes off for will take [s].
        ends: (n, 3) where its feet will be held for the landing, in the frame of the body [m].
        lift: (p, v) of the last lift-off.
    """

    phase: Phase
    time: float
    p: Array
    v: Array
    turning: Turning
    tips: Array
    down: NDArray[np.bool_]
    released: NDArray[np.bool_]
    swing: Swing
    facing: float
    going: float
    course: Course
    floor: float = 0.0
    goal: float = 0.0
    first: float = math.inf
    a: Array = field(default_factory=lambda: np.zeros(3))
    steering: Steering = FREE
    until: float = math.inf
    jumps: int = 0
    hits: int = 0
    armed: bool = True
    saturated: bool = False
    flight: float = 0.5
    ends: Array = field(default_factory=lambda: np.zeros((0, 3)))
    lift: tuple[Array, Array] = field(default_factory=lambda: (np.zeros(3), np.zeros(3)))

    def at(self, h: float, of: Pronker) -> Moved:
        """Return where it is a time `h` later, if the phase goes on so long [s]."""
        turning = turned(self.turning, of.inertia, self.steering, self.time, h)
        return Moved(
            self.time + h,
            self.p + h * (self.v + 0.5 * h * self.a),
            self.v + h * self.a,
            turning,
            of,
        )

    def elsewhere(self, way: Array) -> State:
        """Return the state of one that is so elsewhere, by (3,) [m]."""
        return replace(self, p=self.p + way, tips=self.tips + way, floor=self.floor + way[1])

    def now(self, of: Pronker) -> Moved:
        """Return where it is."""
        return Moved(self.time, self.p, self.v, self.turning, of)


@dataclass(eq=False)
class Moved:
    """A body at some time; see `State`."""

    time: float
    p: Array
    v: Array
    turning: Turning
    of: Pronker
    R: Array = field(init=False)
    origin: Array = field(init=False)

    def __post_init__(self) -> None:
        self.R = np.array(spin.rows(self.turning[0]))
        self.origin = self.p - self.R @ self.of.mass.centre

    def points(self, own: Array) -> Array:
        """Return points (n, 3) of the body in the world [m]."""
        result: Array = self.origin + own @ self.R.T
        return result

    @property
    def tilt(self) -> float:
        """Angle between the body's up and the world's [rad]."""
        return math.acos(min(max(float(self.R[1, 1]), -1.0), 1.0))

    @property
    def heading(self) -> float:
        """Where it looks [rad]."""
        return math.atan2(-self.R[2, 0], self.R[0, 0])


def level(of: Pronker, p: Array) -> float:
    """Return the height of the body's frame if it were level [m]."""
    return float(p[1] - of.mass.centre[1])


def yawed(angle: float) -> Quaternion:
    """Return the attitude of a level body that looks along a heading [rad]."""
    return spin.of_vector((0.0, angle, 0.0))
