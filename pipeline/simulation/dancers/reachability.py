"""Reachability: places and angles of a dance that no arm reaches are refused with their line.

Joint limits or the trunk may stop an arm on its way to a place that is near enough. A trial finds
out: a force field pulls the hand there, with retreats; a place that stays away is refused.
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
from pipeline.simulation.dancers.key_postures import STEP, pull_to_site
from pipeline.simulation.dancers.torso import HANDS
from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation
from pipeline.simulation.spatial import Array

TRIAL_TOLERANCE = 0.06
"""Distance at which a trial succeeds [m]: the body may stop the hand or sway with it."""


def unreachable_places(
    choreography: Choreography, parts: Sequence[PlacedSubtask], ready: str
) -> Iterator[Problem]:
    """Yields a problem for each position that no hand comes near to.

    Args:
        choreography: of the dancer.
        parts: its subtasks.
        ready: path of the ready places in the scene.
    """
    trial = _Trial(choreography)
    for part, goal in zip(parts, choreography.goals, strict=True):
        for site, key in zip(goal.sites, goal.position_keys, strict=True):
            if key:
                path = part.place_path or f"{part.path}.{key}"
                yield from trial.problem(goal.subtask.hand, site, goal.held, path)
    for side, site in choreography.ready.items():
        yield from trial.problem(side, site, reaching_posture(), f"{ready}.ready.{side}")


class _Trial:
    """A dancer without drums that tries each place once."""

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
        self._tried = set[tuple[str, bytes]]()

    def problem(self, side: str, site: int, held: Array, path: str) -> Iterator[Problem]:
        """Yields a problem if the hand stays away from a site, the arm held near `held` (7,)."""
        moving, arm = self._moving, self._arms[side]
        moving.q[:], moving.v[:], moving.targets[:] = self._home, 0.0, self._home
        moving.q[arm.all] = reaching_posture()
        moving.settle()
        place = moving.places[site].copy()
        key = side, place.tobytes()
        if key in self._tried:
            return
        self._tried.add(key)
        pull_to_site(arm, moving, held, site, 0.0)
        distance = float(np.linalg.norm(moving.places[arm.palm] - place))
        arm.drive(False)
        if distance > TRIAL_TOLERANCE:
            message = (
                "cannot be reached: a joint limit or the body stops the arm; move the place "
                "forward, or to the side of the hand"
            )
            yield Problem(path, message)
