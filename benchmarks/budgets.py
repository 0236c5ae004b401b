"""Budgets: estimates of memory and time beside what runs take.

Each scene is checked, simulated or rendered by the command in a process of its own. Memory is the
largest resident set of one process, time is that on the wall; where other programs keep the machine
busy, the processor time over the number of processors says more, and stands beside it.

    python benchmarks/budgets.py [part of a scene's name ...]
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

MIB = 1 << 20
SMALL = '{size: [64, 36], samples: 1, depth: 2, denoise: "off"}'
PROGRAM = "from pipeline.cli import main; main()"


def herd(count: int) -> str:
    """Return the cast of a herd of beetles."""
    side = int(count**0.5) + 1
    places = ((4 * (i % side) - 2 * side, 4 * (i // side) - 2 * side) for i in range(count))
    return "".join(f"  - {{figure: beetle, at: [{x}, {z}], walk: {{}}}}\n" for x, z in places)


def scene(cast: str, frames: int, film: str = SMALL, terrain: str = "{kind: flat}") -> str:
    """Return a scene in studio light."""
    head = f"pronk: 1\nframes: {frames}\nterrain: {terrain}\nlight: studio\n"
    return f"{head}film: {film}\ncast:\n{cast}"


def ground(side: int, kind: str) -> str:
    """Return a terrain of 0.1 m a cell."""
    return f"{{kind: {kind}, size: [{side / 10}, {side / 10}], cells: [{side}, {side}]}}"


def cases() -> Iterator[tuple[str, str, str]]:
    """Yield name, command and scene."""
    one, wide = herd(1), "{kind: flat, size: [200, 200]}"
    wall = "  - {many: {layout: wall, rows: 20, columns: 50, of: brick}}\n"
    flock = "  - {group: {rule: flock, count: 2000, spread: 20}, at: [0, 10, 0]}\n"
    people = "".join(f"  - {{character: child, at: [{2 * i}, 0], name: c{i}}}\n" for i in range(4))
    yield "small", "check", scene(one, 24)
    yield "small", "simulate", scene(one, 24)
    yield "small", "render", scene(one, 24)
    yield "cells 16 million", "check", scene(one, 4, terrain=ground(4000, "boulders"))
    yield "cells 4 million", "simulate", scene(one, 4, terrain=ground(2000, "fractal"))
    yield "cells 1 million", "render", scene(one, 4, terrain=ground(1000, "fractal"))
    yield "creatures 1,000", "check", scene(herd(1000), 24, terrain=wide)
    yield "creatures 100", "simulate", scene(herd(100), 24, terrain=wide)
    yield "bodies 1,000", "simulate", scene(wall, 24, terrain=wide)
    yield "members 2,000", "simulate", scene(flock, 24)
    yield "people 4", "simulate", scene(people, 48)
    yield "preview", "render", scene(one, 12, "{preset: preview}")
    yield "samples 16", "render", scene(one, 4, "{size: [1280, 720], samples: 16, depth: 4}")


def measured(command: str, text: str) -> tuple[float, float, float]:
    """Return peak memory [bytes], time and processor time [s] of a command on a scene."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "play.yaml")
        file.write_text(text, encoding="utf-8")
        out = [] if command == "check" else ["--out", str(Path(folder, "out"))]
        start = time.monotonic()
        words = [sys.executable, "-c", PROGRAM, command, str(file), "-q", *out]
        run = subprocess.Popen(words, stdout=subprocess.DEVNULL)
        _, status, used = os.wait4(run.pid, 0)
        seconds = time.monotonic() - start
        run.returncode = os.waitstatus_to_exitcode(status)
        if run.returncode:
            raise SystemExit(f"{command} ended with {run.returncode}")
    return used.ru_maxrss * 1024.0, seconds, used.ru_utime + used.ru_stime


def main(wanted: list[str]) -> None:
    """Measure and print."""
    from pipeline.production.run.scene_cost import Job, processors, scene_cost
    from pipeline.spec import read_scene

    print("scene             work          MiB estimate ratio    s  estimate ratio  processor s")
    for name, command, text in cases():
        if wanted and not any(part in name for part in wanted):
            continue
        play = read_scene(text)
        cost = scene_cost(play, Job(command, play.n_frames))  # type: ignore[arg-type]
        memory, seconds, worked = measured(command, text)
        sizes = f"{memory / MIB:8.0f} {cost.memory / MIB:8.0f} {cost.memory / memory:5.2f}"
        times = f"{seconds:6.1f} {cost.seconds:7.1f} {cost.seconds / seconds:6.2f}"
        share = f"{worked:7.1f} over {processors()}"
        print(f"{name:17} {command:8} {sizes} {times}  {share}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
