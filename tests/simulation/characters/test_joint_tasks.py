"""Joint tasks: who gives a thing stands for the other that comes for it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

import pytest

from pipeline.simulation.characters.hand_over import HandOver
from pipeline.simulation.characters.joint_tasks import stand_to_give
from pipeline.simulation.characters.person_tasks import SitDown, Task, Walk
from pipeline.simulation.characters.task_dispatcher import TaskDispatcher


@dataclass
class People:
    """People of whom one is about to give."""

    its_task: Task | None
    minded: dict[int, object] = field(default_factory=lambda: {3: None})
    giving: set[int] = field(default_factory=set)
    ended: list[int] = field(default_factory=list)

    def task(self, k: int) -> Task | None:
        """Return the task of a person."""
        return self.its_task

    def end(self, k: int) -> None:
        """Note that the task of a person ends."""
        self.ended.append(k)


@dataclass
class Giving:
    """A hand-over whose taker is near, or not."""

    is_near: bool


def _stand(people: People, is_near: bool, k: int = 3) -> set[int]:
    givings = {k: cast(HandOver, Giving(is_near))}
    return stand_to_give(cast(TaskDispatcher, people), givings)


def test_a_walk_of_its_own_will_ends_once_when_the_taker_comes_near() -> None:
    people = People(Walk())
    assert _stand(people, is_near=False) == set()
    assert not people.ended
    people.giving = _stand(people, is_near=True)
    assert people.giving == {3}
    assert people.ended == [3]
    assert _stand(people, is_near=True) == {3}
    assert people.ended == [3]


@pytest.mark.parametrize(("k", "task"), [(3, SitDown()), (4, Walk())])
def test_who_sits_or_has_no_mind_goes_on(k: int, task: Task) -> None:
    people = People(task)
    assert _stand(people, is_near=True, k=k) == set()
    assert not people.ended
