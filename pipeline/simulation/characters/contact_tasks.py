"""Contact tasks: reaching for somebody or something, and grabbing a character."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.grasp import lift_over_knees
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import SWINGING
from pipeline.simulation.characters.person_tasks import (
    Approach,
    Task,
    place_text,
    shoulder_height,
)
from pipeline.simulation.characters.standoff import (
    BOWED_RANGE,
    BOWING_TOLERANCE,
    LEAST_RANGE,
    Standoff,
)
from pipeline.simulation.characters.task_progress import TaskProgress
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
STOPPING_SLACK, STOPPED_SLACK = 0.12, 0.2
"""Distance beyond the range of hands at which a person stops, and sets out again, in arms."""

BOWING_COSINE = math.cos(BOWING_TOLERANCE)  # of the turn to a low place, before a person bows

GRAB_DISTANCE, PATIENT_GRAB_DISTANCE = 0.05, 0.09  # of a hand that closes, in heights
CLOSING_INTERVAL, HELD_INTERVAL = (
    2,
    4,
)  # of commands until hands or arms hold, and after that [steps]


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
        joins: whether one hand brings what it has to the other.
        is_held: whether all hands hold it.
    """

    hands: tuple[int, ...]
    owner: int
    part: str | None = None
    nodes: dict[int, int] = field(default_factory=dict)
    time: float = 0.0
    approach: Approach = field(default_factory=Approach)
    progress: TaskProgress = field(default_factory=TaskProgress)
    standoff: Standoff = field(default_factory=Standoff)
    joins: bool = False
    is_held: bool = False

    @property
    def interval(self) -> int:
        """See `Task`."""
        return HELD_INTERVAL if self.is_held else CLOSING_INTERVAL

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
        self.nodes = self.nodes or self._choose_nodes(controller)
        self.is_held = controller.are_gripping(self.hands)
        if self.is_held:
            self.joins = self.leads_hands = False
            return True
        first = p[self.nodes[self.hands[0]]]
        is_high = first.item(1) - person.floor > 0.4 * person.height
        near = (0.8 if is_high else BOWED_RANGE) * controller.arm
        near += controller.ball_radius(self.owner)
        # One that has stopped does not set out again for what its bow moves it away.
        is_stopped = not person.has_goal or self.standoff.is_stepping
        far = near + (STOPPED_SLACK if is_stopped else STOPPING_SLACK) * controller.arm
        distance = controller.ground_distance(first)
        is_walking = distance > far
        held = controller.hands_holding(controller.view.names[self.owner])
        # What hangs from one hand is neither run after nor stepped off from.
        is_ready = not is_walking and (is_high or self._is_bowed_to(controller, first, distance))
        joined_before = self.joins
        self.joins = self.leads_hands = bool(held) and (joined_before or not is_ready)
        if self.joins:
            self.progress = self.progress if joined_before else TaskProgress()
            self._join_hands(controller, held, dt)
            return False
        if is_walking and not self.standoff.is_stepping:
            if self.part is None:
                self.nodes.clear()
            for k in self.hands:
                if not controller.is_holding(k):
                    person.arm_mode[k] = SWINGING
            partner = self.giver if self.giver >= 0 else self.owner
            reason = self.approach.walk_to(controller, first, near, partner, dt)
            self.stick(reason, self.approach)
            return False
        if person.has_goal and not self.standoff.is_stepping:
            self.progress = TaskProgress()
            controller.face_to(first)
        if is_high or self._gets_down(controller, first, dt):
            self._close_hands(controller, dt)
        return False

    def _choose_nodes(self, controller: PersonController) -> dict[int, int]:
        """Return the node of each hand; two hands take two, near them and about the middle.

        A hand that holds one keeps it.
        """
        view = controller.view
        first, count = (int(n) for n in view.arrays.owners[self.owner].nodes)
        if self.part is not None or len(self.hands) < 2 or count < 2:
            return {k: controller.node_to_grip(self.owner, self.part, k) for k in self.hands}
        places = view.nodes(self.owner)
        left, right = (np.linalg.norm(places - controller.hand(k), axis=1) for k in range(2))
        middles = 0.5 * (places[:, None] + places) - places.mean(axis=0)
        cost = left[:, None] + right + np.linalg.norm(middles[..., [0, 2]], axis=-1)
        np.fill_diagonal(cost, math.inf)
        held = [controller.held_node(k) - first for k in range(2)]
        if 0 <= held[0] < count:
            cost[np.arange(count) != held[0]] = math.inf
        if 0 <= held[1] < count:
            cost[:, np.arange(count) != held[1]] = math.inf
        i, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
        return {0: first + int(i), 1: first + int(j)}

    def _is_bowed_to(self, controller: PersonController, place: Array, distance: float) -> bool:
        """Tell whether a person at a distance from a low place [m] can bow to it without a step."""
        if self.standoff.is_stepping or distance < LEAST_RANGE * controller.arm:
            return False
        return controller.cosine_to(place) > BOWING_COSINE

    def _join_hands(self, controller: PersonController, held: tuple[int, ...], dt: float) -> None:
        """Bring what one hand holds before the waist, and close the other around it."""
        controller.stop()
        view, farthest = controller.view, 0.0
        radius = controller.ball_radius(self.owner)
        flat = view.nodes(self.owner) - view.nodes(self.owner).mean(axis=0)
        right = np.array([-controller.ahead[2], 0.0, controller.ahead[0]])
        width, depth = (float(np.abs(flat @ axis).max()) for axis in (right, controller.ahead))
        self.nodes = self._choose_nodes(controller)
        for k in {*held, *self.hands}:
            if k in held:
                controller.lead_hand(k, controller.place_before(k, width, depth))
                continue
            place = view.p[self.nodes[k]]
            controller.lead_hand(k, place)
            distance = math.dist(controller.hand(k), place)
            farthest = max(farthest, distance)
            if distance < PATIENT_GRAB_DISTANCE * controller.record.height + radius:
                controller.grip(k, self.nodes[k])
        self._check_progress(controller, farthest, dt)

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
        height, radius = controller.record.height, controller.ball_radius(self.owner)
        self.time += dt
        closing = GRAB_DISTANCE if self.time < PATIENCE else PATIENT_GRAB_DISTANCE
        farthest = 0.0
        for k in self.hands:
            node = self.nodes[k]
            middle = place = controller.view.p[node]
            if radius > 0.0:
                # A ball is taken from this side.
                place = middle - radius * controller.direction_to(middle)
            controller.put_hand(k, place + lift_over_knees(controller, k, place))
            distance = math.dist(controller.hand(k).tolist(), middle.tolist())
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
