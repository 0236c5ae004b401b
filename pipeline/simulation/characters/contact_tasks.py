"""Contact tasks: reaching, grabbing, hugging and grappling.

Source: Horswill 2008, "Hugging" and "Grappling".
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.grasp import lift_over_knees
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import (
    PELVIS,
    REACHING,
    SHOULDERS,
    SPINE,
    SWINGING,
)
from pipeline.simulation.characters.person_tasks import Approach, Task, place_text
from pipeline.simulation.characters.standoff import BOWED_RANGE, BOWING_TOLERANCE, Standoff
from pipeline.simulation.characters.task_progress import TaskProgress
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.spatial import Array

GRAB_PATIENCE = 2.5  # without coming nearer [s]
PATIENCE = 1.6
"""Time after which a hand is near enough to a place that it cannot quite reach [s]."""

STANDING_RANGE = 0.75  # of hands before an upright body, in arm lengths
REACHING_TIME = 0.5  # of a hand that comes no nearer, after which the person turns and steps [s]
REACHING_RANGE = 0.55  # of hands before an upright body that has stepped up, in arm lengths
BEHIND = math.radians(100.0)  # turn to a place beyond which no hand reaches it
REACHING_TOLERANCE = math.radians(30.0)  # of the turn to a place that a hand reaches for
HIGHEST_REACH = 0.3  # of a hand on a taller person, above the own shoulder, in arm lengths
FARTHEST_STEPS = 1.5  # of a person that steps to where its hand reaches [m]
HAND_BREADTH = 0.06  # within which a hand counts as there in the end, in heights
BEYOND_REACH = 0.4  # from its place at which a hand that was there sinks again, in arm lengths
PALM_OFFSET = 0.045  # of the wrist from a surface that the hand touches, in heights
CHEST_DEPTH = 0.06  # of a chest before its middle, in heights
HAND_AT_PLACE = 0.04  # distance at which a hand has reached a place, in heights
HANDED_MASS = 0.1  # below which a thing goes from hand to hand, in the person's mass
GRAB_DISTANCE, PATIENT_GRAB_DISTANCE = 0.05, 0.09  # of a hand that closes, in heights


@dataclass(frozen=True)
class HugShape:
    """Where arms go in a hug; lengths in heights of the partner or the person.

    Attributes:
        chest_radius: of either of the two.
        back_depth: of a back behind the spine, where hands lie that cannot meet.
        waist: height of the narrowest place of a trunk above the pelvis.
        hands_joined: distance of hands that join.
        reach: largest part of an arm's reach to go around with.
        closing_time: of the arms [s].
    """

    chest_radius: float = 0.075
    back_depth: float = 0.055
    waist: float = 0.085
    hands_joined: float = 0.06
    reach: float = 0.95
    closing_time: float = 0.7


HUG = HugShape()

SHOVE_RANGE = 0.5  # of who shoves from the middle of the other, in arm lengths
SHOVING_RATE = 3.0  # speed of the last steps to a shove, by the distance that is left [1/s]
STEP_BACK = 0.25  # after a hug that an order ends [m]
OPEN_TIME = 0.7  # of the arms after a hug [s]
HUG_REACHED = 0.06  # from touching, within which arms close [m]
LOST_HUG = 0.45  # from touching, at which a partner is gone, in arm lengths
HUG_DEPTH = 0.02  # by which two press against each other [m]
COMING_TIME = 0.12  # over which the speed of a partner is averaged [s]
CLOSING_RATE = 1.2  # speed of the last steps, by the distance from touching [1/s]
SLOWEST_FROUDE = 0.07  # of these steps, in √(g l); the knee of a faster one strikes the partner
LEAST_APPROACH = 0.3  # of both together, below which one walks the whole way [m/s]
EMBRACE_DESCENT = 0.8  # of the hands below the own shoulders at most, in arm lengths


@dataclass
class Reach(Task):
    """Hold hands out to a place or to a character.

    Attributes:
        hands: numbers of the hands.
        place: (3,) [m]; None for a character or a member of another room.
        owner: number of the character.
        target: name of the member of another room, "" for none.
        time: since the start [s].
        progress: of the hand that is farthest off.
        steps: whether the person turns and steps to where its hands reach.
        approach: of these steps.
        has_reached: whether all hands were near enough.
        beyond: time for which a hand has been far off [s].
    """

    hands: tuple[int, ...]
    place: Array | None
    owner: int = -1
    target: str = ""
    time: float = 0.0
    progress: TaskProgress = field(default_factory=TaskProgress)
    steps: bool = False
    approach: Approach = field(default_factory=Approach)
    has_reached: bool = False
    beyond: float = 0.0

    @property
    def members(self) -> tuple[str, ...]:
        """See `Task`."""
        return (self.target,) if self.target else ()

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        self.time += dt
        if not self.has_reached and self._steps_nearer(controller, dt):
            self.progress = TaskProgress()
            for k in self.hands:
                if not controller.is_holding(k):
                    controller.record.arm_mode[k] = SWINGING
            return False
        farthest, height = 0.0, float(controller.record.height)
        for k in self.hands:
            place = self._place(controller, k)
            controller.put_hand(k, place)
            farthest = max(farthest, math.dist(controller.hand(k), place))
        is_late = self.time > PATIENCE and farthest < HAND_BREADTH * height
        self.has_reached |= is_late or farthest < HAND_AT_PLACE * height
        if not self.has_reached and self.progress.update(farthest, dt) > PATIENCE:
            self.failure = f"{farthest:.2f} m out of reach at {place_text(controller)}"
        if self.has_reached and self.steps:
            self.steps = controller.record.has_facing = False
        self.beyond = self.beyond + dt if farthest > BEYOND_REACH * controller.arm else 0.0
        self.is_lost = self.has_reached and self.beyond > PATIENCE
        return self.has_reached

    def _steps_nearer(self, controller: PersonController, dt: float) -> bool:
        """Turn and step to where the hands reach, if they do not; tell whether that goes on."""
        person = controller.record
        place = np.mean([self._place(controller, k) for k in self.hands], axis=0)
        if not self.steps and controller.is_standing:
            way = controller.direction_to(place)
            is_behind = float(way @ controller.ahead) < math.cos(BEHIND)
            self.steps = is_behind or self.progress.time > REACHING_TIME
        is_high = place[1] - person.floor > 0.4 * person.height
        near = (REACHING_RANGE if is_high else BOWED_RANGE) * controller.arm
        left = controller.ground_distance(place) - near
        is_above = place[1] - shoulder_height(controller) > controller.arm
        if not self.steps or is_above or left > FARTHEST_STEPS:
            return False
        if left > 0.12 * controller.arm:
            self.stick(self.approach.walk_to(controller, place, near, self.owner, dt))
            return True
        controller.face_to(place)
        return not (controller.is_facing(REACHING_TOLERANCE) and controller.is_standing)

    def _place(self, controller: PersonController, k: int) -> Array:
        """Return (3,) where a hand goes [m]."""
        if self.place is not None:
            return self.place
        # The palm touches the surface, not the wrist.
        shoulder, off = controller.shoulder(k), PALM_OFFSET * float(controller.record.height)
        if self.target:
            place = controller.view.state(self.target).nearest(shoulder)
        else:
            place = controller.view.middle(self.owner)
            if self.owner in controller.view.people:
                off += CHEST_DEPTH * controller.view.size(self.owner)
                # As high as a smaller one reaches.
                highest = float(shoulder[1]) + HIGHEST_REACH * controller.arm
                place = np.array([place[0], min(float(place[1]), highest), place[2]])
        size = max(math.dist(shoulder, place), 1e-9)
        share = min(off / size, 1.0)
        surface: Array = place + share * (shoulder - place)
        return surface


@dataclass
class Grab(Task):
    """Go to a character and close hands around it.

    Attributes:
        hands: numbers of the hands.
        owner: number of the character.
        part: the joint to take, None for the nearest node.
        nodes: node of each hand that is on its way or grips.
        time: since it is near [s].
        approach: to it.
        progress: of the hands.
        standoff: from low things.
    """

    hands: tuple[int, ...]
    owner: int
    part: str | None = None
    nodes: dict[int, int] = field(default_factory=dict)
    time: float = 0.0
    approach: Approach = field(default_factory=Approach)
    progress: TaskProgress = field(default_factory=TaskProgress)
    standoff: Standoff = field(default_factory=Standoff)

    def asks_for(self, controller: PersonController) -> str:
        """See `Task`; what is light is handed over, heavy things are held by several."""
        owners = controller.view.arrays.owners
        is_light = (
            owners["mass"][self.owner] < HANDED_MASS * owners["mass"][controller.record.owner]
        )
        return controller.view.names[self.owner] if is_light and self.part is None else ""

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        person, p = controller.record, controller.view.p
        for k in self.hands:
            self.nodes.setdefault(k, controller.node_to_grip(self.owner, self.part, k))
        if all(controller.held_node(k) >= 0 for k in self.hands):
            return True
        first = p[self.nodes[self.hands[0]]]
        is_high = first[1] - person.floor > 0.4 * person.height
        near = (0.8 if is_high else BOWED_RANGE) * controller.arm
        near += controller.ball_radius(self.owner)
        is_walking = controller.ground_distance(first) > near + 0.12 * controller.arm
        if is_walking and not self.standoff.is_stepping:
            if self.part is None:
                self.nodes.clear()
            reason = self.approach.walk_to(controller, first, near, self.owner, dt)
            self.stick(reason, self.approach)
            return False
        if person.has_goal and not self.standoff.is_stepping:
            self.progress = TaskProgress()
            controller.face_to(first)
        if is_high or self._gets_down(controller, first, dt):
            self._close_hands(controller, dt)
        return False

    def _gets_down(self, controller: PersonController, place: Array, dt: float) -> bool:
        """Step off from a low place that is too near, turn to it, and tell when to bow."""
        if not self.standoff.is_kept(controller, place, place, dt, self.progress.time):
            self.progress, self.time = TaskProgress(), 0.0
            return False
        controller.face_to(place)
        if controller.is_facing(BOWING_TOLERANCE):
            return True
        self._check_progress(controller, controller.turn_left, dt)
        return False

    def _close_hands(self, controller: PersonController, dt: float) -> None:
        """Send hands to their nodes, and close each that is there."""
        p, height = controller.view.p, controller.record.height
        radius = controller.ball_radius(self.owner)
        self.time += dt
        closing = GRAB_DISTANCE if self.time < PATIENCE else PATIENT_GRAB_DISTANCE
        farthest = 0.0
        for k in self.hands:
            node = self.nodes[k]
            # A ball is taken from this side.
            place = p[node] - radius * controller.direction_to(p[node])
            controller.put_hand(k, place + lift_over_knees(controller, k, place))
            distance = math.dist(controller.hand(k), p[node])
            if not controller.is_holding(k):
                farthest = max(farthest, distance)
            if distance < closing * height + radius:
                controller.grip(k, node)
                controller.record.has_facing = False
        self._check_progress(controller, farthest, dt)

    def _check_progress(self, controller: PersonController, distance: float, dt: float) -> None:
        """Give up what comes no nearer."""
        if self.progress.update(distance, dt) <= GRAB_PATIENCE:
            return
        held = [k for k in self.hands if controller.is_holding(k)]
        for k in held:
            controller.let_go(k)
        only = "lets go again: the other hand " if held else ""
        self.stick(f"{only}stays {distance:.2f} m out of reach at {place_text(controller)}")


@dataclass
class Encounter:
    """Two who come to each other, as one of them sees it.

    Two who each slow down before the place of the other meet at full speed: they slow down before
    the place where they meet.

    Attributes:
        coming: speed at which the partner comes nearer [m/s].
        seen: place of the partner (3,) at the step before [m].
    """

    coming: float = 0.0
    seen: Array | None = None

    def share_of_way(
        self, controller: PersonController, partner: Array, touching: float, dt: float
    ) -> float:
        """Return how much of the way the partner comes itself [m].

        Args:
            controller: of the person.
            partner: (3,) where the partner is [m].
            touching: distance at which the way ends [m].
            dt: time since the last call [s].
        """
        ahead = controller.direction_to(partner)
        moved = np.zeros(3) if self.seen is None else partner - self.seen
        self.seen = partner.copy()
        share = min(dt / COMING_TIME, 1.0)
        self.coming += share * (max(-float(moved @ ahead) / dt, 0.0) - self.coming)
        own = math.hypot(*controller.record.velocity)
        left = max(controller.ground_distance(partner) - touching, 0.0)
        return left * self.coming / max(self.coming + own, LEAST_APPROACH)


def closing_pace(controller: PersonController, left: float, rate: float = CLOSING_RATE) -> float:
    """Return the pace of the last steps to a person [m/s].

    Args:
        controller: of the person.
        left: distance from touching [m].
        rate: at which the distance closes [1/s].
    """
    slowest = SLOWEST_FROUDE * math.sqrt(GRAVITY * float(controller.record.hip_height))
    return max(rate * left, slowest)


@dataclass
class Hug(Task):
    """Go to a character, put both arms around it, and join the hands.

    Attributes:
        owner: number of the partner.
        size: height of the partner [m].
        touched: time since the two touch [s], 0 before.
        encounter: with the partner.
        is_gentle: whether the last steps are slow.
        is_near: whether the person has opened its arms.
        is_answered: whether the partner has accepted or declined.
        approach: to the partner.
    """

    owner: int
    size: float
    touched: float = 0.0
    encounter: Encounter = field(default_factory=Encounter)
    is_gentle: bool = True
    is_near: bool = False
    is_answered: bool = False
    approach: Approach = field(default_factory=Approach)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        person = controller.record
        partner = controller.view.pelvis(self.owner)
        closeness = HUG.chest_radius * (person.height + self.size)
        distance = controller.ground_distance(partner)
        if self.touched == 0.0 and distance > closeness + HUG_REACHED:
            share = self.encounter.share_of_way(controller, partner, closeness, dt)
            stop = closeness - HUG_DEPTH + share
            reason = self.approach.walk_to(controller, partner, stop, self.owner, dt)
            self.stick(reason, self.approach)
            if self.is_gentle:
                self.most_pace = closing_pace(controller, distance - closeness - share)
            if distance < closeness + 1.1 * controller.arm:
                self.is_near = True
                # Bowing only once the partner is there would knock heads.
                self._bow(controller)
                self._open_arms(controller)
            return False
        self.most_pace = math.inf
        if self.touched == 0.0:
            controller.face_to(partner)
        elif distance > closeness + LOST_HUG * controller.arm:
            # In a hug a person lets its partner go, and does not reach after it.
            self.is_lost, self.touched = self.touched > PATIENCE, 0.0
            controller.part_hands()
            return self.is_lost
        self.touched += dt
        self._bow(controller)
        self._close_arms(controller, partner)
        if self.touched > HUG.closing_time:
            gap = math.dist(controller.hand(0), controller.hand(1))
            if gap < HUG.hands_joined * person.height:
                controller.join_hands()
        return self.touched > PATIENCE

    def _bow(self, controller: PersonController) -> None:
        level = self._arm_level(controller, 0)
        controller.record.stoop_depth = max(
            shoulder_height(controller) - level - 0.3 * controller.arm, 0.0
        )

    def loosen(self, controller: PersonController, dt: float) -> bool:
        """Open the arms as they were closed; tell whether they are open."""
        controller.part_hands()
        self.touched = max(min(self.touched, HUG.closing_time) - dt, 1e-6)
        self._close_arms(controller, controller.view.pelvis(self.owner))
        return self.touched <= dt

    def _arm_level(self, controller: PersonController, k: int) -> float:
        """Return the height at which an arm goes around: one under, one over the partner's."""
        nodes = controller.view.nodes(self.owner)
        low, high = float(nodes[PELVIS, 1]), float(nodes[SHOULDERS, 1])
        person = controller.record
        own = shoulder_height(controller)
        # The taller one's arms go over, the smaller one's under.
        is_taller = person.height > 1.05 * self.size
        top = high + (0.02 if is_taller else -0.06) * self.size
        # Round the waist at the lowest: no arm is long enough for hips.
        level = min(max(own - 0.1 * person.height, low + HUG.waist * self.size), top)
        apart = (0.01 if is_taller else 0.03) * person.height
        return float(level + (apart if k == 0 else -apart))

    def _open_arms(self, controller: PersonController) -> None:
        """Hold both arms out, wide enough for the partner's shoulders."""
        person = controller.record
        controller.embrace(self.owner)
        ahead = controller.direction_to(controller.view.pelvis(self.owner))
        right = np.array([-ahead[2], 0.0, ahead[0]])
        start = np.array([person.at[0], 0.0, person.at[1]])
        for k in range(2):
            side = (1.0 if k == 1 else -1.0) * (0.15 * self.size + 0.03)
            place = start + 0.85 * controller.arm * ahead + side * right
            place[1] = self._arm_level(controller, k)
            controller.put_hand_around(k, place)

    def _close_arms(self, controller: PersonController, partner: Array) -> None:
        """Bring the hands together behind the partner's back."""
        person = controller.record
        controller.embrace(self.owner)
        ahead = controller.direction_to(partner)
        right = np.array([-ahead[2], 0.0, ahead[0]])
        full = HUG.chest_radius * self.size + 0.035 * person.height
        reach = math.sqrt(max(controller.arm**2 - float(person.shoulders) ** 2, 0.0))
        # First past the partner's sides, then together.
        closed = min(self.touched / HUG.closing_time, 1.0)
        wide = (1.0 - closed) * 0.13 * self.size + 0.02 * self.size
        for k in range(2):
            side = (1.0 if k == 1 else -1.0) * wide
            level = self._arm_level(controller, k)
            spine = controller.view.nodes(self.owner)[[PELVIS, SPINE, SHOULDERS]]
            x, z = (np.interp(level, spine[:, 1], spine[:, c]) for c in (0, 2))
            middle = np.array([x, level, z])
            beyond = HUG.reach * reach - controller.ground_distance(middle)
            behind = min(full, max(beyond, HUG.back_depth * self.size))
            controller.put_hand_around(k, middle + behind * ahead + side * right)


def shoulder_height(controller: PersonController) -> float:
    """Return the height of the shoulders in standing upright [m]."""
    person = controller.record
    return float(person.floor + person.hip_height + person.belly + person.chest)


@dataclass
class LoosenHug(Task):
    """Open the arms around a partner and step back, so that no arm is torn out.

    Attributes:
        hug: that ends.
        back: distance to step back [m].
        time: since the arms are open [s].
    """

    hug: Hug
    back: float = 0.0
    time: float = 0.0

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.time > 0.0 or self.hug.loosen(controller, dt):
            if self.time == 0.0:
                self._step_back(controller)
            self.time += dt
        self.is_lost = self.time > OPEN_TIME
        return self.is_lost

    def _step_back(self, controller: PersonController) -> None:
        """Let the arms sink, and step back facing the partner."""
        person = controller.record
        partner = controller.view.pelvis(self.hug.owner)
        x, z = person.at[0] - partner[0], person.at[1] - partner[2]
        share = self.back / max(math.hypot(x, z), 0.1)
        controller.go(person.at[0] + share * x, person.at[1] + share * z)
        person.has_facing, person.facing = True, math.atan2(z, -x)
        for k in range(2):
            if not controller.is_holding(k):
                person.arm_mode[k] = SWINGING


@dataclass
class ReturnHug(Task):
    """Put both hands on the back of an approaching partner, without a step and without bowing.

    Attributes:
        owner: number of the partner.
        size: height of the partner [m].
        opens: whether the hands come off again.
        time: since they do, or since the start [s].
    """

    owner: int
    size: float
    opens: bool = False
    time: float = 0.0

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        person = controller.record
        if self.time == 0.0:
            controller.stop()
            person.has_facing = False
        controller.embrace(self.owner)
        self.time += dt
        partner = controller.view.middle(self.owner)
        ahead = np.array([partner[0] - person.at[0], partner[2] - person.at[1]])
        ahead /= max(math.hypot(ahead[0], ahead[1]), 1e-6)
        share = min(self.time / HUG.closing_time, 1.0)
        wide = self.size * (0.2 - 0.14 * (1.0 - share if self.opens else share))
        lowest = shoulder_height(controller) - EMBRACE_DESCENT * controller.arm
        level = max(float(partner[1]) - 0.03 * self.size, lowest)
        for k in range(2):
            side = wide if k == 1 else -wide
            x = partner[0] + 0.11 * self.size * ahead[0] - side * ahead[1]
            z = partner[2] + 0.11 * self.size * ahead[1] + side * ahead[0]
            controller.put_hand(k, np.array([x, level, z]))
        return self.time > HUG.closing_time


@dataclass
class Grapple(Task):
    """Go to a character with both arms ahead.

    Attributes:
        owner: number of the character.
        time: since the arms came up [s].
        encounter: with it.
        approach: to it.
    """

    owner: int
    time: float = 0.0
    encounter: Encounter = field(default_factory=Encounter)
    approach: Approach = field(default_factory=Approach)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.time > PATIENCE:
            return True
        partner, stop = controller.view.pelvis(self.owner), SHOVE_RANGE * controller.arm
        share = self.encounter.share_of_way(controller, partner, stop, dt)
        reason = self.approach.walk_to(controller, partner, stop + share, self.owner, dt)
        distance = controller.ground_distance(partner)
        self.most_pace = closing_pace(controller, distance - stop - share, SHOVING_RATE)
        is_near = distance < 1.3 * controller.arm
        for k in range(2):
            if not controller.is_holding(k):
                controller.record.arm_mode[k] = REACHING if is_near else SWINGING
        if is_near:
            self.time += dt
        else:
            self.stick(reason, self.approach)
        if self.time > PATIENCE:
            controller.stop()
            for k in range(2):
                if not controller.is_holding(k):
                    controller.record.arm_mode[k] = SWINGING
        return self.time > PATIENCE
