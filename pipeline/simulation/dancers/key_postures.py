"""Key postures: joint angles of places, found by pulling the hand there once with a force field.

Joint torques need angles. A field therefore dances the places of a dance once, slowly, and the
angles at which the arm comes to rest become its key postures. No inverse kinematics is solved. To
press on a surface, servos aim beyond the posture by the torque of the field over their stiffness.
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

STEP = 0.002
"""Step of the dynamics [s]."""

STEPS_PER_CONTROL = 2

PRESS_ANGLE_LIMIT = 0.12
"""Largest angle by which servos aim beyond a posture to press [rad]."""

TRAVEL_TIME, SETTLE_TIME = 0.45, 0.35
"""Time of a hand to a place, and to come to rest there [s]."""


@dataclass(frozen=True, eq=False)
class KeyPostures:
    """The postures of one subtask.

    Attributes:
        keys: angles (7,) at each of its places [rad].
        meets: angles (7,) at first contact, before the last key; None without a contact [rad].
    """

    keys: tuple[Array, ...]
    meets: Array | None = None


@lru_cache(maxsize=4)
def key_postures(choreography: Choreography) -> tuple[KeyPostures, ...]:
    """Returns the postures of every subtask; practice asks for the same ones repeatedly."""
    torso = choreography.torso
    moving = LinkageSimulation(torso.linkage, STEP)
    arms = {side: ArmController(side, torso, moving, FIELD_RATE, False) for side in HANDS}
    ready = ready_postures(choreography)
    for side, arm in arms.items():
        moving.q[arm.all] = moving.targets[arm.all] = ready.get(side, hanging_posture())
    moving.settle()
    found, now = list[KeyPostures](), 0.0
    for goal in choreography.goals:
        arm = arms[goal.subtask.hand]
        if goal.subtask.is_of_joints:
            found.append(_assume_angles(arm, moving, goal))
            continue
        keys, met = list[Array](), moving.q[arm.all]
        for site in goal.sites:
            now = _visit(arm, moving, goal, site, now)
            met = moving.q[arm.all].copy()
            beyond = moving.given()[arm.all] / arm.stiffness
            keys.append(met + np.clip(beyond, -PRESS_ANGLE_LIMIT, PRESS_ANGLE_LIMIT))
        found.append(KeyPostures(tuple(keys), met if goal.surface is not None else None))
    return tuple(found)


@lru_cache(maxsize=4)
def ready_postures(choreography: Choreography) -> Mapping[str, Array]:
    """Returns the start postures (7,) by side [rad]; drums are no obstacles on the way."""
    if not choreography.ready:
        return {}
    linkage = replace(choreography.torso.linkage, discs=())
    torso = replace(choreography.torso, linkage=linkage)
    moving, found = LinkageSimulation(linkage, STEP), dict[str, Array]()
    for side, site in choreography.ready.items():
        arm = ArmController(side, torso, moving, FIELD_RATE, False)
        pull_to_site(arm, moving, reaching_posture(), site, 0.0)
        found[side] = moving.q[arm.all].copy()
    return found


def pull_to_site(
    arm: ArmController,
    moving: LinkageSimulation,
    held: Array,
    site: int,
    now: float,
    touches: bool = False,
) -> float:
    """Pulls a hand to a site by a force field until it rests there.

    Args:
        arm: arm of the hand.
        moving: state of its torso, with steps of `STEP`.
        held: (7,) preferred angles [rad].
        site: number of the site.
        now: start [s].
        touches: whether the hand touches a surface there.

    Returns:
        The end [s].
    """
    arm.reach([site], held, now, now + TRAVEL_TIME, touches)
    end = now + TRAVEL_TIME + SETTLE_TIME
    while now < end - 0.5 * STEP:
        arm.control(now)
        done = 0
        while done < STEPS_PER_CONTROL:
            done += moving.advance(STEPS_PER_CONTROL - done)
        now += STEP * STEPS_PER_CONTROL
        # A stalled hand retries and then needs time to rest.
        end = max(end, arm.retry_until + SETTLE_TIME)
    return now


def _assume_angles(arm: ArmController, moving: LinkageSimulation, goal: Goal) -> KeyPostures:
    """Puts an arm into given angles."""
    posture = np.where(goal.given, goal.held, moving.q[arm.all])
    arm.drive(False)
    moving.targets[arm.all] = moving.q[arm.all] = posture
    moving.v[arm.all] = 0.0
    moving.settle()
    return KeyPostures((posture,))


def _visit(
    arm: ArmController, moving: LinkageSimulation, goal: Goal, site: int, now: float
) -> float:
    """Pulls the hand to one site of a subtask; returns the end [s]."""
    return pull_to_site(arm, moving, goal.held, site, now, goal.surface is not None)
