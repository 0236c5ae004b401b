"""Assignment: which task an idle worker gets."""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from pipeline.farm.film_run import FilmRun
from pipeline.farm.tasks import Encoding, Rendering, Simulation, Task

STRAGGLER_RATIO, STRAGGLER_SECONDS = 2.0, 10.0
"""A task is raced by a second copy when it takes so many times as long as expected, and so long
at least [s]."""


@dataclass(slots=True)
class Given:
    """A task that a worker has.

    Attributes:
        run: film of the task.
        task: that the worker has.
        is_copy: whether another worker has it, too, and is late.
        since: start on the monotonic clock [s].
    """

    run: FilmRun
    task: Task
    is_copy: bool = False
    since: float = field(default_factory=lambda: time.monotonic())


def frames_of(task: Task) -> tuple[int, ...]:
    """Return the frames that a task renders."""
    return task.frames if isinstance(task, Rendering) else ()


def next_task(worker: str, runs: Sequence[FilmRun], workers: int, last: str | None) -> Given | None:
    """Return the next task of a worker: a segment, frames of its last film, a take, other frames.

    Args:
        worker: that is idle.
        runs: films under way; frames of the task are taken from theirs.
        workers: number of all workers.
        last: key of the film of the worker's last task.
    """
    for run in runs:
        # Those that are due are few, and the film waits for the last of them.
        if worker not in run.unsuited and (segment := run.next_segment()) is not None:
            return Given(run, Encoding(run.film.key, segment))
    suited = [run for run in runs if run.has_frames and worker not in run.unsuited]
    share = max(workers // max(sum(run.has_frames for run in runs), 1), 1)
    for run in suited:
        if run.film.key == last:
            return _chunk(run, share)
    for run in runs:
        if run.state == "simulating" and run.waiting and worker not in run.unsuited:
            run.waiting = False
            return Given(run, Simulation(run.film.key))
    if suited:
        # The film whose workers have most to do.
        run = max(suited, key=lambda run: len(run.pending) / (1 + len(run.running)))
        return _chunk(run, share)
    return None


def _chunk(run: FilmRun, share: int) -> Given:
    return Given(run, Rendering(run.film.key, run.next_chunk(share)))


def late_copy(worker: str, given: Collection[Given]) -> Given | None:
    """Return a copy of the task that is most behind its time, None if none is.

    Args:
        worker: that is idle.
        given: tasks of the other workers.
    """
    now = time.monotonic()
    raced = {one.task for one in given if one.is_copy}
    late: list[tuple[float, Given]] = []
    for one in given:
        if not isinstance(one.task, Rendering) or one.is_copy or one.task in raced:
            continue
        expected = one.run.costs.expected(len(one.task.frames))
        if expected is None or worker in one.run.unsuited:
            continue
        taken = now - one.since
        if taken > max(STRAGGLER_RATIO * expected, STRAGGLER_SECONDS):
            late.append((taken / expected, one))
    if not late:
        return None
    _, latest = max(late, key=lambda pair: pair[0])
    return Given(latest.run, latest.task, is_copy=True)
