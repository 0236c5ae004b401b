"""Person controller."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY, CharacterArrays
from pipeline.simulation.characters.person_record import (
    HAND,
    HEAD,
    HUGGING,
    PELVIS,
    PLACED,
    SHOULDERS,
    STANDING,
    SWINGING,
)
from pipeline.simulation.characters.visibility_route import LIGHT, ObstacleCircles
from pipeline.simulation.dynamics.compiled import Record
from pipeline.simulation.people.proportions import JOINTS
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

SIDES: Mapping[str, tuple[int, ...]] = {"left": (0,), "right": (1,), "both": (0, 1)}
"""Arms by name."""

BOTH = 2
"""The grip of both hands on one another, behind those of each."""

EMBRACES = 2.0
"""How far off the other one is when arms are clear of one another again, in arms."""

SLIM = 0.17
"""Half of the room that a person takes, in heights."""

HEAVY = 0.5
"""From which part of one's own mass on something is held, and does not hang from the hand."""

NOTHING = np.zeros((0, 2)), np.zeros(0)
"""No circles."""


@dataclass(frozen=True, eq=False)
class CharacterView:
    """Where controllers are.

    Attributes:
        names: of all characters, in the order of the arrays's owners.
        arrays: the characters.
        ground: the terrain.
        people: numbers of those owners who have the joints of people.
        obstacle_circles: what of other rooms they go round.
    """

    names: Sequence[str]
    arrays: CharacterArrays
    ground: Ground
    people: frozenset[int]
    obstacle_circles: ObstacleCircles

    @cached_property
    def p(self) -> Array:
        """(N, 3) all nodes, as they are at any time [m]."""
        return self.arrays.p

    @cached_property
    def edges(self) -> tuple[Array, Array]:
        """Least and greatest x and z (2,) of the terrain, of a turned one within it [m]."""
        field = self.ground.field
        half = np.array(field.size) / (2.0 if field.heading == 0.0 else 2.0 * math.sqrt(2.0))
        return np.array(field.at) - half, np.array(field.at) + half

    @cached_property
    def _spans(self) -> list[list[int]]:
        """First node of each character, and how many it has."""
        spans: list[list[int]] = self.arrays.owners["nodes"].tolist()
        return spans

    def number(self, name: str) -> int:
        """Return the number of a character."""
        return self.names.index(name)

    def nodes(self, owner: int) -> Array:
        """Return (n, 3) the nodes of a character [m]."""
        first, count = self._spans[owner]
        nodes: Array = self.p[first : first + count]
        return nodes

    def middle(self, owner: int) -> Array:
        """Return (3,) about where a character is: its chest, if it has one [m]."""
        nodes = self.nodes(owner)
        middle: Array = nodes[SHOULDERS] if owner in self.people else nodes.mean(axis=0)
        return middle

    def face(self, owner: int) -> Array:
        """Return (3,) what one looks at in a character [m]."""
        nodes = self.nodes(owner)
        face: Array = nodes[HEAD] if owner in self.people else nodes.mean(axis=0)
        return face

    @cached_property
    def things(self) -> tuple[int, ...]:
        """IntArray of what stands on the ground and is too heavy to be kicked away."""
        owners = self.arrays.owners
        count = range(len(owners))
        stand = (k for k in count if k not in self.people and owners["nodes"][k, 1] > 1)
        return tuple(k for k in stand if owners["mass"][k] > LIGHT)

    def circle(self, owner: int) -> tuple[Array, float]:
        """Return the middle (2,) and the radius of a circle around a character [m]."""
        flat = self.nodes(owner)[:, [0, 2]]
        middle = flat.mean(axis=0)
        girth = float(self.arrays.nodes["radius"][self._spans[owner][0]])
        off = flat - middle
        return middle, float(np.sqrt((off * off).sum(axis=1)).max()) + girth

    def pelvis(self, owner: int) -> Array:
        """Return (3,) the middle of a character that others come up to [m]."""
        nodes = self.nodes(owner)
        pelvis: Array = nodes[PELVIS] if owner in self.people else nodes.mean(axis=0)
        return pelvis

    def size(self, owner: int) -> float:
        """Return about how high a character stands [m]."""
        return float(np.ptp(self.nodes(owner)[:, 1])) * 1.12

    def height(self, x: float, z: float) -> float:
        """Return the height of the ground [m]."""
        return float(self.ground.height(np.asarray(x), np.asarray(z)))


@dataclass(frozen=True, eq=False)
class PersonController:
    """One person.

    Attributes:
        name: of it.
        me: its record.
        view: where it is.
    """

    name: str
    record: Record
    view: CharacterView

    @property
    def arm(self) -> float:
        """Length of an arm [m]."""
        return float(self.record.upper_arm + self.record.forearm)

    @property
    def stands(self) -> bool:
        """Whether it neither steps nor sits."""
        return not self.record.stepping and float(self.record.sit_blend) == 0.0

    def hand(self, k: int) -> Array:
        """Return (3,) where a hand is [m]."""
        place: Array = self.view.p[self.record.node + HAND + k]
        return place

    def away(self, place: Array) -> float:
        """Return how far over the ground a place is [m]."""
        return math.hypot(place[0] - self.record.at[0], place[2] - self.record.at[1])

    def in_the_way(self) -> tuple[Array, Array]:
        """Return circles that it goes round: middles (n, 2) and radii (n,) [m].

        They are what stands there of other rooms, and things too heavy to be kicked away.
        """
        barriers = self.view.obstacle_circles
        found = (barriers.middles, barriers.radii) if barriers.look() else NOTHING
        owners = self.view.arrays.nodes["owner"]
        held = {int(owners[node]) for k in range(2) if (node := self.held(k)) >= 0}
        things = [one for one in self.view.things if one not in held]
        if not things:
            return found
        around = [self.view.circle(one) for one in things]
        middles = np.concatenate([found[0], [middle for middle, _ in around]])
        return middles, np.concatenate([found[1], [radius for _, radius in around]])

    def go(self, x: float, z: float, near: float = 0.0, whom: int = NOBODY) -> None:
        """Walk somewhere, up to so near."""
        me = self.record
        me.posture, me.has_goal, me.has_facing = STANDING, True, False
        me.goal[0], me.goal[1] = x, z
        me.stop_distance, me.partner = near, whom

    def stop(self) -> None:
        """Stop and stand there."""
        self.record.has_goal = False

    def turn_to(self, heading: float) -> None:
        """Turn on the spot."""
        self.record.has_goal, self.record.has_facing, self.record.facing = False, True, heading

    def face_to(self, place: Array) -> None:
        """Turn to a place."""
        x, z = place[0] - self.record.at[0], place[2] - self.record.at[1]
        self.turn_to(math.atan2(-z, x))

    def faces(self, tolerance: float) -> bool:
        """Tell whether it has turned to where it was to."""
        off = math.remainder(float(self.record.facing - self.record.heading), 2.0 * math.pi)
        return abs(off) < tolerance

    def look(self, place: Array) -> None:
        """Look at a place."""
        self.record.has_look_target = True
        self.record.look_at[:] = place

    def put_hand(self, k: int, place: Array) -> None:
        """Send a hand to a place."""
        self.record.arm_mode[k] = PLACED
        self.record.arm_target[k] = place

    def put_round(self, k: int, place: Array) -> None:
        """Send a hand to a place behind somebody."""
        self.record.arm_mode[k] = HUGGING
        self.record.arm_target[k] = place

    def hold(self, k: int, node: int) -> None:
        """Close a hand around a node; the left one for both."""
        hand, nodes = int(self.record.node) + HAND + k % BOTH, self.view.arrays.nodes
        self.view.arrays.grips[self.record.grip + k] = hand, node
        nodes["grip_partner"][hand], nodes["grip_partner"][node] = (
            nodes["owner"][node],
            self.record.owner,
        )
        nodes["grip_gap"][hand] = math.dist(nodes["p"][hand], nodes["p"][node])

    @cached_property
    def _grip(self) -> int:
        return int(self.record.grip)

    def held(self, k: int) -> int:
        """Return the node that a hand holds, -1 for none."""
        return int(self.view.arrays.grips[self._grip + k, 1])

    def let_go(self, k: int) -> None:
        """Open a hand, and let the arm hang."""
        self._open(k)
        self.record.arm_mode[k] = SWINGING

    def embrace(self, owner: int) -> None:
        """Put the arms around a character: they pass through its arms until both are apart."""
        self.view.arrays.owners["embraces"][self.record.owner] = owner

    def forget_embrace(self) -> None:
        """Have nobody in the arms any more who is out of their reach."""
        whom = int(self.view.arrays.owners["embraces"][self.record.owner])
        if whom >= 0 and self.away(self.view.pelvis(whom)) > EMBRACES * self.arm:
            self.embrace(NOBODY)

    def join_hands(self) -> None:
        """Hold one hand with the other, unless one holds something else."""
        if self.held(0) < 0 and self.held(1) < 0:
            self.hold(BOTH, int(self.record.node) + HAND + 1)

    def part_hands(self) -> None:
        """Let the hands go of one another."""
        self._open(BOTH)

    def _open(self, k: int) -> None:
        grip = self.view.arrays.grips[self.record.grip + k]
        if grip[0] >= 0:
            self.view.arrays.nodes["grip_partner"][grip] = NOBODY
        grip[:] = NOBODY

    def nearest(self, owner: int, place: Array) -> int:
        """Return the node of a character that is nearest to a place."""
        apart = self.view.nodes(owner) - place
        return int(self.view.arrays.owners[owner].nodes[0] + np.argmin((apart * apart).sum(axis=1)))

    def part(self, owner: int, part: str | None, k: int) -> int:
        """Return the node of a character that a hand takes: by name, or the nearest one."""
        if part is None:
            return self.nearest(owner, self.hand(k))
        return int(self.view.arrays.owners[owner].nodes[0]) + JOINTS.index(part)


def is_heavy(controller: PersonController, owner: int) -> bool:
    """Tell whether a character is too heavy to hang from a hand."""
    owners = controller.view.arrays.owners
    return bool(owners[owner].mass > HEAVY * owners[controller.record.owner].mass)
