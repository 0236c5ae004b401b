"""Person controller: the state and the commands of one acting person."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY, SOLID, IntArray
from pipeline.simulation.characters.character_view import CharacterView
from pipeline.simulation.characters.deck_choice import deck_height
from pipeline.simulation.characters.hurdles import DEEPEST_STEP_OVER, HIGHEST_STEP_OVER
from pipeline.simulation.characters.person_record import (
    HAND,
    HUGGING,
    PLACED,
    SHOULDER,
    STANDING,
    SWINGING,
)
from pipeline.simulation.characters.visibility_route import MAX_CIRCLES
from pipeline.simulation.dynamics.compiled import Record
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.order_outcome import GripChange
from pipeline.simulation.people.proportions import JOINTS
from pipeline.simulation.spatial import Array

HANDS: Mapping[str, tuple[int, ...]] = {"left": (0,), "right": (1,), "both": (0, 1)}
"""Numbers of hands by name."""

NOTHING_GRIPPED = [NOBODY] * 2

EMBRACE_RANGE = 2.0  # distance at which an embrace has ended, in arm lengths
BODY_RADIUS = 0.17  # of a person on the ground, in heights
CARRIED_MASS = 0.5  # up to which a gripped thing hangs from the hand, in the person's mass

HOLD_HEIGHT = 0.6  # of a thing between two hands, in heights
UPRIGHT_BOW, UPRIGHT_CROUCH = 0.25, 0.06  # of the trunk as a tangent, of the legs
HAND_LEAD = 0.12  # by which hands that hold a thing are led at most [m]
PARTING_TIME = 0.6  # in which a hand comes away from a bar that it has held [s]
RUN_FROUDE = 1.1  # speed of the fastest run, in √(g l)

NO_CIRCLES = np.zeros((0, 2)), np.zeros(0)


@dataclass(frozen=True, eq=False)
class PersonController:
    """The state and the commands of one acting person.

    Attributes:
        name: of the person.
        record: `PERSON`; changed by commands.
        view: all characters.
        held_members: members of other rooms in its hands, by the number of the hand.
        grip_changes: of this step.
        touched: names of those that its hands or arms closed around in this step; both stop short
            of their surfaces.
        kicked_bodies: bodies of another room that it kicks in this step, and their velocities
            (3,) from then on [m/s].
        avoided: distance at which it keeps off targets, by name [m].
        parting: time for which hands that have let go of bars pass through them [s].
    """

    name: str
    record: Record
    view: CharacterView
    held_members: dict[int, str] = field(default_factory=dict)
    grip_changes: list[GripChange] = field(default_factory=list)
    touched: list[str] = field(default_factory=list)
    kicked_bodies: list[tuple[str, Array]] = field(default_factory=list)
    avoided: dict[str, float] = field(default_factory=dict)
    parting: dict[int, float] = field(default_factory=dict)

    @cached_property
    def arm(self) -> float:
        """Length of an arm [m]."""
        return float(self.record.upper_arm + self.record.forearm)

    @property
    def is_standing(self) -> bool:
        """Whether the person neither steps nor sits."""
        return not self.record.stepping and float(self.record.sit_blend) == 0.0

    @property
    def is_upright(self) -> bool:
        """Whether the person has risen from what its hands reached down for."""
        return float(self.record.bow) < UPRIGHT_BOW and float(self.record.crouch) < UPRIGHT_CROUCH

    def hand(self, k: int) -> Array:
        """Return (3,) the place of a hand [m]."""
        return self._hands[k]

    @cached_property
    def _hands(self) -> Array:
        """(2, 3) the places of the hands, always up to date [m]."""
        first = int(self.record.node) + HAND
        return self.view.p[first : first + 2]

    def ground_distance(self, place: Array) -> float:
        """Return the horizontal distance to a place [m]."""
        at, (x, _, z) = self.record.at, place.tolist()
        return math.hypot(x - at.item(0), z - at.item(1))

    def direction_to(self, place: Array) -> Array:
        """Return the level unit vector (3,) to a place."""
        at, (x, _, z) = self.record.at, place.tolist()
        x, z = x - at.item(0), z - at.item(1)
        size = math.hypot(x, z)
        return self.ahead if size < 1e-9 else np.array([x / size, 0.0, z / size])

    def cosine_to(self, place: Array) -> float:
        """Return the cosine of the angle from straight ahead to a place."""
        at, (x, _, z) = self.record.at, place.tolist()
        x, z = x - at.item(0), z - at.item(1)
        size, heading = math.hypot(x, z), self.record.heading
        if size < 1e-9:
            return 1.0
        return x / size * math.cos(heading) - z / size * math.sin(heading)

    def obstacles(self) -> tuple[Array, Array]:
        """Return the middles (n, 2) and radii (n,) of circles to walk around [m].

        They are obstacles of other rooms, things too heavy to be kicked away, and people that lie
        there, other than the deck that the person stands on or is about to, what it steps over,
        and what its task is about.
        """
        circles, found = self.view.obstacle_circles, NO_CIRCLES
        if circles.update():
            others = circles.keys // MAX_CIRCLES != SOLID - self.record.deck
            leg = float(self.record.hip_height)
            low = (circles.rises < HIGHEST_STEP_OVER * leg) & (
                circles.depths < DEEPEST_STEP_OVER * leg
            )
            others &= ~low
            found = circles.middles[others], circles.radii[others]
        owners = self.view.arrays.nodes["owner"]
        held = {int(owners[node]) for k in range(2) if (node := self.held_node(k)) >= 0}
        if self.record.deck_share > 0.0:
            held.add(int(self.record.deck))
        things = [k for k in self.view.heavy_things if k not in held]
        held.update(self.record.act_things.tolist())
        things += [k for k in self.view.lying_things() if k not in held]
        if not things:
            return found
        middles, radii = self.view.circles(things)
        if not len(found[1]):
            return middles, radii
        return np.concatenate([found[0], middles]), np.concatenate([found[1], radii])

    @property
    def body_radius(self) -> float:
        """Radius of the circle that the person takes up on the ground [m]."""
        return BODY_RADIUS * float(self.record.height)

    @property
    def ahead(self) -> Array:
        """(3,) the level unit vector ahead."""
        heading = float(self.record.heading)
        return np.array([math.cos(heading), 0.0, -math.sin(heading)])

    @property
    def best_pace(self) -> float:
        """Speed of its fastest run [m/s]."""
        return RUN_FROUDE * math.sqrt(GRAVITY * float(self.record.hip_height))

    def shoulder(self, k: int) -> Array:
        """Return (3,) the place of a shoulder [m]."""
        return self.view.p[self.record.node + SHOULDER + k]

    def floor_height(self, x: float, z: float) -> float:
        """Return the height of the ground, or of the deck that the person stands on [m]."""
        is_on_deck = float(self.record.deck_share) > 0.5
        return deck_height(self.record, x, z) if is_on_deck else self.view.ground_height(x, z)

    def waist(self) -> Array:
        """Return (3,) the middle of the body as it is led [m]."""
        person = self.record
        return np.array([person.at[0], person.floor + person.hip_height, person.at[1]])

    def go(self, x: float, z: float, stop_distance: float = 0.0, partner: int = NOBODY) -> None:
        """Walk to x and z, up to a distance [m]; a partner is not stepped aside for."""
        record = self.record
        record.posture, record.has_goal, record.has_facing = STANDING, True, False
        record.goal[0], record.goal[1] = x, z
        record.stop_distance, record.partner = stop_distance, partner
        record.neighbour_distance = math.inf

    def stop(self) -> None:
        """Stop and stand."""
        self.record.has_goal = False

    def turn_to(self, heading: float) -> None:
        """Turn on the spot."""
        self.record.has_goal, self.record.has_facing = False, True
        self.record.facing = heading

    def face_to(self, place: Array) -> None:
        """Turn to a place."""
        at, (x, _, z) = self.record.at, place.tolist()
        x, z = x - at.item(0), z - at.item(1)
        self.turn_to(math.atan2(-z, x))

    def is_facing(self, tolerance: float) -> bool:
        """Tell whether the person has turned to the facing asked for [rad]."""
        return self.turn_left < tolerance

    @property
    def turn_left(self) -> float:
        """Angle left to the facing asked for [rad]."""
        return abs(math.remainder(float(self.record.facing - self.record.heading), 2.0 * math.pi))

    def look_at(self, place: Array) -> None:
        """Look at a place."""
        self.record.has_look_target = True
        self.record.look_at[:] = place

    def put_hand(self, k: int, place: Array) -> None:
        """Send a hand to a place."""
        self.record.arm_mode[k] = PLACED
        self.record.arm_target[k] = place

    def lead_hand(self, k: int, place: Array, lead: float = HAND_LEAD) -> None:
        """Send a hand towards a place, so far ahead [m] that it goes there without haste."""
        here = self.hand(k)
        offset = place - here
        distance = float(np.linalg.norm(offset))
        self.put_hand(k, here + offset * min(lead / max(distance, 1e-9), 1.0))

    def put_hand_around(self, k: int, place: Array) -> None:
        """Send a hand to a place behind a partner, with the elbow aside."""
        self.record.arm_mode[k] = HUGGING
        self.record.arm_target[k] = place

    def grip(
        self, k: int, node: int, bar: int = NOBODY, share: float = 0.0, follows: bool = False
    ) -> None:
        """Close a hand around a node or a bar.

        Args:
            k: number of the hand.
            node: that is held, or one end of the bar.
            bar: the node at its other end.
            share: how far along the bar, 0 to 1.
            follows: whether the hand only follows the node and does not move it, as for a rider,
                whose feet push back as much, and a pusher, who moves the bar by `push_bar`.
        """
        hand, nodes = int(self.record.node) + HAND + k, self.view.arrays.nodes
        if self.held_node(k) != node and nodes["owner"][node] != self.record.owner:
            self.touched.append(self.view.names[nodes["owner"][node]])
        self.view.arrays.grips[self.record.grip + k] = hand, node
        nodes["grip_partner"][hand] = nodes["owner"][node]
        nodes["grip_partner"][node] = self.record.owner
        self.parting.pop(k, None)
        nodes["grip_bar"][hand], nodes["grip_share"][hand] = bar, share
        nodes["grip_follows"][hand] = follows
        nodes["grip_gap"][hand] = math.dist(nodes["p"][hand], self.held_place(k))
        # A ball hangs from the hand by its surface.
        is_ball = self.view.arrays.owners[nodes["owner"][node]].nodes[1] == 1
        nodes["grip_length"][hand] = nodes["radius"][node] if is_ball else 0.0

    @cached_property
    def owner(self) -> int:
        """Number of the person among the owners."""
        return int(self.record.owner)

    @property
    def is_gripping(self) -> bool:
        """Whether a hand grips a node."""
        return self._gripped.tolist() != NOTHING_GRIPPED

    @cached_property
    def _gripped(self) -> IntArray:
        """(2,) the nodes that its hands grip, NOBODY for none."""
        return self.view.arrays.grips[self._first_grip : self._first_grip + 2, 1]

    @cached_property
    def _first_grip(self) -> int:
        return int(self.record.grip)

    def held_node(self, k: int) -> int:
        """Return the node that a hand grips, -1 for none."""
        return self._gripped.item(k)

    def are_gripping(self, hands: Sequence[int]) -> bool:
        """Tell whether hands all grip nodes."""
        nodes = self._gripped.tolist()
        return all(nodes[k] >= 0 for k in hands)

    def held_place(self, k: int) -> Array:
        """Return (3,) the place on a node or a bar at which a grip holds it [m]."""
        place = np.empty(3)
        self.view.find_held_place(self._first_grip + k, place)
        return place

    def is_holding(self, k: int) -> bool:
        """Tell whether a hand grips something."""
        return k in self.held_members or self.held_node(k) >= 0

    def hands_holding(self, name: str) -> tuple[int, ...]:
        """Return the hands that hold a member."""
        owner, owners = self.view.owner(name), self.view.owner_of_node
        if owner < 0:
            return tuple(k for k in range(2) if self.held_members.get(k) == name)
        left, right = self._gripped.tolist()
        if left < 0 and right < 0:
            return ()
        nodes = enumerate((left, right))
        return tuple(k for k, node in nodes if node >= 0 and owners[node] == owner)

    def hold_member(self, name: str, hands: Sequence[int]) -> None:
        """Close hands around a member of another room, which follows them from now on."""
        for k in hands:
            self.let_go(k)
        self.held_members.update(dict.fromkeys(hands, name))
        self.view.holders[name] = self.name
        self.touched.append(name)
        self.grip_changes.append(GripChange(self.name, self._hand_names(hands), name, True))

    def take(self, name: str, hands: Sequence[int]) -> None:
        """Close hands around a member of another room or a ball."""
        if (owner := self.view.owner(name)) < 0:
            self.hold_member(name, hands)
            return
        for k in hands:
            self.grip(k, int(self.view.arrays.owners[owner].nodes[0]))

    def release(self, name: str, v: Array | None = None) -> None:
        """Open the hands that hold a member, which goes on with a velocity (3,) [m/s].

        Args:
            name: of the member.
            v: None for the velocity of the hands.
        """
        hands, owner = self.hands_holding(name), self.view.owner(name)
        if owner >= 0:
            for k in hands:
                self.let_go(k)
            if v is not None:
                self.view.set_velocity(owner, v)
        elif hands:
            for k in hands:
                del self.held_members[k]
                self.record.arm_mode[k] = SWINGING
            if self.view.holders.get(name) == self.name:
                del self.view.holders[name]
            self.grip_changes.append(GripChange(self.name, self._hand_names(hands), name, False, v))

    def _hand_names(self, hands: Sequence[int]) -> tuple[str, ...]:
        """Return the names of the nodes of hands."""
        return tuple(f"{self.name}.hand_{'lr'[k]}" for k in hands)

    def let_go(self, k: int) -> None:
        """Open a hand, and let the arm hang."""
        if k in self.held_members:
            self.release(self.held_members[k])
        self._open(k)
        self.record.arm_mode[k] = SWINGING

    def embrace(self, owner: int) -> None:
        """Put the arms around a character: they pass through its arms until both are apart.

        Likewise they pass through a ball that is thrown.
        """
        self.view.arrays.owners["embraces"][self.record.owner] = owner

    def end_distant_embrace(self) -> None:
        """End an embrace when the partner is out of reach."""
        partner = int(self.view.arrays.owners["embraces"][self.record.owner])
        if partner >= 0:
            if self.ground_distance(self.view.pelvis(partner)) > EMBRACE_RANGE * self.arm:
                self.embrace(NOBODY)

    def _open(self, k: int) -> None:
        grip = self.view.arrays.grips[self.record.grip + k]
        nodes = self.view.arrays.nodes
        if grip[0] >= 0:
            if nodes["grip_bar"][grip[0]] >= 0:
                # An arm that met the bar at once would knock it away.
                self.parting[k], nodes["grip_partner"][grip[1]] = PARTING_TIME, NOBODY
            else:
                nodes["grip_partner"][grip] = NOBODY
            nodes["grip_bar"][grip[0]] = NOBODY
        grip[:] = NOBODY

    def reach_for_bar(self, k: int, owner: int) -> None:
        """Let a forearm pass through the bars of a thing that its hand is about to close around."""
        self.view.arrays.nodes["grip_partner"][self.record.node + HAND + k] = owner
        self.parting[k] = PARTING_TIME

    def push_bar(self, nodes: tuple[int, int], force: Array, dt: float) -> None:
        """Push a bar between two nodes with a force (3,) for a step [N], [s]."""
        for node in nodes:
            self.view.push_node(node, 0.5 * dt * force, self.view.sub_step)
        self.view.decks.forget_rates()

    def part_from_bars(self, dt: float) -> None:
        """Let hands that have opened around bars meet them again after a while [s]."""
        for k in list(self.parting):
            self.parting[k] -= dt
            if self.parting[k] <= 0.0:
                del self.parting[k]
                self.view.arrays.nodes["grip_partner"][self.record.node + HAND + k] = NOBODY

    def node_to_grip(self, owner: int, part: str | None, k: int) -> int:
        """Return the node of a character that a hand takes: by name, or the nearest one."""
        first = int(self.view.arrays.owners[owner].nodes[0])
        if part is not None:
            return first + JOINTS.index(part)
        offset = self.view.nodes(owner) - self.hand(k)
        return int(first + np.argmin((offset * offset).sum(axis=1)))

    def ball_radius(self, owner: int) -> float:
        """Return the radius of a ball, 0 of another character [m]."""
        return self.view.ball_radii[owner]

    def hold_gripped_things(self) -> None:
        """Let light things hang from the hand, and the hand follow heavy ones."""
        view = self.view
        for k in range(2):
            node = self.held_node(k)
            if node < 0:
                continue
            mass = view.masses[view.owner_of_node[node]]
            if mass > CARRIED_MASS * view.masses[self.owner]:
                self.put_hand(k, self.held_place(k))
            elif self._holds_between(node):
                radius = float(view.arrays.nodes["radius"][node])
                self.lead_hand(k, self.place_before(k, radius, radius))
            else:
                self.record.arm_mode[k] = SWINGING

    def _holds_between(self, node: int) -> bool:
        """Tell whether both hands grip a node."""
        return self.held_node(0) == node == self.held_node(1)

    def place_before(self, k: int, half_width: float, half_depth: float) -> Array:
        """Return the place (3,) of a hand that holds a thing before the waist.

        Args:
            k: number of the hand.
            half_width: half the extent of the thing from hand to hand [m].
            half_depth: half its extent ahead [m].
        """
        person, ahead = self.record, self.ahead
        right = np.array([-ahead[2], 0.0, ahead[0]])
        middle = np.array([person.at[0], person.floor, person.at[1]])
        middle += min(0.12 * person.height + half_depth, 0.85 * self.arm) * ahead
        middle[1] += HOLD_HEIGHT * person.height
        return middle + (half_width if k == 1 else -half_width) * right
