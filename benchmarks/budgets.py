"""Budgets: estimates of memory and time beside what runs take.

Each scene is checked, simulated or rendered by the command in a process of its own. Memory is the
largest resident set of one process. Time is processor time, which other programs on the machine
hardly change, beside the estimate for one processor. At the end stand the smallest and the largest
ratio.

    python benchmarks/budgets.py [part of a scene's name ...]
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

MIB = 1 << 20
SMALL = '{size: [64, 36], samples: 1, depth: 2, denoise: "off"}'
FLAT = "{kind: flat, size: [200, 200]}"
PROGRAM = "from pipeline.cli import main; main()"


def placed(member: str, count: int, spacing: float = 4.0) -> str:
    """Return a cast of members that stand in a square.

    Args:
        member: keys of each.
        count: number of members.
        spacing: between them [m].
    """
    side = int((count - 1) ** 0.5) + 1
    first = -spacing * (side - 1) / 2
    places = ((first + spacing * (i % side), first + spacing * (i // side)) for i in range(count))
    lines = (f"  - {{{member}, at: [{x}, {z}], name: m{i}}}" for i, (x, z) in enumerate(places))
    return "\n".join(lines) + "\n"


def herd(count: int) -> str:
    """Return the cast of a herd of beetles."""
    return placed("figure: beetle, walk: {}", count)


def scene(cast: str, frames: int, film: str = SMALL, terrain: str = FLAT) -> str:
    """Return a scene in studio light."""
    head = f"pronk: 1\nframes: {frames}\nterrain: {terrain}\nlight: studio\n"
    return f"{head}film: {film}\ncast:\n{cast}"


def ground(side: int, kind: str) -> str:
    """Return a terrain of 0.1 m a cell."""
    return f"{{kind: {kind}, size: [{side / 10}, {side / 10}], cells: [{side}, {side}]}}"


def cases() -> Iterator[tuple[str, str, str]]:
    """Yield name, command and scene."""
    one = herd(1)
    wall = "  - {many: {layout: wall, rows: 10, columns: 50, of: brick}}\n"
    flock = "  - {group: {rule: flock, count: 2000, spread: 20}, at: [0, 10, 0]}\n"
    grass = "  - {group: {rule: grass, count: 2000, area: [20, 20]}}\n"
    quiet = "fps: 1\n" + scene("  - {prop: {shape: box}, at: [0, 2, 0]}\n", 200)
    ball = "  - {name: ball, character: ball, at: [8, -1]}\n"
    playing = placed("character: child, behaviours: [{play: ball}]", 6) + ball
    people, dancers = placed("character: child", 6), placed("dancer: torso, dance: macarena", 6)
    for command in ("check", "simulate", "render"):
        yield "small", command, scene(one, 24)
    yield "cells 4 million", "check", scene(one, 4, terrain=ground(2000, "boulders"))
    yield "cells 2 million", "simulate", scene(one, 4, terrain=ground(1400, "fractal"))
    yield "cells 1 million", "render", scene(one, 4, terrain=ground(1000, "fractal"))
    yield "creatures 400", "check", scene(herd(400), 24)
    yield "creatures 60", "simulate", scene(herd(60), 24)
    yield "creatures 6 long", "simulate", scene(herd(6), 240)
    yield "creatures 30", "render", scene(herd(30), 8)
    yield "bodies 500", "check", scene(wall, 24)
    yield "bodies 500", "simulate", scene(wall, 24)
    yield "bodies 500", "render", scene(wall, 4)
    yield "flock 2,000", "simulate", scene(flock, 24)
    yield "grass 2,000", "render", scene(grass, 8)
    yield "people 6", "check", scene(people, 24)
    yield "people 6", "simulate", scene(people, 96)
    yield "people at play", "simulate", scene(playing, 96)
    yield "people 6", "render", scene(people, 8)
    yield "dancers 6", "check", scene(dancers, 24)
    yield "dancers 6", "simulate", scene(dancers, 96)
    yield "dancers 6", "render", scene(dancers, 8)
    yield "sound of 200 s", "midi", quiet
    yield "preview", "render", scene(one, 6, "{preset: preview}")
    yield "samples 16", "render", scene(one, 2, "{size: [1280, 720], samples: 16, depth: 4}")


def measured(command: str, text: str) -> tuple[float, float]:
    """Return peak memory [bytes] and processor time [s] of a command on a scene."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "play.yaml")
        file.write_text(text, encoding="utf-8")
        out = [] if command == "check" else ["--out", str(Path(folder, "out"))]
        words = [sys.executable, "-c", PROGRAM, command, str(file), "-q", *out]
        run = subprocess.Popen(words, stdout=subprocess.DEVNULL)
        _, status, used = os.wait4(run.pid, 0)
        run.returncode = os.waitstatus_to_exitcode(status)
        if run.returncode:
            raise SystemExit(f"{command} ended with {run.returncode}")
    return used.ru_maxrss * 1024.0, used.ru_utime + used.ru_stime


def main(wanted: list[str]) -> None:
    """Measure and print."""
    found = list[tuple[str, str, str, float, float]]()
    # Before the pipeline is imported: the size of this process counts as that of each it starts.
    for name, command, text in cases():
        if not wanted or any(part in name for part in wanted):
            print(f"{name}: {command}", file=sys.stderr, flush=True)
            found.append((name, command, text, *measured(command, text)))

    from pipeline.production.run.scene_cost import Job, scene_cost
    from pipeline.spec import read_scene

    print("scene            command       MiB  estimate ratio  processor s  estimate ratio")
    ratios = list[tuple[float, float]]()
    for name, command, text, memory, seconds in found:
        play = read_scene(text)
        work = "score" if command == "midi" else command
        cost = scene_cost(play, Job(work, play.n_frames, processors=1))  # type: ignore[arg-type]
        ratios.append((cost.memory / memory, cost.seconds / seconds))
        sizes = f"{memory / MIB:7.0f} {cost.memory / MIB:9.0f} {ratios[-1][0]:5.2f}"
        times = f"{seconds:12.1f} {cost.seconds:9.1f} {ratios[-1][1]:5.2f}"
        print(f"{name:16} {command:8} {sizes} {times}")
    for quantity, own in zip(("memory", "time"), zip(*ratios, strict=True), strict=True):
        print(f"{quantity}: estimate over measured from {min(own):.2f} to {max(own):.2f}")


if __name__ == "__main__":
    main(sys.argv[1:])
