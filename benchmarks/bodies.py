"""Bodies: microseconds a world step of falling boxes, beside other engines, in both modes.

Mode `terrain`: 1, 50, 500 and 5,000 boxes rain on flat ground and on hills, bounce, slide and
come to rest.
The same boxes in the same places go through MuJoCo and, where it is installed, PyBullet, on
the same heights, all engines in turn, world step by world step of 1/96 s, so that what else
the machine does disturbs all alike; the median over the steps of one run counts, and the mean
beside it. The others go through a world step at their own customary steps: MuJoCo in 5 of
about 2 ms, PyBullet in 3 of about 3.5 ms; MuJoCo also in one as long as the world step, at
which it is cheapest and its boxes sink in and tremble. Mode `all`: piles, see `piles.py`. A
count is the last where a step takes longer than a second.

    python benchmarks/bodies.py [terrain | all] [bodies ...]
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

# One core: numpy reads these when it is imported.
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import mujoco
import numpy as np
import piles

from pipeline.simulation.dynamics.hull import hull_of
from pipeline.simulation.dynamics.mass import mass_of_solid
from pipeline.simulation.dynamics.rigid_body import Bodies, BodyModel, State
from pipeline.simulation.dynamics.terrain_bodies import TerrainBodies
from pipeline.simulation.terrain import Ground, build_ground
from pipeline.spec import read_scene

try:
    import pybullet
except ImportError:
    pybullet = None

Array = Any
Step = Callable[[], object]

DT = 1.0 / 96.0
SIZE = np.array([0.3, 0.2, 0.2])
DENSITY, BOUNCINESS, FRICTION = 600.0, 0.3, 0.5
SPACING = 0.6
"""Distance of neighbours at the start [m]."""

SECONDS = 4.0
"""Of simulated time, at most."""

BUDGET = 60.0
"""Seconds of a run, about; the steps that it has time for are the first ones."""

COUNTS = (1, 50, 500, 5000)


def ground_for(kind: str, count: int) -> Ground:
    """Return ground with room for so many bodies."""
    side = max(8.0, 1.5 * SPACING * np.sqrt(count))
    words = f"{{kind: {kind}, size: [{side}, {side}], cells: [160, 160]}}"
    text = f"pronk: 1\nduration: 1\nterrain: {words}\ncast: [{{prop: {{shape: ball}}}}]\n"
    return build_ground(read_scene(text).terrain, 3)


def start(ground: Ground, count: int) -> tuple[Array, Array]:
    """Return places (n, 3) and attitudes (n, 4) of bodies in a square above the ground."""
    chance, side = np.random.default_rng(1), int(np.ceil(np.sqrt(count)))
    i = np.arange(count, dtype=float)
    x, z = (i % side - 0.5 * (side - 1)) * SPACING, (i // side - 0.5 * (side - 1)) * SPACING
    y = ground.height(x, z) + chance.uniform(0.4, 1.2, count)
    q = chance.normal(size=(count, 4))
    return np.column_stack([x, y, z]), q / np.linalg.norm(q, axis=1, keepdims=True)


def ours(ground: Ground, p: Array, q: Array) -> Step:
    """Return the step of bodies that meet the terrain alone."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * SIZE / 2
    hull = hull_of(corners)
    mass = mass_of_solid(hull.vertices, hull.faces, DENSITY)
    build = BodyModel(mass, hull, 0.0, BOUNCINESS, FRICTION)
    nothing = np.zeros_like(p)
    bouncing = TerrainBodies(
        Bodies.of([build] * len(p)), State(p, q, nothing, nothing.copy()), ground
    )
    return lambda: bouncing.advance(DT)


def by_mujoco(ground: Ground, p: Array, q: Array, steps: int) -> Step:
    """Return the step of MuJoCo's bodies; its Z is up, so it sees x, -z, y."""
    field = ground.field
    low, high = field.heights.min(), field.heights.max()
    rows, columns = field.heights.shape
    bodies = "".join(
        f'<body pos="{x} {-z} {y}" quat="{w} {a} {-c} {b}"><freejoint/><geom type="box" '
        f'size="{SIZE[0] / 2} {SIZE[2] / 2} {SIZE[1] / 2}" density="{DENSITY}" '
        f'friction="{FRICTION}" contype="2" conaffinity="1"/></body>'
        for (x, y, z), (w, a, b, c) in zip(p.tolist(), q.tolist(), strict=True)
    )
    flat = high - low < 1e-9
    asset = (
        ""
        if flat
        else (
            f'<asset><hfield name="ground" nrow="{rows}" ncol="{columns}" '
            f'size="{field.size[0] / 2} {field.size[1] / 2} {high - low} 1"/></asset>'
        )
    )
    shape = 'type="plane" size="0 0 1"' if flat else 'type="hfield" hfield="ground"'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{DT / steps}" gravity="0 0 -9.81"/>{asset}<worldbody>'
        f'<geom {shape} pos="0 0 {low}" contype="1" conaffinity="2" friction="{FRICTION}"/>'
        f"{bodies}</worldbody></mujoco>"
    )
    if not flat:
        # Its rows run along its y, our -z.
        model.hfield_data[:] = ((field.heights[::-1] - low) / (high - low)).ravel()
    data = mujoco.MjData(model)
    return lambda: mujoco.mj_step(model, data, nstep=steps)


def by_pybullet(ground: Ground, p: Array, q: Array, steps: int) -> Step:
    """Return the step of PyBullet's bodies."""
    client = pybullet.connect(pybullet.DIRECT)
    here = {"physicsClientId": client}
    pybullet.setGravity(0, 0, -9.81, **here)
    pybullet.setTimeStep(DT / steps, **here)
    field = ground.field
    rows, columns = field.heights.shape
    if np.ptp(field.heights) < 1e-9:
        surface = pybullet.createCollisionShape(pybullet.GEOM_PLANE, **here)
        middle = 0.0
    else:
        surface = pybullet.createCollisionShape(
            pybullet.GEOM_HEIGHTFIELD,
            meshScale=[*field.cell, 1.0],
            heightfieldData=field.heights[::-1].ravel().tolist(),
            numHeightfieldRows=columns,
            numHeightfieldColumns=rows,
            **here,
        )
        middle = 0.5 * float(field.heights.min() + field.heights.max())
    base = pybullet.createMultiBody(0, surface, basePosition=[0, 0, middle], **here)
    pybullet.setCollisionFilterGroupMask(base, -1, 1, 2, **here)
    box = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=(SIZE[[0, 2, 1]] / 2).tolist(), **here
    )
    for (x, y, z), (w, a, b, c) in zip(p.tolist(), q.tolist(), strict=True):
        one = pybullet.createMultiBody(
            DENSITY * float(SIZE.prod()), box, -1, [x, -z, y], [a, -c, b, w], **here
        )
        pybullet.setCollisionFilterGroupMask(one, -1, 2, 1, **here)
        pybullet.changeDynamics(one, -1, lateralFriction=FRICTION, restitution=BOUNCINESS, **here)

    def step() -> None:
        for _ in range(steps):
            pybullet.stepSimulation(**here)

    return step


def measured(engines: dict[str, Step]) -> dict[str, Array]:
    """Return the microseconds of each step of each engine, which take turns."""
    times: dict[str, list[float]] = {name: [] for name in engines}
    begin = time.perf_counter()
    while len(times["terrain"]) < SECONDS / DT and time.perf_counter() - begin < BUDGET:
        for name, step in engines.items():
            before = time.perf_counter()
            step()
            times[name].append((time.perf_counter() - before) * 1e6)
    return {name: np.array(values) for name, values in times.items()}


def rain(counts: Sequence[int]) -> None:
    """Print the table of bodies that meet the terrain alone, as do those beside them."""
    # Machine code is made or loaded at the first step, once.
    ours(ground_for("hills", 1), *start(ground_for("hills", 1), 1))()
    print("microseconds a world step of 1/96 s: median (mean) over the steps, and ratios of means")
    for kind in ("flat", "hills"):
        for count in counts:
            ground = ground_for(kind, count)
            p, q = start(ground, count)
            engines = {"terrain": ours(ground, p, q)}
            try:
                engines["mujoco 5"] = by_mujoco(ground, p, q, 5)
                engines["mujoco 1"] = by_mujoco(ground, p, q, 1)
            except ValueError as error:
                print(f"MuJoCo does not hold {count} bodies: {error}")
            if pybullet is not None:
                engines["pybullet 3"] = by_pybullet(ground, p, q, 3)
            times = measured(engines)
            own = times["terrain"].mean()
            print(f"{kind}, {count} bodies, {len(times['terrain'])} steps:")
            for name, values in times.items():
                print(
                    f"  {name:12} {np.median(values):10.0f} ({values.mean():10.0f})"
                    f"   terrain takes {own / values.mean():6.3f} of it"
                )
            if max(values.mean() for values in times.values()) > 1e6:
                break


MODES = {"terrain": rain, "all": piles.main}


def main() -> None:
    """Print the tables that are asked for."""
    words = sys.argv[1:]
    counts = [int(word) for word in words if word.isdigit()] or COUNTS
    asked = [word for word in words if not word.isdigit()] or MODES
    for mode in asked:
        MODES[mode](counts)


if __name__ == "__main__":
    main()
