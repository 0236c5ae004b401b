"""Arms: what moves one arm, by fields on its hand or by torques of its joints."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipeline.simulation.dancers.dance_goals import Goal
from pipeline.simulation.dancers.force_fields import (
    HandField,
    Point,
    as_point,
    desired_velocity,
)
from pipeline.simulation.dancers.posture_sequence import PostureSpline
from pipeline.simulation.dancers.stall_recovery import RETREAT_POSTURES, StallDetector
from pipeline.simulation.dancers.torso import ARM, HANDS, Torso
from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation
from pipeline.simulation.spatial import Array

EASE, CALM = 20.0, 0.9
"""Stiffness [N m/rad] and damping [N m s/rad] that hold the elbow of an arm whose hand is pulled:
without them the arm swings about the line from shoulder to hand like a marionette's."""

MOST_EASE = 8.0
"""Greatest torque that does so [N m]."""

SELDOM, SETTLES = 6, 0.3
"""The elbow of a hand that has been where it goes for so long [s] is looked after at every sixth
control alone: it hardly moves."""

BACK, BACK_BY, AGAIN, AGAIN_BY = 0.3, 0.35, 0.3, 0.6
"""How long a hand that was held up is taken back, and reaches anew, at least [s]; and how much
longer by the angle [s/rad], and by the way [s/m]."""

BY = 0.06
"""How far from its point a hand may be stopped by something that it touches [m]: two thick."""

STIFF_WRIST = np.radians([50.0, 0.0, 0.0])
"""How wrists are held while a field pulls the hand [rad]."""


class ArmController:
    """One arm of a dancer.

    Args:
        side: r or l.
        torso: whose.
        moving: the torso in motion.
        rate: k of its fields [1/s].
        winner: whether the strongest field acts alone.

    Attributes:
        by_fields: whether fields move it now.
        fields: of its hand.
        ease: angles of shoulder and elbow that it is held near to while a field pulls [rad].
        anew_until: when a hand that was held up is there at the earliest on its new way; -inf
            if it was not held up [s].
    """

    def __init__(
        self, side: str, torso: Torso, moving: LinkageSimulation, rate: float, winner: bool
    ) -> None:
        self.side, self.moving, self.number = side, moving, HANDS.index(side)
        self.palm = moving.pulled[self.number]
        arm, wrist = torso.arm(side), torso.wrist(side)
        self.own, self.wrist = arm, wrist
        self.all = slice(arm.start, wrist.stop)
        # Views, made once: there are some hundred controls a second.
        self._hand, self._q, self._push = moving.places[self.palm], moving.q[arm], moving.push[arm]
        self._targets, self._velocity = moving.targets[self.all], moving.velocities[self.number]
        self._before_wrist = wrist.start - arm.start
        self._wrist_targets = moving.targets[wrist]
        self._jacobian = moving.jacobian(self.number)[:, arm]
        self.fields = HandField(self._hand, rate, winner)
        self.by_fields = False
        self.ease: list[float] = moving.q[arm].tolist()
        self.anew_until = -math.inf
        self._patience = StallDetector()
        self._anew_from = math.inf
        self._written: PostureSpline | None = None
        self._controls = 0
        self.passage: PostureSpline | None = None
        self.traced: PostureSpline | None = None
        hinges = torso.linkage.hinges[self.all]
        self.stiffness = np.array([hinge.stiffness for hinge in hinges])
        self.lead = np.array([hinge.damping for hinge in hinges]) / self.stiffness
        moving.share(arm.start, arm.stop, self.number, 1.0, CALM)

    def drive(self, by_fields: bool) -> None:
        """Let fields or torques move it from now on; a hand that is taken back stays so."""
        self._anew_from = math.inf
        if by_fields == self.by_fields:
            return
        self.by_fields = by_fields
        self.moving.share(
            self.own.start, self.own.stop, self.number, 0.0 if by_fields else 1.0, CALM
        )
        if by_fields:
            self.fields.stay(self.moving.places[self.palm])
        else:
            self.moving.push[self.own] = 0.0
            self.passage = None
            self.moving.targets[self.all] = self.moving.q[self.all]

    def pull(self, goal: Goal, now: float, land: float) -> None:
        """Send the hand to a goal by fields."""
        held = np.concatenate([goal.held[: len(ARM)], STIFF_WRIST])
        if goal.words.trace is not None:
            self.trace(self.moving.places[list(goal.spots)], held, now, land)
        else:
            self.reach(goal.spots, held, now, land, goal.surface is not None, goal.press)

    def reach(
        self,
        spots: Sequence[int],
        held: Array,
        now: float,
        land: float,
        touches: bool = False,
        press: float = 0.0,
    ) -> None:
        """Send the hand through places by fields.

        Args:
            spots: their numbers; none to turn the wrist alone.
            held: (7,) angles that the arm is held near to [rad].
            now: when it sets out [s].
            land: when it is to be there [s].
            touches: whether it is to meet something, which then holds it up.
            press: how far under a surface the last place is [m].
        """
        self._set_out(held, now, land)
        self._patience = StallDetector(0 if touches else len(RETREAT_POSTURES))
        self.traced = None
        if spots:
            self.fields.go(spots, now, land, self.moving.places, press)

    def trace(self, places: Array, held: Array, now: float, land: float) -> None:
        """Lead the hand along a curve through places (m, 3) that stay where they are [m]."""
        self._set_out(held, now, land)
        self._patience = StallDetector(len(RETREAT_POSTURES))
        self.traced = PostureSpline([np.array(self.fields.point), *places], now, land)

    def _set_out(self, held: Array, now: float, land: float) -> None:
        self.drive(True)
        self.ease = held[: len(ARM)].tolist()
        self.turn_wrist(held[len(ARM) :], now, land)
        self.anew_until = -math.inf

    def turn(
        self,
        postures: Sequence[Array],
        now: float,
        land: float,
        meets: Array | None = None,
    ) -> None:
        """Send the joints through postures (7,), in `meets` of which a hand touches [rad]."""
        self.passage = PostureSpline([self.desired(now), *postures], now, land, meets)

    def hold(self, now: float) -> None:
        """Stay where it is."""
        if self._anew_from < math.inf:
            self.drive(True)
        if self.by_fields:
            self.traced = None
            self.fields.stay(self._hand)
        else:
            self.turn((self.desired(now),), now, now)

    def desired(self, now: float) -> Array:
        """Return (7,) where the joints are to be now [rad]."""
        q: Array = self.moving.q[self.all].copy()
        return q if self.passage is None or self.by_fields else self.passage.at(now)[0]

    def control(self, now: float) -> None:
        """Write what the arm is to do from now on."""
        if now >= self._anew_from:
            self._go_anew(now)
        if self.by_fields:
            self._pull(now)
        passage = self.passage
        if passage is not None and passage is not self._written:
            self._servo(now, passage)

    def _servo(self, now: float, passage: PostureSpline) -> None:
        """Let servos follow the passage: what leads the angles makes them follow the speeds too."""
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
        if self._is_there(now) and self._patience.is_lost(hand, self.fields.point, now):
            if not self._meets(hand):
                self._take_back(now)
                return
            self._patience = StallDetector(0)
        self._controls += 1
        if self._controls % SELDOM and self.traced is None and fields.is_there(now - SETTLES):
            return
        moving.jacobian(self.number)
        free = _free(self._jacobian.tolist())
        torque = 0.0
        for f, wanted, angle in zip(free, self.ease, self._q.tolist(), strict=True):
            torque += f * EASE * (wanted - angle)
        torque = min(max(torque, -MOST_EASE), MOST_EASE)
        self._push[:] = [torque * f for f in free]

    def _is_there(self, now: float) -> bool:
        """Tell whether the point, not the hand, has come to its last place."""
        return self.fields.is_there(now) if self.traced is None else self.traced.is_over(now)

    def _meets(self, hand: Point) -> bool:
        """Tell whether the hand is where it can be: by its place, on something that it touches."""
        if math.dist(hand, self.fields.point) > BY:
            return False
        solid = f"hand_{self.side}"
        return any(solid in (touch.one, touch.other) for touch in self.moving.touches())

    def _take_back(self, now: float) -> None:
        """Take a hand that is held up back by torques, to reach for its place from there."""
        posture = self.moving.q[self.all].copy()
        if self.passage is not None:
            posture[len(ARM) :] = self.passage.at(now)[0][len(ARM) :]
        self.ease = self._patience.withdraws_to(self.ease)
        posture[: len(ARM)] = self.ease
        turned = float(np.abs(posture - self.moving.q[self.all]).max())
        there = now + BACK + BACK_BY * turned
        self.drive(False)
        self.turn((posture,), now, there)
        self._anew_from, self.anew_until = there, there + AGAIN

    def _go_anew(self, now: float) -> None:
        """Let fields pull the hand that was taken back to where it was to be."""
        wrist = self.desired(now)[len(ARM) :]
        spots, traced, point = self.fields.spots, self.traced, self.fields.point
        self.drive(True)
        self.turn_wrist(wrist, now, now)
        self.anew_until = now + AGAIN + AGAIN_BY * math.dist(as_point(self._hand), point)
        if traced is not None:
            self.traced = PostureSpline([self._hand.copy(), traced.keys[-1]], now, self.anew_until)
        else:
            self.fields.go(spots[-1:], now, self.anew_until, self.moving.places)

    def turn_wrist(self, angles: Array, now: float, land: float) -> None:
        """Turn the wrist to angles (3,) while a field pulls the hand [rad]."""
        posture = self.moving.q[self.all].copy()
        if self.passage is not None:
            posture[len(ARM) :] = self.passage.at(now)[0][len(ARM) :]
        goal = posture.copy()
        goal[len(ARM) :] = angles
        self.passage = PostureSpline([posture, goal], now, land)


def _free(jacobian: list[list[float]]) -> list[float]:
    """Return the motion of four joints that leaves the hand where it is, of unit length.

    It is the generalised vector product of the rows of the Jacobian (3, 4); zero where the arm
    is stretched and has no such motion alone. A torque along it pulls at no hand at rest.
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
    # Near a stretched arm it fades out; its direction is no longer certain there.
    length = math.hypot(*free) + 1e-3
    return [value / length for value in free]
