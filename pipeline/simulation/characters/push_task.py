"""Push task: walking round with a merry-go-round, hands on a post, until it has turned enough.

The person stands outside the rim a little behind its post, leans against it and walks after it; it
pushes the post the harder the slower that turns than it should. The push is a force of a size that
legs can bear: hands that were tied to the post would throw it about with the weight of the body.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.carousel_places import CarouselPose
from pipeline.simulation.characters.carousel_pose import carousel_pose
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_tasks import Approach, Task, place_text, shoulder_height
from pipeline.simulation.characters.playthings import SPOKES
from pipeline.simulation.characters.ride_task import hold_bar, release_bars
from pipeline.simulation.dynamics.gravity import GRAVITY

WANTED_RATE = 0.85  # of a turning merry-go-round [rad/s]
PUSHING_FROUDE = 0.6  # speed of the fastest pusher, in √(g l)
BOARDING_RATE = 0.3  # at which it is pushed while somebody steps on [rad/s]
STARTING_TIME = 3.0  # in which the wanted rate grows [s]
PUSH_FORCE = 0.15  # at full effort, in weights of the pusher
FULL_PUSH_LAG = 0.2  # of the rate, from which it pushes with full effort [rad/s]
RIM_DISTANCE = 0.1  # of the middle of a pusher from the rim, in heights
RIM_CLEARANCE = 0.05  # more of it [m]
POST_REACH = 0.75  # of shoulders from a post, in arm lengths: a stretched arm does not push
POST_AHEAD = 0.45, 0.62  # of its post before a pusher over the ground, in arm lengths
LEAST_LAG = 0.06  # by which a pusher is behind its post, in heights
PUSHING_LEVEL = 0.72  # of the hands, in heights
TOP_MARGIN = 0.05  # of the hands below the top of a post [m]
LOWEST_LEVEL = 0.15  # of them above the foot of a post [m]
HANDS_APART = 0.07  # on a post [m]
UPRIGHT_REACH = 0.8  # of hands below the shoulders without a bow, in arm lengths
LONGEST_STRETCH = 1.08  # of an arm, from which its hand lets go of the post
BRACE = 0.12  # tangent of the lean at full push
INWARD_TURN = math.radians(22.0)  # of a pusher towards its post
FAR_HAND_TURN = math.radians(50.0)  # of one whose only free hand is on the other side
FOLLOW_GAIN = 2.5  # speed of a pusher beyond that of its post, by how far it is behind [1/s]
ROUND_LEAD = 0.3  # ahead along the round to which it walks [rad]
PUSHING_INTERVAL, REACHING_INTERVAL = 4, 2  # of commands with a hand at the post, before [steps]
REACHING_TIME = 4.0  # in which hands get hold of a post [s]
IDLE_TIME = 4.5  # without a turn of a tenth, after which it does not turn [s]
NEAR_RING = 0.25  # of a person from where pushers walk, at which it takes a post [m]
COMING_TIME = 0.3  # by which a person sees where a post will be [s]
BACK_DISTANCE = 0.45  # from the rim to which a pusher steps back, in heights
STEPPING_BACK_TIME = 1.2  # [s]
TURNING_RATE = 0.1  # from which the sense of a turn counts [rad/s]


class Stance(NamedTuple):
    """How a pusher stands at a merry-go-round.

    Attributes:
        ring: distance from the hub [m].
        upright: height to which hands reach down without a bow [m].
        level: height at which it holds a post [m].
        lag: angle by which it is behind its post [rad].
    """

    ring: float
    upright: float
    level: float
    lag: float


def stance_of(controller: PersonController, carousel: CarouselPose) -> Stance:
    """Return how a person stands that pushes a merry-go-round."""
    person, arm, rim = controller.record, controller.arm, carousel.radius
    height, shoulders = float(person.height), shoulder_height(controller)
    ring = rim + RIM_DISTANCE * height + RIM_CLEARANCE
    upright = shoulders - UPRIGHT_REACH * arm
    level = float(person.floor) + PUSHING_LEVEL * height
    lowest = float(carousel.feet[0, 1]) + LOWEST_LEVEL
    top = float(carousel.tops[0, 1])
    # Tall people hold the very top.
    highest = max(top - TOP_MARGIN, min(top, upright))
    level = min(max(level, lowest), highest)
    rise = shoulders - level
    reach = math.sqrt(max((POST_REACH * arm) ** 2 - rise * rise, 0.0))
    reach = min(max(reach, POST_AHEAD[0] * arm), POST_AHEAD[1] * arm)
    behind = math.sqrt(max(reach * reach - (ring - rim) ** 2, 0.0))
    return Stance(ring, upright, level, max(behind, LEAST_LAG * height) / ring)


@dataclass
class PushRound(Task):
    """Push a merry-go-round.

    Attributes:
        owner: its number.
        turns: how far it is turned.
        number: of the post that the person has taken, None before.
        sense: 1 for turns about +Y, -1 for the other way.
        approach: to the rim.
        is_at_rim: whether the person has come to the rim.
        time: since it has a post [s].
        turned: angle by which it has been pushed [rad].
        idle: time since it turned by a tenth of a turn [s].
        mark: angle at that time [rad].
        is_done: whether it has turned enough.
        is_holding: whether a hand holds the post.
    """

    owner: int
    turns: float = 2.0
    number: int | None = field(default=None, init=False)
    sense: float = field(default=1.0, init=False)
    approach: Approach = field(default_factory=Approach, init=False)
    is_at_rim: bool = field(default=False, init=False)
    time: float = field(default=0.0, init=False)
    turned: float = field(default=0.0, init=False)
    idle: float = field(default=0.0, init=False)
    mark: float = field(default=0.0, init=False)
    is_done: bool = field(default=False, init=False)
    is_holding: bool = field(default=False, init=False)

    @property
    def interval(self) -> int:
        """See `Task`; going round is steady."""
        if not self.is_at_rim or self.is_done:
            return 1
        return PUSHING_INTERVAL if self.is_holding else REACHING_INTERVAL

    @property
    def wants_slot(self) -> bool:
        """See `Task`; posts are chosen at the rim, wherever they have turned by then."""
        return self.is_at_rim and self.number is None

    def slot_distance(self, controller: PersonController) -> float:
        """See `Task`."""
        return controller.ground_distance(carousel_pose(controller.view, self.owner).hub)

    def take_slot(self, controller: PersonController) -> None:
        """See `Task`; it is the post that is ahead, or comes by."""
        view = controller.view
        carousel, thing = carousel_pose(view, self.owner), view.names[self.owner]
        free = view.slots.free(thing, SPOKES)
        if not free:
            self.failure = f"all {SPOKES} posts are taken"
            return
        # The merry-go-round is on the left of those who push it about +Y.
        self.sense = -1.0 if self._free_hands(controller) == (1,) else 1.0
        if abs(carousel.rate) > TURNING_RATE:
            self.sense = math.copysign(1.0, carousel.rate)
        own = carousel.angle_of(*controller.record.at.tolist())
        lag = self.sense * stance_of(controller, carousel).lag - COMING_TIME * carousel.rate
        offsets = [carousel.post_angle(n) - lag - own for n in free]
        away = [abs(math.remainder(offset, 2.0 * math.pi)) for offset in offsets]
        self.number = free[away.index(min(away))]
        view.slots.take(thing, self.number, controller.name, float(controller.record.heading))

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        carousel = carousel_pose(controller.view, self.owner)
        if self.is_done:
            return self._step_back(controller, carousel, dt)
        if not self.is_at_rim:
            self._walk_up(controller, carousel, dt)
            return False
        if self.number is None:
            return False
        self.time += dt
        stance = stance_of(controller, carousel)
        self._walk_round(controller, carousel, stance, self.number)
        self.is_holding = self._push(controller, carousel, stance, self.number, dt)
        if not self.is_holding and self.time > REACHING_TIME and self.turned == 0.0:
            self.stick(f"its hands do not reach the post at {place_text(controller)}")
        self.turned += self.sense * carousel.rate * dt if self.is_holding else 0.0
        self.idle += dt
        if self.turned > self.mark + 0.2 * math.pi:
            self.idle, self.mark = 0.0, self.turned
        if self.idle > IDLE_TIME:
            self.failure = f"it does not turn ({carousel.rate:.2f} rad/s)"
        if self.turned >= 2.0 * math.pi * self.turns:
            self.is_done, self.time = True, 0.0
            self.leave(controller)
        return False

    def _step_back(self, controller: PersonController, carousel: CarouselPose, dt: float) -> bool:
        """Step back from the posts that come by; tell whether that is done."""
        person = controller.record
        self.time += dt
        self.pace, self.most_pace = 0.0, math.inf
        if self.time < STEPPING_BACK_TIME:
            distance = carousel.radius + BACK_DISTANCE * float(person.height)
            place = carousel.place(carousel.angle_of(*person.at.tolist()), distance)
            controller.go(place[0], place[2], 0.0, self.owner)
            person.has_facing, person.facing = True, person.heading
        elif self.time < STEPPING_BACK_TIME + dt:
            controller.stop()
            person.has_facing = False
        return self.time >= STEPPING_BACK_TIME and controller.is_standing

    def _free_hands(self, controller: PersonController) -> tuple[int, ...]:
        """Return the hands that hold nothing else than a post."""
        posts = controller.hands_holding(controller.view.names[self.owner])
        return tuple(k for k in range(2) if k in posts or not controller.is_holding(k))

    def _walk_up(self, controller: PersonController, carousel: CarouselPose, dt: float) -> None:
        """Go to the rim."""
        ring = stance_of(controller, carousel).ring
        place = carousel.place(carousel.angle_of(*controller.record.at.tolist()), ring)
        self.stick(self.approach.walk_to(controller, place, 0.0, self.owner, dt), self.approach)
        self.is_at_rim = controller.ground_distance(carousel.hub) < ring + NEAR_RING

    def _walk_round(
        self, controller: PersonController, carousel: CarouselPose, stance: Stance, number: int
    ) -> None:
        """Walk after the post, facing along the round."""
        person, ring = controller.record, stance.ring
        # Feet that swing past the rim need not clear the deck: nobody lifts them so high.
        person.beside_deck = person.stance_on_deck.tolist() == [0, 0]
        own = carousel.angle_of(*person.at.tolist())
        wanted = carousel.post_angle(number) - self.sense * stance.lag
        behind = self.sense * math.remainder(wanted - own, 2.0 * math.pi)
        speed = self.sense * carousel.rate * ring + FOLLOW_GAIN * ring * behind
        aim = carousel.place(own + self.sense * ROUND_LEAD, ring)
        fastest = 1.3 * PUSHING_FROUDE * math.sqrt(GRAVITY * float(person.hip_height))
        self.pace = self.most_pace = min(max(speed, 0.0), fastest)
        if self.most_pace > 0.05:
            way, at = controller.direction_to(aim).tolist(), person.at.tolist()
            controller.go(at[0] + 2.0 * way[0], at[1] + 2.0 * way[2], 0.0, self.owner)
        else:
            controller.stop()
        far_hand = (1,) if self.sense > 0.0 else (0,)
        inward = FAR_HAND_TURN if self._free_hands(controller) == far_hand else INWARD_TURN
        tangent = own + self.sense * (0.5 * math.pi + inward)
        person.has_facing, person.facing = True, math.remainder(tangent, 2.0 * math.pi)

    def _is_crossed(self, controller: PersonController) -> bool:
        """Tell whether somebody is about to step on or off."""
        view = controller.view
        leaving = view.decks.leaving[self.owner]
        leaving -= {k for k in leaving if view.persons[k].deck_share == 0.0}
        return bool(view.decks.boarding[self.owner] or leaving)

    def _push(
        self,
        controller: PersonController,
        carousel: CarouselPose,
        stance: Stance,
        number: int,
        dt: float,
    ) -> bool:
        """Hold the post, and push it on; tell whether a hand holds it."""
        person = controller.record
        fastest = PUSHING_FROUDE * math.sqrt(GRAVITY * float(person.hip_height))
        rate = min(WANTED_RATE, fastest / stance.ring)
        rate *= min(self.time / STARTING_TIME, 1.0)
        is_boarded = self._is_crossed(controller)
        if is_boarded:
            rate, self.idle = min(rate, BOARDING_RATE), 0.0
        lag = rate - self.sense * carousel.rate
        # Nobody slows it down but for somebody who steps on.
        effort = min(max(lag / FULL_PUSH_LAG, -1.0 if is_boarded else 0.0), 1.0)
        person.brace = BRACE * effort
        angle = carousel.post_angle(number) + self.sense * 0.5 * math.pi
        ahead = np.array([math.cos(angle), 0.0, -math.sin(angle)])
        self.leads_hands, upright, level = True, stance.upright, stance.level
        nodes, holds = carousel.post_nodes(number), 0
        for k in range(2):
            own = level if k == 0 else max(level - HANDS_APART, min(level, upright))
            if hold_bar(controller, k, nodes, own, self.owner):
                place = controller.held_place(k)
                stretch = math.dist(controller.shoulder(k).tolist(), place.tolist())
                # Who bows to push would walk with bent knees.
                place[1] = max(float(place[1]), upright)
                controller.put_hand(k, place)
                holds += 1
                if stretch > LONGEST_STRETCH * controller.arm:
                    controller.let_go(k)
        mass = controller.view.masses[controller.owner]
        if holds:
            controller.push_bar(nodes, effort * PUSH_FORCE * mass * GRAVITY * ahead, dt)
        return holds > 0

    def leave(self, controller: PersonController) -> None:
        """See `Task`."""
        release_bars(controller, self.owner)
        self.leads_hands = controller.record.beside_deck = False
