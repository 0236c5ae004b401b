"""State: how one pronker is just now."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.hopper import STANCE_STRETCH, Hopper
from pipeline.simulation.locomotion.pronking.jump_parameters import Jump
from pipeline.simulation.locomotion.pronking.leg_forces import (
    NO_CONTROL,
    AttitudeControl,
    AttitudeState,
    integrate_attitude,
)
from pipeline.simulation.scalar_rotation import Quaternion, from_rotation_vector, matrix_rows
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

Phase = Literal[
    "standing", "crouching", "flight", "landing", "pushing", "rising", "straightening", "fallen"
]
"""Those of Sims 1987, ch. 11, and what comes before the first jump and after the last: a body
that stands, sinks for half the way into its crouch, rises and comes to a stop."""

SUPPORT_PHASES = ("landing", "pushing")

FREE_FALL = np.array([0.0, -GRAVITY, 0.0])
"""Acceleration of what nothing carries [m/s²]."""


@dataclass(eq=False)
class HopState:
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
    turning: AttitudeState
    tips: Array
    down: NDArray[np.bool_]
    released: NDArray[np.bool_]
    swing: SwingPath
    facing: float
    going: float
    course: JumpQueue
    floor: float = 0.0
    goal: float = 0.0
    first: float = math.inf
    a: Array = field(default_factory=lambda: np.zeros(3))
    steering: AttitudeControl = NO_CONTROL
    until: float = math.inf
    jumps: int = 0
    hits: int = 0
    armed: bool = True
    saturated: bool = False
    flight: float = 0.5
    ends: Array = field(default_factory=lambda: np.zeros((0, 3)))
    lift: tuple[Array, Array] = field(default_factory=lambda: (np.zeros(3), np.zeros(3)))

    def at(self, h: float, of: Hopper) -> BodyState:
        """Return where it is a time `h` later, if the phase goes on so long [s]."""
        turning = integrate_attitude(self.turning, of.inertia, self.steering, self.time, h)
        return BodyState(
            self.time + h,
            self.p + h * (self.v + 0.5 * h * self.a),
            self.v + h * self.a,
            turning,
            of,
        )

    def elsewhere(self, way: Array) -> HopState:
        """Return the state of one that is so elsewhere, by (3,) [m]."""
        return replace(self, p=self.p + way, tips=self.tips + way, floor=self.floor + way[1])

    def now(self, of: Hopper) -> BodyState:
        """Return where it is."""
        return BodyState(self.time, self.p, self.v, self.turning, of)


@dataclass(eq=False)
class BodyState:
    """A body at some time; see `HopState`."""

    time: float
    p: Array
    v: Array
    turning: AttitudeState
    of: Hopper
    R: Array = field(init=False)
    origin: Array = field(init=False)

    def __post_init__(self) -> None:
        self.R = np.array(matrix_rows(self.turning[0]))
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


def level_height(of: Hopper, p: Array) -> float:
    """Return the height of the body's frame if it were level [m]."""
    return float(p[1] - of.mass.centre[1])


def yaw_quaternion(angle: float) -> Quaternion:
    """Return the attitude of a level body that looks along a heading [rad]."""
    return from_rotation_vector((0.0, angle, 0.0))


APEX_FRACTION = 0.46
"""When feet are at the middle point, as a part of the flight."""


@dataclass(frozen=True, eq=False)
class SwingPath:
    """The ways of n feet.

    Attributes:
        begin: (n,) [s].
        time: (n,) how long they take [s].
        start, middle, end: (n, 3) in the frame of the body [m].
        trail: (n, 3) speed with which they begin [m/s].
    """

    begin: Array
    time: Array
    start: Array
    middle: Array
    end: Array
    trail: Array

    @staticmethod
    def still(feet: Array) -> SwingPath:
        """Return feet (n, 3) that do not move."""
        n, zero = len(feet), np.zeros_like(feet)
        return SwingPath(np.zeros(n), np.ones(n), feet, feet, feet, zero)

    def tips(self, time: float) -> Array:
        """Return the feet (n, 3) in the frame of the body [m]."""
        s = np.minimum(np.maximum((time - self.begin) / self.time, 0.0), 1.0)[:, None]
        late = s > APEX_FRACTION
        span = np.where(late, 1.0 - APEX_FRACTION, APEX_FRACTION)
        u = np.where(late, s - APEX_FRACTION, s) / span
        a, b = np.where(late, self.middle, self.start), np.where(late, self.end, self.middle)
        through = self.end - self.start
        through[:, 1] = 0.0
        reach = self.time[:, None] * span
        m_a = np.where(late, span * through, reach * self.trail)
        m_b = np.where(late, 0.0, span * through)
        return _hermite(u, a, b, m_a, m_b)

    def again(self, which: NDArray[np.bool_], time: float, start: Array, takes: float) -> SwingPath:
        """Return the ways where some feet begin another one, straight to their ends."""
        one = which[:, None]
        middle = 0.5 * (start + self.end)
        return replace(
            self,
            begin=np.where(which, time, self.begin),
            time=np.where(which, takes, self.time),
            start=np.where(one, start, self.start),
            middle=np.where(one, middle, self.middle),
            trail=np.where(one, 0.0, self.trail),
        )


def _hermite(u: Array, a: Array, b: Array, m_a: Array, m_b: Array) -> Array:
    """Return the cubic from a to b whose slopes there are m_a and m_b."""
    v = 1.0 - u
    result: Array = v * v * ((1.0 + 2.0 * u) * a + u * m_a) + u * u * (
        (1.0 + 2.0 * v) * b - v * m_b
    )
    return result


@dataclass(frozen=True, slots=True)
class PlannedJump:
    """The next jump of an errand.

    Attributes:
        up: speed at lift-off [m/s].
        facing: where it is to look when it has landed [rad].
        spot: (x, z) where the middle of its feet is to land [m]; straight on if None.
        forward: horizontal speed, if it goes straight on [m/s].
        last: whether the errand ends with it.
        folds: whether it draws its feet up as far as its legs fold.
    """

    up: float
    facing: float
    spot: tuple[float, float] | None = None
    forward: float = 0.0
    last: bool = True
    folds: bool = False


class JumpOrder(Protocol):
    """What a script asks a pronker to do."""

    def leap(self, of: Hopper, state: HopState, ground: Ground) -> PlannedJump | str:
        """Return the next jump of one that is about to push off; else why there is none.

        The reason is empty if there is nothing left to do.
        """


@dataclass(eq=False)
class JumpQueue:
    """The jumps that one pronker is to make.

    Attributes:
        jump: that it makes by its words.
        onward: whether it hops as its words say when it has no errand.
        errands: one after the other.
        leap: jump of the first errand that is pushed for or in the air; None for one by its words.
        made: jumps made by its words.
    """

    jump: Jump
    onward: bool = True
    errands: list[JumpOrder] = field(default_factory=list)
    leap: PlannedJump | None = None
    made: int = 0

    def choose(self, of: Hopper, state: HopState, ground: Ground) -> list[str]:
        """Decide on the jump that is pushed for next; return what cannot be done."""
        self.leap, causes = None, list[str]()
        while self.errands:
            found = self.errands[0].leap(of, state, ground)
            if isinstance(found, PlannedJump):
                self.leap = found
                break
            self.errands.pop(0)
            if found:
                causes.append(found)
        return causes

    def took_off(self) -> None:
        """Take down that the jump is being made."""
        if self.leap is None:
            self.made += 1
        elif self.leap.last and self.errands:
            self.errands.pop(0)


def is_overloaded(of: Hopper, state: HopState) -> bool:
    """Tell whether it stands, or sinks and rises slowly, on fewer legs than can carry it."""
    if state.phase not in ("standing", "crouching", "rising", "straightening"):
        return False
    force = of.mass.mass * float(state.a[1] + GRAVITY)
    return force > available_force(of, state) * (1.0 + 1e-9)


def standing_height(
    of: Hopper,
    R: Array,
    feet: Array,
    height: float,
    x: float,
    z: float,
    down: NDArray[np.bool_] | None = None,
) -> float:
    """Return the height of a body at which all feet that are down reach the ground [m].

    Args:
        of: whose body.
        R: (3, 3) its attitude.
        feet: (n, 3) of those that are down [m].
        height: at most [m].
        x: place of the body [m].
        z: likewise.
        down: (n,) which feet they are, all if left out.
    """
    own = slice(None) if down is None else down
    hips = of.hips[own] @ R.T + [x, 0.0, z]
    across = ((hips - feet)[:, [0, 2]] ** 2).sum(axis=-1)
    room = np.sqrt(np.maximum((STANCE_STRETCH * 0.995 * of.lengths[own]) ** 2 - across, 0.0))
    return min(height, float((feet[:, 1] + room - hips[:, 1]).min()))


def floor_height(of: Hopper, state: HopState) -> float:
    """Return the mean height of the footholds, of the ground without them [m]."""
    if not state.down.any():
        return 0.0
    return float((state.tips[:, 1] - of.soles)[state.down].mean())


def available_force(of: Hopper, state: HopState) -> float:
    """Return the greatest force that the legs on the ground give together [N]."""
    return of.most * int(state.down.sum())
