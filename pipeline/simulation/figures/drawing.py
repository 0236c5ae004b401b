"""Drawing: nodes and connections on the dissection table, all operations done.

Seen from above: x to the right, y towards the tail, head up.

Source: Sims 1987, 4.1 and A.1.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.spec.figure import Figure
from pipeline.spec.mirror import copied_names, mirrored


@dataclass(frozen=True, eq=False)
class Drawing:
    """A flat network.

    Attributes:
        names: names of the nodes, in the order of the drawing.
        places: (n, 2) positions, x to the right, y towards the tail [m].
        radii: (n,) radii of the solid around each node [m].
        materials: material of each node, empty for the figure's own.
        connections: pairs of node numbers, the lower first, each once.
    """

    names: tuple[str, ...]
    places: Array
    radii: Array
    materials: tuple[str, ...]
    connections: tuple[tuple[int, int], ...]

    @cached_property
    def neighbours(self) -> tuple[tuple[int, ...], ...]:
        """For each node the nodes that it is connected to, in ascending order."""
        found: list[list[int]] = [[] for _ in self.names]
        for a, b in self.connections:
            found[a].append(b)
            found[b].append(a)
        return tuple(tuple(sorted(row)) for row in found)

    def creation(self) -> Array:
        """Return the nodes (n, 3) in the creation frame: X forward, Y up, Z right [m].

        Source: Sims 1987, eq. 4.1, whose -y_c up is left-handed for a drawing seen
        from above; p_C = (-y_f, 0, x_f) is right-handed.
        """
        x, y = self.places.T
        return np.stack([-y, np.zeros_like(x), x], axis=-1)


def draw(words: Figure) -> Drawing:
    """Carry out the figure's chains and operations in their order."""
    places = {name: node.at for name, node in words.nodes.items()}
    nodes = dict(words.nodes)
    connections = {frozenset(pair) for chain in words.chains for pair in itertools.pairwise(chain)}
    for operation in words.then:
        twin = copied_names(operation, places)
        nodes |= {copy: nodes[name] for name, copy in twin.items()}
        # A connection between two copied nodes is copied whole; one that leads out
        # of them ties the copy to the original, so that a mirrored leg keeps its hip.
        connections |= {
            frozenset(twin.get(end, end) for end in pair)
            for pair in connections
            if any(end in twin for end in pair)
        }
        places = mirrored(operation, places)
    names = tuple(places)
    number = {name: i for i, name in enumerate(names)}
    pairs = sorted(sorted(number[end] for end in pair) for pair in connections)
    extent = float(np.ptp(np.array(list(places.values())), axis=0).max())
    return Drawing(
        names=names,
        places=np.array([places[name] for name in names], dtype=float),
        radii=np.array([nodes[name].radius or words.radius or extent / 40.0 for name in names]),
        materials=tuple(nodes[name].material or "" for name in names),
        connections=tuple((a, b) for a, b in pairs),
    )
