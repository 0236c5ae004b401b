"""Rehearsal: the key postures of places, found by letting a field bring the hand there once.

Joint torques need angles for everything. What a dance says by places is therefore danced once
by fields, slowly and alone, and the angles in which the arm comes to rest at each place are
kept as its postures, as an animator would find them by hand. No inverse kinematics are solved.
A hand that touches presses; servos do so as well when they aim beyond the posture by the torque
that the field had there, over their stiffness.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.dancers.arms import Arm
from pipeline.simulation.dancers.fields import RATE
from pipeline.simulation.dancers.goals import Choreography, Goal, rest_posture
from pipeline.simulation.dancers.torso import ARM, HANDS
from pipeline.simulation.dynamics.mujoco_linkage import Moving
from pipeline.simulation.spatial import Array

STEP, TICK = 0.002, 2
"""Step [s], and how many of them a control lasts."""

WAY, REST = 0.45, 0.35
"""How long a hand takes to a place, and rests there until it is still [s]."""


def postures_of(choreography: Choreography) -> tuple[tuple[Array, ...], ...]:
    """Return the postures (7,) of every subtask: one at each of its places, or of its angles."""
    torso, goals = choreography.torso, choreography.goals
    moving = Moving(torso.linkage, STEP)
    arms = {side: Arm(side, torso, moving, RATE, False) for side in HANDS}
    for arm in arms.values():
        moving.q[arm.all] = rest_posture(arm.side, torso)
        moving.targets[arm.all] = moving.q[arm.all]
    moving.settle()
    stiffness = np.array([hinge.stiffness for hinge in torso.linkage.hinges])
    found, now = list[tuple[Array, ...]](), 0.0
    for goal in goals:
        arm = arms[goal.words.hand]
        if goal.words.is_of_joints:
            before = moving.q[arm.all].copy()
            posture = np.where(goal.given, goal.held, before)
            arm.drive(False)
            moving.targets[arm.all] = moving.q[arm.all] = posture
            moving.v[arm.all] = 0.0
            moving.settle()
            found.append((posture,))
            continue
        rows = list[Array]()
        for spot in goal.spots:
            now = _visit(arm, moving, goal, spot, now)
            rows.append(moving.q[arm.all] + moving.given()[arm.all] / stiffness[arm.all])
        # The last is where it stays: hints alone turn a wrist.
        found.append(tuple(rows))
    return tuple(found)


def _visit(arm: Arm, moving: Moving, goal: Goal, spot: int, now: float) -> float:
    """Bring the hand to one place; return the time then."""
    arm.drive(True)
    arm.ease = goal.held[: len(ARM)].tolist()
    arm.traced = None
    arm.fields.go([spot], now, now + WAY, moving.places)
    arm.turn_wrist(goal.held[len(ARM) :], now, now + WAY)
    for _ in range(round((WAY + REST) / (STEP * TICK))):
        arm.control(now)
        done = 0
        while done < TICK:
            done += moving.advance(TICK - done)
        now += STEP * TICK
    return now
