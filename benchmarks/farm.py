"""Costs of a farm, measured here, and what they mean for many machines.

    python benchmarks/farm.py [SCENE] [--frames N] [--size WxH] [--machines-cores 16]

Prints the rate of empty tasks of each engine, what a worker spends on a film (imports, load, build,
frames, bytes), the efficiency of two workers against one, and a model: machines against time and
efficiency, and what is at its limit first. Ray is measured where it is installed; run it under
`unshare -n` where its ports must not be seen.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

from pipeline.farm.engine import Engine
from pipeline.farm.film import Film
from pipeline.farm.frame_worker import ChunkCost
from pipeline.farm.process_engine import ProcessEngine
from pipeline.farm.shards import prepare_film
from pipeline.farm.store import Store
from pipeline.farm.tasks import Nothing, Rendering, Task, TaskResult, WorkerSettings
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from pipeline.spec import find_scene, load_scene

TASKS = 3000
"""Empty tasks by which a rate is measured."""

STORE_RATE = 1000.0
"""Of a shared store: 8 Gbit a second [MB/s]."""

ENCODING_RATE = 60.0
"""Frames a second that one assembler encodes; the driver's machine has one for each four cores."""

MACHINES = (1, 10, 100, 1000, 10_000)


@dataclass(frozen=True, slots=True)
class Measured:
    """What was measured.

    Attributes:
        driver_rate: tasks a second.
        overhead: load and build of a film in a worker [s].
        per_frame: of a frame in a worker [s].
        frame_bytes: of a picture.
        film_bytes: that a worker reads of a take.
    """

    driver_rate: float
    overhead: float
    per_frame: float
    frame_bytes: float
    film_bytes: float


def run_tasks(engine: Engine, tasks: list[Task]) -> tuple[float, list[TaskResult]]:
    """Return the time that tasks take from the first start [s], and their results."""
    while not engine.idle:
        engine.wait(0.05)
    waiting, results = list(reversed(tasks)), list[TaskResult]()
    began = time.perf_counter()
    while len(results) < len(tasks):
        for worker in engine.idle:
            if waiting:
                engine.start(worker, waiting.pop())
        for ended in engine.wait(1.0):
            if ended.result is None or ended.result.error is not None:
                raise SystemExit(f"a task failed: {ended}")
            results.append(ended.result)
    return time.perf_counter() - began, results


def task_rate(engine: Engine, count: int) -> float:
    """Return empty tasks a second."""
    # Workers start with their first task.
    run_tasks(engine, [Nothing()] * 8)
    seconds, _ = run_tasks(engine, [Nothing()] * count)
    return count / seconds


def worker_costs(store: Store, film: Film, workers: int) -> tuple[float, ChunkCost]:
    """Return the time of a film's frames by workers of one thread each, and what they cost.

    Each worker renders a frame first, so that fixed costs stand beside the time.
    """
    settings = WorkerSettings(store.address, threads=1)
    engine = ProcessEngine(workers, settings)
    frames = list(range(workers + 1, film.frames + 1))
    try:
        _, first = run_tasks(engine, [Rendering(film.key, (n + 1,)) for n in range(workers)])
        size = max(len(frames) // (8 * workers), 1)
        chunks = [tuple(frames[k : k + size]) for k in range(0, len(frames), size)]
        seconds, results = run_tasks(engine, [Rendering(film.key, chunk) for chunk in chunks])
    finally:
        engine.close()
    total = ChunkCost()
    for result in results:
        cost = result.cost
        total = replace(
            total,
            rendered=total.rendered + cost.rendered,
            frames=total.frames + cost.frames,
            stored=total.stored + cost.stored,
        )
    begun = first[0].cost
    return seconds, replace(total, load=begun.load, first=begun.first, fetched=begun.fetched)


def prepared(folder: Path, scene: str, frames: int, size: str) -> tuple[Store, Film]:
    """Return a store with the take of a scene."""
    width, height = size.split("x")
    file = find_scene(scene)
    changes = [f"frames={frames}", f"film.size=[{width},{height}]", "film.preset=preview"]
    order = Order(load_scene(file, changes), file.stem, folder)
    store = Store(str(folder))
    return store, prepare_film(order, store, Reporter())


@dataclass(frozen=True, slots=True)
class Load:
    """A night's work: scenes of some frames, on machines of some cores.

    Attributes:
        scenes: number of scenes.
        frames: of each.
        cores: of a machine.
        worker_cores: of a worker.
        chunk: time of a task [s].
    """

    scenes: int = 1000
    frames: int = 2400
    cores: int = 16
    worker_cores: int = 4
    chunk: float = 60.0


def modelled(measured: Measured, load: Load, machines: int) -> tuple[float, float, str]:
    """Return the time of a load [s], its efficiency, and what limits it."""
    workers = machines * load.cores // load.worker_cores
    frames = load.scenes * load.frames
    # Measured with one thread a worker; rendering uses all of them.
    per_frame = measured.per_frame / load.worker_cores
    useful = frames * per_frame / workers
    films_of_worker = max(load.scenes / workers, 1.0)
    compute = useful + films_of_worker * measured.overhead
    tasks = frames * per_frame / load.chunk + 2 * load.scenes
    stored = frames * measured.frame_bytes * 2 + workers * films_of_worker * measured.film_bytes
    limits = {
        "workers": compute,
        "driver": tasks / measured.driver_rate,
        "store": stored / 1e6 / STORE_RATE,
        "longest task": measured.overhead + load.chunk / 2,
        "encoding": frames / ENCODING_RATE / (load.cores // load.worker_cores),
    }
    limit = max(limits, key=lambda name: limits[name])
    seconds = limits[limit]
    return seconds, useful / seconds, limit


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default="first_steps")
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--tasks", type=int, default=TASKS)
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        rates = {"processes": _process_rate(made, wanted.tasks)}
        if find_spec("ray") is not None:
            rates["Ray"] = _ray_rate(made, wanted.tasks)
        for name, rate in rates.items():
            print(f"empty tasks on 2 workers, {name}: {rate:.0f} a second")
        found: dict[int, tuple[float, ChunkCost]] = {}
        for workers in (1, 2):
            place = Path(made, f"store {workers}")
            store, film = prepared(place, wanted.scene, wanted.frames, wanted.size)
            found[workers] = worker_costs(store, film, workers)
    (one, cost), (two, both) = found[1], found[2]
    rate_one, rate_two = cost.rendered / one, both.rendered / two
    print(
        f"{wanted.scene}, {wanted.size}: load {cost.load:.2f} s, first frame {cost.first:.2f} s, "
        f"then {cost.frames / cost.rendered:.3f} s a frame with one thread; "
        f"{cost.stored / cost.rendered / 1e3:.0f} kB a frame, {cost.fetched / 1e3:.0f} kB of take"
    )
    print(
        f"2 workers against 1, one thread each: x{rate_two / rate_one:.2f} frames a second, "
        f"efficiency {rate_two / rate_one / 2:.2f} beside fixed costs ({os.cpu_count()} processors)"
    )
    per_frame = cost.frames / cost.rendered
    measured = Measured(
        rates.get("Ray", rates["processes"]),
        cost.load + max(cost.first - per_frame, 0.0),
        per_frame,
        cost.stored / cost.rendered,
        cost.fetched,
    )
    load = Load()
    print(
        f"model: {load.scenes} scenes of {load.frames} such frames, machines of {load.cores} "
        f"cores, a store of {STORE_RATE:.0f} MB/s, assemblers of {ENCODING_RATE:.0f} frames/s"
    )
    print(f"{'machines':>9} {'hours':>9} {'efficiency':>11}  limit")
    for machines in MACHINES:
        seconds, efficiency, limit = modelled(measured, load, machines)
        print(f"{machines:>9} {seconds / 3600:>9.2f} {efficiency:>11.2f}  {limit}")


def _process_rate(folder: str, tasks: int) -> float:
    engine = ProcessEngine(2, WorkerSettings(folder))
    try:
        return task_rate(engine, tasks)
    finally:
        engine.close()


def _ray_rate(folder: str, tasks: int) -> float:
    from pipeline.farm.ray_engine import RayEngine

    engine = RayEngine("auto", WorkerSettings(folder), jobs=2, cores=1)
    try:
        return task_rate(engine, tasks)
    finally:
        engine.close()


if __name__ == "__main__":
    main()
