"""Pose output: the frames of the take that characters' meshes hang on, from nodes and records.

People and dolls have the frames of `people.body_frames`; a thing has one, which follows its nodes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY, IntArray
from pipeline.simulation.characters.body_plan import BodyPlan
from pipeline.simulation.characters.character_plans import proportions_of
from pipeline.simulation.characters.person_record import STANCE
from pipeline.simulation.characters.playthings import axes_of, axis_nodes, thing_solids
from pipeline.simulation.dynamics.compiled import Records, bound, entry
from pipeline.simulation.dynamics.vectors import cross, dot
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.people.body_frames import (
    FRAMES,
    Trunks,
    frames_from_joints,
    guided_arms,
    hands_on_trunks,
)
from pipeline.simulation.people.face_tracker import MAX_EYE_DOWN, MAX_EYE_SIDE, MAX_EYE_UP
from pipeline.simulation.people.guided_dance import GUIDED_FRAMES
from pipeline.simulation.people.person_inventory import person_record
from pipeline.simulation.people.proportions import JOINTS, Proportions
from pipeline.simulation.people.wardrobe import Clothes
from pipeline.simulation.spatial import Array, heading, normalized, turn
from pipeline.simulation.take import Mesh, Node, Part
from pipeline.simulation.terrain import Ground
from pipeline.spec.character import Character

FEET, HANDS, FOREARMS = (
    [FRAMES.index(f"{name}_l"), FRAMES.index(f"{name}_r")] for name in ("foot", "hand", "forearm")
)
ARMS = [FRAMES.index(name) for name in GUIDED_FRAMES]
CHEST = FRAMES.index("chest")
HEAD = JOINTS.index("head")
TRUNK = [JOINTS.index(name) for name in ("pelvis", "spine", "shoulders")]
WRISTS = [JOINTS.index(name) for name in ("hand_l", "hand_r")]

LEAST_BLEND = 1e-4
"""Blend of an arm to an embrace that is not seen."""

ROLLING_HEIGHT = 0.02, 1e-3
"""Height over the ground up to which a ball rolls: in radii, plus [m]."""


def gaze_directions(persons: Records) -> Array:
    """Return (..., 3) the directions in which people look."""
    yaw, pitch = persons["gaze"][..., 0], persons["gaze"][..., 1]
    level = np.cos(pitch)
    return np.stack([level * np.cos(yaw), np.sin(pitch), -level * np.sin(yaw)], axis=-1)


def eye_aims(persons: Records) -> Array:
    """Return (..., 2) the turns of the eyes to what is looked at: left and up [rad].

    The head faces along the gaze of the record.
    """
    x, y, z = np.moveaxis(persons["look_at"] - persons["targets"][..., HEAD, :], -1, 0)
    left = np.arctan2(-z, x) - persons["gaze"][..., 0]
    left = np.remainder(left + np.pi, 2.0 * np.pi) - np.pi
    up = np.arctan2(y, np.hypot(x, z)) - persons["gaze"][..., 1]
    # What is behind is not looked at with the eyes alone.
    looks = persons["has_look_target"] & (np.abs(left) < 0.5 * np.pi)
    aims = np.stack(
        [np.clip(left, -MAX_EYE_SIDE, MAX_EYE_SIDE), np.clip(up, -MAX_EYE_DOWN, MAX_EYE_UP)],
        axis=-1,
    )
    return np.where(looks[..., None], aims, 0.0)


def foot_rotations(persons: Records, ground: Ground) -> Array:
    """Return (..., 2, 3, 3) the rotations of feet, which lie on the ground or are pitched.

    A swinging foot goes from the slope at lift-off to the slope at its landing place.
    """
    liftoff, landing = persons["liftoff_place"], persons["landing_place"]
    way, gone = landing - liftoff, persons["ankles"] - liftoff
    squared = np.maximum(way[..., 0] ** 2 + way[..., 2] ** 2, 1e-12)
    share = (gone[..., 0] * way[..., 0] + gone[..., 2] * way[..., 2]) / squared
    share = np.where(persons["foot_state"] == STANCE, 0.0, np.clip(share, 0.0, 1.0))[..., None]
    below = (1.0 - share) * _normals_below(persons, ground, "stance")
    below = below + share * _normals_below(persons, ground, "landing")
    yaw, pitch = persons["yaw"], persons["pitch"][..., None]
    ahead = np.stack([np.cos(yaw), np.zeros_like(yaw), -np.sin(yaw)], axis=-1)
    up = normalized(below)
    ahead = normalized(ahead - (ahead * up).sum(axis=-1)[..., None] * up)
    x = np.cos(pitch) * ahead + np.sin(pitch) * up
    y = np.cos(pitch) * up - np.sin(pitch) * ahead
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def _normals_below(persons: Records, ground: Ground, moment: str) -> Array:
    """Return (..., 2, 3) the normals of ground or decks below feet at stance or at landing."""
    places = persons[f"{moment}_place"]
    normals: Array = ground.field.normal(places[..., 0], places[..., 2])
    on_deck = persons[f"{moment}_on_deck"] > 0
    if not on_deck.any():
        return normals
    up = persons["deck_axes"][..., None, :, 1]
    return np.where(on_deck[..., None], up, normals)


class BallRotations:
    """Rotations of balls: on the ground they roll, in the air they keep turning.

    Args:
        nodes: of all characters.
        balls: (B,) numbers of those that are balls.

    Attributes:
        R: (B, 3, 3) rotations.
    """

    def __init__(self, nodes: Records, balls: IntArray) -> None:
        self._nodes, self._balls = nodes, balls
        self.R: Array = np.broadcast_to(np.eye(3), (len(balls), 3, 3)).copy()
        self._turn, self._before = np.zeros((len(balls), 3)), nodes["p"][balls]

    def advance(self, floor: Array) -> None:
        """Turn balls by the step since the last call, over a floor at heights (B,) [m]."""
        self._roll(np.ascontiguousarray(floor))

    @cached_property
    def _roll(self) -> Callable[[Array], None]:
        balls = self.R, self._turn, self._nodes, self._balls, self._before
        return bound(_roll, *balls, examples=(np.zeros(1),))


@entry
def _roll(
    R: Array, turn: Array, nodes: Records, balls: IntArray, before: Array, floor: Array
) -> None:
    """Roll or turn balls by a step.

    Args:
        R: (B, 3, 3) rotations; changed.
        turn: (B, 3) rotation vectors of the last step; changed [rad].
        nodes: of all characters.
        balls: (B,) numbers of those that are balls.
        before: (B, 3) places before the step [m]; set to those after it.
        floor: (B,) heights of the ground [m].
    """
    relative, absolute = ROLLING_HEIGHT
    for b in range(len(R)):
        p, radius = nodes[balls[b]].p, nodes[balls[b]].radius
        x, z = p[0] - before[b, 0], p[2] - before[b, 2]
        for k in range(3):
            before[b, k] = p[k]
        if p[1] - floor[b] < radius * (1.0 + relative) + absolute:
            # Up × moved, over the radius.
            turn[b, 0], turn[b, 2] = z / radius, -x / radius
            turn[b, 1] = 0.0
        angle = math.sqrt(turn[b, 0] ** 2 + turn[b, 1] ** 2 + turn[b, 2] ** 2)
        if angle == 0.0:
            continue
        axis = (turn[b, 0] / angle, turn[b, 1] / angle, turn[b, 2] / angle)
        s, c = math.sin(angle), math.cos(angle)
        for k in range(3):
            # Each column turns by Rodrigues' formula.
            v = (R[b, 0, k], R[b, 1, k], R[b, 2, k])
            across, along = cross(axis, v), (1.0 - c) * dot(axis, v)
            for i in range(3):
                R[b, i, k] = c * v[i] + s * across[i] + along * axis[i]


@dataclass(frozen=True, eq=False)
class ThingFrame:
    """The frame of a thing.

    Attributes:
        frame: its number.
        nodes: first node of the thing, and the first after it.
        rest: (n, 3) nodes at rest [m].
        axes: pairs of nodes along Z and along Y; None for a ball.
    """

    frame: int
    nodes: tuple[int, int]
    rest: Array
    axes: tuple[tuple[int, int], tuple[int, int]] | None


@dataclass(frozen=True, eq=False)
class FramePoser:
    """Meshes and frames of the take, and the nodes that the frames follow.

    Attributes:
        inventory: for the take.
        people: (P,) first frames of people and dolls.
        acting: (A,) indices of acting people among these.
        joints: (P, 16) nodes of people and dolls.
        builds: of people and dolls.
        owners: (C,) index of each character among people and dolls, NOBODY of a thing.
        things: the other characters.
    """

    inventory: Inventory
    people: IntArray
    acting: IntArray
    joints: IntArray
    builds: tuple[Proportions, ...]
    owners: IntArray
    things: tuple[ThingFrame, ...]

    def pose(
        self, p: Array, ball_rotations: Array, persons: Records, embraced: IntArray, ground: Ground
    ) -> tuple[Array, Array]:
        """Return rotations (K, J, 3, 3) and places (K, J, 3) of all frames.

        Args:
            p: (K, N, 3) nodes [m].
            ball_rotations: (K, B, 3, 3) of balls.
            persons: (K, A) `PERSON` records of acting people.
            embraced: (K, A) characters around which their arms lie, or NOBODY.
            ground: the terrain.
        """
        count = len(self.inventory.nodes)
        R, places = np.empty((len(p), count, 3, 3)), np.empty((len(p), count, 3))
        gaze, feet = gaze_directions(persons), foot_rotations(persons, ground)
        if len(self.people):
            frames = self.people[:, None] + np.arange(len(FRAMES))
            limp = np.setdiff1d(np.arange(len(frames)), self.acting)
            for own, looks in ((limp, None), (self.acting, gaze)):
                if len(own):
                    posed = frames_from_joints(p[:, self.joints[own]], looks)
                    R[:, frames[own]], places[:, frames[own]] = posed
            acting = frames[self.acting]
            self._lay_hands(R, p, persons["embrace_blend"], embraced)
            R[:, acting[:, FEET]] = feet
            _guide_arms(R, acting, persons)
        ball = 0
        for thing in self.things:
            own_nodes = p[:, slice(*thing.nodes)]
            places[:, thing.frame] = own_nodes.mean(axis=1)
            if thing.axes is None:
                # The mesh of a ball lies about its node, not where it stands.
                R[:, thing.frame] = ball_rotations[:, ball]
                ball += 1
            else:
                R[:, thing.frame] = turned = axes_of(own_nodes, *thing.axes)
                rest = np.broadcast_to(thing.rest.mean(axis=0), own_nodes[:, 0].shape)
                places[:, thing.frame] -= turn(turned, rest)
        return R, places

    def _lay_hands(self, R: Array, p: Array, blend: Array, embraced: IntArray) -> None:
        """Lay the hands of people that embrace somebody on the back of that one.

        Args:
            R: (K, J, 3, 3) rotations; changed.
            p: (K, N, 3) nodes [m].
            blend: (K, A, 2) of the arms to an embrace, 0 to 1.
            embraced: (K, A) see `pose`.
        """
        others = np.where(embraced >= 0, self.owners[embraced], NOBODY)
        rows, who = np.nonzero((blend.max(axis=-1) > LEAST_BLEND) & (others >= 0))
        if not len(rows):
            return
        own, other = self.acting[who], others[rows, who]
        sizes = np.array([[build.height, build.hand] for build in self.builds])
        spines = p[rows[:, None], self.joints[other][:, TRUNK]]
        chests = R[rows, self.people[other] + CHEST]
        hands = rows[:, None], self.people[own][:, None] + np.array(HANDS)
        forearms = rows[:, None], self.people[own][:, None] + np.array(FOREARMS)
        R[forearms], R[hands] = hands_on_trunks(
            *(R[forearms], p[rows[:, None], self.joints[own][:, WRISTS]]),
            *(sizes[own].prod(axis=-1), Trunks(spines, chests, sizes[other, 0])),
            blend[rows, who],
        )


def _guide_arms(R: Array, acting: IntArray, persons: Records) -> None:
    """Turn the arms of people that dance as their dances do.

    Args:
        R: (K, J, 3, 3) rotations; changed.
        acting: (A, 15) frames of acting people.
        persons: (K, A) `PERSON` records.
    """
    for k in np.flatnonzero((persons["dance_blend"] > 0.0).any(axis=0)).tolist():
        rows = np.flatnonzero(persons["dance_blend"][:, k] > 0.0)
        guide = heading(persons["heading"][rows, k])[:, None] @ persons["dance_arms"][rows, k]
        places = np.ix_(rows, acting[k, ARMS])
        R[places] = guided_arms(R[places], guide, persons["dance_blend"][rows, k])


def frame_poser(
    cast: Sequence[Character], plans: Sequence[BodyPlan], clothes: Mapping[str, Clothes], rows: int
) -> FramePoser:
    """Return the meshes and frames of characters, people in their clothes by name."""
    nodes, meshes, parts = list[Node](), list[Mesh](), list[Part]()
    people, joints, things = list[int](), list[IntArray](), list[ThingFrame]()
    acting, builds, owners = list[int](), list[Proportions](), list[int]()
    first = 0
    for member, plan in zip(cast, plans, strict=True):
        frame = len(nodes)
        if (proportions := proportions_of(member)) is not None:
            acting += [len(people)] if member.acts else []
            owners.append(len(people))
            builds.append(proportions)
            people.append(frame)
            joints.append(first + np.arange(len(JOINTS)))
            worn = clothes[member.name]
            made = person_record(member.name, proportions, worn, frame, len(meshes), rows)
        else:
            owners.append(NOBODY)
            span = first, first + len(plan.rest)
            things.append(ThingFrame(frame, span, plan.rest, axis_nodes(member.character)))
            made = _thing(member, plan, frame, len(meshes), rows)
        nodes += made[0]
        meshes += made[1]
        parts += made[2]
        first += len(plan.rest)
    return FramePoser(
        Inventory(tuple(nodes), (), tuple(meshes), tuple(parts)),
        np.array(people, dtype=np.int64),
        np.array(acting, dtype=np.int64),
        np.array(joints, dtype=np.int64).reshape(-1, len(JOINTS)),
        tuple(builds),
        np.array(owners, dtype=np.int64),
        tuple(things),
    )


def _thing(
    member: Character, plan: BodyPlan, frame: int, mesh: int, rows: int
) -> tuple[list[Node], list[Mesh], list[Part]]:
    meshes, parts = list[Mesh](), list[Part]()
    for suffix, solid, material in thing_solids(member, plan):
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
