"""Piles: microseconds a sub-step of bodies that meet, beside plain MuJoCo and PyBullet.

The same boxes fall in the same columns on the same ground. Ours is the whole adapter: the
impact law, strikes and sub-steps; plain MuJoCo takes each step from where ours is with a copy
of its model, as many sub-steps and its own springs, critically damped; PyBullet, where it is
installed, goes its own way. Sizes go up until one step of the world takes a second.

    python benchmarks/piles.py [seconds]
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import mujoco
import numpy as np

from pipeline.simulation.bodies.building import build_of
from pipeline.simulation.dynamics.mujoco_world import Collider, MujocoWorld
from pipeline.simulation.dynamics.rigid import State
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.body import Box

COUNTS = (1, 50, 500, 5000)
STEP = 1.0 / 96.0
SUBSTEPS = 10
MOST = 1.0
"""Seconds of processor time of one step of the world after which no more are tried."""

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


def ours(count: int) -> tuple[MujocoWorld, Callable[[], int]]:
    """Return a world, and what goes on by one step and tells how many sub-steps it took."""
    p = places(count)
    q = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    state = State(p, q, np.zeros((count, 3)), np.zeros((count, 3)))
    collider = Collider(build_of(WORDS, ""), 0.5 * np.array(WORDS.size))
    world = MujocoWorld([collider] * count, state, GROUND, [], STEP)

    def step() -> int:
        world.advance()
        return round(STEP / world.model.opt.timestep)

    return world, step


def plain(world: MujocoWorld) -> Callable[[], int]:
    """Return what takes the same step with a copy of the model alone, from where `world` is."""
    model = world.model.__copy__()
    data = mujoco.MjData(model)

    def begin() -> None:
        stiffness = 0.25 * SUBSTEPS / STEP
        model.geom_solref[:] = -(stiffness**2), -2.0 * stiffness
        model.opt.timestep = STEP / SUBSTEPS
        mujoco.mj_copyData(data, model, world.data)

    def step() -> int:
        mujoco.mj_step(model, data, SUBSTEPS)
        return SUBSTEPS

    step.begin = begin  # type: ignore[attr-defined]
    return step


def bullet(count: int) -> Callable[[], int] | None:
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

    def step() -> int:
        for _ in range(SUBSTEPS):
            pybullet.stepSimulation()
        return SUBSTEPS

    return step


def timed(seconds: float, *steps: Callable[[], int]) -> tuple[list[float], float]:
    """Return microseconds a sub-step over `seconds` of the world, and the longest step [s].

    Args:
        seconds: of the world.
        steps: what is timed, taking turns; the last of them goes on.
    """
    spent, substeps, longest = np.zeros(len(steps)), np.zeros(len(steps)), 0.0
    for _ in range(max(round(seconds / STEP), 1)):
        for k, step in enumerate(steps):
            getattr(step, "begin", int)()
            began = time.process_time()
            substeps[k] += step()
            took = time.process_time() - began
            spent[k] += took
            longest = max(longest, took)
        if longest > MOST:
            break
    return (1e6 * spent / substeps).tolist(), longest


def main() -> None:
    """Measure and print."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 1.0
    timed(0.5, ours(2)[1])
    print("bodies   ours   MuJoCo   ratio   PyBullet   [us a sub-step]")
    for count in COUNTS:
        world, step = ours(count)
        (other, mine), longest = timed(seconds, plain(world), step)
        there = bullet(count)
        third = f"{timed(seconds, there)[0][0]:10.0f}" if there else "         -"
        print(f"{count:6d} {mine:6.0f} {other:8.0f} {mine / other:7.2f} {third}", flush=True)
        if longest > MOST:
            break


if __name__ == "__main__":
    main()
