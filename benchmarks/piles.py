"""Piles: microseconds a world step of bodies that meet, beside plain MuJoCo and PyBullet.

The same boxes fall in the same columns on the same level ground. Ours is the whole adapter:
sub-steps, impact law, strikes as Python has them. Plain MuJoCo takes every step from where ours
is, as `mj_step` alone on a copy of the same model and state, with as many sub-steps, the same
sleep and solver, and its own contact parameters, as stiff as ours and critically damped: for
the same bodies in the same places, what it does not do is to bounce and to tell of it.
PyBullet, where it is installed, goes its own way with as many sub-steps.

All take turns step by step, which first by round. Motion is deterministic, so each step is
the same work in each round, and its least time over the rounds counts; then the mean over
steps. Sizes go up until one step takes a second.

    python benchmarks/piles.py [bodies ...]
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Sequence

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import mujoco
import numpy as np

from pipeline.simulation.bodies.body_model import build_body
from pipeline.simulation.dynamics.impact_law import STIFFNESS
from pipeline.simulation.dynamics.mujoco_bodies import Collider
from pipeline.simulation.dynamics.mujoco_world import MujocoWorld
from pipeline.simulation.dynamics.rigid_body import State
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.body import Box

COUNTS = (1, 50, 500, 5000)
STEP = 1.0 / 96.0
SUBSTEPS = 10
ROUNDS = 4
SECONDS = 1.5
"""Of simulated time, at most; then many a pile sleeps."""

BUDGET = 20.0
"""Seconds of a round, about; the steps that it has time for are the first ones."""

MOST = 1.0
"""Seconds of one step after which no more bodies are tried."""

Step = Callable[[], object]

GROUND = HeightField(np.zeros((3, 3)), (200.0, 200.0))
WORDS = Box(shape="box", bounciness=0.2, collide="all")


def places(count: int) -> Array:
    """Return where boxes begin (count, 3): columns of five, a little aside of one another."""
    i = np.arange(count)
    column, layer = np.divmod(i, 5)
    side = int(np.ceil(np.sqrt(count / 5)))
    x, z = column % side * 0.45, column // side * 0.45
    aside = 0.04 * np.sin(7.0 * i)
    return np.stack([x + aside, 0.2 + 0.36 * layer, z - aside], axis=1)


def ours(count: int) -> MujocoWorld:
    """Return a world of so many boxes."""
    p = places(count)
    q = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    state = State(p, q, np.zeros((count, 3)), np.zeros((count, 3)))
    collider = Collider(build_body(WORDS, ""), 0.5 * np.array(WORDS.size))
    return MujocoWorld([collider] * count, state, GROUND, [], STEP)


def plain(world: MujocoWorld) -> tuple[Step, Step]:
    """Return what takes plain MuJoCo to where `world` is, and what takes a step from there."""
    model = world.model.__copy__()
    data = mujoco.MjData(model)
    stiffness = STIFFNESS * SUBSTEPS / STEP
    model.geom_solref[:] = -(stiffness**2), -2.0 * stiffness
    model.opt.timestep = STEP / SUBSTEPS
    return (
        lambda: mujoco.mj_copyData(data, model, world.data),
        lambda: mujoco.mj_step(model, data, SUBSTEPS),
    )


def bullet(count: int) -> Step | None:
    """Return what steps PyBullet, None where there is none."""
    try:
        import pybullet
    except ImportError:
        return None
    pybullet.connect(pybullet.DIRECT)
    pybullet.resetSimulation()
    pybullet.setGravity(0.0, -9.81, 0.0)
    pybullet.setTimeStep(STEP / SUBSTEPS)
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[100.0, 1.0, 100.0])
    pybullet.createMultiBody(0.0, shape, basePosition=[0.0, -1.0, 0.0])
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.15] * 3)
    for place in places(count):
        pybullet.createMultiBody(16.2, shape, basePosition=place.tolist())

    def step() -> None:
        for _ in range(SUBSTEPS):
            pybullet.stepSimulation()

    return step


def round_of(count: int, number: int, most: int) -> dict[str, list[float]]:
    """Return the seconds of up to `most` steps of each, in one round."""
    world, third = ours(count), bullet(count)
    begin, other = plain(world)
    steps: dict[str, Step] = {"all": world.advance, "mujoco": other}
    if third is not None:
        steps["pybullet"] = third
    order = list(steps) if number % 2 else list(steps)[::-1]
    times: dict[str, list[float]] = {name: [] for name in steps}
    start = time.perf_counter()
    while len(times["all"]) < most and time.perf_counter() - start < BUDGET:
        begin()
        for name in order:
            before = time.perf_counter()
            steps[name]()
            times[name].append(time.perf_counter() - before)
    return times


def measured(count: int) -> dict[str, Array]:
    """Return the least microseconds of each step of each."""
    rounds = [round_of(count, 0, round(SECONDS / STEP))]
    rounds += [round_of(count, i, len(rounds[0]["all"])) for i in range(1, ROUNDS)]
    # A later round may have had less time.
    steps = min(len(one["all"]) for one in rounds)
    return {name: 1e6 * np.min([one[name][:steps] for one in rounds], axis=0) for name in rounds[0]}


def main(counts: Sequence[int] = COUNTS) -> None:
    """Measure and print."""
    ours(2).advance()
    print("microseconds a world step of 1/96 s: mean over steps of the least of rounds")
    for count in counts:
        times = measured(count)
        own = times["all"].mean()
        print(f"pile, {count} bodies, {len(times['all'])} steps:")
        for name, values in times.items():
            ratio = f"   all takes {own / values.mean():6.3f} of it"
            print(f"  {name:12} {values.mean():10.0f}{ratio}", flush=True)
        if max(values.mean() for values in times.values()) > 1e6 * MOST:
            break


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or COUNTS)
