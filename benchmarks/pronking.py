"""Pronking: creature-frames a second on one core, and how cost grows with the cast.

1, 10 and 100 creatures of five kinds hop over hills, side by side in one run: frames of film
times creatures, by the second of processor time of stepping, and of building the world with it.

    python benchmarks/pronking.py
"""

from __future__ import annotations

import math
import os
import time

# One core: numpy reads these when it is imported.
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene, read_scene

KINDS = ("kangaroo", "antelope", "hopper", "ostrich", "beetle")
SPACING, SECONDS = 2.0, 4.0
"""Distance of neighbours at the start [m], and length of the film [s]."""

COUNTS = (1, 10, 100)


def crowd(count: int) -> Scene:
    """Return a scene of `count` creatures that hop over hills."""
    side, cast = math.ceil(math.sqrt(count)), ""
    for i in range(count):
        x, z = (i % side - side / 2) * SPACING, (i // side - side / 2) * SPACING
        cast += (
            f"- {{name: c{i}, figure: {KINDS[i % len(KINDS)]}, at: [{x}, {z}],"
            f" heading_deg: {i * 37 % 360}, pronk: {{start: {0.07 * (i % 9)}}}}}\n"
        )
    ground = "{preset: hills, size: [80, 80]}"
    return read_scene(f"pronk: 1\nduration: {SECONDS}\nseed: 3\nterrain: {ground}\ncast:\n{cast}")


def main() -> None:
    """Measure and print creature-frames a second."""
    for count in COUNTS:
        scene = crowd(count)
        began = time.process_time()
        simulation = Simulation(scene)
        built = time.process_time()
        while not simulation.finished:
            simulation.step()
        done = time.process_time()
        frames = count * scene.n_frames
        print(
            f"{count:4d} creatures: {frames / (done - built):7.0f} creature-frames a second, "
            f"{frames / (done - began):7.0f} with the building of the world"
        )


if __name__ == "__main__":
    main()
