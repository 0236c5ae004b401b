"""Ride tasks: stepping onto a moving thing and staying on it.

On a merry-go-round a person stands inside a post of its own and holds on to it with the hands that
are free. On the top of a cart, a raft or a board it stands at a place of its own. Whoever is told
to do something else lets go and steps off.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.carousel_places import CarouselPose
from pipeline.simulation.characters.carousel_pose import (
    GAP_TOLERANCE,
    OUTSIDE,
    carousel_pose,
    way_across_rim,
)
from pipeline.simulation.characters.deck_choice import deck_height
from pipeline.simulation.characters.deck_motion import HIGHEST_STEP
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import SWINGING
from pipeline.simulation.characters.person_tasks import (
    Approach,
    Task,
    place_text,
    shoulder_height,
)
from pipeline.simulation.characters.pursuit_tasks import CLOSING_RATE
from pipeline.simulation.characters.seat_task import (
    NEIGHBOUR_SPACE,
    SEAT_PITCH,
    Bench,
    bench_of,
)
from pipeline.simulation.characters.task_progress import TaskProgress
from pipeline.simulation.spatial import Array

BOARDING_SPEED = 0.6  # of the rim of a merry-go-round, above which nobody steps on [m/s]
BOARDING_PATIENCE = 5.0  # of a person that waits until it turns more slowly [s]
ANNOUNCING_DISTANCE = 2.0  # from the rim within which pushers see that somebody comes [m]
RIM_TOLERANCE = 0.15  # of a person from where it stands before the rim [m]
COMING_TIME = 0.4  # by which a person sees where a gap between posts will be [s]
CROSSING_LEAD = 0.2  # by which a person on its way through a gap walks to where that will be [s]
STILL_RATE = 0.08  # of a merry-go-round below which a person goes to the gap [rad/s]
STEPPING_TIME = 5.0  # without coming nearer to its place on a deck [s]
HOLDING_REACH = 0.62  # of a post before a rider, in arm lengths
HOLDING_LEVEL = 0.35  # of hands on a post below the shoulders, in arm lengths
LOWEST_LEVEL = 0.9  # below which no hand reaches down from upright shoulders, in arm lengths
TOP_MARGIN = 0.04  # of hands below the top of a post [m]
HANDS_APART = 0.08  # on a post [m]
CLOSING, REACHING = 0.06, 0.2  # of a hand to its place: it closes; it may touch; in heights
HOLDING_TIME = 2.0  # after which a rider is content with what its hands have got [s]
HOLDING_INTERVAL, CLOSING_INTERVAL = 4, 2  # of commands to one who holds on, and before [steps]
FACED_WAY = math.radians(40.0)  # from the post to where a rider goes, to which it faces
BRISK_RATE = 0.4  # of a merry-go-round from which it does so wholly [rad/s]
AT_PLACE = 0.12  # of a rider from its place [m]
LOST_DECK = 0.3  # share of the weight on a deck below which a rider has left it


@dataclass
class Ride(Task):
    """Step onto something and stay on it.

    Attributes:
        target: its name.
        number: of the place on it that the person has taken, None before.
        approach: to it.
        progress: on it.
        is_there: whether the person stands at its place.
    """

    target: str
    number: int | None = field(default=None, init=False)
    approach: Approach = field(default_factory=Approach, init=False)
    progress: TaskProgress = field(default_factory=TaskProgress, init=False)
    is_there: bool = field(default=False, init=False)

    @property
    def wants_slot(self) -> bool:
        """See `Task`."""
        return self.number is None

    def _take_nearest(self, controller: PersonController, distances: list[float]) -> None:
        """Take the nearest free place, by the distances of all."""
        slots = controller.view.slots
        free = slots.free(self.target, len(distances))
        if not free:
            self.failure = f"all {len(distances)} places on '{self.target}' are taken"
            return
        self.number = min(free, key=lambda n: (distances[n], n))
        slots.take(self.target, self.number, controller.name, float(controller.record.heading))

    def _step(self, controller: PersonController, place: Array, dt: float) -> float:
        """Step to a place (3,) on the deck; return how far off it is [m]."""
        left = controller.ground_distance(place)
        if left > AT_PLACE:
            controller.go(place[0], place[2], 0.0, controller.view.owner(self.target))
            controller.record.neighbour_distance = NEIGHBOUR_SPACE * SEAT_PITCH
        if self.progress.update(left, dt) > STEPPING_TIME:
            self.stick(f"the way is blocked at {place_text(controller)}, {left:.1f} m from it")
        return left


@dataclass
class RideCarousel(Ride):
    """Step onto a merry-go-round between two posts, and hold on to one.

    Attributes:
        owner: its number.
        waited: time for which it has turned too fast [s].
        held: time since the hands are sent to the post [s].
        is_at_still_rim: whether it is at the rim, or beyond, of what hardly turns.
        gap: angle of the gap to step through from the first post, None before [rad].
        is_aboard: whether it has come through the gap.
    """

    owner: int
    waited: float = field(default=0.0, init=False)
    held: float = field(default=0.0, init=False)
    is_at_still_rim: bool = field(default=False, init=False)
    gap: float | None = field(default=None, init=False)
    is_aboard: bool = field(default=False, init=False)

    @property
    def wants_slot(self) -> bool:
        """See `Task`; posts are chosen on the deck, wherever that has turned by then."""
        return self.is_aboard and self.number is None

    @property
    def interval(self) -> int:
        """See `Task`; who steps onto what turns is led closely, but holding on is steady.

        The deck carries what the person faces.
        """
        if not self.is_there:
            return CLOSING_INTERVAL if self.is_at_still_rim else 1
        return HOLDING_INTERVAL if self.held > HOLDING_TIME else CLOSING_INTERVAL

    def slot_distance(self, controller: PersonController) -> float:
        """See `Task`."""
        return controller.ground_distance(carousel_pose(controller.view, self.owner).hub)

    def take_slot(self, controller: PersonController) -> None:
        """See `Task`."""
        carousel = carousel_pose(controller.view, self.owner)
        here = np.array(controller.record.at)
        offsets = carousel.feet[:, [0, 2]] - here
        self._take_nearest(controller, np.hypot(*offsets.T).tolist())

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        carousel = carousel_pose(controller.view, self.owner)
        distance = controller.ground_distance(carousel.hub)
        self._announce(controller, distance < carousel.radius + ANNOUNCING_DISTANCE)
        self.is_at_still_rim = False
        if self.is_there:
            self._hold_on(controller, carousel, dt)
            self.is_lost = controller.record.deck_share < LOST_DECK
            return self.held > HOLDING_TIME
        is_still = abs(carousel.rate) < STILL_RATE
        if self.is_aboard:
            self.is_at_still_rim = is_still
            if self.number is not None:
                self._go_to_post(controller, carousel, self.number, dt)
            return False
        outer = carousel.radius + controller.body_radius + OUTSIDE
        if controller.record.deck_share == 0.0 and distance >= outer + RIM_TOLERANCE:
            own = carousel.angle_of(*controller.record.at.tolist())
            place = carousel.place(own, outer)
            reason = self.approach.walk_to(controller, place, 0.0, self.owner, dt)
            self.stick(reason, self.approach)
        elif self._may_board(controller, carousel, dt):
            self.is_at_still_rim = is_still
            self._step_on(controller, carousel, dt)
        return False

    def _announce(self, controller: PersonController, is_near: bool) -> None:
        """Let pushers know whether the person, which is near or not, is about to step on."""
        decks = controller.view.decks
        boarding = decks.boarding[self.owner]
        decks.leaving[self.owner].discard(controller.owner)
        if is_near and not self.is_aboard and not self.failure:
            boarding.add(controller.name)
        else:
            boarding.discard(controller.name)

    def _step_on(self, controller: PersonController, carousel: CarouselPose, dt: float) -> None:
        """Step through the gap that is there, or that comes by."""
        own = carousel.angle_of(*controller.record.at.tolist())
        if controller.record.deck_share == 0.0 and not controller.record.stepping:
            self.gap = None
        if self.gap is None:
            near = carousel.gap_angle(own - COMING_TIME * carousel.rate)
            off = math.remainder(near + COMING_TIME * carousel.rate - own, 2.0 * math.pi)
            if abs(off) < GAP_TOLERANCE or abs(carousel.rate) < STILL_RATE:
                self.gap = near - carousel.angle
        if self.gap is None:
            controller.face_to(carousel.hub)
            return
        gap = carousel.angle + self.gap
        # A walk to where the gap is now would come late, and a knee swing into the post.
        is_beside = controller.record.deck_share == 0.0
        lead = CROSSING_LEAD * carousel.rate if is_beside else 0.0
        self.pace = abs(carousel.rate) * carousel.radius + CLOSING_RATE
        way = way_across_rim(controller, carousel, gap, 0.0, lead)
        self.is_aboard = way is None
        if way is None:
            self.pace, self.progress = 0.0, TaskProgress()
        else:
            self._step(controller, way, dt)

    def _go_to_post(
        self, controller: PersonController, carousel: CarouselPose, number: int, dt: float
    ) -> None:
        """Go to the place inside the post."""
        inner = carousel.radius - HOLDING_REACH * controller.arm
        place = carousel.place(carousel.post_angle(number), inner)
        self.is_there = self._step(controller, place, dt) < AT_PLACE
        if self.is_there:
            controller.stop()

    def _may_board(self, controller: PersonController, carousel: CarouselPose, dt: float) -> bool:
        """Tell whether it turns slowly enough to step on, or give up waiting."""
        if controller.record.deck_share > 0.0:
            return True
        speed = abs(carousel.rate) * carousel.radius
        if speed < BOARDING_SPEED:
            return True
        self.waited += dt
        if self.waited > BOARDING_PATIENCE:
            self.failure = f"it turns too fast to step on ({speed:.1f} m/s)"
        controller.face_to(carousel.hub)
        return False

    def _hold_on(self, controller: PersonController, carousel: CarouselPose, dt: float) -> None:
        """Face the post, half turned to the way, and close the free hands around it."""
        assert self.number is not None
        self.held += dt
        foot, top = carousel.feet[self.number], carousel.tops[self.number]
        controller.face_to(foot)
        turn = FACED_WAY * min(max(carousel.rate / BRISK_RATE, -1.0), 1.0)
        controller.turn_to(float(controller.record.facing) + turn)
        shoulders = shoulder_height(controller)
        level = min(shoulders - HOLDING_LEVEL * controller.arm, float(top[1]) - TOP_MARGIN)
        lowest = shoulders - LOWEST_LEVEL * controller.arm
        if level < lowest:
            return
        self.leads_hands = True
        nodes = carousel.post_nodes(self.number)
        for k in range(2):
            is_late = self.held > HOLDING_TIME and not controller.is_holding(k)
            if is_late:
                controller.record.arm_mode[k] = SWINGING
            elif hold_bar(controller, k, nodes, max(level - k * HANDS_APART, lowest), self.owner):
                controller.put_hand(k, controller.held_place(k))

    def leave(self, controller: PersonController) -> None:
        """See `Task`."""
        controller.view.decks.boarding[self.owner].discard(controller.name)
        release_bars(controller, self.owner)


def hold_bar(
    controller: PersonController, k: int, nodes: tuple[int, int], level: float, owner: int
) -> bool:
    """Send a free hand to an upright bar and close it there; tell whether it holds the bar.

    Args:
        controller: of the person.
        k: number of the hand.
        nodes: at the lower and the upper end of the bar.
        level: height at which it is held [m].
        owner: number of the thing with the bar.
    """
    view = controller.view
    held = controller.held_node(k)
    if held >= 0:
        return view.owner_of_node[held] == owner
    if controller.is_holding(k):
        return False
    low, high = view.p[nodes[0]], view.p[nodes[1]]
    share = (level - float(low[1])) / max(float(high[1] - low[1]), 1e-6)
    share = min(max(share, 0.0), 1.0)
    place = (1.0 - share) * low + share * high
    controller.put_hand(k, place)
    distance, height = math.dist(controller.hand(k), place), float(controller.record.height)
    if distance < REACHING * height:
        controller.reach_for_bar(k, owner)
    if distance < CLOSING * height:
        controller.grip(k, nodes[0], nodes[1], share, follows=True)
    return False


def release_bars(controller: PersonController, owner: int) -> None:
    """Open the hands that hold a thing, and let the others sink that reach for it."""
    for k in range(2):
        held = controller.held_node(k)
        if held >= 0 and controller.view.owner_of_node[held] == owner:
            controller.let_go(k)
        elif not controller.is_holding(k):
            controller.record.arm_mode[k] = SWINGING
    controller.record.has_facing, controller.record.brace = False, 0.0


@dataclass
class RideSolid(Ride):
    """Step onto the top of a member of another room, and stand there.

    Attributes:
        spot: (3,) the person's place in the frame of the deck, None before it is known [m].
    """

    spot: Array | None = field(default=None, init=False)

    @property
    def members(self) -> tuple[str, ...]:
        """See `Task`."""
        return (self.target,)

    def _top(self, controller: PersonController) -> Bench:
        corners = np.concatenate(controller.view.state(self.target).solids)
        return bench_of(corners, np.array(controller.record.at))

    def slot_distance(self, controller: PersonController) -> float:
        """See `Task`."""
        return controller.ground_distance(controller.view.state(self.target).centre)

    def take_slot(self, controller: PersonController) -> None:
        """See `Task`."""
        top = self._top(controller)
        here, _ = top.coordinates(controller.record.at)
        offsets = [abs(top.seat_offset(n) - here) for n in range(top.seat_count)]
        self._take_nearest(controller, offsets)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        state, person = controller.view.state(self.target), controller.record
        if self.number is None:
            return False
        if not state.is_present:
            self.failure = f"'{self.target}' is not there"
            return False
        if reason := self._cannot_board(controller):
            self.failure = reason
            return False
        if self.is_there:
            self.is_lost = person.deck_share < LOST_DECK
            return True
        place = self._place(controller)
        if person.deck_share > 0.0:
            self.pace = 0.0
            left = self._step(controller, place, dt)
            if left < AT_PLACE:
                controller.stop()
            self.is_there = left < 2.0 * AT_PLACE and controller.is_standing
            return self.is_there
        speed = math.hypot(state.v[0], state.v[2])
        self.pace = min(
            speed + CLOSING_RATE * controller.ground_distance(place), controller.best_pace
        )
        self.stick(self.approach.walk_to(controller, place, 0.0, -1, dt), self.approach)
        return False

    def _cannot_board(self, controller: PersonController) -> str:
        """Heed the deck; return why the person cannot step onto it, "" if it can."""
        person, view = controller.record, controller.view
        if reason := view.decks.board_solid(person, self.target):
            return reason
        person.deck_wanted = True
        highest = HIGHEST_STEP * float(person.hip_height)
        is_beside = person.known_deck == person.deck and person.deck_share == 0.0
        if is_beside and (rise := self._rise(controller)) > highest:
            return f"too high to step on: {rise:.2f} m, steps up {highest:.2f} m"
        return ""

    def _place(self, controller: PersonController) -> Array:
        """Return (3,) the person's place on the deck [m]."""
        person = controller.record
        if self.spot is None:
            top = self._top(controller)
            place = top.place(top.seat_offset(self.number or 0), 0.0)
            if person.known_deck == person.deck:
                self.spot = person.deck_axes.T @ (place - person.deck_middle)
                self.spot[1] = 0.0
            return place
        place = person.deck_middle + person.deck_axes @ self.spot
        return place

    def _rise(self, controller: PersonController) -> float:
        """Return how high the deck is above the feet at the person's place on it [m]."""
        person, place = controller.record, self._place(controller)
        return deck_height(person, place[0], place[2]) - float(person.floor)

    def leave(self, controller: PersonController) -> None:
        """See `Task`."""
        controller.record.deck_wanted = False
