"""Inventory: what a herd adds to a take, and where its nodes' poses come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.flesh import flesh
from pipeline.simulation.figures.kinematics import LimbPose
from pipeline.simulation.figures.skeleton import BODY, volume
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.idle import Idlers
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Channel, Mesh, Node, Part
from pipeline.simulation.troupe import Inventory

DENSITY = 1000.0
"""Of flesh [kg/m³]."""

BODY_NODE, LEG_NODE, IDLE_NODE = 0, 1, 2


@dataclass(frozen=True, eq=False)
class NodeTable:
    """For each node of the herd, creature by creature and link by link: what moves it.

    Attributes:
        owner: (J,) creature.
        names: of the nodes.
        source: (J,) body, a leg's joint or an idle joint.
        leg, column: (J,) which leg, and which of its joints.
        idle: (J,) which idle joint.
        rest: (J, 3) place in the creation frame [m].
        parent: (J,) node it hangs on, -1 for bodies.
        foot_materials: (L,) own material of the last link of each leg, may be empty.
        leg_channels: (L, n) joints of legs that are not padding.
    """

    owner: NDArray[np.int64]
    names: tuple[str, ...]
    source: NDArray[np.int64]
    leg: NDArray[np.int64]
    column: NDArray[np.int64]
    idle: NDArray[np.int64]
    rest: Array
    parent: NDArray[np.int64]
    foot_materials: list[str]
    leg_channels: NDArray[np.bool_]

    @staticmethod
    def of(herd: Herd, idlers: Idlers) -> NodeTable:
        """Number the nodes of a herd."""
        idle_of = {
            (int(c), int(j)): i
            for i, (c, j) in enumerate(zip(idlers.owner, idlers.number, strict=True))
        }
        rows: list[tuple[int, str, int, int, int, int, Array, int]] = []
        first_leg, columns, materials = 0, [], []
        for c, figure in enumerate(herd.figures):
            skeleton, base = figure.skeleton, len(rows)
            leg_of = {
                j: (first_leg + i, k)
                for i, limb in enumerate(skeleton.legs)
                for k, j in enumerate(limb.joints)
            }
            node_of_joint = {BODY: base}
            for i, link in enumerate(skeleton.links):
                j = link.joint
                node_of_joint[j] = base + i
                leg, column = leg_of.get(j, (0, 0))
                source = BODY_NODE if j == BODY else LEG_NODE if j in leg_of else IDLE_NODE
                rest = np.zeros(3) if j == BODY else link.ends[0]
                parent = -1
                if j != BODY:
                    # Joints of one ball move no link of their own: go up to one that does.
                    above = int(skeleton.parents[j])
                    while above not in node_of_joint:
                        above = int(skeleton.parents[above])
                    parent = node_of_joint[above]
                idle = idle_of.get((c, j), 0)
                name = f"{herd.names[c]}.{link.name}"
                rows.append((c, name, source, leg, column, idle, rest, parent))
            for limb in skeleton.legs:
                columns.append(len(limb.joints))
                materials.append(skeleton.links[limb.links[-1]].material)
            first_leg += len(skeleton.legs)
        width = herd.legs.places.shape[1] if columns else 0
        owners, names, sources, leg_, column_, idle_, rest_, parent_ = zip(*rows, strict=True)
        return NodeTable(
            np.array(owners),
            tuple(names),
            np.array(sources),
            np.array(leg_),
            np.array(column_),
            np.array(idle_),
            np.array(rest_),
            np.array(parent_),
            materials,
            np.arange(width) < np.array(columns, dtype=np.int64)[:, None],
        )

    def poses(self, limbs: LimbPose, R_idle: Array, p_idle: Array) -> tuple[Array, Array]:
        """Return R_BN (J, 3, 3) and p_BN (J, 3) of all nodes relative to their bodies."""
        R = np.tile(np.eye(3), (len(self.owner), 1, 1))
        p = np.zeros((len(self.owner), 3))
        legs, idle = self.source == LEG_NODE, self.source == IDLE_NODE
        X = limbs.X_BJ[self.leg[legs], self.column[legs]]
        R[legs], p[legs] = X[:, :3, :3], X[:, :3, 3]
        R[idle], p[idle] = R_idle[self.idle[idle]], p_idle[self.idle[idle]]
        return R, p


def describe(
    herd: Herd, idlers: Idlers, table: NodeTable, materials: Sequence[str], rows: int
) -> Inventory:
    """Return nodes, channels, meshes and parts of a herd.

    Args:
        herd: the creatures.
        idlers: their joints that carry nothing.
        table: their nodes.
        materials: of each creature, for parts that name none.
        rows: of the take; parts live through all of them.
    """
    nodes = tuple(
        Node(name, herd.names[c], int(parent), (float(x), float(y), float(z)))
        for name, c, parent, (x, y, z) in zip(
            table.names, table.owner, table.parent, table.rest, strict=True
        )
    )
    leg_joints = [
        f"{herd.names[herd.owner[leg]]}.{_joint_name(herd, int(leg), int(k))}"
        for leg, k in np.argwhere(table.leg_channels)
    ]
    channels = (
        *(Channel(f"{name}.gait_phase", "1") for name in herd.names),
        *(Channel(f"{name}.speed", "m/s") for name in herd.names),
        *(Channel(name, "rad") for name in (*leg_joints, *idlers.names)),
    )
    meshes, parts = list[Mesh](), list[Part]()
    for c, figure in enumerate(herd.figures):
        base = int(np.argmax(table.owner == c))
        for piece in flesh(figure):
            count = len(piece.solid.vertices)
            meshes.append(
                Mesh(
                    piece.solid.vertices.astype(np.float32),
                    piece.solid.faces,
                    np.full((count, 2), base + piece.link, dtype=np.int32),
                    np.tile(np.array([1.0, 0.0], dtype=np.float32), (count, 1)),
                )
            )
            material = piece.material or materials[c]
            name = f"{herd.names[c]}.{piece.name}"
            parts.append(
                Part(name, herd.names[c], len(meshes) - 1, material, piece.size, (0, rows))
            )
    for leg, c in enumerate(herd.owner):
        table.foot_materials[leg] = table.foot_materials[leg] or materials[c]
    return Inventory(nodes, channels, tuple(meshes), tuple(parts))


def _joint_name(herd: Herd, leg: int, column: int) -> str:
    c = int(herd.owner[leg])
    skeleton = herd.figures[c].skeleton
    limb = skeleton.legs[leg - int(np.argmax(herd.owner == c))]
    return skeleton.joint_names[limb.joints[column]]


def leg_mass(herd: Herd) -> Array:
    """Return the masses of the legs (L,) [kg]."""
    return np.array(
        [
            DENSITY * sum(volume(figure.skeleton.links[i]) for i in limb.links)
            for figure in herd.figures
            for limb in figure.skeleton.legs
        ]
    )
