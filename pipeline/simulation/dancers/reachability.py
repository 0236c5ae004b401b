"""Trying: places to which no way of holding the arm brings a hand, found by trying each once.

Whether a place is too far or inside the body is seen at once. That joints do not turn so far, or
that the trunk is in the way of the forearm, is found as a person would find it: a field pulls
the hand there, the arm is taken back and reaches anew, and what it has not come near to by then
is told.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pipeline.errors import Problem
from pipeline.simulation.dancers.arm_control import ArmController
from pipeline.simulation.dancers.dance_goals import (
    Choreography,
    PlacedSubtask,
    hanging_posture,
    reaching_posture,
)
from pipeline.simulation.dancers.force_fields import FIELD_RATE
from pipeline.simulation.dancers.key_postures import STEP, pull_to_spot
from pipeline.simulation.dancers.torso import HANDS
from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation
from pipeline.simulation.spatial import Array

OFF = 0.06
"""How far from a place a hand may stay that is stopped by the body or sways along with it [m]."""


def unreachable_places(
    choreography: Choreography, parts: Sequence[PlacedSubtask], ready: str
) -> Iterator[Problem]:
    """Yield places that are said as positions and that no hand comes to.

    Args:
        choreography: of the dancer.
        parts: its subtasks.
        ready: path of what says where its hands are at first.
    """
    tried = _Trial(choreography)
    for part, goal in zip(parts, choreography.goals, strict=True):
        for spot, word in zip(goal.spots, goal.said, strict=True):
            if word:
                path = part.said or f"{part.path}.{word}"
                yield from tried.problem(goal.words.hand, spot, goal.held, path)
    for side, spot in choreography.ready.items():
        yield from tried.problem(side, spot, reaching_posture(), f"{ready}.ready.{side}")


class _Trial:
    """A dancer that tries places, each of them once; drums are not in its way."""

    def __init__(self, choreography: Choreography) -> None:
        linkage = replace(choreography.torso.linkage, discs=())
        torso = replace(choreography.torso, linkage=linkage)
        self._moving = LinkageSimulation(linkage, STEP)
        self._arms = {
            side: ArmController(side, torso, self._moving, FIELD_RATE, False) for side in HANDS
        }
        self._home = self._moving.q.copy()
        for arm in self._arms.values():
            self._home[arm.all] = hanging_posture()
        self._known = set[tuple[str, bytes]]()

    def problem(self, side: str, spot: int, held: Array, path: str) -> Iterator[Problem]:
        """Yield what is to be said of a place, held near a posture (7,), if that is anything."""
        moving, arm = self._moving, self._arms[side]
        moving.q[:], moving.v[:], moving.targets[:] = self._home, 0.0, self._home
        moving.q[arm.all] = reaching_posture()
        moving.settle()
        place = moving.places[spot].copy()
        known = side, place.tobytes()
        if known in self._known:
            return
        self._known.add(known)
        pull_to_spot(arm, moving, held, spot, 0.0)
        off = float(np.linalg.norm(moving.places[arm.palm] - place))
        arm.drive(False)
        if off > OFF:
            message = (
                "is where no arm goes: its joints or the body stop it; bring it further to the "
                "front, or to the hand's own side"
            )
            yield Problem(path, message)
