"""Motor command: what a behaviour asks of the body."""

from __future__ import annotations

from typing import NamedTuple

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.person_tasks import Task


class MotorCommand(NamedTuple):
    """The motor vector of a behaviour.

    Attributes:
        goal: x and z to walk to [m]; None stands.
        pace: walking speed [m/s].
        target: number of the character approached and glanced at, or NOBODY.
        touching: whether the target is approached closely and not stepped aside for.
        facing: heading to stand or step back in [rad]; None faces the goal.
        reaching: whether both arms are held out ahead.
        task: done in place of all this, such as a hug.
        sits: whether to sit down.
        frozen: whether to keep quite still.
        startled: whether it starts back from pain.
    """

    goal: tuple[float, float] | None = None
    pace: float = 1.0
    target: int = NOBODY
    touching: bool = False
    facing: float | None = None
    reaching: bool = False
    task: Task | None = None
    sits: bool = False
    frozen: bool = False
    startled: bool = False
