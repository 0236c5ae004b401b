"""The drawing of a figure: nodes and connections in a plane, with all operations carried out.

Seen from above: x to the right, y towards the tail, head up.

Source: Sims 1987, 4.1 and A.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.spec.figure import Figure, LinkShape


@dataclass(frozen=True, eq=False)
class Drawing:
    """A flat network of nodes.

    Attributes:
        names: of the nodes, in the order of the drawing.
        places: (n, 2) positions, x to the right, y towards the tail [m].
        radii: (n,) of the solid around each node [m].
        materials: of each node; empty for the figure's own.
        shapes: of the links that end at each node.
        connections: pairs of node numbers, the lower first, each once.
        made_by: operation that made or last moved each node; -1 for none.
        girths: (n, 3) width and height of the skin around each node, and how far its middle lies
            above the node, all in the radius there.
    """

    names: tuple[str, ...]
    places: Array
    radii: Array
    materials: tuple[str, ...]
    shapes: tuple[LinkShape, ...]
    connections: tuple[tuple[int, int], ...]
    made_by: tuple[int, ...] = ()
    girths: Array = field(default_factory=lambda: np.zeros((0, 3)))

    @cached_property
    def neighbours(self) -> tuple[tuple[int, ...], ...]:
        """Connected nodes of each node, in ascending order."""
        found: list[list[int]] = [[] for _ in self.names]
        for a, b in self.connections:
            found[a].append(b)
            found[b].append(a)
        return tuple(tuple(sorted(row)) for row in found)

    def path_of(self, name: str) -> str:
        """Return the path of a node in the figure's YAML: among its nodes, or an operation."""
        number = self.made_by[self.names.index(name)]
        return f"nodes.{name}" if number < 0 else f"then[{number}]"

    def creation(self) -> Array:
        """Return the nodes (n, 3) in the creation frame: X forward, Y up, Z right [m].

        Source: Sims 1987, eq. 4.1, whose -y_c up is left-handed for a drawing seen
        from above; p_C = (-y_f, 0, x_f) is right-handed.
        """
        x, y = self.places.T
        return np.stack([-y, np.zeros_like(x), x], axis=-1)


def draw(config: Figure) -> Drawing:
    """Return a figure's drawing, with its chains laid and its operations carried out."""
    sheet = config.sheet()
    names = tuple(sheet.marks)
    marks = tuple(sheet.marks.values())
    nodes = [config.nodes[mark.drawn] for mark in marks]
    number = {name: i for i, name in enumerate(names)}
    pairs = sorted(sorted((number[a], number[b])) for a, b in sheet.connections)
    places = np.array([mark.at for mark in marks], dtype=float)
    default_radius = config.radius or _default_radius(places, [node.radius for node in nodes])
    sizes = np.array([mark.size for mark in marks])
    return Drawing(
        names=names,
        places=places,
        radii=sizes * np.array([node.radius or default_radius for node in nodes]),
        materials=tuple(node.material or "" for node in nodes),
        shapes=tuple(node.shape for node in nodes),
        connections=tuple((a, b) for a, b in pairs),
        made_by=tuple(mark.made_by for mark in marks),
        girths=np.array([[node.width, node.height, node.lift] for node in nodes], dtype=float),
    )


def _default_radius(places: Array, radii: Sequence[float | None]) -> float:
    """Return a radius that suits a drawing whose nodes have none [m]."""
    extent = float(np.ptp(places, axis=0).max())
    given = [radius for radius in radii if radius is not None]
    # A drawing with a single place has the size of its nodes.
    return extent / 40.0 or max(given, default=1.0)
