"""Gaze choice: what each person looks at, by orders, its mind, its task, or an act given up."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY, IntArray
from pipeline.simulation.characters.character_view import CharacterView
from pipeline.simulation.characters.gaze_targets import ELSEWHERE
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_tasks import Task
from pipeline.simulation.characters.second_try import Regret
from pipeline.spec.model_base import Target


class GazeChoice:
    """What the people of a troupe look at.

    Args:
        view: all characters.
        count: number of people.

    Attributes:
        targets: that orders name, None to look where task and mind say.
        glances: (P,) numbers of characters that minds choose, or NOBODY.
        regrets: of people that have given up.
    """

    def __init__(self, view: CharacterView, count: int) -> None:
        self._view = view
        self.targets: list[Target | None] = [None] * count
        self.glances: IntArray = np.full(count, NOBODY)
        self.regrets: list[Regret | None] = [None] * count

    def is_led(self, k: int) -> bool:
        """Tell whether an order or an act given up leads the gaze of a person."""
        return self.regrets[k] is not None or self.targets[k] is not None

    def members(self, k: int) -> set[str]:
        """Return the names of the members whose states the gaze of a person needs."""
        target = self.targets[k]
        return {target} if isinstance(target, str) and self._view.owner(target) < 0 else set()

    def choose(self, k: int, controller: PersonController, task: Task | None, time: float) -> int:
        """Return the character to look at, NOBODY, or ELSEWHERE for a place that this sets."""
        regret = self.regrets[k]
        if regret is not None:
            if regret.look(controller, time):
                return ELSEWHERE
            self.regrets[k] = None
        target = self.targets[k]
        if isinstance(target, str):
            owner = self._view.owner(target)
            if owner >= 0:
                return owner
            controller.look_at(self._view.state(target).face)
        elif target is not None:
            controller.look_at(np.array(target))
        else:
            owner = int(self.glances[k])
            if owner < 0 and task is not None:
                owner = getattr(task, "owner", NOBODY)
            subject = task.subject(controller) if task is not None and owner < 0 else None
            if subject is None:
                return owner
            controller.look_at(subject)
        return ELSEWHERE
