"""Group rules: the base class of all groups, and their view of the rest of the cast.

Nobody depends on a group, so it moves last of all: it sees others where they are in the very row,
with all that is attached to them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.spatial import Array, turn
from pipeline.simulation.take import Contact, Mesh, Node
from pipeline.simulation.troupe import World


@dataclass(frozen=True, eq=False)
class Outline:
    """Nodes of one performer, and for each the farthest point of its mesh.

    Attributes:
        nodes: (m,) numbers.
        tips: (m, 3) in the frames of the nodes [m].
    """

    nodes: NDArray[np.int64]
    tips: Array


@dataclass(frozen=True, eq=False)
class CastIndex:
    """All performers, before anything moves.

    Attributes:
        nodes: of all performers.
        meshes: of all performers.
        names: of all nodes and parts.
    """

    nodes: Sequence[Node]
    meshes: Sequence[Mesh]
    names: NodeNames

    def number(self, part_name: str, path: str) -> int:
        """Returns the number of the node of a performer or part.

        Raises:
            SceneError: if there is none; `path` is where it was named.
        """
        found = self.names.find(part_name)
        if isinstance(found, str):
            raise SceneError([Problem(path, found)])
        return found

    def outline(self, name: str) -> Outline:
        """Returns the outline of a performer."""
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
    """Poses of all performers in n rows, in the world.

    Attributes:
        R: (n, J, 3, 3) rotations of all nodes; those of groups are not written yet.
        p: (n, J, 3) their positions [m].
    """

    R: Array
    p: Array

    def points(self, outlines: Sequence[Outline]) -> Array:
        """Returns the nodes and tips (n, m, 3) of performers [m]."""
        if not outlines:
            return np.zeros((len(self.p), 0, 3))
        nodes = np.concatenate([outline.nodes for outline in outlines])
        tips = np.concatenate([outline.tips for outline in outlines])
        p = self.p[:, nodes]
        return np.concatenate([p, p + turn(self.R[:, nodes], tips)], axis=1)

    def balls(self, outlines: Sequence[Outline]) -> tuple[Array, Array]:
        """Returns centres (n, m, 3) and radii (n, m) of balls around performers [m]."""
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
    """Name, place and world of a group.

    Attributes:
        name: of the group.
        path: of the group in the scene.
        place: (3,) its given place [m].
        parent: part that it is attached to, None without.
        material: of its members.
        world: constants of the scene.
    """

    name: str
    path: str
    place: Array
    parent: str | None
    material: str
    world: World

    @property
    def seed(self) -> tuple[int, str]:
        """Seed of the scene, and the name that splits it."""
        return self.world.seed, self.name

    def height(self, places: Array) -> Array:
        """Returns the heights (...) of the ground at positions (..., 3) [m]."""
        return self.world.ground.height(places[..., 0], places[..., 2])


class GroupRule:
    """A group that moves by its rule; the optional passes do nothing by default.

    Attributes:
        default_material: of members, unless the scene names one.
        setting: name, place and material of the group.
        config: its model in the scene.
        inventory: its nodes, meshes and parts.
    """

    default_material: ClassVar[str]
    inventory: Inventory

    def bind(self, cast: CastIndex) -> None:
        """Resolves the performers that the configuration names.

        Raises:
            SceneError: if a part does not exist.
        """

    def send(self, time: float, goal: tuple[float, float]) -> None:
        """Makes for a place (x, z) from `time` [s] on."""

    def write(self, rows: Rows, times: Array, others: CastPoses) -> list[Contact]:
        """Advances through n rows and writes them.

        Args:
            rows: its slice of the take, all of it alive.
            times: (n,) of the rows, later than those before [s].
            others: poses of all other performers in these rows.

        Returns:
            The contacts that began since the rows before.
        """
        raise NotImplementedError


def position_on_ground(at: tuple[float, ...], world: World) -> Array:
    """Returns the position (3,) of three coordinates, or of x and z on the ground [m]."""
    if len(at) == 3:
        return np.array(at)
    height = float(world.ground.height(np.array(at[0]), np.array(at[1])))
    return np.array([at[0], height, at[1]])
