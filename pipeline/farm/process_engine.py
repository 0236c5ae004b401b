"""Process engine: workers that are processes of this machine."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess

from pipeline.farm.engine import Ended
from pipeline.farm.tasks import Task, TaskResult, TaskRunner, WorkerSettings
from pipeline.production.run.workers import begin_worker, children_ignore_interrupts

GRACE = 2.0
"""Time for workers that are ended [s]."""


@dataclass(slots=True)
class _Process:
    process: SpawnProcess
    pipe: Connection
    task: Task | None = None


class ProcessEngine:
    """Workers that are processes of this machine, started when they get their first task.

    Args:
        count: number of workers.
        settings: of each.
        label: first part of their names.
    """

    def __init__(self, count: int, settings: WorkerSettings, label: str = "process") -> None:
        self._settings = settings
        self._context = multiprocessing.get_context("spawn")
        self._names = [f"{label} {number}" for number in range(1, count + 1)]
        self._processes: dict[str, _Process] = {}

    @property
    def workers(self) -> list[str]:
        """Names of the workers."""
        return self._names

    @property
    def idle(self) -> list[str]:
        """Names of those without a task."""
        return [
            name
            for name in self._names
            if (found := self._processes.get(name)) is None or found.task is None
        ]

    def start(self, worker: str, task: Task) -> None:
        """Give a task to an idle worker."""
        process = self._processes.get(worker) or self._begun(worker)
        process.task = task
        try:
            process.pipe.send(task)
        except (BrokenPipeError, ConnectionError):
            pass  # it died while it was idle, and `wait` tells

    def wait(self, seconds: float) -> list[Ended]:
        """Return the tasks that ended, after some time at most."""
        busy = {name: p for name, p in self._processes.items() if p.task is not None}
        if not busy:
            time.sleep(seconds)
            return []
        ready = wait([p.pipe for p in busy.values()], seconds)
        return [self._ended(name) for name, p in busy.items() if p.pipe in ready]

    def discard(self, worker: str) -> None:
        """End a worker with its task; another takes its place."""
        process = self._processes.pop(worker, None)
        if process is not None:
            process.process.kill()
            process.process.join(GRACE)
            process.pipe.close()

    def close(self) -> None:
        """End all workers."""
        for process in self._processes.values():
            process.process.kill()
        for process in self._processes.values():
            process.process.join(GRACE)
            process.pipe.close()
        self._processes.clear()

    def _begun(self, name: str) -> _Process:
        here, there = self._context.Pipe()
        process = self._context.Process(
            target=serve, args=(there, TaskRunner, self._settings), name=name, daemon=True
        )
        with children_ignore_interrupts():
            process.start()
        there.close()
        self._processes[name] = begun = _Process(process, here)
        return begun

    def _ended(self, name: str) -> Ended:
        process = self._processes[name]
        try:
            result = process.pipe.recv()
            assert isinstance(result, TaskResult)
        except (EOFError, ConnectionError):
            process.process.join(GRACE)
            code = process.process.exitcode
            self.discard(name)
            signal = f"killed by signal {-code}" if code is not None and code < 0 else ""
            return Ended(name, None, "crashed", signal or f"ended with code {code}")
        process.task = None
        return Ended(name, result)


def serve(
    pipe: Connection, make_runner: Callable[[WorkerSettings], TaskRunner], settings: WorkerSettings
) -> None:
    """Carry out the tasks of a pipe, in a process of its own, until it ends."""
    begin_worker()
    runner = make_runner(settings)
    while True:
        try:
            task = pipe.recv()
        except (EOFError, ConnectionError):
            return
        pipe.send(runner.run(task))
