"""Scripted people: simulations of people under orders, and measures of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.people.proportions import JOINTS
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact
from pipeline.spec import read_scene

STEPS = 96
"""Steps per second."""

J = {name: k for k, name in enumerate(JOINTS)}


@dataclass
class Play:
    """The course of a simulation, step by step.

    Attributes:
        p: (K, N, 3) all nodes [m].
        firsts: the first node of each character, by name.
        records: (K, P) of acting people.
        arrived: times [s] and names of people whose orders were done.
        contacts: all.
        frames: (K, J, 3, 3) and (K, J, 3) of the take's nodes, by name.
    """

    p: Array
    firsts: dict[str, int]
    records: np.ndarray
    arrived: list[tuple[float, str]]
    contacts: list[Contact]
    frames: dict[str, tuple[Array, Array]] = field(default_factory=dict)

    def joint(self, name: str, joint: str) -> Array:
        """Return (K, 3) a joint of a person [m]."""
        result: Array = self.p[:, self.firsts[name] + J[joint]]
        return result

    def when(self, name: str) -> list[float]:
        """Return the times when a person arrived [s]."""
        return [time for time, arrived in self.arrived if arrived == name]


def troupe_of(simulation: Simulation) -> Characters:
    return next(t for t in simulation.troupes if isinstance(t, Characters))


def play_scene(
    scene: str, each: Callable[[Characters, int], None] | None = None, frames: bool = False
) -> Play:
    """Play a scene; `each` is called before every step."""
    simulation = Simulation(read_scene("pronk: 1\n" + scene))
    troupe = troupe_of(simulation)
    owners = troupe.arrays.owners
    p, records, arrived, contacts = [], [], [], list[Contact]()
    while not simulation.finished:
        if each is not None:
            each(troupe, simulation.step_number)
        simulation.step()
        facts = troupe.facts()
        time = simulation.step_number / STEPS
        arrived += [(time, name) for name in facts.arrived]
        contacts += facts.contacts
        p.append(troupe.arrays.p.copy())
        records.append(np.array(troupe.persons).copy())
    firsts = {m.name: int(owners["nodes"][i, 0]) for i, m in enumerate(troupe.cast)}
    play = Play(np.array(p), firsts, np.array(records), arrived, contacts)
    if frames:
        take = simulation.take()
        from pipeline.simulation.spatial import matrix

        for k, node in enumerate(take.nodes):
            play.frames[node.name] = matrix(take.rotations[:, k]), take.positions[:, k]
    return play


def run_scene(cast: str, seconds: float, script: str = "", **settings: object) -> Simulation:
    """Return the finished simulation of a scene."""
    more = "".join(f"{key}: {value}\n" for key, value in settings.items())
    orders = f"script:\n{script}" if script else ""
    scene = read_scene(f"pronk: 1\nduration: {seconds}\n{more}cast:\n{cast}\n{orders}")
    simulation = Simulation(scene)
    while not simulation.finished:
        simulation.step()
    return simulation


def node_path(simulation: Simulation, performer: str, name: str = "") -> Array:
    """Return the positions (K, 3) of a performer's node, the first without a name [m]."""
    take = simulation.take()
    nodes = enumerate(take.nodes)
    node = next(k for k, n in nodes if n.performer == performer and name in ("", n.name))
    return np.array(take.positions[:, node])


def walk_scene(kind: str, speed: float, terrain: str = "flat", length: float = 4.0) -> str:
    """Return the scene of a straight walk."""
    seconds = length / speed + 2.6
    return (
        f"duration: {seconds:.2f}\nterrain: {terrain}\n"
        f"cast: [{{name: a, character: {kind}, at: [{-length / 2}, 0.3]}}]\n"
        f"script:\n  - {{at: 0, who: a, do: {{speed: {speed}}}}}\n"
        f"  - {{at: 0, who: a, do: {{go_to: [{length / 2}, 0.3]}}}}\n"
    )


@cache
def walk(kind: str, speed: float, terrain: str = "flat", length: float = 4.0) -> Play:
    """Simulate a straight walk."""
    return play_scene(walk_scene(kind, speed, terrain, length), frames=True)


def spells(on: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and last row of each run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]
