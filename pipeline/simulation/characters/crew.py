"""Crew: two people that carry one thing together, each at an end of it.

Both are told to carry the same thing to the same place. They go to its two ends, wait for one
another, take it at the same time, walk facing it, and put it down at the same time. When one of
them is called away, the other puts it down and gives up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.contact_tasks import PATIENCE
from pipeline.simulation.characters.grasp import (
    PALM,
    grasp_failure,
    half_extent,
    lift_over_knees,
)
from pipeline.simulation.characters.handling_tasks import (
    AT_GOAL,
    OPENING_TIME,
    PUT_DOWN_GAP,
    PUT_DOWN_TIME,
)
from pipeline.simulation.characters.held_bar import nearest_standing_edge
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import SWINGING
from pipeline.simulation.characters.person_tasks import Approach, Task, place_text
from pipeline.simulation.characters.standoff import Standoff
from pipeline.simulation.members import MemberState
from pipeline.simulation.spatial import Array

STANDOFF = 0.8  # of the middle of a body from where its hands take the thing, in arm lengths
INWARD = 0.3  # of the hands from the end of the thing, in half its length at most
MOST_INWARD = 0.08  # [m]
AT_END, NEAR_END = 0.1, 0.2  # of a body from its place, to get there and to be there still [m]
FACING_TOLERANCE = math.radians(12.0)
CLOSING, PATIENT_CLOSING = 0.04, 0.1  # of a hand to its place, in heights
OPENING, WIDEST_OPENING = 0.5, 0.08  # of a hand beside its place, by how far it is; in heights
CARRYING_HEIGHT = 0.42  # of the hands, in heights of the smaller one
CARRYING_PACE = 0.45  # of the usual one
LEAD_TIME = 0.5  # by which each goes ahead of where it should be [s]
LAG = 0.25  # behind its place at which the other waits [m]
GATHERING_TIME = 8.0  # since somebody last walked, after which both give up [s]
TAKING_TIME = 6.0  # after which both begin anew, and then give up [s]
WALKING_TIME = 4.0  # without getting on, after which both put it down [s]
LIFTING_TIME = 1.2  # [s]
MOST_TRIES = 2  # to take it


class Stage(IntEnum):
    """What a crew is at."""

    GATHER = 0
    TAKE = 1
    LIFT = 2
    WALK = 3
    LOWER = 4
    DONE = 5


@dataclass(eq=False)
class Crew:
    """Two people and what they carry.

    Attributes:
        thing: its name.
        target: name of where it goes.
        people: the two, the first at the far end of `along`.
        along: (3,) level direction from the second to the first.
        stage: what they are at.
        time: since the stage began [s].
        middle: (3,) where the middle between them should be [m].
        hands: (2, 2, 3) places of the hands on the thing, from its middle, by person and hand [m].
        ready: which of them are.
        steps: for which each has taken part.
        tries: how often both have tried to take it.
        reason: why they give up, "" while they do not.
    """

    thing: str
    target: str
    people: Sequence[PersonController]
    along: Array
    stage: Stage = Stage.GATHER
    time: float = 0.0
    middle: Array = field(default_factory=lambda: np.zeros(3))
    hands: Array = field(default_factory=lambda: np.zeros((2, 2, 3)))
    ready: list[bool] = field(default_factory=lambda: [False, False])
    steps: list[int] = field(default_factory=lambda: [0, 0])
    tries: int = 0
    reason: str = ""

    @property
    def across(self) -> Array:
        """(3,) level direction across `along`, to the right of the second person."""
        return np.array([-self.along[2], 0.0, self.along[0]])

    def side(self, number: int) -> float:
        """Return on which side of the thing along `along` a person is."""
        return 1.0 if number == 0 else -1.0

    def go_on(self, stage: Stage) -> None:
        """Begin a stage."""
        self.stage, self.time, self.ready = stage, 0.0, [False, False]

    def advance(self, dt: float) -> None:
        """Advance the stage by a step, once for both and before either acts."""
        self.time += dt
        if self.stage is Stage.WALK:
            self._lead(dt)
        elif self.stage is Stage.LIFT and self.time > LIFTING_TIME:
            self._set_out()
        elif all(self.ready) and self.stage is not Stage.DONE:
            self.go_on(Stage(self.stage + 1))
        elif self.stage is Stage.GATHER and self.time > GATHERING_TIME:
            late = self.people[self.ready.index(False)]
            self.reason = f"{late.name} does not come to the other end at {place_text(late)}"
        elif self.stage is Stage.TAKE and self.time > TAKING_TIME:
            self.tries += 1
            if self.tries < MOST_TRIES:
                self.go_on(Stage.GATHER)
            else:
                self.reason = "both cannot take it at once"

    def _set_out(self) -> None:
        self.go_on(Stage.WALK)
        at = [np.array(one.record.at) for one in self.people]
        self.middle = 0.5 * np.array([at[0][0] + at[1][0], 0.0, at[0][1] + at[1][1]])

    def _lead(self, dt: float) -> None:
        """Move the middle on towards the target, as fast as both follow."""
        offset = self.people[0].view.state(self.target).centre - self.middle
        offset[1] = 0.0
        left = math.hypot(offset[0], offset[2])
        lags = [one.ground_distance(self.place(k)) for k, one in enumerate(self.people)]
        is_late = max(lags) >= LAG
        if left > 1e-3 and not is_late:
            pace = CARRYING_PACE * min(float(one.record.pace) for one in self.people)
            self.middle = self.middle + offset / left * min(pace * dt, left)
            self.time = 0.0
        elif not is_late and all(not one.record.stepping for one in self.people):
            self.go_on(Stage.LOWER)
        elif self.time > WALKING_TIME:
            late = self.people[lags.index(max(lags))]
            self.reason = f"the way is blocked at {place_text(late)}; puts it down"

    def miss(self) -> str:
        """Return how far from its goal the thing is, "" if it is there."""
        view = self.people[0].view
        offset = view.state(self.thing).centre - view.state(self.target).centre
        distance = math.hypot(offset[0], offset[2])
        return "" if distance < AT_GOAL else f"it lies {distance:.2g} m off '{self.target}'"

    def place(self, number: int) -> Array:
        """Return (3,) where a person should be while both walk [m]."""
        reach = np.abs(self.hands[number] @ self.along).max()
        distance = float(reach) + STANDOFF * self.people[number].arm
        place: Array = self.middle + self.side(number) * distance * self.along
        return place


def crew_of(thing: str, target: str, people: Sequence[PersonController]) -> Crew:
    """Return two people as a crew, each at the end of the thing that is nearer to it."""
    state = people[0].view.state(thing)
    points = np.concatenate(state.solids)[:, [0, 2]]
    flat = points - points.mean(axis=0)
    values, vectors = np.linalg.eigh(flat.T @ flat)
    at = [np.array(one.record.at) - state.centre[[0, 2]] for one in people]
    axis = vectors[:, 1]
    if values[1] < 1.1 * values[0]:
        # As long as it is wide: the side that is nearer to the way of the two.
        way = at[0] - at[1]
        axis = max((vectors[:, k] for k in range(2)), key=lambda v: abs(float(v @ way)))
    if float(axis @ (at[0] - at[1])) < 0.0:
        axis = -axis
    crew = Crew(thing, target, people, np.array([axis[0], 0.0, axis[1]]))
    half_length, half_width = half_extent(state, crew.along), half_extent(state, crew.across)
    inward = min(INWARD * half_length, MOST_INWARD)
    for number, one in enumerate(people):
        palm = PALM * float(one.record.height)
        aside = min(half_width, 1.3 * float(one.record.shoulders)) + 0.4 * palm
        for k in range(2):
            # The first faces back along the axis, so that its right is the second's left.
            right = -crew.side(number) * (1.0 if k == 1 else -1.0)
            crew.hands[number, k] = (
                crew.side(number) * (half_length - inward) * crew.along
                + right * aside * crew.across
            )
    return crew


@dataclass
class CarryEnd(Task):
    """Carry one end of a thing.

    Attributes:
        crew: the two people.
        number: of the person in the crew.
        approach: to the end.
        standoff: from the thing, to bow.
        is_there: whether the person has got to its end.
        has_taken: whether its hands have closed around the end.
        time: since the hands are open [s].
    """

    crew: Crew
    number: int
    approach: Approach = field(default_factory=Approach)
    standoff: Standoff = field(default_factory=Standoff)
    is_there: bool = False
    has_taken: bool = False
    time: float = 0.0

    @property
    def members(self) -> tuple[str, ...]:
        """See `Task`."""
        return (self.crew.thing, self.crew.target)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        crew = self.crew
        state = controller.view.state(crew.thing)
        crew.steps[self.number] += 1
        other = 1 - self.number
        if crew.steps[self.number] > crew.steps[other] + 2 and crew.stage is not Stage.DONE:
            crew.reason = crew.reason or f"{crew.people[other].name} has left it"
        self.leads_hands = crew.stage in (Stage.LIFT, Stage.WALK, Stage.LOWER)
        if self.leads_hands:
            self._keep_hold(controller)
        if reason := crew.reason or self._unfit(controller):
            self.release(controller)
            self.failure = reason
            return False
        if crew.stage is Stage.GATHER:
            self._gather(controller, state, dt)
        elif crew.stage is Stage.TAKE:
            self._take(controller, state, dt)
        elif crew.stage in (Stage.LIFT, Stage.WALK):
            self._carry(controller)
        elif crew.stage is Stage.LOWER:
            self._lower(controller, state)
        else:
            self.release(controller)
            self.time += dt
            if self.time > OPENING_TIME:
                self.failure = crew.miss()
        return self.time > OPENING_TIME and not self.failure

    def _keep_hold(self, controller: PersonController) -> None:
        """Close the hands around the end, once, and give up when they have lost it."""
        crew, view = self.crew, controller.view
        if not self.has_taken:
            self.has_taken = True
            owner = view.owner(crew.thing)
            if owner < 0:
                controller.hold_member(crew.thing, (0, 1))
            else:
                for k in range(2):
                    self._grip(controller, owner, k)
        elif len(controller.hands_holding(crew.thing)) < 2:
            crew.reason = crew.reason or f"{controller.name} has lost hold of it"

    def _grip(self, controller: PersonController, owner: int, k: int) -> None:
        """Close a hand around a character: of a box the edge that stands nearest."""
        arrays = controller.view.arrays
        if arrays.owners[owner].edge_radius > 0.0:
            edge = nearest_standing_edge(arrays, owner, controller.hand(k))
            controller.grip(k, edge.node, edge.far, edge.share)
        else:
            controller.grip(k, controller.node_to_grip(owner, None, k))

    def _unfit(self, controller: PersonController) -> str:
        """Return why the person cannot hold its end, "" if it can."""
        return grasp_failure(controller, self.crew.thing, (0, 1), share=0.5)

    def release(self, controller: PersonController) -> None:
        """Open the hands."""
        for k in range(2):
            if k in controller.hands_holding(self.crew.thing):
                controller.let_go(k)
        controller.record.has_facing = False

    def _spot(self, state: MemberState, controller: PersonController) -> Array:
        """Return (3,) where the person stands at its end [m]."""
        crew = self.crew
        reach = float(np.abs(crew.hands[self.number] @ crew.along).max())
        distance = reach + STANDOFF * controller.arm
        place: Array = state.centre + crew.side(self.number) * distance * crew.along
        return place

    def _gather(self, controller: PersonController, state: MemberState, dt: float) -> None:
        """Go to the end around the thing, and face it."""
        spot = self._spot(state, controller)
        for k in range(2):
            if not controller.is_holding(k):
                controller.record.arm_mode[k] = SWINGING
        if controller.ground_distance(spot) > (NEAR_END if self.is_there else AT_END):
            self.is_there, self.crew.time = False, 0.0
            radius = 0.5 * math.hypot(*np.ptp(np.concatenate(state.solids)[:, [0, 2]], axis=0))
            circle = state.centre[[0, 2]], radius
            reason = self.approach.walk_to(controller, spot, 0.0, NOBODY, dt, circle)
            self.crew.reason = self.crew.reason or reason
            return
        self.is_there, self.approach = True, Approach()
        controller.face_to(state.centre)
        self.crew.ready[self.number] = controller.is_standing and controller.is_facing(
            FACING_TOLERANCE
        )

    def _take(self, controller: PersonController, state: MemberState, dt: float) -> None:
        """Send the hands to the end, first beside it and then together."""
        crew, person = self.crew, controller.record
        places = state.centre + crew.hands[self.number]
        middle = places.mean(axis=0)
        if not self.standoff.is_kept(controller, middle, middle, dt):
            crew.ready[self.number] = False
            return
        controller.face_to(state.centre)
        farthest, widest = 0.0, WIDEST_OPENING * float(person.height)
        for k in range(2):
            distance = math.dist(controller.hand(k), places[k])
            aside = crew.hands[self.number, k] @ crew.across
            opening = math.copysign(min(OPENING * distance, widest), float(aside))
            place = places[k] + opening * crew.across
            controller.put_hand(k, place + lift_over_knees(controller, k, places[k]))
            farthest = max(farthest, distance)
        closing = CLOSING if crew.time < PATIENCE else PATIENT_CLOSING
        crew.ready[self.number] = farthest < closing * person.height

    def _carry(self, controller: PersonController) -> None:
        """Hold the end before the body, and walk to the place that the crew has come to."""
        crew, person = self.crew, controller.record
        lowest = min(float(one.record.height) for one in crew.people)
        self._hold(controller, float(person.floor) + CARRYING_HEIGHT * lowest)
        facing = -crew.side(self.number) * crew.along
        heading = math.atan2(-facing[2], facing[0])
        if crew.stage is Stage.WALK:
            place = crew.place(self.number)
            way = place - np.array([person.at[0], 0.0, person.at[1]])
            target = place + LEAD_TIME * way
            controller.go(target[0], target[2])
        person.has_facing, person.facing = True, heading

    def _hold(self, controller: PersonController, height: float) -> None:
        """Lead the hands to a height before the body [m]."""
        crew, person = self.crew, controller.record
        inward = -crew.side(self.number) * crew.along
        middle = np.array([person.at[0], height, person.at[1]])
        middle = middle + STANDOFF * controller.arm * inward
        for k in range(2):
            aside = float(crew.hands[self.number, k] @ crew.across)
            controller.lead_hand(k, middle + aside * crew.across)

    def _lower(self, controller: PersonController, state: MemberState) -> None:
        """Lead the end down to the ground."""
        floor = controller.view.ground_height(state.centre[0], state.centre[2])
        gap = float(state.low[1]) - floor
        hands = [controller.hand(k)[1] for k in range(2)]
        self._hold(controller, float(np.mean(hands)) - gap - 0.5 * PUT_DOWN_GAP)
        is_late = self.crew.time > PUT_DOWN_TIME
        self.crew.ready[self.number] = gap < PUT_DOWN_GAP or is_late
        if all(self.crew.ready):
            for one in self.crew.people:
                for k in range(2):
                    one.record.arm_mode[k] = SWINGING
