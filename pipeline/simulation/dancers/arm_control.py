"""Arm control: force fields on the hand, or joint torques that follow a posture spline."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipeline.simulation.dancers.dance_goals import Goal
from pipeline.simulation.dancers.force_fields import HandField, Point, as_point, desired_velocity
from pipeline.simulation.dancers.posture_sequence import PostureSpline
from pipeline.simulation.dancers.stall_recovery import RETREAT_POSTURES, StallDetector
from pipeline.simulation.dancers.torso import ARM, HANDS, Torso
from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation
from pipeline.simulation.spatial import Array

ELBOW_STIFFNESS, ELBOW_DAMPING = 20.0, 0.9
"""Null-space stiffness [N m/rad] and damping [N m s/rad] of an arm whose hand a field pulls.

Without them the arm swings about the line from shoulder to hand."""

ELBOW_TORQUE_LIMIT = 8.0
"""Largest null-space torque [N m]."""

SETTLED_INTERVAL, SETTLED_TIME = 6, 0.3
"""Controls between updates of the null-space torque once a hand has rested so long [s]."""

RETREAT_TIME, RETREAT_TIME_PER_RADIAN = 0.3, 0.35
"""Least duration of a retreat [s], and its increase with the angle [s/rad]."""

RETRY_TIME, RETRY_TIME_PER_METRE = 0.3, 0.6
"""Least duration of a new approach [s], and its increase with the distance [s/m]."""

CONTACT_RANGE = 0.06
"""Distance from its target at which a contact explains that a hand stopped [m]: two hands thick."""

FIELD_WRIST = np.radians([50.0, 0.0, 0.0])
"""Wrist angles while a field pulls the hand [rad]."""


class ArmController:
    """Controller of one arm.

    Args:
        side: r or l.
        torso: torso of the arm.
        moving: state of the torso.
        rate: k of its fields [1/s].
        winner_takes_all: whether the strongest field acts alone.

    Attributes:
        by_fields: whether fields drive it now.
        fields: force fields of its hand.
        preferred: angles of shoulder and elbow preferred while a field pulls [rad].
        retry_until: earliest arrival of a new approach [s]; -inf without one.
    """

    def __init__(
        self,
        side: str,
        torso: Torso,
        moving: LinkageSimulation,
        rate: float,
        winner_takes_all: bool,
    ) -> None:
        self.side, self.moving, self.number = side, moving, HANDS.index(side)
        self.palm = moving.pulled[self.number]
        arm, wrist = torso.arm(side), torso.wrist(side)
        self.own, self.wrist = arm, wrist
        self.all = slice(arm.start, wrist.stop)
        # Views made once, since there are about a hundred controls a second.
        self._hand, self._q, self._push = moving.places[self.palm], moving.q[arm], moving.push[arm]
        self._targets, self._velocity = moving.targets[self.all], moving.velocities[self.number]
        self._before_wrist = wrist.start - arm.start
        self._wrist_targets = moving.targets[wrist]
        self._jacobian = moving.jacobian(self.number)[:, arm]
        self.fields = HandField(self._hand, rate, winner_takes_all)
        self.by_fields = False
        self.preferred: list[float] = moving.q[arm].tolist()
        self.retry_until = -math.inf
        self._stalls = StallDetector()
        self._retry_from = math.inf
        self._written: PostureSpline | None = None
        self._controls = 0
        self.passage: PostureSpline | None = None
        self.traced: PostureSpline | None = None
        hinges = torso.linkage.hinges[self.all]
        self.stiffness = np.array([hinge.stiffness for hinge in hinges])
        self.lead = np.array([hinge.damping for hinge in hinges]) / self.stiffness
        moving.share(arm.start, arm.stop, self.number, 1.0, ELBOW_DAMPING)

    def drive(self, by_fields: bool) -> None:
        """Switches between force fields and joint torques; ends a retreat."""
        self._retry_from = math.inf
        if by_fields == self.by_fields:
            return
        self.by_fields = by_fields
        self.moving.share(
            self.own.start, self.own.stop, self.number, 0.0 if by_fields else 1.0, ELBOW_DAMPING
        )
        if by_fields:
            self.fields.stay(self.moving.places[self.palm])
        else:
            self.moving.push[self.own] = 0.0
            self.passage = None
            self.moving.targets[self.all] = self.moving.q[self.all]

    def pull(self, goal: Goal, now: float, land: float) -> None:
        """Sends the hand to a goal by force fields."""
        held = np.concatenate([goal.held[: len(ARM)], FIELD_WRIST])
        if goal.subtask.trace is not None:
            self.trace(self.moving.places[list(goal.sites)], held, now, land)
        else:
            self.reach(goal.sites, held, now, land, goal.surface is not None, goal.press)

    def reach(
        self,
        sites: Sequence[int],
        held: Array,
        now: float,
        land: float,
        touches: bool = False,
        press: float = 0.0,
    ) -> None:
        """Sends the hand through sites by force fields.

        Args:
            sites: numbers of the sites; none to turn the wrist alone.
            held: (7,) preferred angles [rad].
            now: start [s].
            land: arrival [s].
            touches: whether the hand touches a surface, which stops it.
            press: depth of the last site below a surface [m].
        """
        self._set_out(held, now, land)
        self._stalls = StallDetector(0 if touches else len(RETREAT_POSTURES))
        self.traced = None
        if sites:
            self.fields.go(sites, now, land, self.moving.places, press)

    def trace(self, places: Array, held: Array, now: float, land: float) -> None:
        """Moves the hand along a curve through fixed positions (m, 3) [m]."""
        self._set_out(held, now, land)
        self._stalls = StallDetector(len(RETREAT_POSTURES))
        self.traced = PostureSpline([np.array(self.fields.point), *places], now, land)

    def _set_out(self, held: Array, now: float, land: float) -> None:
        self.drive(True)
        self.preferred = held[: len(ARM)].tolist()
        self.turn_wrist(held[len(ARM) :], now, land)
        self.retry_until = -math.inf

    def turn(
        self,
        postures: Sequence[Array],
        now: float,
        land: float,
        meets: Array | None = None,
    ) -> None:
        """Sends the joints through postures (7,) [rad]; the hand touches in `meets`."""
        self.passage = PostureSpline([self.desired(now), *postures], now, land, meets)

    def hold(self, now: float) -> None:
        """Holds the present posture."""
        if self._retry_from < math.inf:
            self.drive(True)
        if self.by_fields:
            self.traced = None
            self.fields.stay(self._hand)
        else:
            self.turn((self.desired(now),), now, now)

    def desired(self, now: float) -> Array:
        """Returns the target angles (7,) [rad]."""
        q: Array = self.moving.q[self.all].copy()
        return q if self.passage is None or self.by_fields else self.passage.at(now)[0]

    def control(self, now: float) -> None:
        """Writes the control of the arm."""
        if now >= self._retry_from:
            self._retry(now)
        if self.by_fields:
            self._pull(now)
        passage = self.passage
        if passage is not None and passage is not self._written:
            self._servo(now, passage)

    def _servo(self, now: float, passage: PostureSpline) -> None:
        """Writes servo targets; leading the angles makes the servos follow the speeds too."""
        q, speed = passage.at(now)
        if passage.is_over(now):
            self._written = passage
        else:
            q = q + self.lead * speed
        if self.by_fields:
            self._wrist_targets[:] = q[self._before_wrist :]
        else:
            self._targets[:] = q

    def _pull(self, now: float) -> None:
        moving, fields = self.moving, self.fields
        hand = as_point(self._hand)
        if self.traced is not None:
            point, speed = (as_point(value) for value in self.traced.at(now))
            fields.point = point
            velocity = desired_velocity(point, hand, fields.rate, speed)
        else:
            velocity = fields.desired(hand, now, moving.places)
        self._velocity[:] = velocity
        if self._is_there(now) and self._stalls.is_stalled(hand, self.fields.point, now):
            if not self._is_blocked(hand):
                self._retreat(now)
                return
            self._stalls = StallDetector(0)
        self._controls += 1
        if (
            self._controls % SETTLED_INTERVAL
            and self.traced is None
            and fields.is_there(now - SETTLED_TIME)
        ):
            return
        moving.jacobian(self.number)
        free = _null_space_direction(self._jacobian.tolist())
        torque = 0.0
        for f, wanted, angle in zip(free, self.preferred, self._q.tolist(), strict=True):
            torque += f * ELBOW_STIFFNESS * (wanted - angle)
        torque = min(max(torque, -ELBOW_TORQUE_LIMIT), ELBOW_TORQUE_LIMIT)
        self._push[:] = [torque * f for f in free]

    def _is_there(self, now: float) -> bool:
        """Returns whether the target point, not the hand, has arrived."""
        return self.fields.is_there(now) if self.traced is None else self.traced.is_over(now)

    def _is_blocked(self, hand: Point) -> bool:
        """Returns whether a contact near the target explains that the hand stopped."""
        if math.dist(hand, self.fields.point) > CONTACT_RANGE:
            return False
        solid = f"hand_{self.side}"
        return any(solid in (touch.one, touch.other) for touch in self.moving.touches())

    def _retreat(self, now: float) -> None:
        """Moves a stalled hand by joint torques to a posture from which it approaches anew."""
        posture = self.moving.q[self.all].copy()
        if self.passage is not None:
            posture[len(ARM) :] = self.passage.at(now)[0][len(ARM) :]
        self.preferred = self._stalls.next_retreat(self.preferred)
        posture[: len(ARM)] = self.preferred
        turned = float(np.abs(posture - self.moving.q[self.all]).max())
        there = now + RETREAT_TIME + RETREAT_TIME_PER_RADIAN * turned
        self.drive(False)
        self.turn((posture,), now, there)
        self._retry_from, self.retry_until = there, there + RETRY_TIME

    def _retry(self, now: float) -> None:
        """Starts a new approach after a retreat."""
        wrist = self.desired(now)[len(ARM) :]
        sites, traced, point = self.fields.sites, self.traced, self.fields.point
        self.drive(True)
        self.turn_wrist(wrist, now, now)
        self.retry_until = (
            now + RETRY_TIME + RETRY_TIME_PER_METRE * math.dist(as_point(self._hand), point)
        )
        if traced is not None:
            self.traced = PostureSpline([self._hand.copy(), traced.keys[-1]], now, self.retry_until)
        else:
            self.fields.go(sites[-1:], now, self.retry_until, self.moving.places)

    def turn_wrist(self, angles: Array, now: float, land: float) -> None:
        """Turns the wrist to angles (3,) while a field pulls the hand [rad]."""
        posture = self.moving.q[self.all].copy()
        if self.passage is not None:
            posture[len(ARM) :] = self.passage.at(now)[0][len(ARM) :]
        goal = posture.copy()
        goal[len(ARM) :] = angles
        self.passage = PostureSpline([posture, goal], now, land)


def _null_space_direction(jacobian: list[list[float]]) -> list[float]:
    """Returns the null-space direction of four joints, which leaves the hand in place.

    It is the generalised cross product of the rows of the Jacobian (3, 4), of unit length, and zero
    for a stretched arm. A torque along it exerts no force at the hand.
    """
    (a, b, c, d), (e, f, g, h), (i, j, k, m) = jacobian
    gm_hk, fm_hj, fk_gj = g * m - h * k, f * m - h * j, f * k - g * j
    em_hi, ek_gi, ej_fi = e * m - h * i, e * k - g * i, e * j - f * i
    free = (
        b * gm_hk - c * fm_hj + d * fk_gj,
        -(a * gm_hk - c * em_hi + d * ek_gi),
        a * fm_hj - b * em_hi + d * ej_fi,
        -(a * fk_gj - b * ek_gi + c * ej_fi),
    )
    # It fades out near a stretched arm, where its direction is ill-conditioned.
    length = math.hypot(*free) + 1e-3
    return [value / length for value in free]
