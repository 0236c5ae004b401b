"""Workers: processes that render at once, and the processor in place of a GPU short of memory."""

from __future__ import annotations

import atexit
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from pipeline.errors import FilmingError, PronkError
from pipeline.production.run.file_records import FileRecord, FileRecords
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.progress import Reporter
from pipeline.production.shots.frame_rendering import render_frames
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.take_store import read_take
from pipeline.spec.scene import Scene
from render.backend import Backend, Choice, choose, without_gpu
from render.development import Tone
from render.errors import DeviceMemoryShort, RenderError
from render.renderer import Renderer, Timings

FRAMES_PER_PROCESS = 500
"""Frames after which workers are replaced, because Mitsuba does not return all memory."""

MAX_BATCH = 16
"""Most frames that a worker gets at once."""

BATCHES_PER_PROCESS = 4
"""Batches per worker that keep all workers busy to the end."""

FIRST_BATCH = 5
"""Frames of the first batch of a worker: enough to measure its pace after building its scene."""

T = TypeVar("T")
Item = TypeVar("Item")


def with_gpu_fallback(choice: Choice, reporter: Reporter, work: Callable[[Backend], T]) -> T:
    """Return the result of work on a backend, repeated on the processor if GPU memory is short.

    All frames are due again then, because their pixels depend on the backend.

    Args:
        choice: of the backend.
        reporter: of the change of backend.
        work: function of the backend.
    """
    try:
        return work(choose(choice))
    except DeviceMemoryShort as error:
        backend = without_gpu()
        reporter.note(f"{error}; going on with {backend.variant}, which needs none")
        return work(backend)


@contextmanager
def worker_pool(
    jobs: int, death: PronkError, work: Callable[[Item], T], items: Sequence[Item]
) -> Iterator[list[Future[T]]]:
    """Do work on each of the items in `jobs` processes.

    Each process gets `work` when it starts; through the pool's pipe go only the items, which
    have to be small: before Python 3.11.5, a pool whose workers are ended while it waits for room
    in its pipe waits for ever.

    Args:
        jobs: number of processes.
        death: raised when a process died.
        work: picklable; may be a `partial` that carries much data.
        items: at most some hundred bytes each.

    Yields:
        The results to come, in the order of the items.

    Raises:
        PronkError: `death`, if a worker died.
    """
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, context, _start_worker, (work,)) as pool:
        try:
            with children_ignore_interrupts():
                futures: list[Future[T]] = [pool.submit(_work_on, item) for item in items]
            yield futures
        except BrokenProcessPool as error:
            raise death from error
        except BaseException:
            # The pool would wait for all that is under way.
            for child in multiprocessing.active_children():
                child.terminate()
            raise


@contextmanager
def children_ignore_interrupts() -> Iterator[None]:
    """Let processes that are started inside ignore Ctrl-C from the start.

    An ignored signal stays ignored in a new program; a handler would come too late for the
    imports of the worker. This process goes on hearing Ctrl-C, see `interrupts`.
    """
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@dataclass(frozen=True, slots=True)
class FrameJob:
    """Frames to render and all that a worker needs for them.

    Attributes:
        scene: of the frames.
        take: folder of its take.
        outputs: that the frames are written to.
        backend: of the renderer.
        keys: by frame.
        tones: exposures of all frames of the film, as metered.
    """

    scene: Scene
    take: Path
    outputs: Outputs
    backend: Backend
    keys: dict[int, str]
    tones: tuple[Tone, ...] = ()


@dataclass(frozen=True, slots=True)
class BatchResult:
    """Result of a batch.

    Attributes:
        timings: of the renderer.
        pace: time per frame after a worker's first ones [s], None if not measured.
        records: of the frames, with their files.
    """

    timings: Timings
    pace: float | None
    records: list[tuple[Path, FileRecord]]


def film_in_processes(
    job: FrameJob,
    jobs: int,
    records: FileRecords,
    progress: Callable[[int, float | None], None],
) -> Timings:
    """Render frames in `jobs` processes.

    Args:
        job: all of them.
        jobs: number of processes.
        records: of the outputs; those of the frames are added.
        progress: called with the number of frames done, and the latest time per frame of all
            processes together [s], None before it is measured.

    Returns:
        Render times, summed over the processes.

    Raises:
        FilmingError: a frame cannot be rendered or written, or a process died.
        DeviceMemoryShort: a GPU has too little memory.
    """
    total = Timings()
    death = FilmingError("a process that rendered has died; if memory was short, try fewer --jobs")
    pace: float | None = None
    numbers = list(job.keys)
    share = jobs * FRAMES_PER_PROCESS
    for first in range(0, len(numbers), share):
        batches = _batches(numbers[first : first + share], jobs)
        work = partial(_film_batch, job)
        with worker_pool(min(jobs, len(batches)), death, work, batches) as futures:
            for future in as_completed(futures):
                part = future.result()
                if isinstance(part, DeviceMemoryShort):
                    raise part
                if isinstance(part, str):
                    raise FilmingError(part)
                for path, record in part.records:
                    records.put(path, record)
                for quantity in fields(total):
                    name = quantity.name
                    setattr(total, name, getattr(total, name) + getattr(part.timings, name))
                if part.pace is not None:
                    pace = part.pace / min(jobs, len(batches))
                progress(total.frames, pace)
    return total


def _batches(numbers: list[int], jobs: int) -> list[list[int]]:
    """Return successive frames in batches, the first one of each worker a short one."""
    size = min(MAX_BATCH, max(1, len(numbers) // (jobs * BATCHES_PER_PROCESS)))
    batches = list[list[int]]()
    while numbers:
        count = min(size, FIRST_BATCH) if len(batches) < jobs else size
        batches.append(numbers[:count])
        numbers = numbers[count:]
    return batches


# --- in a worker ------------------------------------------------------------------

_work: Callable[[Any], Any] | None = None
"""What this worker does with each item."""

_equipment: tuple[ShotBuilder, Renderer] | None = None
"""Shots and renderer of this worker, made for its first batch."""


def _start_worker(work: Callable[[Any], Any]) -> None:
    global _work
    _work = work
    begin_worker()
    atexit.register(_end_worker)


def begin_worker() -> None:
    """Make this process one that works for its parent: it ends with it and prints no results."""
    # The parent answers Ctrl-C and ends its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Prints of libraries are no results of the command.
    os.dup2(2, 1)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_worker() -> None:
    # The bindings complain of objects that are alive when Python ends.
    global _equipment
    _equipment = None


def _end_with_parent() -> None:
    """End this process when its parent has been killed, so that the outputs are free again."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _work_on(item: Any) -> Any:
    assert _work is not None
    return _work(item)


def _film_batch(job: FrameJob, numbers: list[int]) -> BatchResult | str | DeviceMemoryShort:
    """Render one batch and return its times; an error is returned as its message."""
    global _equipment
    try:
        first, times = _equipment is None, [time.monotonic()]
        if _equipment is None:
            shooting = ShotBuilder(job.scene, read_take(job.take))
            shooting.set_tones(job.tones)
            _equipment = shooting, Renderer(job.backend)
        shooting, renderer = _equipment
        renderer.timings = Timings()
        records = []
        keys = {number: job.keys[number] for number in numbers}
        for written in render_frames(renderer, shooting, job.outputs, keys):
            records.append(written)
            times.append(time.monotonic())
    except DeviceMemoryShort as error:
        return error
    except (FilmingError, RenderError) as error:
        return str(error)
    return BatchResult(renderer.timings, _batch_pace(times, first), records)


def _batch_pace(times: Sequence[float], first: bool) -> float | None:
    """Return the time per frame of a batch [s], None if it is too short to tell.

    Args:
        times: of the start and of each frame as it is written, one frame after it is rendered.
        first: whether scenes were built and kernels compiled for its first frame.
    """
    if not first:
        return (times[-1] - times[0]) / (len(times) - 1)
    # The second frame is rendered when the first is written.
    count = len(times) - 3
    return (times[-1] - times[1]) / count if count > 0 else None
