"""Characters: microseconds a world step, beside MuJoCo's humanoids and plain Python.

The schoolyard's bodies: a grown-up and two children, who stand and hold themselves, a ball, a
ragdoll, and a merry-go-round. A world step is a quarter of a frame at 24 frames a second,
three sub-steps; what is timed is the whole step of machine code, control included. In the same
run MuJoCo steps three humanoids of 13 capsules that lie on a plane, the same time a step in two
of its own, and the same step of ours is done once by the undecorated functions.

Then a step of the shipped schoolyard and one of 100 people, with minds: bodies, behaviour and
its events, beside the bodies alone in the same steps. Then the cost of a character where
3 to 300 are spread out, and where they touch one another.
Processor time, the least of many rounds.

    python benchmarks/characters.py
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import mujoco
import numpy as np

from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.script import Orders
from pipeline.simulation.simulate import Simulation
from pipeline.spec import load_scene, read_scene
from pipeline.spec.scene import Scene
from pipeline.spec.scene_library import library

ROUNDS, STEPS = 12, 48

YARD = """
- {character: adult, at: [0, 0], limp: LIMP}
- {character: child, at: [1.2, 0.4], limp: LIMP}
- {character: child, at: [-1.1, 0.6], scale: 0.85, limp: LIMP}
- {character: ball, at: [0.6, 1.2]}
- {character: ragdoll, at: [0.8, -0.6]}
- {character: merry-go-round, at: [0, 3.2]}
"""

PLAIN = """
import sys, time
sys.path.insert(0, ".")
from benchmarks.characters import troupe, YARD
yard = troupe(YARD.replace("LIMP", "false"))
yard.advance(0)
start = time.process_time()
yard.advance(1)
print(time.process_time() - start)
"""


def troupe(cast: str) -> Characters:
    """Return the characters of a cast on level ground."""
    return characters_of(Simulation(scene_of(cast)))


def scene_of(cast: str) -> Scene:
    """Return a scene of a cast on level ground."""
    head = "pronk: 1\nduration: 10\nterrain: {kind: flat, size: [200, 200]}"
    return read_scene(f"{head}\ncast:\n{cast}")


def characters_of(simulation: Simulation) -> Characters:
    """Return the characters of a simulation."""
    return next(one for one in simulation.troupes if isinstance(one, Characters))


def least(step: Callable[[], object], steps: int = STEPS) -> float:
    """Return the least time of a step over rounds of several [us]."""
    best = np.inf
    for _ in range(ROUNDS):
        start = time.process_time()
        for _ in range(steps):
            step()
        best = min(best, time.process_time() - start)
    return best / steps * 1e6


def falling() -> float:
    """Return the least time of a step of all who fall, in the second in which they do [us]."""
    best = np.inf
    for _ in range(3):
        step = machine(troupe(YARD.replace("LIMP", "true")))
        start = time.process_time()
        for _ in range(96):
            step()
        best = min(best, time.process_time() - start)
    return best / 96 * 1e6


def minded(scene: Scene, steps: int) -> tuple[float, float]:
    """Return the time of a step of people with minds, and that of their bodies alone in it [us].

    Of a few rounds the one with the least total counts.
    """
    made = characters_of(Simulation(scene))
    move, spent = made.move, [0.0]

    def timed() -> None:
        start = time.process_time()
        move()
        spent[0] += time.process_time() - start

    made.move = timed  # type: ignore[method-assign]
    orders: Orders = {}
    rounds, step = list[tuple[float, float]](), 0
    for _ in range(ROUNDS):
        spent[0], start = 0.0, time.process_time()
        for _ in range(steps):
            made.read(orders)
            made.advance(step)
            step += 1
        total = time.process_time() - start
        rounds.append((total / steps * 1e6, spent[0] / steps * 1e6))
    return min(rounds[1:])


def group_of_ten(n: int) -> str:
    """Return a grown-up, nine children who play and come back to it, their ball and a bench."""
    x, z = 8.0 * (n % 4), 8.0 * (n // 4)
    minds = f"behaviours: [{{attachment: a{n}}}, {{play: b{n}}}, {{wander: 3}}]"
    return "\n".join(
        (
            f"- {{name: a{n}, character: adult, at: [{x}, {z}], "
            f"behaviours: [{{comfort: c{n}x0}}, {{wander: 2}}]}}",
            *(
                f"- {{name: c{n}x{k}, character: child, at: [{x + 1 + k % 3}, {z + 1 + k // 3}], "
                f"traits: {{anxiety: {0.1 + 0.08 * k:.2f}}}, {minds}}}"
                for k in range(9)
            ),
            f"- {{name: b{n}, character: ball, at: [{x + 5}, {z + 2}]}}",
            f"- {{name: s{n}, character: bench, at: [{x + 4}, {z}]}}",
        )
    )


def machine(made: Characters) -> Callable[[], object]:
    """Return what takes a step of machine code, without telling of it in Python."""
    return made.move


def arrays(count: int, apart: float) -> str:
    """Return so many children on a grid [m]."""
    side = int(np.ceil(np.sqrt(count)))
    return "\n".join(
        f"- {{name: c{k}, character: child, at: [{k % side * apart:.3f}, {k // side * apart:.3f}]}}"
        for k in range(count)
    )


def humanoid(x: float) -> str:
    """Return a body of 13 capsules and hinges that falls at x."""
    limb = '<geom type="capsule" fromto="0 0 0 0 0 -.3" size=".05"/>'

    def chain(at: str) -> str:
        hinges = "".join(f'<joint type="hinge" axis="{a}"/>' for a in ("1 0 0", "0 1 0", "0 0 1"))
        lower = f'<body pos="0 0 -.3"><joint type="hinge" axis="0 1 0"/>{limb}</body>'
        return f'<body pos="{at}">{hinges}{limb}{lower}</body>'

    limbs = "".join(chain(at) for at in ("0 .1 -.3", "0 -.1 -.3", "0 .25 .25", "0 -.25 .25"))
    trunk = "".join(
        f'<geom type="capsule" fromto="{ends}" size=".07"/>'
        for ends in (
            "0 0 -.3 0 0 0",
            "0 0 0 0 0 .25",
            "0 0 .3 0 0 .4",
            "0 -.2 .25 0 .2 .25",
            "0 -.1 -.3 0 .1 -.3",
        )
    )
    return f'<body pos="{x} 0 1.2"><freejoint/>{trunk}{limbs}</body>'


def humanoids() -> Callable[[], object]:
    """Return what takes a world step of three humanoids, which have fallen, in MuJoCo."""
    bodies = "".join(humanoid(1.5 * k) for k in range(3))
    plane = '<geom type="plane" size="20 20 1"/>'
    options = f'<option timestep="{1 / 192}"/>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco>{options}<worldbody>{plane}{bodies}</worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    for _ in range(192):
        mujoco.mj_step(model, data)

    def step() -> None:
        mujoco.mj_step(model, data, 2)

    return step


def main() -> None:
    """Print the table."""
    step = machine(troupe(YARD.replace("LIMP", "false")))
    step()
    print(f"schoolyard, standing: {least(step):.0f} us a world step")
    print(f"schoolyard, falling: {falling():.0f} us a world step")
    hundred = scene_of("\n".join(group_of_ten(n) for n in range(10)))
    for name, scene, steps in (
        ("schoolyard", load_scene(library() / "schoolyard.yaml"), 4 * STEPS),
        ("100 people", hundred, STEPS),
    ):
        total, bodies = minded(scene, steps)
        print(
            f"{name}, with minds: {total:.0f} us a world step, of which bodies {bodies:.0f}; "
            f"ratio {total / bodies:.2f}"
        )
    print(f"three humanoids in MuJoCo: {least(humanoids()):.0f} us")
    plain = subprocess.run(
        [sys.executable, "-c", PLAIN],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    print(f"schoolyard, undecorated: {float(plain.stdout) * 1e6:.0f} us")
    for apart, how in ((3.0, "spread out"), (0.45, "touching")):
        for count in (3, 30, 300):
            step = machine(troupe(arrays(count, apart)))
            step()
            print(f"{count:4d} {how}: {least(step, 12) / count:.1f} us a character")


if __name__ == "__main__":
    main()
