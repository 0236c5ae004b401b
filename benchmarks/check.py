"""Check of large scenes: what `pronk check` takes for each cell, creature and body.

Every scene is checked in a process of its own at two sizes. The last column is the ratio of their
times beside the ratio of their sizes: equal numbers mean that the time grows no faster than the
scene. `--large` checks 4,000 x 4,000 cells and 5,000 creatures, which takes minutes.

    python benchmarks/check.py [--large]
"""

from __future__ import annotations

import multiprocessing
import resource
import sys
import time
from collections.abc import Callable, Iterator

MIB = 1 << 20

Make = Callable[[int], str]


def ground(kind: str) -> Make:
    """Return a maker of scenes by the number of cells along each side."""

    def scene(cells: int) -> str:
        terrain = f"{{kind: {kind}, size: [{cells / 10}, {cells / 10}], cells: [{cells}, {cells}]}}"
        return f"pronk: 1\nframes: 24\nterrain: {terrain}\ncast: [{{figure: beetle, walk: {{}}}}]\n"

    return scene


def creatures(count: int) -> str:
    """Return a scene of walking creatures, each an entry of the cast."""
    side = int(count**0.5) + 1
    places = ((4 * (i % side) - 2 * side, 4 * (i // side) - 2 * side) for i in range(count))
    cast = "".join(f"  - {{figure: beetle, at: [{x}, {z}], walk: {{}}}}\n" for x, z in places)
    size = 4 * side + 40
    return f"pronk: 1\nframes: 24\nterrain: {{kind: flat, size: [{size}, {size}]}}\ncast:\n{cast}"


def flock(count: int) -> str:
    """Return a scene with one flock."""
    group = f"{{rule: flock, count: {count}, spread: 50}}"
    return f"pronk: 1\nframes: 24\ncast: [{{group: {group}, at: [0, 20, 0]}}]\n"


def wall(count: int) -> str:
    """Return a scene with a wall of bricks."""
    many = f"{{layout: wall, rows: 50, columns: {count // 50}, of: brick}}"
    terrain = "{kind: flat, size: [100, 100]}"
    return f"pronk: 1\nframes: 24\nterrain: {terrain}\ncast: [{{many: {many}}}]\n"


def cases(large: bool) -> Iterator[tuple[str, str, Make, tuple[int, int], int]]:
    """Yield name, unit, maker of scenes, two sizes, and the power of the size that is counted."""
    cells, count = (4000, 5000) if large else (1000, 1000)
    for kind in ("flat", "fractal", "boulders"):
        yield kind, "cells", ground(kind), (cells // 2, cells), 2
    yield "cast", "creatures", creatures, (count // 2, count), 1
    yield "flock", "creatures", flock, (count // 2, count), 1
    yield "wall", "bodies", wall, (count // 2, count), 1


def measured(text: str) -> tuple[float, int]:
    """Return the processor time [s] and the peak memory [bytes] of one check."""
    from pipeline.production.run.scene_check import check_scene
    from pipeline.spec import read_scene

    # Imports and compiled code are not what is measured.
    check_scene(read_scene(creatures(2)))
    start = time.process_time()
    check_scene(read_scene(text))
    return (
        time.process_time() - start,
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
    )


def _alone(text: str) -> tuple[float, int]:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(measured, (text,))


def main(large: bool) -> None:
    """Measure and print."""
    print("scene      size                seconds    ms per 1,000        MiB   time/size ratio")
    for name, unit, make, sizes, power in cases(large):
        times = []
        for size in sizes:
            seconds, memory = _alone(make(size))
            times.append(seconds)
            many = size**power
            text = f"{many:,} {unit}"
            each = 1e6 * seconds / many
            print(f"{name:10} {text:20} {seconds:6.2f} {each:15.3f} {memory / MIB:10.0f}", end="")
            ratio = f"{times[-1] / times[0]:8.1f} / {(sizes[1] / sizes[0]) ** power:.0f}"
            print(ratio if len(times) > 1 else "", flush=True)


if __name__ == "__main__":
    main("--large" in sys.argv[1:])
