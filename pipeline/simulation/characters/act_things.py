"""Act things: what the task of a person is about, over which its feet do not mean to step."""

from __future__ import annotations

from pipeline.simulation.characters.body_arrays import NOBODY, SOLID
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_tasks import Task
from pipeline.simulation.characters.second_try import StepAside


def mark_act_things(controller: PersonController, task: Task | None) -> None:
    """Write what a task is about into the record of its person.

    What it steps aside from for a second try stays what it is about.
    """
    if isinstance(task, StepAside):
        return
    owner = max(getattr(task, "owner", NOBODY), NOBODY)
    found = [] if owner == NOBODY else [owner]
    if task is not None and task.members:
        view = controller.view
        numbers = view.decks.tracker.thing_numbers
        for name in task.members:
            if (other := view.owner(name)) >= 0:
                found.append(other)
            elif name in numbers:
                found.append(SOLID - numbers[name])
    marks = controller.record.act_things
    marks[0] = found[0] if found else NOBODY
    marks[1] = found[1] if len(found) > 1 else NOBODY
