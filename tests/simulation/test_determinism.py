"""The same scene gives the same bytes, whatever the process, cast order, neighbours and rates."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest

from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.take import Take
from pipeline.spec import dump, read_scene

if TYPE_CHECKING:
    from pipeline.spec import Scene

    SceneOf = Callable[..., Scene]

pytestmark = pytest.mark.slow

ROUGH = "{kind: fractal, height: 0.8, size: [16, 16]}"
BUG = "{name: bug, figure: beetle, scale: 0.5, at: [1, 1], walk: {gait: tripod}}"
WAVER = (
    "{name: waver, figure: beetle, scale: 0.7, at: [-2, 0], heading_deg: 80, walk: {gait: wave}}"
)
STANDER = "{name: stander, figure: beetle, scale: 0.4, at: [0, -3]}"

PRINT_DIGEST = """
import sys
from pipeline.simulation.simulate import simulate
from pipeline.spec import read_scene
sys.stdout.write(simulate(read_scene(sys.stdin.read())).digest)
"""


def _of(take: Take, name: str) -> tuple[bytes, ...]:
    """Return all bytes of one performer."""
    nodes = [i for i, node in enumerate(take.nodes) if node.performer == name]
    channels = [i for i, c in enumerate(take.channels) if c.name.startswith(f"{name}.")]
    lines = [repr(c) for c in take.contacts if c.performer == name]
    lines += [repr(e) for e in take.events if e.who == name]
    return (
        take.positions[:, nodes].tobytes(),
        take.rotations[:, nodes].tobytes(),
        take.values[:, channels].tobytes(),
        "\n".join(lines).encode(),
    )


def test_the_same_scene_gives_the_same_take(scene_of: SceneOf) -> None:
    scene = scene_of(BUG, WAVER, terrain=ROUGH)
    assert simulate(scene).digest == simulate(scene).digest
    other = scene_of(BUG, WAVER, terrain=ROUGH, seed=4)
    assert simulate(other).digest != simulate(scene).digest


@pytest.mark.sample(1)
@pytest.mark.parametrize("salt", ["0", "4242"])
def test_another_process_gives_the_same_take(scene_of: SceneOf, salt: str) -> None:
    scene = scene_of(BUG, WAVER, terrain=ROUGH, duration=1)
    done = subprocess.run(
        [sys.executable, "-c", PRINT_DIGEST],
        input=dump(scene),
        env={**os.environ, "PYTHONHASHSEED": salt},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == simulate(read_scene(dump(scene))).digest


def test_cast_order_does_not_change_motion(scene_of: SceneOf) -> None:
    there = simulate(scene_of(BUG, WAVER, STANDER, terrain=ROUGH))
    back = simulate(scene_of(STANDER, WAVER, BUG, terrain=ROUGH))
    for name in ("bug", "waver", "stander"):
        assert _of(there, name) == _of(back, name)


PEOPLE = (
    "{name: mother, character: adult, at: [0.9, 0]}",
    "{name: ben, character: child, traits: {}, behaviours: [{fight: anna}]}",
    "{name: anna, character: child, at: [0.3, 0], traits: {}, behaviours: [{attachment: mother}]}",
    "{name: ball, character: ball, at: [-0.4, 0]}",
)


def test_cast_order_does_not_change_what_people_do(scene_of: SceneOf) -> None:
    """People who touch, push and heed one another are led one after the other."""
    there = simulate(scene_of(*PEOPLE, duration=1.5))
    back = simulate(scene_of(*PEOPLE[::-1], duration=1.5))
    for name in ("mother", "ben", "anna", "ball"):
        assert _of(there, name) == _of(back, name)


INTEGRATED = 5e-4
"""How far phases, seconds and metres may be apart for the steps that integrate them."""


def test_motion_does_not_depend_on_other_performers(scene_of: SceneOf) -> None:
    alone = simulate(scene_of(BUG, terrain=ROUGH))
    beside = simulate(scene_of(STANDER, BUG, WAVER, terrain=ROUGH))
    assert _of(alone, "bug") == _of(beside, "bug")


@pytest.mark.parametrize("terrain", ["flat", ROUGH])
def test_frame_rate_does_not_change_the_motion(scene_of: SceneOf, terrain: str) -> None:
    one = simulate(scene_of(BUG, WAVER, terrain=terrain, more="fps: 24"))
    two = simulate(scene_of(BUG, WAVER, terrain=terrain, more="fps: 48"))
    assert np.abs(one.positions - two.positions[::2]).max() < 2e-3
    # Slopes change the speed, which is integrated from step to step; on the level it is exact.
    near = 1e-9 if terrain == "flat" else INTEGRATED
    phase = np.abs(one.values[:, 0] - two.values[::2, 0])
    assert np.minimum(phase, 1.0 - phase).max() < near
    assert np.abs(one.values[:, 1] - two.values[::2, 1]).max() < near
    times = [sorted(_moments(take)) for take in (one, two)]
    assert len(times[0]) == len(times[1])
    assert np.allclose(times[0], times[1], atol=near)


@pytest.mark.nightly
def test_finer_steps_converge_to_the_same_motion(scene_of: SceneOf) -> None:
    coarse, fine = (
        simulate(scene_of(BUG, terrain=ROUGH, more=f"{{steps: {n}}}"[1:-1])) for n in (4, 16)
    )
    assert len(coarse.positions) == len(fine.positions)
    body = [n.name for n in coarse.nodes].index("bug.body")
    assert np.abs(coarse.positions[:, body] - fine.positions[:, body]).max() < INTEGRATED
    assert np.allclose(sorted(_moments(coarse)), sorted(_moments(fine)), atol=INTEGRATED)


def test_manual_steps_give_the_take_of_simulate(scene_of: SceneOf) -> None:
    scene = scene_of(BUG, terrain=ROUGH)
    simulation, seen = Simulation(scene), list[tuple[int, int]]()
    while not simulation.finished:
        simulation.step()
    assert simulation.take().digest == simulate(scene, progress=lambda *n: seen.append(n)).digest
    assert seen
    assert all(total == 48 for _, total in seen)


def _moments(take: Take) -> list[float]:
    rate = float(take.header.rate * take.header.steps)
    return [(c.step + c.fraction) / rate for c in take.contacts]
