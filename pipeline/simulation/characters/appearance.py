"""Appearance: what is seen of characters, and the frames that it hangs on.

People and dolls have the frames of their flesh; things one each, which follows their nodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.characters.layout import Numbers, Plan
from pipeline.simulation.characters.looks import looks_of
from pipeline.simulation.characters.making import proportions_of
from pipeline.simulation.characters.things import axes_of, directions_of
from pipeline.simulation.people.clothes import clothes_of
from pipeline.simulation.people.flesh import dressed, worn
from pipeline.simulation.people.frames import FRAMES, PARENTS, closed, frame_origins, frames_of
from pipeline.simulation.people.proportions import JOINTS
from pipeline.simulation.spatial import Array, turn
from pipeline.simulation.take import Mesh, Node, Part
from pipeline.simulation.troupe import Inventory
from pipeline.spec.cast import Character

FEET, HANDS, FOREARMS = (
    [FRAMES.index(f"{name}_l"), FRAMES.index(f"{name}_r")] for name in ("foot", "hand", "forearm")
)
CHEST = FRAMES.index("chest")


@dataclass(frozen=True, eq=False)
class Thing:
    """How a thing follows its nodes.

    Attributes:
        frame: number of its frame.
        nodes: its first node, and the first after it.
        rest: (n, 3) its nodes at rest [m].
        directions: nodes that lie towards Z and towards Y from others; None for a ball.
    """

    frame: int
    nodes: tuple[int, int]
    rest: Array
    directions: tuple[tuple[int, int], tuple[int, int]] | None


@dataclass(frozen=True, eq=False)
class Appearance:
    """What is seen, and what it hangs on.

    Attributes:
        inventory: for the take.
        people: (P,) first frames of people and dolls.
        acting: (A,) which of these hold themselves.
        joints: (P, 16) their nodes.
        things: the others.
    """

    inventory: Inventory
    people: Numbers
    acting: Numbers
    joints: Numbers
    things: tuple[Thing, ...]

    def pose(
        self, p: Array, spins: Array, gaze: Array, feet: Array, clasp: Array
    ) -> tuple[Array, Array]:
        """Return rotations (K, J, 3, 3) and places (K, J, 3) of all frames.

        Args:
            p: (K, N, 3) nodes [m].
            spins: (K, T, 3, 3) rotations of things; those of balls count.
            gaze: (K, A, 3) where those look who hold themselves, a direction.
            feet: (K, A, 2, 3, 3) rotations of their feet, which nodes do not say.
            clasp: (K, A, 2) how far their hands close around somebody, 0 to 1.
        """
        count = len(self.inventory.nodes)
        R = np.empty((len(p), count, 3, 3))
        places = np.empty((len(p), count, 3))
        if len(self.people):
            which = self.people[:, None] + np.arange(len(FRAMES))
            limp = np.setdiff1d(np.arange(len(which)), self.acting)
            for some, looks in ((limp, None), (self.acting, gaze)):
                if len(some):
                    posed = frames_of(p[:, self.joints[some]], looks)
                    R[:, which[some]], places[:, which[some]] = posed
            acting = which[self.acting]
            forearms, chests = R[:, acting[:, FOREARMS]], R[:, acting[:, CHEST]]
            R[:, acting[:, HANDS]] = closed(forearms, chests, clasp)
            R[:, acting[:, FEET]] = feet
        for k, thing in enumerate(self.things):
            own = p[:, slice(*thing.nodes)]
            turned = spins[:, k]
            if thing.directions is not None:
                turned = axes_of(own, *thing.directions)
            R[:, thing.frame] = turned
            middle = turn(turned, np.broadcast_to(thing.rest.mean(axis=0), own[:, 0].shape))
            # What a ball is seen as lies about its node, not where it stands.
            places[:, thing.frame] = own.mean(axis=1)
            if thing.directions is not None:
                places[:, thing.frame] -= middle
        return R, places


def appearance(
    cast: Sequence[Character], plans: Sequence[Plan], seed: int, rows: int
) -> Appearance:
    """Return what is seen of characters."""
    nodes, meshes, parts = list[Node](), list[Mesh](), list[Part]()
    people, joints, things = list[int](), list[Numbers](), list[Thing]()
    acting = list[int]()
    first = 0
    for member, plan in zip(cast, plans, strict=True):
        frame = len(nodes)
        if proportions_of(member) is not None:
            acting += [len(people)] if member.acts else []
            people.append(frame)
            joints.append(first + np.arange(len(JOINTS)))
            seen = _person(member, frame, len(meshes), seed, rows)
        else:
            span = first, first + len(plan.rest)
            things.append(Thing(frame, span, plan.rest, directions_of(member.character)))
            seen = _thing(member, plan, frame, len(meshes), rows)
        nodes += seen[0]
        meshes += seen[1]
        parts += seen[2]
        first += len(plan.rest)
    return Appearance(
        Inventory(tuple(nodes), (), tuple(meshes), tuple(parts)),
        np.array(people, dtype=np.int64),
        np.array(acting, dtype=np.int64),
        np.array(joints, dtype=np.int64).reshape(-1, len(JOINTS)),
        tuple(things),
    )


def _person(
    member: Character, frame: int, mesh: int, seed: int, rows: int
) -> tuple[list[Node], list[Mesh], list[Part]]:
    proportions = proportions_of(member)
    assert proportions is not None
    origins = frame_origins(proportions)
    nodes = [
        Node(
            f"{member.name}.{name}",
            member.name,
            frame + parent if parent >= 0 else -1,
            (float(x), float(y), float(z)),
        )
        for name, parent, (x, y, z) in zip(FRAMES, PARENTS, origins, strict=True)
    ]
    clothes = clothes_of(member.name, seed, child=member.character != "adult")
    if member.material is not None:
        clothes = replace(clothes, shirt=member.material)
    meshes, parts = worn(member.name, dressed(proportions, clothes), frame, mesh, rows)
    return nodes, meshes, parts


def _thing(
    member: Character, plan: Plan, frame: int, mesh: int, rows: int
) -> tuple[list[Node], list[Mesh], list[Part]]:
    meshes, parts = list[Mesh](), list[Part]()
    for suffix, solid, material in looks_of(member, plan):
        count = len(solid.vertices)
        size = float(np.ptp(solid.vertices, axis=0).max())
        name = member.name + suffix
        parts.append(Part(name, member.name, mesh + len(meshes), material, size, (0, rows)))
        meshes.append(
            Mesh(
                solid.vertices.astype(np.float32),
                solid.faces.astype(np.uint32),
                np.full((count, 2), frame, dtype=np.int32),
                np.tile(np.array([1.0, 0.0], dtype=np.float32), (count, 1)),
            )
        )
    return [Node(member.name, member.name, -1, (0.0, 0.0, 0.0))], meshes, parts
