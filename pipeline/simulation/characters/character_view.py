"""Character view: where all characters of a scene are, by their number among the owners."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pipeline.simulation.characters import held_bar
from pipeline.simulation.characters.body_arrays import (
    FREE,
    NOBODY,
    RESTING,
    CharacterArrays,
    IntArray,
)
from pipeline.simulation.characters.deck_choice import Decks
from pipeline.simulation.characters.hurdles import STILL_SPEED
from pipeline.simulation.characters.person_record import HEAD, KNEE, PELVIS, SHOULDERS
from pipeline.simulation.characters.queues import Queues
from pipeline.simulation.characters.slots import Slots
from pipeline.simulation.characters.thing_circles import find_circles
from pipeline.simulation.characters.visibility_route import LIGHT_MASS, ObstacleCircles
from pipeline.simulation.dynamics.compiled import Record, Records, bound
from pipeline.simulation.members import MemberState
from pipeline.simulation.people.guided_dance import DanceGuide
from pipeline.simulation.people.proportions import SEGMENTS
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground
from pipeline.spec.model_base import Goal, Target

SIZE_FACTOR = 1.12  # from the height of the nodes of a standing person to its size

SEGMENT_NAMES = tuple(SEGMENTS)
"""Names of a person's segments, in the order of their links."""


@dataclass(frozen=True, eq=False)
class CharacterView:
    """The places of all characters, by their number among the owners.

    Attributes:
        names: of all characters, in the order of the owners.
        arrays: the characters.
        ground: the terrain.
        people: numbers of the owners with the joints of people.
        obstacle_circles: obstacles of other rooms.
        sub_step: [s].
        members: states of members by name, one row ago.
        places: places that orders give by their coordinates, by these as text.
        body_masses: masses of bodies that can be pushed, by name [kg].
        holders: names of the people that hold members of other rooms, by name.
        slots: places on things that people have taken.
        queues: of people who wait to be served.
        sadness: that faces of acting people show, 0 to 1, by their number.
        persons: `PERSON` records of acting people, by their number.
        dances: what people dance that are told to, by name.
    """

    names: Sequence[str]
    arrays: CharacterArrays
    ground: Ground
    people: frozenset[int]
    obstacle_circles: ObstacleCircles
    sub_step: float
    members: dict[str, MemberState] = field(default_factory=dict)
    places: dict[str, MemberState] = field(default_factory=dict)
    body_masses: dict[str, float] = field(default_factory=dict)
    holders: dict[str, str] = field(default_factory=dict)
    slots: Slots = field(default_factory=Slots)
    queues: Queues = field(default_factory=Queues)
    sadness: dict[int, float] = field(default_factory=dict)
    persons: dict[int, Record] = field(default_factory=dict)
    dances: Mapping[str, DanceGuide] = field(default_factory=dict)

    @cached_property
    def decks(self) -> Decks:
        """What people can stand on and be carried by."""
        return Decks(self.arrays)

    @cached_property
    def p(self) -> Array:
        """(N, 3) all nodes, always up to date [m]."""
        return self.arrays.p

    @cached_property
    def edges(self) -> tuple[Array, Array]:
        """Least and greatest x and z (2,) of a square within the terrain [m]."""
        return self.ground.field.inner_bounds

    @cached_property
    def _spans(self) -> list[list[int]]:
        return self.arrays.owners["nodes"].tolist()

    @cached_property
    def heavy_things(self) -> tuple[int, ...]:
        """Numbers of things too heavy to be kicked away, balls excepted."""
        owners = self.arrays.owners
        things = (k for k in range(len(owners)) if k not in self.people)
        return tuple(
            k for k in things if owners["nodes"][k, 1] > 1 and owners["mass"][k] > LIGHT_MASS
        )

    def lying_things(self) -> list[int]:
        """Return the numbers of limp people, and of balls that lie still."""
        speeds = self.arrays.owners["speed"]
        balls = [k for k in self._balls if speeds[k] < STILL_SPEED]
        return [*self.limp_people, *balls]

    @cached_property
    def _balls(self) -> tuple[int, ...]:
        return tuple(k for k, span in enumerate(self._spans) if span[1] == 1)

    @cached_property
    def limp_people(self) -> tuple[int, ...]:
        """Numbers of limp people and dolls that are too heavy to be kicked away."""
        owners = self.arrays.owners
        return tuple(
            k for k in self.people if not owners["acts"][k] and owners["mass"][k] > LIGHT_MASS
        )

    def number(self, name: str) -> int:
        """Return the number of a character."""
        return self.names.index(name)

    def target_name(self, target: Goal | Target) -> str:
        """Return the name of a target; a place without one gets that of its coordinates."""
        if isinstance(target, str):
            return target
        name = str(list(target))
        if name not in self.places:
            x, z = target[0], target[-1]
            y = target[1] if len(target) == 3 else self.ground_height(x, z)
            self.places[name] = MemberState.of_place(np.array([x, y, z], dtype=float))
        return name

    def state(self, name: str) -> MemberState:
        """Return the state of a target."""
        return self.places[name] if name in self.places else self.members[name]

    def owner(self, name: str) -> int:
        """Return the number of a character, NOBODY for a member of another room."""
        return self._numbers.get(name, NOBODY)

    @cached_property
    def _numbers(self) -> Mapping[str, int]:
        return {name: k for k, name in enumerate(self.names)}

    @cached_property
    def owner_of_node(self) -> tuple[int, ...]:
        """(N,) the character of each node."""
        return tuple(self.arrays.nodes["owner"].tolist())

    @cached_property
    def ball_radii(self) -> tuple[float, ...]:
        """(C,) radius of each ball, 0 of other characters [m]."""
        radii = self.arrays.nodes["radius"]
        return tuple(float(radii[first]) if count == 1 else 0.0 for first, count in self._spans)

    @cached_property
    def masses(self) -> tuple[float, ...]:
        """(C,) of all characters [kg]."""
        return tuple(self.arrays.owners["mass"].tolist())

    @cached_property
    def find_held_place(self) -> Callable[[int, Array], None]:
        """Sets a place (3,) to that on a node or a bar at which a grip, by its number, holds it."""
        known = self.arrays.nodes, self.arrays.grips
        return bound(held_bar.find_held_place, *known, examples=(0, np.zeros(3)))

    def is_ball(self, owner: int) -> bool:
        """Tell whether a character is a ball: a single node."""
        return self._spans[owner][1] == 1

    def set_velocity(self, owner: int, v: Array) -> None:
        """Give all nodes of a character a velocity (3,) [m/s]."""
        nodes = self._wake(owner)
        nodes["previous"] = nodes["p"] - self.sub_step * v

    def _wake(self, owner: int) -> Records:
        """Wake a character, and return its nodes."""
        first, count = self._spans[owner]
        nodes, state = self.arrays.nodes[first : first + count], self.arrays.owners[owner]
        state.asleep, state.watch_time, state.still_count = False, 0.0, 0
        resting = nodes["lock"] == RESTING
        nodes["lock"][resting] = FREE
        nodes["mobility"][resting] = nodes["inverse_mass"][resting]
        nodes["anchor"] = nodes["p"]
        return nodes

    def push(self, owner: int, v: Array, slackness: float) -> None:
        """Throw a character off balance.

        Args:
            owner: its number.
            v: (3,) velocity that is added, of a person to all but its knees and feet [m/s].
            slackness: of its muscles, 0 to 1.
        """
        nodes = self._wake(owner)
        nodes["previous"][: KNEE if owner in self.people else None] -= self.sub_step * v
        person = self.persons.get(owner)
        if person is not None:
            # The feet go along, or the legs would hold the body where it is.
            person.velocity[0] += v[0]
            person.velocity[1] += v[2]
            person.stun = max(float(person.stun), slackness)

    def strike(self, owner: int, segment: str, striker: int, energy: float) -> None:
        """Let a segment of a person feel a blow of the right hand of another [J]."""
        links = self.arrays.links
        link = links[self._link(owner, segment)]
        link.blow, link.age[0] = energy, 0.0
        link.touched, link.touched_owner = self._link(striker, "forearm_r"), striker

    def _link(self, owner: int, segment: str) -> int:
        """Return the number of the link of a person's segment."""
        return int(self.arrays.owners["links"][owner, 0]) + SEGMENT_NAMES.index(segment)

    def speed_between(self, node: int, other: int) -> float:
        """Return the relative speed of two nodes [m/s]."""
        nodes = self.arrays.nodes
        moved = nodes["p"] - nodes["previous"]
        return math.dist(moved[node], moved[other]) / self.sub_step

    def nodes(self, owner: int) -> Array:
        """Return (n, 3) the nodes of a character [m]."""
        first, count = self._spans[owner]
        return self.p[first : first + count]

    @cached_property
    def push_node(self) -> Callable[[int, Array, float], None]:
        """Pushes a node, by its number, with an impulse (3,) [N s], for sub-steps [s]."""
        return bound(held_bar.push_node, self.arrays.nodes, examples=(0, np.zeros(3), 1.0))

    def first_node(self, owner: int) -> int:
        """Return the number of the first node of a character."""
        return self._spans[owner][0]

    def _joint(self, owner: int, joint: int) -> Array:
        """Return (3,) a joint of a person, or the middle of a thing [m]."""
        nodes = self.nodes(owner)
        return nodes[joint] if owner in self.people else nodes.mean(axis=0)

    def middle(self, owner: int) -> Array:
        """Return (3,) the chest of a person, or the middle of a thing [m]."""
        return self._joint(owner, SHOULDERS)

    def face(self, owner: int) -> Array:
        """Return (3,) the place to look at in a character [m]."""
        return self._joint(owner, HEAD)

    def pelvis(self, owner: int) -> Array:
        """Return (3,) the place to walk up to in a character [m]."""
        return self._joint(owner, PELVIS)

    def circle(self, owner: int) -> tuple[Array, float]:
        """Return the middle (2,) and the radius of a circle around a character [m]."""
        middles, radii = self.circles([owner])
        return middles[0], float(radii[0])

    def circles(self, owners: Sequence[int]) -> tuple[Array, Array]:
        """Return the middles (n, 2) and radii (n,) of circles around characters [m]."""
        numbers = np.array(owners, dtype=np.int64)
        middles, radii = np.empty((len(numbers), 2)), np.empty(len(numbers))
        self._find_circles(numbers, middles, radii)
        return middles, radii

    @cached_property
    def _find_circles(self) -> Callable[[IntArray, Array, Array], None]:
        examples = np.zeros(1, dtype=np.int64), np.zeros((1, 2)), np.zeros(1)
        return bound(find_circles, self.arrays.nodes, self.arrays.owners, examples=examples)

    def size(self, owner: int) -> float:
        """Return the approximate height of a standing character [m]."""
        return float(np.ptp(self.nodes(owner)[:, 1])) * SIZE_FACTOR

    def ground_height(self, x: float, z: float) -> float:
        """Return the height of the ground [m]."""
        return float(self.ground.height(np.asarray(x), np.asarray(z)))
