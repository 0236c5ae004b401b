"""The state of one hopper: phase, motion, feet, and the queue of its jumps.

Source: Sims 1987, ch. 11; 11.1 for the paths of feet in flight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.flight_swing import NO_PITCH, SwingPath, TrunkPitch
from pipeline.simulation.locomotion.pronking.hopper import STANCE_STRETCH, Hopper
from pipeline.simulation.locomotion.pronking.jump_parameters import Jump
from pipeline.simulation.locomotion.pronking.leg_forces import (
    NO_CONTROL,
    AttitudeControl,
    AttitudeState,
    integrate_attitude,
)
from pipeline.simulation.scalar_rotation import (
    Quaternion,
    Vector,
    from_rotation_vector,
    quaternion_product,
    rotation_matrix,
)
from pipeline.simulation.spatial import Array, heading
from pipeline.simulation.terrain import Ground

Phase = Literal[
    "standing", "crouching", "flight", "landing", "pushing", "rising", "straightening", "fallen"
]
"""The phases of Sims 1987, ch. 11, and those around them: before the first jump a body stands and
sinks into its crouch, after the last it rises and straightens."""

SUPPORT_PHASES = ("landing", "pushing")

FREE_FALL = np.array([0.0, -GRAVITY, 0.0])
"""Acceleration in flight [m/s²]."""


LEAN_FRACTION, MAX_LEAN = 0.6, 0.35
"""How much of the ground's slope a body leans with, as a fraction, and at most [rad]."""


@dataclass(eq=False)
class HopState:
    """The state of one hopper.

    Attributes:
        phase: the current phase.
        time: since the start of the film [s].
        p: (3,) centre of mass [m].
        v: (3,) its velocity [m/s].
        a: (3,) its acceleration, constant within a phase [m/s²].
        attitude: quaternion and angular velocity, without `pitch`.
        control: forces and goals that turn the body.
        phase_end: time at which the phase ends if no event ends it before [s].
        tips: (n, 3) feet that are down [m].
        down: (n,) which feet are on the ground.
        released: (n,) which feet left the ground before the others and no longer carry.
        swing: paths of the feet in the air.
        floor_height: of the ground that it lands or stands on [m].
        landing_height: of the body above that, at which the landing ends [m].
        first_touch_height: of the centre of mass when the first foot touched [m].
        next_heading: of the body after the next jump [rad].
        travel_heading: direction of the next jump [rad].
        queue: the jumps to make.
        jump_count: number of lift-offs.
        body_hits: number of body impacts in this phase.
        body_armed: whether the body was clear of the ground since its last impact.
        saturated: whether the legs reached their greatest force since the last lift-off.
        flight_time: of the jump that it pushes off for [s].
        landing_feet: (n, 3) feet as held for the landing, in the frame of the body [m].
        lift_off: (p, v) of the last lift-off.
        pitch: how its legs turn it in flight.
    """

    phase: Phase
    time: float
    p: Array
    v: Array
    attitude: AttitudeState
    tips: Array
    down: NDArray[np.bool_]
    released: NDArray[np.bool_]
    swing: SwingPath
    next_heading: float
    travel_heading: float
    queue: JumpQueue
    floor_height: float = 0.0
    landing_height: float = 0.0
    first_touch_height: float = math.inf
    a: Array = field(default_factory=lambda: np.zeros(3))
    control: AttitudeControl = NO_CONTROL
    phase_end: float = math.inf
    jump_count: int = 0
    body_hits: int = 0
    body_armed: bool = True
    saturated: bool = False
    flight_time: float = 0.5
    landing_feet: Array = field(default_factory=lambda: np.zeros((0, 3)))
    lift_off: tuple[Array, Array] = field(default_factory=lambda: (np.zeros(3), np.zeros(3)))
    pitch: TrunkPitch = NO_PITCH

    def predict(self, h: float, hopper: Hopper) -> BodyState:
        """Return the body a time `h` later, if the phase lasts that long [s]."""
        turning = integrate_attitude(self.attitude, hopper.inertia, self.control, self.time, h)
        return BodyState(
            self.time + h,
            self.p + h * (self.v + 0.5 * h * self.a),
            self.v + h * self.a,
            turning,
            hopper,
            self.pitch,
        )

    def shifted(self, offset: Array) -> HopState:
        """Return the same state displaced by `offset` (3,) [m]."""
        return replace(
            self,
            p=self.p + offset,
            tips=self.tips + offset,
            floor_height=self.floor_height + offset[1],
        )

    def body(self, hopper: Hopper) -> BodyState:
        """Return the body now."""
        return BodyState(self.time, self.p, self.v, self.attitude, hopper, self.pitch)

    def settle_pitch(self) -> None:
        """Make the pitch of a flight part of the attitude, which legs on the ground control."""
        self.attitude, self.pitch = self.pitch.turned(self.attitude, self.time), NO_PITCH


@dataclass(eq=False)
class BodyState:
    """A body at one time; see `HopState`.

    Attributes:
        R: (3, 3) its orientation, `pitch` included.
        origin: (3,) of its frame [m].
        rate: (3,) angular velocity, `pitch` included [rad/s].
    """

    time: float
    p: Array
    v: Array
    attitude: AttitudeState
    hopper: Hopper
    pitch: TrunkPitch
    R: Array = field(init=False)
    origin: Array = field(init=False)
    rate: Vector = field(init=False)

    def __post_init__(self) -> None:
        q, self.rate = self.pitch.turned(self.attitude, self.time)
        self.R = rotation_matrix(q)
        self.origin = self.p - self.R @ self.hopper.mass.centre

    def to_world(self, points: Array) -> Array:
        """Return points (n, 3) of the body in the world [m]."""
        return self.origin + points @ self.R.T

    @property
    def tilt(self) -> float:
        """Angle between the body's vertical and the world's [rad]."""
        return math.acos(min(max(float(self.R[1, 1]), -1.0), 1.0))

    @property
    def heading(self) -> float:
        """Heading [rad]."""
        return math.atan2(-self.R[2, 0], self.R[0, 0])


def level_height(hopper: Hopper, p: Array) -> float:
    """Return the height of the body frame for a centre of mass `p`, if the body were level [m]."""
    return float(p[1] - hopper.mass.centre[1])


def yaw_quaternion(angle: float) -> Quaternion:
    """Return the attitude of a level body with a heading [rad]."""
    return from_rotation_vector((0.0, angle, 0.0))


def leaning_attitude(
    hopper: Hopper, ground: Ground, x: float, z: float, heading_angle: float
) -> Quaternion:
    """Return the attitude of a body with a heading that leans with the ground below it."""
    (c, _, s), (_, _, _), (_, _, _) = heading(heading_angle).tolist()
    a, b = (float(w) for w in hopper.half_extents)
    # In (x, z), forward is (c, -s) and right is (s, c).
    around = ground.height(
        x + np.array([a * c, -a * c, b * s, -b * s]), z + np.array([-a * s, a * s, b * c, -b * c])
    )
    ahead, back, right, left = (float(h) for h in around)
    pitch, roll = (
        LEAN_FRACTION * (ahead - back) / (2.0 * a),
        LEAN_FRACTION * (right - left) / (2.0 * b),
    )
    size = math.hypot(pitch, roll)
    k = math.tanh(size / MAX_LEAN) * MAX_LEAN / size if size > 1e-12 else 0.0
    q = quaternion_product(
        from_rotation_vector((0.0, heading_angle, 0.0)),
        from_rotation_vector((-k * roll, 0.0, k * pitch)),
    )
    return q


@dataclass(frozen=True, slots=True)
class PlannedJump:
    """The next jump of an order.

    Attributes:
        up: speed at lift-off [m/s].
        heading: of the body after landing [rad].
        target: (x, z) that the middle of the feet lands at [m]; None for straight on.
        forward: horizontal speed of a jump straight on [m/s].
        is_last: whether it completes the order.
        fold_legs: whether the feet are drawn up as far as the legs fold.
    """

    up: float
    heading: float
    target: tuple[float, float] | None = None
    forward: float = 0.0
    is_last: bool = True
    fold_legs: bool = False


class JumpOrder(Protocol):
    """A scripted order: a sequence of jumps."""

    def next_jump(self, hopper: Hopper, state: HopState, ground: Ground) -> PlannedJump | str:
        """Return the next jump of a hopper about to push off, or the reason why there is none.

        The reason is empty if the order is complete.
        """


@dataclass(eq=False)
class JumpQueue:
    """The jumps that one hopper is to make: those of scripted orders, else its configured ones.

    Attributes:
        jump: the configured jump.
        keep_hopping: whether it makes configured jumps when it has no order.
        hops_from: time from which it makes configured jumps; orders are carried out before [s].
        orders: scripted orders, the current one first.
        planned: the jump of the current order that is being made; None for a configured one.
        jumps_made: number of configured jumps made.
        dropped: orders that were given up, with the reasons, until somebody reads them.
    """

    jump: Jump
    keep_hopping: bool = True
    hops_from: float = 0.0
    orders: list[JumpOrder] = field(default_factory=list)
    planned: PlannedJump | None = None
    jumps_made: int = 0
    dropped: list[tuple[JumpOrder, str]] = field(default_factory=list)

    def plan_next(self, hopper: Hopper, state: HopState, ground: Ground) -> None:
        """Choose the next jump; drop orders that cannot be carried out."""
        self.planned = None
        while self.orders:
            jump = self.orders[0].next_jump(hopper, state, ground)
            if isinstance(jump, PlannedJump):
                self.planned = jump
                break
            ended = self.orders.pop(0)
            if jump:
                self.dropped.append((ended, jump))

    def record_take_off(self) -> None:
        """Advance the queue at a lift-off."""
        if self.planned is None:
            self.jumps_made += 1
        elif self.planned.is_last and self.orders:
            self.orders.pop(0)


def is_overloaded(hopper: Hopper, state: HopState) -> bool:
    """Return whether it stands, or slowly sinks or rises, on too few legs to carry it."""
    if state.phase not in ("standing", "crouching", "rising", "straightening"):
        return False
    force = hopper.mass.mass * float(state.a[1] + GRAVITY)
    return force > available_force(hopper, state) * (1.0 + 1e-9)


def standing_height(
    hopper: Hopper,
    R: Array,
    feet: Array,
    height: float,
    x: float,
    z: float,
    down: NDArray[np.bool_] | None = None,
) -> float:
    """Return the body height at which all feet that are down reach the ground [m].

    Args:
        hopper: the creature.
        R: (3, 3) attitude of the body.
        feet: (n, 3) the feet that are down [m].
        height: upper bound [m].
        x: place of the body [m].
        z: place of the body [m].
        down: (n,) which feet are down; None for all.
    """
    own = slice(None) if down is None else down
    hips = hopper.hips[own] @ R.T + [x, 0.0, z]
    across = ((hips - feet)[:, [0, 2]] ** 2).sum(axis=-1)
    room = np.sqrt(
        np.maximum((STANCE_STRETCH * 0.995 * hopper.leg_lengths[own]) ** 2 - across, 0.0)
    )
    return min(height, float((feet[:, 1] + room - hips[:, 1]).min()))


def floor_height(hopper: Hopper, state: HopState) -> float:
    """Return the mean height of the footholds; 0 without any [m]."""
    if not state.down.any():
        return 0.0
    return float((state.tips[:, 1] - hopper.foot_radii)[state.down].mean())


def available_force(hopper: Hopper, state: HopState) -> float:
    """Return the greatest total force of the legs on the ground [N]."""
    return hopper.max_leg_force * int(state.down.sum())
