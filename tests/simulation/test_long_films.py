"""Long films: memory use does not grow with the length."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pipeline.spec import dump

if TYPE_CHECKING:
    from pipeline.spec import Scene

KINDS = ("beetle", "horse", "spider", "person", "antelope")

GROUND = (
    "{kind: sum, size: [60, 60], cells: [240, 240], unsteppable_slope_deg: 40, of: "
    "[{kind: hills, height: 1.5, spacing: 9}, {kind: fractal, height: 0.8, roughness: 0.5}]}"
)

FOOTFALL = 1024
"""What a footfall, its contact and its sound event, may take in memory [bytes]."""

WALK = """
import sys
from pathlib import Path
import numpy as np
from pipeline.simulation import row_storage
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene

def anonymous():
    lines = Path("/proc/self/status").read_text().splitlines()
    return int(next(line for line in lines if line.startswith("RssAnon")).split()[1]) * 1024

row_storage.MAX_IN_MEMORY = int(sys.argv[1])
simulation = Simulation(read_scene(sys.stdin.read()))
last, most = simulation.world.clock.last_step, [0, 0]
while not simulation.finished:
    simulation.step()
    if simulation.step_number == last // 5:
        footfalls = len(simulation.recorder.contacts)
    if simulation.step_number % 24 == 0:
        # Peaks of both parts: in between memory is freed and allocated again.
        part = int(simulation.step_number > last // 5)
        most[part] = max(most[part], anonymous())
take = simulation.take()
take.digest
early, late = most[0], max(most[1], anonymous())
finite = all(np.isfinite(take.positions[some]).all() and np.isfinite(take.values[some]).all()
             for some in row_storage.row_chunks(take.positions))
print(early, late, footfalls, len(take.contacts), len(take.positions), finite)
"""


def _crowd(scene_of: Callable[..., Scene], seconds: float) -> Scene:
    """Return 20 creatures that go round and round over varied ground."""
    cast = []
    for i in range(20):
        x, z = 8.0 * (i % 5) - 16.0, 8.0 * (i // 5) - 12.0
        path = [[x, z], [x + 5, z], [x + 5, z + 5], [x, z + 5]]
        walk = f"{{path: {path}, repeat: loop}}"
        cast.append(f"{{name: c{i}, figure: {KINDS[i % 5]}, at: [{x}, {z}], walk: {walk}}}")
    return scene_of(*cast, terrain=GROUND, duration=seconds)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="asks Linux for its memory")
@pytest.mark.parametrize(
    ("seconds", "on_disk_from"),
    [
        pytest.param(20, 2**16, marks=pytest.mark.nightly),
        pytest.param(300, 4 * 2**20, marks=pytest.mark.nightly),
    ],
)
def test_memory_stays_flat(scene_of: Callable[..., Scene], seconds: int, on_disk_from: int) -> None:
    """Runs in a new process; file-backed memory is not counted."""
    scene = _crowd(scene_of, seconds)
    done = subprocess.run(
        [sys.executable, "-c", WALK, str(on_disk_from)],
        input=dump(scene),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    *numbers, finite = done.stdout.split()
    early, late, before, footfalls, rows = map(int, numbers)
    assert finite == "True"
    assert rows == seconds * 96 + 1
    # They walk on to the end.
    assert footfalls > 20 * seconds
    assert late < 1.1 * early + FOOTFALL * (footfalls - before)
