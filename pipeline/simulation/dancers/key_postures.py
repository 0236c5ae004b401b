"""Rehearsal: the key postures of places, found by letting a field bring the hand there once.

Joint torques need angles for everything. What a dance says by places is therefore danced once
by fields, slowly and alone, and the angles in which the arm comes to rest at each place are
kept as its postures, as an animator would find them by hand. No inverse kinematics are solved.
A hand that touches presses; servos do so as well when they aim beyond the posture by the torque
that the field had there, over their stiffness.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from pipeline.simulation.dancers.arm_control import ArmController
from pipeline.simulation.dancers.dance_goals import (
    Choreography,
    Goal,
    hanging_posture,
    reaching_posture,
)
from pipeline.simulation.dancers.force_fields import FIELD_RATE
from pipeline.simulation.dancers.torso import HANDS
from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation
from pipeline.simulation.spatial import Array

STEP, TICK = 0.002, 2
"""Step [s], and how many of them a control lasts."""

BEYOND = 0.12
"""How far beyond a posture servos aim at most to press as the field did [rad]."""

WAY, REST = 0.45, 0.35
"""How long a hand takes to a place, and rests there until it is still [s]."""


@dataclass(frozen=True, eq=False)
class KeyPostures:
    """The postures of one subtask.

    Attributes:
        keys: (7,) each, one at each of its places, or of its angles [rad].
        meets: (7,) in which the hand touches, before the last; None where it touches nothing.
    """

    keys: tuple[Array, ...]
    meets: Array | None = None


@lru_cache(maxsize=4)
def key_postures(choreography: Choreography) -> tuple[KeyPostures, ...]:
    """Return the postures of every subtask; who practises asks for the same several times."""
    torso = choreography.torso
    moving = LinkageSimulation(torso.linkage, STEP)
    arms = {side: ArmController(side, torso, moving, FIELD_RATE, False) for side in HANDS}
    ready = ready_postures(choreography)
    for side, arm in arms.items():
        moving.q[arm.all] = moving.targets[arm.all] = ready.get(side, hanging_posture())
    moving.settle()
    found, now = list[KeyPostures](), 0.0
    for goal in choreography.goals:
        arm = arms[goal.words.hand]
        if goal.words.is_of_joints:
            found.append(_taken_up(arm, moving, goal))
            continue
        keys, met = list[Array](), moving.q[arm.all]
        for spot in goal.spots:
            now = _visit(arm, moving, goal, spot, now)
            met = moving.q[arm.all].copy()
            beyond = moving.given()[arm.all] / arm.stiffness
            keys.append(met + np.clip(beyond, -BEYOND, BEYOND))
        found.append(KeyPostures(tuple(keys), met if goal.surface is not None else None))
    return tuple(found)


@lru_cache(maxsize=4)
def ready_postures(choreography: Choreography) -> Mapping[str, Array]:
    """Return the postures (7,) in which hands are ready, by side; hands go there past all drums."""
    if not choreography.ready:
        return {}
    linkage = replace(choreography.torso.linkage, discs=())
    torso = replace(choreography.torso, linkage=linkage)
    moving, found = LinkageSimulation(linkage, STEP), dict[str, Array]()
    for side, spot in choreography.ready.items():
        arm = ArmController(side, torso, moving, FIELD_RATE, False)
        pull_to_spot(arm, moving, reaching_posture(), spot, 0.0)
        found[side] = moving.q[arm.all].copy()
    return found


def pull_to_spot(
    arm: ArmController,
    moving: LinkageSimulation,
    held: Array,
    spot: int,
    now: float,
    touches: bool = False,
) -> float:
    """Let a field bring a hand to a place until it rests there.

    Args:
        arm: whose hand.
        moving: its torso, with steps of `STEP`.
        held: (7,) angles that the arm is held near to [rad].
        spot: number of the place.
        now: the time [s].
        touches: whether it is to meet something there.

    Returns:
        The time then [s].
    """
    arm.reach([spot], held, now, now + WAY, touches)
    end = now + WAY + REST
    while now < end - 0.5 * STEP:
        arm.control(now)
        done = 0
        while done < TICK:
            done += moving.advance(TICK - done)
        now += STEP * TICK
        # Who is held up reaches anew, and rests there.
        end = max(end, arm.anew_until + REST)
    return now


def _taken_up(arm: ArmController, moving: LinkageSimulation, goal: Goal) -> KeyPostures:
    """Put an arm into angles that are given."""
    posture = np.where(goal.given, goal.held, moving.q[arm.all])
    arm.drive(False)
    moving.targets[arm.all] = moving.q[arm.all] = posture
    moving.v[arm.all] = 0.0
    moving.settle()
    return KeyPostures((posture,))


def _visit(
    arm: ArmController, moving: LinkageSimulation, goal: Goal, spot: int, now: float
) -> float:
    """Bring the hand to one place of a subtask; return the time then."""
    return pull_to_spot(arm, moving, goal.held, spot, now, goal.surface is not None)
