"""Acting: people in a scene who do what a script tells them, and what is measured of them."""

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
"""Of a second."""

J = {name: k for k, name in enumerate(JOINTS)}


@dataclass
class Play:
    """What happened in a scene, step by step.

    Attributes:
        p: (K, N, 3) all nodes [m].
        firsts: the first node of each character, by name.
        records: (K, P) of those who act.
        arrived: who has done what it was told, and when [s].
        contacts: all.
        frames: (K, J, 3, 3) and (K, J, 3) of the take's nodes, by name.
    """

    p: Array
    firsts: dict[str, int]
    records: np.ndarray
    arrived: list[tuple[float, str]]
    contacts: list[Contact]
    frames: dict[str, tuple[Array, Array]] = field(default_factory=dict)

    def joint(self, who: str, name: str) -> Array:
        """Return (K, 3) a joint [m]."""
        result: Array = self.p[:, self.firsts[who] + J[name]]
        return result

    def when(self, who: str) -> list[float]:
        """Return when somebody arrived [s]."""
        return [time for time, name in self.arrived if name == who]


def troupe_of(simulation: Simulation) -> Characters:
    return next(t for t in simulation.troupes if isinstance(t, Characters))


def play_scene(
    words: str, each: Callable[[Characters, int], None] | None = None, frames: bool = False
) -> Play:
    """Play a scene; `each` is called before every step."""
    simulation = Simulation(read_scene("pronk: 1\n" + words))
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


def walk_words(kind: str, speed: float, terrain: str = "flat", length: float = 4.0) -> str:
    """Return the scene of one who walks straight on."""
    seconds = length / speed + 2.6
    return (
        f"duration: {seconds:.2f}\nterrain: {terrain}\n"
        f"cast: [{{name: a, character: {kind}, at: [{-length / 2}, 0.3]}}]\n"
        f"script:\n  - {{at: 0, who: a, do: {{speed: {speed}}}}}\n"
        f"  - {{at: 0, who: a, do: {{go_to: [{length / 2}, 0.3]}}}}\n"
    )


@cache
def walk(kind: str, speed: float, terrain: str = "flat", length: float = 4.0) -> Play:
    """Play one who walks."""
    return play_scene(walk_words(kind, speed, terrain, length), frames=True)


def spells(on: np.ndarray) -> list[tuple[int, int]]:
    """Return first and last of the rows of each spell in which something holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]
