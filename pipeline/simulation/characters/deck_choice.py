"""Deck choice: which moving surface each person may stand on.

A merry-go-round in reach is a deck for everybody who comes near it. The top of a solid of another
room is one for a person that rides it, until both feet have left it.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY, SOLID, CharacterArrays, IntArray
from pipeline.simulation.characters.carousel_places import CarouselPose, CarouselSurvey
from pipeline.simulation.characters.deck_motion import STEEPEST_DECK
from pipeline.simulation.characters.person_record import NODE_COUNT, STANCE
from pipeline.simulation.characters.solid_arrays import SolidTracker
from pipeline.simulation.dynamics.compiled import Record, Records, bound, compiled, entry
from pipeline.simulation.dynamics.vectors import hypotenuse
from pipeline.simulation.spatial import Array

NEAR_DECK = 1.5  # from the edge of a merry-go-round, within which a person heeds its deck [m]
EDGE_ROOM = 0.15  # from the edge of a deck, farther in than which people start on it [m]
TOP_TOLERANCE = 0.02  # of corners below the highest ones of a top, in its size


class DeckShape(NamedTuple):
    """The flat top of something in its own frame.

    Attributes:
        place: (3,) its middle [m].
        turn: (3, 3) its axes as columns: along, up, across.
        half: half extents along and across, of a round one its radius twice [m].
        is_round: whether it is a disc.
    """

    place: Array
    turn: Array
    half: tuple[float, float]
    is_round: bool


class Carousel(NamedTuple):
    """A merry-go-round.

    Attributes:
        owner: its number.
        hub: number of the node in the middle of its deck.
        shape: of its deck.
    """

    owner: int
    hub: int
    shape: DeckShape


@dataclass(eq=False)
class Decks:
    """The decks of a scene.

    Attributes:
        arrays: all characters.
        tracker: of the solids of other rooms.
        carousels: the merry-go-rounds.
        boarding: names of people who are about to step onto each, by its number.
        leaving: numbers of people on each who want to step off it, by its number.
        poses: of the merry-go-rounds in this step, by their numbers, as far as asked for.
        surveys: what measures each merry-go-round, by its number, as far as asked for.
    """

    arrays: CharacterArrays
    tracker: SolidTracker = field(default_factory=SolidTracker)
    carousels: Sequence[Carousel] = ()
    boarding: dict[int, set[str]] = field(default_factory=lambda: defaultdict(set))
    leaving: dict[int, set[int]] = field(default_factory=lambda: defaultdict(set))
    poses: dict[int, CarouselPose] = field(default_factory=dict)
    surveys: dict[int, CarouselSurvey] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Find the merry-go-rounds: what runs on a bearing."""
        owners, nodes = self.arrays.owners, self.arrays.nodes
        found = []
        for owner in np.flatnonzero(owners["on_bearing"]).tolist():
            hub = int(owners["nodes"][owner, 0])
            rise = float(nodes["radius"][hub])
            radius = math.dist(nodes["p"][hub], nodes["p"][hub + 2]) + rise
            shape = DeckShape(np.array([0.0, rise, 0.0]), np.eye(3), (radius, radius), True)
            found.append(Carousel(owner, hub, shape))
        self.carousels = tuple(found)
        numbers = [(carousel.owner, carousel.hub) for carousel in found]
        self._numbers: IntArray = np.array(numbers, dtype=np.int64).reshape(-1, 2)
        self._radii = np.array([carousel.shape.half[0] for carousel in found])
        self._heed_known: Callable[[Records], bool] | None = None

    def update(self, persons: Records) -> None:
        """Let people heed the deck that they ride, or else a merry-go-round near them."""
        if self._heed_known is None:
            known = self.arrays.nodes, self._numbers, self._radii
            self._heed_known = bound(_heed_known_decks, *known, examples=(persons,))
        if not self._heed_known(persons):
            for person in persons:
                if not _stays_on_solid(person):
                    self._heed_carousel(person)

    def forget_poses(self) -> None:
        """Forget the poses of merry-go-rounds, which have moved."""
        self.poses.clear()

    def forget_rates(self) -> None:
        """Forget how fast merry-go-rounds turn, for one has been pushed."""
        for owner, pose in self.poses.items():
            self.poses[owner] = pose.without_rate()

    def start_on(self, persons: Sequence[Record]) -> None:
        """Let people that start within a merry-go-round stand on its deck, and turn with it."""
        for person in persons:
            self._heed_carousel(person)
            for carousel in self.carousels:
                hub = self.arrays.nodes["p"][carousel.hub]
                away = math.hypot(person.at[0] - hub[0], person.at[1] - hub[2])
                if away < carousel.shape.half[0] - EDGE_ROOM and person.deck == carousel.owner:
                    self._lift(person, carousel)

    def _lift(self, person: Record, carousel: Carousel) -> None:
        """Move a standing person from the ground up to a deck."""
        hub, rim = self.arrays.nodes[carousel.hub], self.arrays.nodes[carousel.hub + 2]
        rise = float(hub["p"][1] + carousel.shape.place[1] - person.floor)
        person.floor += rise
        for name in ("targets", "previous_targets", "ankles"):
            person[name][:, 1] += rise
        for name in ("stance", "liftoff", "landing"):
            person[f"{name}_place"][:, 1] += rise
            person[f"{name}_on_deck"][:] = 1
        person.deck_share = 1.0
        nodes = self.arrays.nodes[person.node : person.node + NODE_COUNT]
        for name in ("p", "lock_place", "anchor"):
            nodes[name][:, 1] += rise
        arm, moved = rim["p"] - hub["p"], rim["p"] - rim["previous"]
        turn = (arm[2] * moved[0] - arm[0] * moved[2]) / (arm[0] ** 2 + arm[2] ** 2)
        nodes["previous"] = nodes["p"] - np.cross([0.0, turn, 0.0], nodes["p"] - hub["p"])

    def _heed_carousel(self, person: Record) -> None:
        x, z = float(person.at[0]), float(person.at[1])
        best, least = None, NEAR_DECK
        for carousel in self.carousels:
            hub = self.arrays.nodes["p"][carousel.hub]
            gap = math.hypot(x - hub[0], z - hub[2]) - carousel.shape.half[0]
            if gap < least:
                best, least = carousel, gap
        owner = NOBODY if best is None else best.owner
        if person.deck != owner:
            _set_deck(person, owner, None if best is None else best.shape)
            self.arrays.owners["stands_on"][person.owner] = owner

    def board_solid(self, person: Record, name: str) -> str:
        """Let a person heed the top of a member of another room; return why not, "" if it does."""
        for k, obstacle in enumerate(self.tracker.obstacles):
            if name in (obstacle.performer, obstacle.name):
                solid = self.tracker.solids.bodies[k]
                shape = top_of(self._corners(solid), solid["R"])
                if shape is None:
                    return f"'{name}' has no flat top to stand on"
                if person.deck != SOLID - k:
                    _set_deck(person, SOLID - k, shape)
                    self.arrays.owners["stands_on"][person.owner] = NOBODY
                return ""
        return f"people do not touch '{name}'; a body needs `collide: all`"

    def _corners(self, solid: Record) -> Array:
        first, count = solid["corners"]
        return self.tracker.solids.corners[first : first + count]


def top_of(corners: Array, R: Array) -> DeckShape | None:
    """Return the top of a convex solid, None if it is not flat.

    Args:
        corners: (n, 3) in its own frame [m].
        R: (3, 3) its rotation.
    """
    if len(corners) < 4:
        return None
    # Its own axis that is nearest to the vertical: boards and boxes have their tops across it.
    axis = int(np.argmax(np.abs(R[1])))
    if abs(float(R[1, axis])) < STEEPEST_DECK:
        return None
    side = math.copysign(1.0, float(R[1, axis]))
    heights = side * corners[:, axis]
    size = float(np.ptp(corners, axis=0).max())
    top = corners[heights > float(heights.max()) - TOP_TOLERANCE * size]
    along, across = (axis + 1) % 3, (axis + 2) % 3
    if len(top) < 3:
        return None
    up = np.zeros(3)
    up[axis] = side
    turn = np.zeros((3, 3))
    turn[:, 1] = up
    turn[along, 0] = 1.0
    turn[:, 2] = np.cross(turn[:, 0], up)
    low, high = top.min(axis=0), top.max(axis=0)
    half = 0.5 * (high - low)
    if min(half[along], half[across]) <= 0.0:
        return None
    place = 0.5 * (low + high)
    place[axis] = side * float(heights.max())
    return DeckShape(place, turn, (float(half[along]), float(half[across])), False)


def deck_height(person: Record, x: float, z: float) -> float:
    """Return the height of the plane of a person's deck at a position [m]."""
    middle, up = person.deck_middle, person.deck_axes[:, 1]
    return float(middle[1] - (up[0] * (x - middle[0]) + up[2] * (z - middle[2])) / up[1])


@entry
def _heed_known_decks(nodes: Records, carousels: IntArray, radii: Array, persons: Records) -> bool:
    """Tell whether all people heed the decks that they should already.

    Args:
        nodes: of all characters.
        carousels: (n, 2) numbers of merry-go-rounds and of the nodes of their hubs.
        radii: (n,) of their decks [m].
        persons: `PERSON` records.
    """
    for k in range(len(persons)):
        person = persons[k]
        if _stays_on_solid(person):
            continue
        best, least = NOBODY, NEAR_DECK
        for c in range(len(carousels)):
            hub = nodes[carousels[c, 1]]
            gap = hypotenuse(person.at[0] - hub.p[0], person.at[1] - hub.p[2]) - radii[c]
            if gap < least:
                best, least = carousels[c, 0], gap
        if person.deck != best:
            return False
    return True


@entry
def _stays_on_solid(person: Record) -> bool:
    """Tell whether a person heeds the top of a solid, and goes on doing so."""
    return person.deck <= SOLID and (person.deck_wanted or _stands_on_deck(person))


@compiled
def _stands_on_deck(person: Record) -> bool:
    """Tell whether a foot stands on the deck, or will."""
    for k in range(2):
        if person.foot_state[k] == STANCE:
            if person.stance_on_deck[k]:
                return True
        elif person.landing_on_deck[k] or person.liftoff_on_deck[k]:
            return True
    return False


def _set_deck(person: Record, deck: int, shape: DeckShape | None) -> None:
    """Let a person heed a deck."""
    person.deck, person.known_deck = deck, NOBODY
    for name in ("stance_on_deck", "liftoff_on_deck", "landing_on_deck"):
        person[name][:] = 0
    if shape is not None:
        person.deck_place[:], person.deck_turn[:] = shape.place, shape.turn
        person.deck_half[:], person.deck_is_round = shape.half, shape.is_round
