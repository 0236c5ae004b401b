"""Company behaviours: walking along with somebody."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipeline.simulation.characters.behaviours.registry import (
    ConfiguredBehaviour,
    implements,
)
from pipeline.simulation.characters.company_task import WalkAlong, leads_somewhere, usual_pace
from pipeline.simulation.characters.mind.motor_command import MotorCommand
from pipeline.spec.behaviour import Accompany

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

JOINING_RANGE = 8.0  # within which a walking companion is joined [m]
JOINING_ACTIVATION = 0.6


@implements(Accompany)
class AccompanyOther(ConfiguredBehaviour[Accompany]):
    """Walk along with a companion."""

    def __init__(self, config: Accompany, mind: Mind) -> None:
        super().__init__(config, mind)
        self.target = mind.number(config.accompany)
        self.task: WalkAlong | None = None

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        leader = mind.record_of(self.target)
        if leader is None:
            return 0.0
        goes = self.task is not None and not self.task.is_there
        if not goes and not leads_somewhere(leader):
            return 0.0
        is_near = mind.distance_to(self.target) < JOINING_RANGE
        return JOINING_ACTIVATION + self.config.urge if is_near else 0.0

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        leader = mind.record_of(self.target)
        if self.task is None or self.task.is_there:
            assert leader is not None
            self.task = WalkAlong(leader)
        return MotorCommand(task=self.task, pace=usual_pace(mind.controller.record))

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.task = None
