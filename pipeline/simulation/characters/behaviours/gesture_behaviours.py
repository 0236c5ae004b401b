"""Gesture behaviours: comforting a friend that is sad or hurt with a hand on its shoulder."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipeline.simulation.characters.behaviours.registry import (
    ConfiguredBehaviour,
    implements,
)
from pipeline.simulation.characters.mind.motor_command import MotorCommand
from pipeline.simulation.characters.soothe_task import Soothe
from pipeline.spec.behaviour import Soothe as SootheConfig

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

SOOTHING_RANGE = 1.6  # within which a sad friend is soothed [m]
SADNESS = 0.4  # that a face shows, from which it is comforted
PAIN = 0.2  # the same, of pain
SOOTHING_ACTIVATION = 0.55
PAUSE = 6.0  # before the same friend is comforted again [s]


@implements(SootheConfig)
class SootheFriend(ConfiguredBehaviour[SootheConfig]):
    """Go up to a sad or hurt person nearby, and stroke its shoulder."""

    def __init__(self, config: SootheConfig, mind: Mind) -> None:
        super().__init__(config, mind)
        self.target = mind.number(config.soothe)
        self.task: Soothe | None = None
        self.again = 0.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if self.task is not None and (self.task.is_over or self.task.failure):
            self.task, self.again = None, mind.now + PAUSE
        if self.task is not None:
            return SOOTHING_ACTIVATION + self.config.urge
        if mind.now < self.again or mind.distance_to(self.target) > SOOTHING_RANGE:
            return 0.0
        view = mind.surroundings.view
        pain = float(view.arrays.owners["pain"][self.target])
        is_sad = view.sadness.get(self.target, 0.0) > SADNESS or pain > PAIN
        is_calm = mind.anger < SADNESS and mind.anxiety < SADNESS
        return SOOTHING_ACTIVATION + self.config.urge if is_sad and is_calm else 0.0

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        if self.task is None:
            self.task = Soothe(self.target)
        return MotorCommand(task=self.task, pace=mind.stroll, target=self.target, touching=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        if self.task is not None:
            self.task, self.again = None, mind.now + PAUSE
