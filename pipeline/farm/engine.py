"""Engine: workers that carry out tasks, one each at a time, on one machine or on many."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal, Protocol

from pipeline.farm.tasks import Task, TaskResult

Death = Literal["crashed", "lost"]
"""Why a worker is no more: its process died, or its machine is gone or took it back."""


@dataclass(frozen=True, slots=True)
class Ended:
    """The end of a task.

    Attributes:
        worker: that had it.
        result: None if the worker died.
        death: of the worker, None if it lives.
        reason: of the death.
    """

    worker: str
    result: TaskResult | None = None
    death: Death | None = None
    reason: str = ""


class Engine(Protocol):
    """Workers that carry out tasks."""

    @property
    def workers(self) -> Collection[str]:
        """Names of the workers there are; dead ones are replaced after a while."""
        ...

    @property
    def idle(self) -> Collection[str]:
        """Names of those without a task."""
        ...

    def start(self, worker: str, task: Task) -> None:
        """Give a task to an idle worker."""
        ...

    def wait(self, seconds: float) -> list[Ended]:
        """Return the tasks that ended, after some time at most."""
        ...

    def discard(self, worker: str) -> None:
        """End a worker with its task, which then never ends; another takes its place."""
        ...

    def close(self) -> None:
        """End all workers."""
        ...
