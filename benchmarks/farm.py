"""Costs of a farm, measured here, and what they mean for many machines.

    python benchmarks/farm.py [SCENE] [--frames N] [--size WxH] [--tasks N] [--turns N]

Prints the rate of empty tasks of each engine; what a worker spends on a film (imports, load, build,
frames, bytes); the efficiency of two workers against one, and against two farms that share nothing
but the machine, since a worker of one thread writes files on another; what encoding a segment and
joining it cost; and a model: machines against time and efficiency, and what is at its limit first,
with segments encoded by workers and with films encoded where they are assembled. Ray is measured
where it is installed; where its ports must not be seen, run

    unshare -n sh -c "ip link set lo up && python benchmarks/farm.py"
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from importlib.util import find_spec
from itertools import cycle, islice
from pathlib import Path

import numpy as np

from pipeline.farm.engine import Engine
from pipeline.farm.film import Film, scene_of
from pipeline.farm.frame_index import READERS
from pipeline.farm.frame_worker import ChunkCost
from pipeline.farm.process_engine import ProcessEngine
from pipeline.farm.shards import prepare_film
from pipeline.farm.store import Store
from pipeline.farm.stored_frames import stored_pictures, stored_records
from pipeline.farm.tasks import Nothing, Rendering, Task, TaskResult, WorkerSettings
from pipeline.production.run.film_source import FilmSource
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from pipeline.spec import find_scene, load_scene
from render.film_encoder import join_film
from render.film_segments import segment_length, segment_suffix, write_segment

TASKS = 3000
"""Empty tasks by which a rate is measured."""

STORE_RATE = 1000.0
"""Of a shared store: 8 Gbit a second [MB/s]."""

JOINED = 20
"""Segments of a film by which the cost of a join is measured."""

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
        encoding: of a frame, processor time [s].
        joining: of a frame, processor time [s].
        encoded_bytes: of a frame in a segment.
    """

    driver_rate: float
    overhead: float
    per_frame: float
    frame_bytes: float
    film_bytes: float
    encoding: float
    joining: float
    encoded_bytes: float


def run_tasks(*parts: tuple[Engine, list[Task]]) -> tuple[float, list[TaskResult]]:
    """Return the time that tasks of some engines take from the first start [s], and the results."""
    for engine, _ in parts:
        while not engine.idle:
            engine.wait(0.05)
    waiting = [(engine, list(reversed(tasks))) for engine, tasks in parts]
    count, results = sum(len(tasks) for _, tasks in parts), list[TaskResult]()
    patience = 1.0 if len(parts) == 1 else 0.01
    began = time.perf_counter()
    while len(results) < count:
        for engine, tasks in waiting:
            for worker in engine.idle:
                if tasks:
                    engine.start(worker, tasks.pop())
            for ended in engine.wait(patience):
                if ended.result is None or ended.result.error is not None:
                    raise SystemExit(f"a task failed: {ended}")
                results.append(ended.result)
    return time.perf_counter() - began, results


def task_rate(engine: Engine, count: int) -> float:
    """Return empty tasks a second."""
    # Workers start with their first task.
    run_tasks((engine, [Nothing()] * 8))
    seconds, _ = run_tasks((engine, [Nothing()] * count))
    return count / seconds


def worker_costs(farms: Sequence[tuple[Store, Film]], workers: int) -> tuple[float, ChunkCost]:
    """Return the time of the films' frames by workers of one thread each, and what they cost.

    Each worker renders a frame first, so that fixed costs stand beside the time.

    Args:
        farms: stores and their films, which are made at once.
        workers: of each farm.
    """
    engines = [
        ProcessEngine(workers, WorkerSettings(store.address, threads=1)) for store, _ in farms
    ]
    try:
        _, first = run_tasks(*_parts(engines, farms, range(1, workers + 1), 1))
        rest = range(workers + 1, farms[0][1].frames + 1)
        size = max(len(rest) // (8 * workers), 1)
        seconds, results = run_tasks(*_parts(engines, farms, rest, size))
    finally:
        for engine in engines:
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


def _parts(
    engines: Sequence[Engine], farms: Sequence[tuple[Store, Film]], frames: range, size: int
) -> list[tuple[Engine, list[Task]]]:
    """Return the tasks of so many frames each for every engine."""
    chunks = [tuple(frames[k : k + size]) for k in range(0, len(frames), size)]
    return [
        (engine, [Rendering(film.key, chunk) for chunk in chunks])
        for engine, (_, film) in zip(engines, farms, strict=True)
    ]


def segment_costs(store: Store, film: Film) -> tuple[float, float, float]:
    """Return the processor time of encoding and joining a frame [s], and its encoded bytes.

    Both are measured on a whole segment, in which the frames of a film repeat, and the join on many
    such segments against one.
    """
    frames = tuple(range(1, film.frames + 1))
    source = FilmSource.of(scene_of(store, film), frames, has_sound=False)
    records = stored_records(store, film, frames, mixed=False)
    with tempfile.TemporaryDirectory() as made:
        picture = Path(made, f"frame.{film.format}")
        pictures = []
        for _, data in stored_pictures(store, film, records, READERS):
            picture.write_bytes(data)
            pictures.append(source.picture(picture))
        segment = Path(made, f"segment{segment_suffix(source.codec)}")
        began = time.process_time()
        length = segment_length(film.rate)
        write_segment(segment, islice(cycle(pictures), length), film.rate, source.codec)
        encoding = time.process_time() - began
        taken = []
        for count in (1, JOINED + 1):
            began = time.process_time()
            place = segment.with_stem("film")
            join_film(place, [segment] * count, film.rate, codec=source.codec)
            taken.append(time.process_time() - began)
        joining = (taken[1] - taken[0]) / JOINED
        size = segment.stat().st_size
    return encoding / length, joining / length, size / length


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
        rate: frames a second.
    """

    scenes: int = 1000
    frames: int = 2400
    cores: int = 16
    worker_cores: int = 4
    chunk: float = 60.0
    rate: Fraction = Fraction(24)


def modelled(
    measured: Measured, load: Load, machines: int, segments: bool
) -> tuple[float, float, str]:
    """Return the time of a load [s], its efficiency, and what limits it.

    Args:
        measured: costs.
        load: that is modelled.
        machines: that work on it, and one that drives them and assembles.
        segments: whether workers encode, and the assembly joins.
    """
    workers = machines * load.cores // load.worker_cores
    frames = load.scenes * load.frames
    # Measured with one thread a worker; rendering uses all of them.
    per_frame = measured.per_frame / load.worker_cores
    useful = frames * per_frame / workers
    films_of_worker = max(load.scenes / workers, 1.0)
    compute = useful + films_of_worker * measured.overhead
    tasks = frames * per_frame / load.chunk + 2 * load.scenes
    stored = frames * measured.frame_bytes * 2 + workers * films_of_worker * measured.film_bytes
    assembly = measured.encoding
    if segments:
        compute += frames * measured.encoding / load.worker_cores / workers
        tasks += frames / segment_length(load.rate)
        stored += frames * (measured.frame_bytes + 2 * measured.encoded_bytes)
        assembly = measured.joining
    limits = {
        "workers": compute,
        "driver": tasks / measured.driver_rate,
        "store": stored / 1e6 / STORE_RATE,
        "longest task": measured.overhead + load.chunk / 2,
        "joining" if segments else "encoding": frames * assembly / load.cores,
    }
    limit = max(limits, key=lambda name: limits[name])
    seconds = limits[limit]
    return seconds, useful / seconds, limit


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default="first_steps")
    parser.add_argument("--frames", type=int, default=48)
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--tasks", type=int, default=TASKS)
    parser.add_argument("--turns", type=int, default=3)
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        rates = {"processes": _process_rate(made, wanted.tasks)}
        if find_spec("ray") is not None:
            rates["Ray"] = _ray_rate(made, wanted.tasks)
        for name, rate in rates.items():
            print(f"empty tasks on 2 workers, {name}: {rate:.0f} a second")
        alone, both, apart = list[float](), list[float](), list[float]()
        for turn in range(wanted.turns):
            farms = [
                prepared(Path(made, f"{turn} {n}"), wanted.scene, wanted.frames, wanted.size)
                for n in range(4)
            ]
            cost = _added(alone, worker_costs(farms[:1], 1))
            _added(both, worker_costs(farms[1:2], 2))
            _added(apart, worker_costs(farms[2:], 1))
        store, film = farms[0]
        encoding, joining, encoded_bytes = segment_costs(store, film)
    print(
        f"{wanted.scene}, {wanted.size}: load {cost.load:.2f} s, first frame {cost.first:.2f} s, "
        f"then {cost.frames / cost.rendered:.3f} s a frame with one thread; "
        f"{cost.stored / cost.rendered / 1e3:.0f} kB a frame, {cost.fetched / 1e3:.0f} kB of take"
    )
    print(
        f"frames a second beside fixed costs, one thread a worker, {os.cpu_count()} processors, "
        f"median of {wanted.turns}:\n"
        f"  2 workers against 1: {_ratio(both, alone)}\n"
        f"  2 farms of 1 worker that share nothing, at once, against 1: {_ratio(apart, alone)}\n"
        f"  2 workers of one farm against these: {_ratio(both, apart)}"
    )
    length = segment_length(film.rate)
    print(
        f"segments of {length} frames, {length * encoded_bytes / 1e6:.2f} MB: encoding takes "
        f"{length * encoding:.2f} s of processor time, joining {length * joining:.4f} s "
        f"({encoded_bytes / joining / 1e6:.0f} MB/s), 1/{encoding / joining:.0f} of it"
    )
    per_frame = cost.frames / cost.rendered
    measured = Measured(
        rates.get("Ray", rates["processes"]),
        cost.load + max(cost.first - per_frame, 0.0),
        per_frame,
        cost.stored / cost.rendered,
        cost.fetched,
        encoding,
        joining,
        encoded_bytes,
    )
    load = Load()
    print(
        f"model: {load.scenes} scenes of {load.frames} such frames, machines of {load.cores} "
        f"cores, one of which assembles, a store of {STORE_RATE:.0f} MB/s"
    )
    head = f"{'hours':>9} {'efficiency':>11}  {'limit':<12}"
    print(f"{'':>9} {'segments of workers':^35}   {'encoded by the assembly':^35}")
    print(f"{'machines':>9} {head}   {head}".rstrip())
    for machines in MACHINES:
        cells = []
        for segments in (True, False):
            seconds, efficiency, limit = modelled(measured, load, machines, segments)
            cells.append(f"{seconds / 3600:>9.2f} {efficiency:>11.2f}  {limit:<12}")
        print(f"{machines:>9} {'   '.join(cells)}".rstrip())


def _added(rates: list[float], measured: tuple[float, ChunkCost]) -> ChunkCost:
    """Add frames a second to others, and return the cost of the frames."""
    seconds, cost = measured
    rates.append(cost.rendered / seconds)
    return cost


def _ratio(rates: Sequence[float], others: Sequence[float]) -> str:
    """Return the median and the range of the ratios of rates that were measured in one turn."""
    ratios = [rate / other for rate, other in zip(rates, others, strict=True)]
    return f"x{np.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"


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
