"""An engine whose workers are in this process, and fail as tests ask."""

from __future__ import annotations

from collections.abc import Callable

from pipeline.farm.engine import Ended
from pipeline.farm.tasks import Rendering, Task, TaskResult

Act = Callable[[str, Task], TaskResult | Ended | None]
"""Carries out a task of a worker; None for one that never ends."""


class ScriptedEngine:
    """Workers that carry out tasks when the driver waits.

    Args:
        count: number of workers.
        act: what they do.

    Attributes:
        started: every task with its worker, in order.
        discarded: workers that were ended with their tasks.
        closed: whether it is closed.
    """

    def __init__(self, count: int, act: Act) -> None:
        self.workers = [f"worker {number}" for number in range(1, count + 1)]
        self.started: list[tuple[str, Task]] = []
        self.discarded: list[str] = []
        self.closed = False
        self._act = act
        self._busy: dict[str, Task] = {}
        self._hanging: set[str] = set()

    @property
    def idle(self) -> list[str]:
        """Names of the workers without a task."""
        return [name for name in self.workers if name not in self._busy]

    @property
    def chunks(self) -> list[tuple[int, ...]]:
        """Frames of every rendering task."""
        return [task.frames for _, task in self.started if isinstance(task, Rendering)]

    def start(self, worker: str, task: Task) -> None:
        """Give a task to an idle worker."""
        assert worker not in self._busy
        self.started.append((worker, task))
        self._busy[worker] = task

    def wait(self, seconds: float) -> list[Ended]:
        """Return the ends of all tasks that do not hang."""
        ended = []
        for worker, task in list(self._busy.items()):
            if worker in self._hanging:
                continue
            result = self._act(worker, task)
            if result is None:
                self._hanging.add(worker)
                continue
            del self._busy[worker]
            ended.append(result if isinstance(result, Ended) else Ended(worker, result))
        return ended

    def discard(self, worker: str) -> None:
        """End a worker with its task."""
        self.discarded.append(worker)
        self._busy.pop(worker, None)
        self._hanging.discard(worker)

    def close(self) -> None:
        """Note the end."""
        self.closed = True
