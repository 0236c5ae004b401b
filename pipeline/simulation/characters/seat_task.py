"""Seat task: sitting down on a thing with one or more seats, side by side with others.

A thing is as many seats as fit along its length, and all who sit on it face the same way. Who
comes from behind walks around its nearer end, and along the knees of those who sit there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import SITTING
from pipeline.simulation.characters.person_tasks import (
    POSTURE_PATIENCE,
    SEAT_HEIGHT,
    Task,
    place_text,
    take_route,
    walking_failure,
)
from pipeline.simulation.characters.seat_perch import perch_on
from pipeline.simulation.characters.task_progress import TaskProgress
from pipeline.simulation.characters.visibility_route import Route
from pipeline.simulation.spatial import Array

SEAT_RANGE = 0.25, 0.8  # heights of seats, in the height of the hips
HIGHEST_PERCH = 0.9  # of a seat of this room, up to whose edge the feet stand
SEAT_STANDOFF = 0.17  # of the feet before a seat of another room, in heights
SQUARE = 1.25  # length of a thing in its width, up to which one sits on any of its sides
SEAT_PITCH = 0.48  # length of a thing that one person takes up in sitting [m]
SEAT_TURN_TOLERANCE = 0.08  # [rad]
NEIGHBOUR_SPACE = 0.75  # distance to those beside a seat that a person accepts, in its pitch
NEAR_SEAT = 2.5  # from its seat, within which it does [m]
LANE = 0.3  # distance before the feet of those who sit at which one passes them, in heights
PASSING = 0.3  # beside its seat from which a person goes on to it [m]
END_CLEARANCE = 0.1  # between a body and the end of a thing that it walks around [m]
CORNER_TOLERANCE = 0.15  # of a place on the way around a thing [m]
TOP_CORNERS = 4  # of a thing, whose mean height is that of its top even while it rocks


@dataclass(frozen=True, eq=False)
class Bench:
    """A thing to sit on, as level directions and lengths.

    Attributes:
        middle: (3,) [m].
        ahead: (3,) direction that people on it face.
        half_depth: along that [m].
        half_length: across that [m].
        top: height of its top [m].
    """

    middle: Array
    ahead: Array
    half_depth: float
    half_length: float
    top: float

    @property
    def along(self) -> Array:
        """(3,) level direction across `ahead`."""
        return np.array([-self.ahead[2], 0.0, self.ahead[0]])

    @property
    def seat_count(self) -> int:
        """Number of seats, side by side."""
        return max(int(2.0 * self.half_length / SEAT_PITCH), 1)

    def seat_offset(self, number: int) -> float:
        """Return where a seat is along the thing, from its middle [m]."""
        pitch = 2.0 * self.half_length / self.seat_count
        return (number - 0.5 * (self.seat_count - 1)) * pitch

    def coordinates(self, at: Array) -> tuple[float, float]:
        """Return how far along and ahead of the middle a place (2,) on the ground is [m]."""
        x, z = at[0] - self.middle[0], at[1] - self.middle[2]
        return (
            float(x * self.along[0] + z * self.along[2]),
            float(x * self.ahead[0] + z * self.ahead[2]),
        )

    def place(self, along: float, ahead: float) -> Array:
        """Return the place (3,) at these coordinates [m]."""
        place: Array = self.middle + along * self.along + ahead * self.ahead
        return place


def bench_of(nodes: Array, at: Array, facing: float | None = None) -> Bench:
    """Return a thing to sit on.

    Args:
        nodes: (n, 3) of the thing [m].
        at: (2,) the place of the person, who sits down on its own side [m].
        facing: heading of those who sit there already [rad].
    """
    middle = nodes.mean(axis=0)
    flat = nodes - middle
    flat[:, 1] = 0.0
    xx, zz = float((flat[:, 0] ** 2).sum()), float((flat[:, 2] ** 2).sum())
    xz = float((flat[:, 0] * flat[:, 2]).sum())
    # The longer of the two principal directions; the front is across it.
    angle = 0.5 * math.atan2(2.0 * xz, xx - zz)
    ahead = np.array([-math.sin(angle), 0.0, math.cos(angle)])
    front = at - middle[[0, 2]]
    if facing is not None:
        front = np.array([math.cos(facing), -math.sin(facing)])
    if _is_as_long_as_wide(flat, ahead):
        aside = np.array([ahead[2], 0.0, -ahead[0]])
        if abs(float(aside[[0, 2]] @ front)) > abs(float(ahead[[0, 2]] @ front)):
            ahead = aside
    if ahead[0] * front[0] + ahead[2] * front[1] < 0.0:
        ahead = -ahead
    along = np.array([-ahead[2], 0.0, ahead[0]])
    half_depth, half_length = (float((flat @ axis).max()) for axis in (ahead, along))
    top = float(np.sort(nodes[:, 1])[-TOP_CORNERS:].mean())
    return Bench(middle, ahead, half_depth, half_length, top)


def _is_as_long_as_wide(flat: Array, ahead: Array) -> bool:
    """Tell whether a thing has one seat whichever side one sits on.

    Args:
        flat: (n, 3) its nodes from its middle, on the ground [m].
        ahead: (3,) direction across its longer side.
    """
    along = np.array([-ahead[2], 0.0, ahead[0]])
    depth, length = float(np.ptp(flat @ ahead)), float(np.ptp(flat @ along))
    return length < min(SQUARE * depth, 2.0 * SEAT_PITCH)


@dataclass
class SitOn(Task):
    """Go to a free seat of a thing, turn round and sit down on it.

    Attributes:
        owner: number of the thing, NOBODY for a member of another room.
        target: name of that member.
        number: of the seat, None before one is chosen.
        stage: 0 walk there, 1 turn round and sit down.
        time: since it is there [s].
        progress: of the walk.
        route: around obstacles.
    """

    owner: int
    target: str = ""
    number: int | None = None
    stage: int = 0
    time: float = 0.0
    progress: TaskProgress = field(default_factory=TaskProgress)
    route: Route = field(default_factory=Route)

    @property
    def members(self) -> tuple[str, ...]:
        """See `Task`."""
        return (self.target,) if self.target else ()

    @property
    def wants_slot(self) -> bool:
        """See `Task`."""
        return self.number is None

    def slot_distance(self, controller: PersonController) -> float:
        """See `Task`."""
        return controller.ground_distance(self._nodes(controller).mean(axis=0))

    def take_slot(self, controller: PersonController) -> None:
        """Take the nearest free seat."""
        view, thing = controller.view, self._thing(controller)
        bench = self._bench(controller)
        free = view.slots.free(thing, bench.seat_count)
        if not free:
            persons = ", ".join(view.slots.persons(thing))
            every = "the seat is" if bench.seat_count == 1 else f"all {bench.seat_count} seats are"
            self.failure = f"{every} taken, by {persons}"
            return
        here, _ = bench.coordinates(controller.record.at)
        self.number = min(free, key=lambda n: (abs(bench.seat_offset(n) - here), n))
        facing = math.atan2(-bench.ahead[2], bench.ahead[0])
        view.slots.take(thing, self.number, controller.name, facing)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        person = controller.record
        if self.number is None or (self.stage == 1 and person.sit_blend >= 1.0):
            return self.number is not None
        bench = self._bench(controller)
        if self.stage == 0 or self.owner < 0:
            self.failure = _seat_failure(bench.top, controller, self.owner >= 0)
            if self.failure:
                return False
        distance, back = self._standoff(controller, bench)
        if self.stage == 0:
            self._walk(controller, bench, distance, dt)
        else:
            self._sit(controller, bench, back, dt)
        return bool(person.sit_blend >= 1.0)

    def _thing(self, controller: PersonController) -> str:
        return self.target or controller.view.names[self.owner]

    def _nodes(self, controller: PersonController) -> Array:
        if self.owner >= 0:
            return controller.view.nodes(self.owner)
        return np.concatenate(controller.view.state(self.target).solids)

    def _bench(self, controller: PersonController) -> Bench:
        facing = controller.view.slots.facing(self._thing(controller))
        return bench_of(self._nodes(controller), np.array(controller.record.at), facing)

    def _standoff(self, controller: PersonController, bench: Bench) -> tuple[float, float]:
        """Return how far before its middle one stands, and how far back one sits from there [m]."""
        person = controller.record
        if self.owner >= 0:
            back = max(0.92 * person.thigh, bench.half_depth + 0.08 * person.height - 0.04)
            return back, back
        # Solids of other rooms keep the feet farther off than those of this room.
        off = SEAT_STANDOFF * person.height
        return bench.half_depth + off, off + min(0.6 * person.thigh, bench.half_depth)

    def _walk(self, controller: PersonController, bench: Bench, distance: float, dt: float) -> None:
        """Go on to the place before the seat, and then turn round."""
        person = controller.record
        offset = bench.seat_offset(self.number or 0)
        spot = bench.place(offset, distance)
        corner = self._corner(controller, bench, offset, distance)
        if corner is None and not person.has_goal and controller.ground_distance(spot) < PASSING:
            if not person.stepping:
                controller.turn_to(math.atan2(-bench.ahead[2], bench.ahead[0]))
                self.stage = 1
            return
        place = spot if corner is None else corner
        controller.go(place[0], place[2])
        if controller.ground_distance(spot) < NEAR_SEAT:
            person.neighbour_distance = NEIGHBOUR_SPACE * SEAT_PITCH
        if self.owner < 0 and corner is None:
            take_route(controller, self.route, spot[[0, 2]])
        left = controller.ground_distance(place) + math.dist(place, spot)
        self.stick(walking_failure(controller, self.progress, left, dt))

    def _corner(
        self, controller: PersonController, bench: Bench, offset: float, distance: float
    ) -> Array | None:
        """Return the next place (3,) on the way around the thing, None when the way is free [m]."""
        along, ahead = bench.coordinates(controller.record.at)
        room = controller.body_radius + END_CLEARANCE
        beyond, lane = bench.half_length + room, distance + LANE * controller.record.height
        end = math.copysign(beyond, along if abs(along) > 0.05 else offset)
        if ahead < bench.half_depth:
            if abs(along) < beyond - CORNER_TOLERANCE:
                return bench.place(end, min(ahead, -bench.half_depth - room))
            return bench.place(end, lane)
        mates = len(controller.view.slots.persons(self._thing(controller))) > 1
        if mates and abs(along - offset) > PASSING:
            return bench.place(offset, lane)
        return None

    def _sit(self, controller: PersonController, bench: Bench, back: float, dt: float) -> None:
        """Sit down once it has turned round."""
        person = controller.record
        if controller.is_standing and controller.is_facing(SEAT_TURN_TOLERANCE):
            person.has_facing, person.posture = False, SITTING
            perch = perch_on(person, bench.top, back)
            person.seat[:] = perch.back, bench.top + SEAT_HEIGHT * person.height, 0.02
            person.seat_heel_rise = perch.heel_rise
        if person.sit_blend == 0.0:
            self.time += dt
            if self.time > POSTURE_PATIENCE:
                self.stick(f"cannot turn round before it at {place_text(controller)}")


def _seat_failure(top: float, controller: PersonController, is_near: bool) -> str:
    """Return why a person cannot sit at a height [m], "" if it can.

    Args:
        top: height of the seat [m].
        controller: of the person.
        is_near: whether the feet stand right before its edge.
    """
    person = controller.record
    height = top - float(person.floor)
    shares = SEAT_RANGE[0], HIGHEST_PERCH if is_near else SEAT_RANGE[1]
    low, high = (share * float(person.hip_height) for share in shares)
    if low <= height <= high:
        return ""
    text = "high" if height > high else "low"
    return f"too {text}: {height:.2f} m, sits at {low:.2f} to {high:.2f} m"
