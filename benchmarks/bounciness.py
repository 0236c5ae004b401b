"""Bounciness: what bodies that meet give back of their speed, beside what they are asked for.

Balls and boxes fall flat on level ground at several speeds, from heights that let them touch
at different moments of a step. The table in `dynamics/impact_law.py` is what this prints.

    python benchmarks/bounciness.py
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.bodies.body_model import build_body
from pipeline.simulation.dynamics.impact_law import MEASURED_BOUNCINESS
from pipeline.simulation.dynamics.mujoco_bodies import Collider
from pipeline.simulation.dynamics.mujoco_world import MujocoWorld
from pipeline.simulation.dynamics.rigid_body import State
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.body import Box, Sphere

SPEEDS = (0.5, 1.0, 2.0, 4.0, 6.0)
PHASES = 12
STEP = 1.0 / 96.0
GROUND = HeightField(np.zeros((3, 3)), (100.0, 100.0))


def colliders(b: float) -> list[Collider]:
    """Return a ball and a box."""
    box = Box(shape="box", bounciness=b, collide="all")
    sphere = Sphere(shape="sphere", bounciness=b, radius=0.15, collide="all")
    half = 0.5 * np.array(box.size)
    return [Collider(build_body(sphere, ""), None), Collider(build_body(box, ""), half)]


def measured(b: float) -> tuple[float, float]:
    """Return the least and the greatest bounciness found where `b` was asked for."""
    kinds = colliders(b)
    cases = [(k, v, i) for k in range(2) for v in SPEEDS for i in range(PHASES)]
    places = [[2.0 * (n % 12) - 12, 0.15, 2.0 * (n // 12) - 12] for n in range(len(cases))]
    p, v = np.array(places), np.zeros((len(cases), 3))
    for n, (_, speed, i) in enumerate(cases):
        p[n, 1] += speed * (0.01 + 0.00012 * i)
        v[n, 1] = -speed
    q = np.tile([1.0, 0.0, 0.0, 0.0], (len(cases), 1))
    state = State(p, q, v, np.zeros_like(v))
    world = MujocoWorld([kinds[k] for k, _, _ in cases], state, GROUND, [], STEP)
    came, left = np.zeros(len(cases)), np.zeros(len(cases))
    for _ in range(24):
        for strike in world.advance():
            came[strike.one] = came[strike.one] or strike.speed
        now = world.state
        up = (came > 0.0) & (left == 0.0) & (now.p[:, 1] > 0.15) & (now.v[:, 1] > 0.0)
        height = now.p[:, 1] - 0.15
        left[up] = np.sqrt(now.v[up, 1] ** 2 + 2.0 * 9.81 * height[up])
    ratios = left / came
    return float(ratios.min()), float(ratios.max())


if __name__ == "__main__":
    print("asked      least   greatest")
    for asked in MEASURED_BOUNCINESS:
        least, greatest = measured(asked)
        print(f"{asked:5.2f}   {math.floor(1000 * least) / 1000:8.3f} {greatest:8.3f}")
