"""Group rules: the base class of all groups, and their view of the rest of the cast.

Nobody depends on a group, so it moves last of all: it sees others where they are in the very row,
with all that is attached to them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.attachment import node_number
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.spatial import Array, turn
from pipeline.simulation.take import Contact, Mesh, Node
from pipeline.simulation.troupe import Rows, World


@dataclass(frozen=True, eq=False)
class Outline:
    """The nodes of one performer, and of each the point of its mesh that is farthest away.

    Attributes:
        nodes: (m,) numbers.
        tips: (m, 3) in the frames of the nodes [m].
    """

    nodes: NDArray[np.int64]
    tips: Array


@dataclass(frozen=True, eq=False)
class CastIndex:
    """Everybody else, before anything moves.

    Attributes:
        nodes: of all performers.
        meshes: of all performers.
        figures: of the creatures, by name.
    """

    nodes: Sequence[Node]
    meshes: Sequence[Mesh]
    figures: Mapping[str, Figure]

    def number(self, whom: str, path: str) -> int:
        """Return the number of the node that somebody is called by.

        Raises:
            SceneError: there is none; `path` says where it was named.
        """
        numbers = {node.name: i for i, node in enumerate(self.nodes)}
        found = node_number(whom, self.figures, numbers)
        if isinstance(found, str):
            raise SceneError([Problem(path, found)])
        return found

    def outline(self, name: str) -> Outline:
        """Return the outline of a performer."""
        own = [i for i, node in enumerate(self.nodes) if node.performer == name]
        tips = dict.fromkeys(own, np.zeros(3))
        for mesh in self.meshes:
            if int(mesh.nodes[0, 0]) in tips:
                for i in np.unique(mesh.nodes[:, 0]).tolist():
                    arms = mesh.vertices[mesh.nodes[:, 0] == i] - np.array(self.nodes[i].rest)
                    tips[i] = arms[np.argmax((arms * arms).sum(axis=-1))].astype(float)
        return Outline(np.array(own), np.array([tips[i] for i in own]))


@dataclass(frozen=True, eq=False)
class CastPoses:
    """Everybody else in n rows, in the world.

    Attributes:
        R: (n, J, 3, 3) rotations of all nodes; those of groups are not written yet.
        p: (n, J, 3) their positions [m].
    """

    R: Array
    p: Array

    def points(self, outlines: Sequence[Outline]) -> Array:
        """Return the nodes and tips (n, m, 3) of performers [m]."""
        if not outlines:
            return np.zeros((len(self.p), 0, 3))
        nodes = np.concatenate([outline.nodes for outline in outlines])
        tips = np.concatenate([outline.tips for outline in outlines])
        p = self.p[:, nodes]
        return np.concatenate([p, p + turn(self.R[:, nodes], tips)], axis=1)

    def balls(self, outlines: Sequence[Outline]) -> tuple[Array, Array]:
        """Return middles (n, m, 3) and radii (n, m) of balls around performers [m]."""
        middles, radii = [np.zeros((len(self.p), 0, 3))], [np.zeros((len(self.p), 0))]
        for outline in outlines:
            points = self.points([outline])
            middle = 0.5 * (points.min(axis=1) + points.max(axis=1))
            away = points - middle[:, None]
            middles.append(middle[:, None])
            radii.append(np.sqrt((away * away).sum(axis=-1).max(axis=1))[:, None])
        return np.concatenate(middles, axis=1), np.concatenate(radii, axis=1)


@dataclass(frozen=True, eq=False)
class GroupContext:
    """What is known of a group before it moves.

    Attributes:
        name: of it.
        path: where its words stand in the scene.
        place: (3,) where it is said to be [m].
        parent: whom it goes along with, if anybody.
        material: of its members.
        world: that it is in.
    """

    name: str
    path: str
    place: Array
    parent: str | None
    material: str
    world: World

    @property
    def seed(self) -> tuple[int, str]:
        """Seed of the scene, and the name that it is split by."""
        return self.world.seed, self.name

    def height(self, places: Array) -> Array:
        """Return the heights (...) of the ground at places (..., 3) [m]."""
        return self.world.ground.height(places[..., 0], places[..., 2])


class GroupRule(Protocol):
    """A group that moves by its rule."""

    inventory: Inventory

    def meet(self, cast: CastIndex) -> None:
        """Find those that its words name.

        Raises:
            SceneError: somebody has no such part.
        """

    def send(self, time: float, goal: tuple[float, float]) -> None:
        """Make for a place (x, z) from `time` on, if it is one that can be sent."""

    def write(self, rows: Rows, times: Array, others: CastPoses) -> list[Contact]:
        """Go on through n rows and write them.

        Args:
            rows: its slice of the take; all of it alive.
            times: (n,) of the rows, later than those before [s].
            others: everybody else in these rows.

        Returns:
            The contacts that have begun since the rows before.
        """


def position_on_ground(at: tuple[float, ...], world: World) -> Array:
    """Return the place (3,) that two or three numbers stand for: two are on the ground [m]."""
    if len(at) == 3:
        return np.array(at)
    height = float(world.ground.height(np.array(at[0]), np.array(at[1])))
    return np.array([at[0], height, at[1]])
