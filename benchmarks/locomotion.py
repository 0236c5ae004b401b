"""Walking: creature-frames a second on one core, how cost grows with the cast, and memory.

1, 10 and 100 creatures of five kinds walk over hills, and 100 with six legs, side by side in one
run: frames of film times creatures, by the second of processor time of stepping, and of building
the world with it. The exponent is that of cost against creatures, over the last ten times.

With minutes given, 20 creatures go round and round for so long, and the anonymous memory of
the process is printed minute by minute: what is mapped from files is not in it, as the
system can take it back.

    python benchmarks/locomotion.py [minutes]
"""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

# One core: numpy reads these when it is imported.
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene, read_scene

KINDS = "beetle", "horse", "spider", "person", "antelope"
SIX_LEGGED = ("beetle",)
SPACING = 2.0
"""Distance of neighbours at the start [m]."""

ROUND = 3.0
"""Side of the squares that creatures go round [m]."""

RUNS = 3
"""Runs of each size, in turn; the quickest counts, the others were disturbed."""

COUNTS = (1, 10, 100)


def crowd(count: int, seconds: float, rounds: bool = False, kinds: Sequence[str] = KINDS) -> Scene:
    """Return a scene of `count` creatures over hills.

    Args:
        count: of creatures, which start in a square.
        seconds: of film.
        rounds: whether they go round and round instead of straight on in all directions.
        kinds: of creatures, in turn.
    """
    side, cast = math.ceil(math.sqrt(count)), ""
    for i in range(count):
        x, z = (i % side - side / 2) * SPACING, (i // side - side / 2) * SPACING
        path = [[x, z], [x + ROUND, z], [x + ROUND, z + ROUND], [x, z + ROUND]]
        walk = f"path: {path}, repeat: loop" if rounds else ""
        cast += (
            f"- {{name: c{i}, figure: {kinds[i % len(kinds)]}, at: [{x}, {z}],"
            f" heading_deg: {i * 37 % 360}, walk: {{{walk}}}}}\n"
        )
    return read_scene(f"pronk: 1\nduration: {seconds}\nseed: 3\nterrain: hills\ncast:\n{cast}")


def timed(scene: Scene) -> tuple[float, float]:
    """Return seconds of processor time of building the world and of stepping to the end."""
    began = time.process_time()
    simulation = Simulation(scene)
    built = time.process_time()
    while not simulation.finished:
        simulation.step()
    simulation.take()
    return built - began, time.process_time() - built


def anonymous() -> float:
    """Return the anonymous memory of this process [MB]."""
    status = Path("/proc/self/status").read_text()
    line = next(line for line in status.splitlines() if line.startswith("RssAnon"))
    return int(line.split()[1]) / 1024.0


def speed() -> None:
    """Measure and print creature-frames a second."""
    scenes = {f"{count} creatures": (count, crowd(count, 5.0)) for count in COUNTS}
    scenes["100 six-legged"] = 100, crowd(100, 5.0, kinds=SIX_LEGGED)
    timed(scenes["1 creatures"][1])  # imports and caches
    times = [{name: timed(scene) for name, (_, scene) in scenes.items()} for _ in range(RUNS)]
    best = {}
    for name, (count, scene) in scenes.items():
        build = min(run[name][0] for run in times)
        step = best[name] = min(run[name][1] for run in times)
        work = count * scene.n_frames
        print(
            f"{name:>14}: {work / step:6.0f} creature-frames a second,"
            f" {work / (step + build):6.0f} with building ({1e3 * build / count:.1f} ms each)"
        )
    exponent = math.log10(best["100 creatures"] / best["10 creatures"])
    print(f"cost grows as creatures to the power {exponent:.2f}")


def memory(minutes: int) -> None:
    """Walk for a long time and print the memory minute by minute."""
    scene = crowd(20, 60.0 * minutes, rounds=True)
    simulation = Simulation(scene)
    clock = simulation.world.clock
    a_minute = clock.step_from(60.0)
    print(f"20 creatures, {minutes} minutes; built: {anonymous():.0f} MB anonymous")
    while not simulation.finished:
        simulation.step()
        if simulation.step_number % a_minute == 0:
            print(f"  after minute {simulation.step_number // a_minute}: {anonymous():.0f} MB")
    take = simulation.take()
    rows = sum(values.nbytes for _, values in take.arrays())
    print(f"the take holds {rows / 2**20:.0f} MB, {len(take.contacts)} footfalls")
    digest = take.digest
    print(f"with its digest {digest[:8]}: {anonymous():.0f} MB; notes: {len(take.notes)}")


if __name__ == "__main__":
    speed()
    if len(sys.argv) > 1:
        memory(int(sys.argv[1]))
