"""Mind scenes: simulations of characters with minds, and measures of them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take
from pipeline.spec import read_scene
from pipeline.spec.behaviour import NAMES

SIZES = {"box": 0.36, "bench": 0.78, "merry-go-round": 1.33}
"""Radii of the circles around obstacles [m]."""


def simulation(cast: str, duration: float, more: str = "") -> Simulation:
    """Return the simulation of a cast on level ground."""
    head = f"pronk: 1\nduration: {duration}\nterrain: {{kind: flat, size: [24, 24]}}\n"
    return Simulation(read_scene(f"{head}{more}\ncast:\n{cast}"))


def troupe(simulation: Simulation) -> Characters:
    """Return the characters of a simulation."""
    return next(t for t in simulation.troupes if isinstance(t, Characters))


def steps(simulation: Simulation) -> Iterator[Characters]:
    """Yield the characters after each step to the end."""
    characters = troupe(simulation)
    while not simulation.finished:
        simulation.step()
        yield characters


def channel(take: Take, name: str) -> Array:
    """Return (K,) a channel of a take."""
    column = [channel.name for channel in take.channels].index(name)
    return np.asarray(take.values[:, column])


def behaviours_of(take: Take, name: str) -> list[str]:
    """Return the name of a character's behaviour in each row."""
    numbers = np.rint(channel(take, f"{name}.behaviour")).astype(int)
    return [NAMES[n] if n >= 0 else "" for n in numbers.tolist()]


def obstacle_course(seed: int, count: int = 12) -> str:
    """Return a cast: a child, a ball 12 m away to go to, and random obstacles between.

    Gaps are never too narrow for the child.
    """
    rng = np.random.Generator(np.random.PCG64(seed))
    cast = [
        "- {name: walker, character: child, at: [-6, 0], traits: {speed: 0.5}, "
        "behaviours: [{approach: goal, distance: 0.3}]}",
        "- {name: goal, character: ball, at: [6, 0]}",
    ]
    placed = [(-6.0, 0.0, 0.8), (6.0, 0.0, 0.8)]
    for _ in range(400):
        if len(placed) == count + 2:
            break
        kind = str(rng.choice(list(SIZES), p=[0.6, 0.3, 0.1]))
        x, z = float(rng.uniform(-4.8, 4.8)), float(rng.uniform(-3.0, 3.0))
        if all(np.hypot(x - a, z - b) > SIZES[kind] + c + 0.5 for a, b, c in placed):
            placed.append((x, z, SIZES[kind]))
            cast.append(
                f"- {{name: o{len(placed)}, character: {kind}, at: [{x:.3f}, {z:.3f}], "
                f"heading_deg: {float(rng.uniform(0.0, 360.0)):.1f}}}"
            )
    return "\n".join(cast)
