"""Pose output."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.characters.body_plan import BodyPlan
from pipeline.simulation.characters.character_plans import proportions_of
from pipeline.simulation.characters.person_record import STANCE
from pipeline.simulation.characters.playthings import axes_of, directions_of, looks_of
from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.people.body_frames import FRAMES, PARENTS, closed, frame_origins, frames_of
from pipeline.simulation.people.person_mesh import clothes_of, dressed, worn
from pipeline.simulation.people.proportions import JOINTS
from pipeline.simulation.spatial import Array, normalized, rotation, turn
from pipeline.simulation.take import Mesh, Node, Part
from pipeline.simulation.terrain import Ground
from pipeline.spec.character import Character


def gaze_of(persons: Records) -> Array:
    """Return (..., 3) the directions in which people look."""
    yaw, pitch = persons["gaze"][..., 0], persons["gaze"][..., 1]
    level = np.cos(pitch)
    return np.stack([level * np.cos(yaw), np.sin(pitch), -level * np.sin(yaw)], axis=-1)


def feet_of(persons: Records, ground: Ground) -> Array:
    """Return (..., 2, 3, 3) the rotations of feet: they lie on the ground, or are pitched.

    A foot that swings goes from the slope that it left to the one that it will stand on.
    """
    stood, left, land = persons["stance_place"], persons["liftoff_place"], persons["landing_place"]
    way, gone = land - left, persons["ankles"] - left
    far = np.maximum(way[..., 0] ** 2 + way[..., 2] ** 2, 1e-12)
    share = (gone[..., 0] * way[..., 0] + gone[..., 2] * way[..., 2]) / far
    share = np.where(persons["foot_state"] == STANCE, 0.0, np.clip(share, 0.0, 1.0))[..., None]
    below = (1.0 - share) * _normals(stood, ground) + share * _normals(land, ground)
    yaw, pitch = persons["yaw"], persons["pitch"][..., None]
    ahead = np.stack([np.cos(yaw), np.zeros_like(yaw), -np.sin(yaw)], axis=-1)
    up = normalized(below)
    ahead = normalized(ahead - (ahead * up).sum(axis=-1)[..., None] * up)
    x = np.cos(pitch) * ahead + np.sin(pitch) * up
    y = np.cos(pitch) * up - np.sin(pitch) * ahead
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def _normals(places: Array, ground: Ground) -> Array:
    """Return the normals (..., 2, 3) of the ground at places (..., 2, 3)."""
    result: Array = ground.field.normal(places[..., 0], places[..., 2])
    return result


DEEP = 0.02
"""Height over the ground up to which a ball rolls on it, in radii."""


class BallRotations:
    """Rotations of balls: on the ground they roll, in the air they go on as they turned.

    Attributes:
        R: (T, 3, 3) their rotations.
    """

    def __init__(self, radius: Array) -> None:
        self.radius = radius
        self.R: Array = np.broadcast_to(np.eye(3), (len(radius), 3, 3)).copy()
        self._turn = np.zeros((len(radius), 3))

    def go(self, moved: Array, on_ground: NDArray[np.bool_]) -> None:
        """Go on by a step in which balls moved (T, 3) [m], those on the ground rolling."""
        # Up × moved, over the radius.
        rolled = np.zeros_like(moved)
        rolled[:, 0], rolled[:, 2] = moved[:, 2] / self.radius, -moved[:, 0] / self.radius
        self._turn = np.where(on_ground[:, None], rolled, self._turn)
        if not self._turn.any():
            return
        angle = np.sqrt((self._turn * self._turn).sum(axis=-1))
        axis = self._turn / np.where(angle > 0.0, angle, 1.0)[:, None]
        self.R = rotation(axis, angle) @ self.R


FEET, HANDS, FOREARMS = (
    [FRAMES.index(f"{name}_l"), FRAMES.index(f"{name}_r")] for name in ("foot", "hand", "forearm")
)

CHEST = FRAMES.index("chest")


@dataclass(frozen=True, eq=False)
class ThingFrame:
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
class FramePoser:
    """What is seen, and what it hangs on.

    Attributes:
        inventory: for the take.
        people: (P,) first frames of people and dolls.
        acting: (A,) which of these hold themselves.
        joints: (P, 16) their nodes.
        things: the others.
    """

    inventory: Inventory
    people: IntArray
    acting: IntArray
    joints: IntArray
    things: tuple[ThingFrame, ...]

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


def frame_poser(
    cast: Sequence[Character], plans: Sequence[BodyPlan], seed: int, rows: int
) -> FramePoser:
    """Return what is seen of characters."""
    nodes, meshes, parts = list[Node](), list[Mesh](), list[Part]()
    people, joints, things = list[int](), list[IntArray](), list[ThingFrame]()
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
            things.append(ThingFrame(frame, span, plan.rest, directions_of(member.character)))
            seen = _thing(member, plan, frame, len(meshes), rows)
        nodes += seen[0]
        meshes += seen[1]
        parts += seen[2]
        first += len(plan.rest)
    return FramePoser(
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
    member: Character, plan: BodyPlan, frame: int, mesh: int, rows: int
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
