"""Inventory: the nodes, channels, meshes, parts, mechanisms and legs that a herd adds to a take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.figure_skin import figure_skin
from pipeline.simulation.figures.inverse_dynamics import FrameMasses
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.locomotion.body_motion.idle_motion import FreeJoints
from pipeline.simulation.locomotion.gaits.pace_schedule import PaceSchedule
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.mechanism import Leg, Mechanism
from pipeline.simulation.people.dressed_figure import figure_layers, is_person
from pipeline.simulation.people.person_mesh import layer_parts
from pipeline.simulation.people.wardrobe import Clothes
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import OWN, UNSEEN, Channel, Face, Mesh, Node, Part


@dataclass(frozen=True, eq=False)
class NodeTable:
    """The nodes of a herd, creature by creature and link by link, and the frames that move them.

    Attributes:
        names: of the nodes.
        owner: (J,) creature.
        frame: (J,) number of the node's frame: the body's, then those of all joints of legs with
            padding, then those of all free joints.
        rest: (J, 3) position in the creation frame [m].
        parent: (J,) node that it hangs on, -1 for bodies.
    """

    names: tuple[str, ...]
    owner: NDArray[np.int64]
    frame: NDArray[np.int64]
    rest: Array
    parent: NDArray[np.int64]

    @staticmethod
    def of(herd: Herd, free_joints: FreeJoints) -> NodeTable:
        """Number the nodes of a herd."""
        frame_of = _frame_numbers(herd, free_joints)
        names, owner, frame = list[str](), list[int](), list[int]()
        rest, parent = list[Array](), list[int]()
        for c, figure in enumerate(herd.figures):
            first = len(names)
            for link, above in zip(figure.skeleton.links, parent_links(figure), strict=True):
                names.append(f"{herd.names[c]}.{link.name}")
                owner.append(c)
                frame.append(frame_of[c, link.joint])
                rest.append(np.zeros(3) if link.joint == BODY else link.ends[0])
                parent.append(-1 if above is None else first + above)
        return NodeTable(
            tuple(names), np.array(owner), np.array(frame), np.array(rest), np.array(parent)
        )

    def poses(self, X_legs: Array, X_free: Array) -> Array:
        """Return X_BN (n, J, 4, 4), the poses of all nodes relative to their bodies.

        Args:
            X_legs: (n, m, 4, 4) frames of all joints of legs.
            X_free: (n, M, 4, 4) frames of all free joints.
        """
        poses = np.empty((len(X_free), len(self.frame), 4, 4))
        first = 0
        for frames in (np.broadcast_to(np.eye(4), (len(X_free), 1, 4, 4)), X_legs, X_free):
            after = first + frames.shape[1]
            here = np.flatnonzero((self.frame >= first) & (self.frame < after))
            poses[:, here] = frames[:, self.frame[here] - first]
            first = after
        return poses


def _frame_numbers(herd: Herd, free_joints: FreeJoints) -> dict[tuple[int, int], int]:
    """Return the frame numbers of `NodeTable` by creature and joint."""
    numbers = {(c, BODY): 0 for c in range(len(herd.names))}
    width, leg = herd.legs.is_joint.shape[1], 0
    for c, figure in enumerate(herd.figures):
        for limb in figure.skeleton.legs:
            for column, joint in enumerate(limb.joints):
                numbers[c, joint] = 1 + leg * width + column
            leg += 1
    first = 1 + leg * width
    for i, (c, joint) in enumerate(zip(free_joints.owner, free_joints.number, strict=True)):
        numbers[int(c), int(joint)] = first + i
    return numbers


def parent_links(figure: Figure) -> list[int | None]:
    """Return the parent of each link, None for the body."""
    skeleton = figure.skeleton
    link_of = {link.joint: i for i, link in enumerate(skeleton.links)}
    above = list[int | None]()
    for link in skeleton.links:
        joint = link.joint
        # Joints of a ball joint move no link of their own: go up to one that does.
        while joint != BODY and (joint == link.joint or joint not in link_of):
            joint = int(skeleton.parents[joint])
        above.append(None if link.joint == BODY else link_of[joint])
    return above


def describe_herd(
    herd: Herd,
    free_joints: FreeJoints,
    table: NodeTable,
    materials: Sequence[str],
    clothes: Mapping[str, Clothes],
    rows: int,
) -> Inventory:
    """Return nodes, channels, meshes and parts of a herd.

    Args:
        herd: the creatures.
        free_joints: of the herd.
        table: their nodes.
        materials: default of each creature.
        clothes: of those with the skin of a person, by name.
        rows: of the take; parts are alive in all of them.
    """
    nodes = tuple(
        Node(name, herd.names[c], int(parent), (float(x), float(y), float(z)))
        for name, c, parent, (x, y, z) in zip(
            table.names, table.owner, table.parent, table.rest, strict=True
        )
    )
    leg_joints = [
        f"{name}.{figure.skeleton.joint_names[joint]}"
        for name, figure in zip(herd.names, herd.figures, strict=True)
        for limb in figure.skeleton.legs
        for joint in limb.joints
    ]
    channels = (
        *(Channel(f"{name}.gait_phase", "1") for name in herd.names),
        *(Channel(f"{name}.speed", "m/s") for name in herd.names),
        *(Channel(name, "rad") for name in (*leg_joints, *free_joints.names)),
    )
    meshes, parts, looks = list[Mesh](), list[Part](), list[Mesh]()
    faces = list[Face]()
    for c, figure in enumerate(herd.figures):
        first = int(np.argmax(table.owner == c))
        own = creature_solids(herd.names[c], figure, first, len(meshes), materials[c], rows)
        meshes.extend(own[0])
        parts.extend(assign_looks(own[1], figure, len(looks)))
        looks.extend(creature_skins(figure, first))
        if is_person(figure):
            layers = figure_layers(figure, clothes[herd.names[c]])
            worn = layer_parts(herd.names[c], layers, first, len(meshes), rows)
            meshes.extend(worn[0])
            parts.extend(worn[1])
            faces.append(Face(herd.names[c]))
    return Inventory(
        *(nodes, channels, tuple(meshes), tuple(parts)), looks=tuple(looks), faces=tuple(faces)
    )


def creature_solids(
    name: str, figure: Figure, first: int, mesh: int, material: str, rows: int
) -> tuple[list[Mesh], list[Part]]:
    """Return the meshes and parts of one creature; each link follows its own node.

    Args:
        name: of the creature.
        figure: of the creature.
        first: number of its first node.
        mesh: number of its first mesh.
        material: default of the links.
        rows: of the take; parts are alive in all of them.
    """
    meshes, parts = list[Mesh](), list[Part]()
    for piece in figure.pieces:
        count = len(piece.solid.vertices)
        meshes.append(
            Mesh(
                piece.vertices,
                piece.solid.faces,
                np.full((count, 2), first + piece.link, dtype=np.int32),
                _rigid_weights(count),
            )
        )
        number, life = mesh + len(meshes) - 1, (0, rows)
        material_name = piece.material or material
        part = Part(f"{name}.{piece.name}", name, number, material_name, piece.size, life)
        parts.append(part)
    return meshes, parts


@lru_cache
def _rigid_weights(count: int) -> NDArray[np.float32]:
    """Return the weights (count, 2) of vertices that follow one node, shared by all meshes."""
    weights = np.tile(np.array([1.0, 0.0], dtype=np.float32), (count, 1))
    weights.flags.writeable = False
    return weights


def assign_looks(parts: Sequence[Part], figure: Figure, look: int) -> list[Part]:
    """Return the parts of a creature with the numbers of their render meshes, `look` the first."""
    skin = figure_skin(figure)
    numbers = {piece: look + k for k, piece in enumerate(skin.skins)}
    numbers |= dict.fromkeys(skin.covered, UNSEEN)
    return [replace(part, look=numbers.get(i, OWN)) for i, part in enumerate(parts)]


def creature_skins(figure: Figure, first: int) -> list[Mesh]:
    """Return the render meshes that replace the meshes of a creature's parts.

    Args:
        figure: of the creature.
        first: number of its first node.
    """
    return [replace(mesh, nodes=mesh.nodes + np.int32(first)) for mesh in _skin_meshes(figure)]


_SKIN_MESHES: WeakKeyDictionary[Figure, tuple[Mesh, ...]] = WeakKeyDictionary()


def _skin_meshes(figure: Figure) -> tuple[Mesh, ...]:
    """Return the render meshes of a figure whose first node has the number 0."""
    if figure not in _SKIN_MESHES:
        _SKIN_MESHES[figure] = tuple(
            Mesh(
                skin.vertices.astype(np.float32),
                skin.faces,
                skin.links.astype(np.int32),
                np.stack([1.0 - skin.share, skin.share], axis=-1).astype(np.float32),
                paint=_rows(skin.paint, 4),
                hair=_rows(skin.hair, 3),
            )
            for skin in figure_skin(figure).skins.values()
        )
    return _SKIN_MESHES[figure]


def _rows(values: Array | None, width: int) -> NDArray[np.float32]:
    """Return values (V, width) in single precision, (0, width) for none."""
    return np.zeros((0, width), np.float32) if values is None else values.astype(np.float32)


# --- mechanisms and legs --------------------------------------------------------------


def foot_materials(herd: Herd, materials: Sequence[str]) -> list[str]:
    """Return the material of the last link of each leg.

    Args:
        herd: the creatures.
        materials: default of each creature.
    """
    return [
        figure.skeleton.links[limb.links[-1]].material or material
        for figure, material in zip(herd.figures, materials, strict=True)
        for limb in figure.skeleton.legs
    ]


def leg_masses(herd: Herd) -> Array:
    """Return the masses of the legs (L,) [kg]."""
    masses = {
        figure: [FigureMass(figure).mass_of(limb.links) for limb in figure.skeleton.legs]
        for figure in dict.fromkeys(herd.figures)
    }
    return np.array([mass for figure in herd.figures for mass in masses[figure]])


def mechanisms_of(herd: Herd) -> list[Mechanism]:
    """Return the mechanism of each figure of a herd that has legs."""
    members: dict[int, list[str]] = {}
    figures = {id(figure): figure for figure in herd.figures if figure.skeleton.legs}
    for name, figure in zip(herd.names, herd.figures, strict=True):
        members.setdefault(id(figure), []).append(name)
    found = []
    for key, figure in figures.items():
        skeleton = figure.skeleton
        masses = FrameMasses.of(skeleton, FigureMass(figure).links)
        found.append(
            Mechanism(
                tuple(members[key]),
                tuple(skeleton.joint_names),
                _frozen(skeleton.parents),
                _frozen(skeleton.axes),
                _frozen(skeleton.places),
                _frozen(skeleton.prismatic),
                _frozen(masses.mass),
                _frozen(masses.centre),
                _frozen(masses.inertia),
            )
        )
    return found


def legs_of(herd: Herd, paces: PaceSchedule, phase: Array) -> list[Leg]:
    """Return the legs of a herd, with the stances planned from phase 0 up to `phase` (C,)."""
    limbs = [limb for figure in herd.figures for limb in figure.skeleton.legs]
    found = []
    for k, (limb, c) in enumerate(zip(limbs, herd.owner.tolist(), strict=True)):
        start, end = herd.figures[c].skeleton.links[limb.links[-1]].ends
        stances = paces.stances(k, 0.0, float(phase[c])) if herd.walks[c] else np.zeros((0, 2))
        found.append(
            Leg(
                herd.names[c],
                limb.name,
                limb.side,
                limb.links[-1],
                limb.joints[-1],
                _frozen(end - start),
                float(herd.legs.lengths[k]),
                float(herd.foot_radius[k]),
                _frozen(stances),
            )
        )
    return found


def _frozen(values: Any) -> Any:
    """Return an array as nested tuples."""
    plain = np.asarray(values).tolist()

    def tuples(value: Any) -> Any:
        return tuple(map(tuples, value)) if isinstance(value, list) else value

    return tuples(plain)
