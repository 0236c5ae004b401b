"""Person tasks: walking, turning and sitting until they are done, and hands posed key by key.

A task is asked once a step, before control acts, and says whether it is done. It goes on being
asked after that for what lasts, such as a hug or a hand held out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import PELVIS, SITTING, STANDING, SWINGING
from pipeline.simulation.characters.task_progress import TaskProgress
from pipeline.simulation.characters.visibility_route import Route
from pipeline.simulation.keyframe_track import BlendedTrack, Track
from pipeline.simulation.spatial import Array
from pipeline.spec.character_kinds import HANDS
from pipeline.spec.keyframes import Frame, PoseKey

SEAT_RANGE = 0.25, 0.75  # heights of seats, in the height of the hips
SEAT_STANDOFF = 0.17  # of the feet before a seat of another room, in heights
SEAT_HEIGHT = 0.062  # of the pelvis above the seat, in heights
BLOCKED_TIME = 4.0  # without getting on, after which a way is blocked [s]
VAIN_TIME = 20.0  # without coming nearer, after which a walk is in vain [s]
POSTURE_PATIENCE = 8.0  # to turn, to stand up or to come to stand [s]
TURN_TOLERANCE, SEAT_TURN_TOLERANCE = math.radians(3.0), 0.08  # [rad]


@dataclass
class Task:
    """Something that a person does.

    Attributes:
        failure: why it cannot be done, "" while it can; one whose order it is gives it up.
        pace: least walking speed that it asks for [m/s].
        leads_hands: whether it leads hands that hold something.
    """

    failure: str = field(default="", init=False)
    pace: float = field(default=0.0, init=False)
    leads_hands: bool = field(default=False, init=False)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """Command the person for the coming step of `dt` [s]; tell whether the task is done."""
        raise NotImplementedError

    @property
    def members(self) -> tuple[str, ...]:
        """Names of members whose states it needs."""
        return ()


@dataclass
class Walk(Task):
    """Walk to a place, around what stands on the straight way.

    Attributes:
        goal: (2,) [m]; None goes as commanded before.
        route: the way around obstacles.
        progress: of the walk.
    """

    goal: Array | None = None
    route: Route = field(default_factory=Route)
    progress: TaskProgress = field(default_factory=TaskProgress)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        person = controller.record
        if self.goal is not None and person.has_goal:
            take_route(controller, self.route, self.goal)
            left = math.dist(person.at, self.goal)
            self.failure = walking_failure(controller, self.progress, left, dt)
        return not person.has_goal and controller.is_standing


def take_route(
    controller: PersonController,
    route: Route,
    goal: Array,
    circle: tuple[Array, float] | None = None,
) -> None:
    """Head for the next place on the way around obstacles to where a person goes.

    Args:
        controller: of the person.
        route: of the walk; changed.
        goal: (2,) where to [m].
        circle: middle (2,) and radius of a further obstacle [m].
    """
    person = controller.record
    middles, radii = controller.obstacles()
    if circle is not None:
        middles = np.concatenate([middles, circle[0][None]])
        radii = np.append(radii, circle[1])
    if not len(radii):
        return
    reaches = radii + controller.body_radius
    bounds, at = np.stack(controller.view.edges), np.array(person.at)
    # An author's straight ways are kept wherever they can be walked.
    first, length = route.next(at, goal, middles, reaches, bounds, clearance=0.0)
    offset = first - at
    # A corner of the way is not slowed down for as its end is.
    is_straight = len(route.places) == 1
    ahead = at + offset * (length / max(math.hypot(*offset), 1e-9))
    person.goal[:] = goal if is_straight else ahead


def walking_failure(
    controller: PersonController, progress: TaskProgress, left: float, dt: float
) -> str:
    """Return why a person does not get to where it goes, "" if it does.

    Args:
        controller: of the person.
        progress: of its walk; changed.
        left: distance to the goal [m].
        dt: time since the last update [s].
    """
    person = controller.record
    if person.frozen or person.sit_blend > 0.0:
        return ""
    if progress.update(left, dt, person.at) > BLOCKED_TIME:
        return f"the way is blocked at {place_text(controller)}, {left:.1f} m from it"
    if progress.idle_time > VAIN_TIME:
        return f"has come no nearer for {VAIN_TIME:g} s at {place_text(controller)}"
    return ""


def place_text(controller: PersonController) -> str:
    """Return where a person is, for messages."""
    x, z = (float(c) for c in controller.record.at)
    return f"[{x:.2f}, {z:.2f}]"


@dataclass
class Turn(Task):
    """Turn to the facing asked for.

    Attributes:
        time: since the start [s].
    """

    time: float = 0.0

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        self.time += dt
        is_done = controller.is_facing(TURN_TOLERANCE) and controller.is_standing
        if not is_done and self.time > POSTURE_PATIENCE:
            self.failure = f"cannot turn at {place_text(controller)}"
        if is_done:
            controller.record.has_facing = False
        return is_done


@dataclass
class StandUp(Task):
    """Stand up.

    Attributes:
        time: since the start [s].
    """

    time: float = 0.0

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        controller.record.posture = STANDING
        self.time += dt
        if not controller.is_standing and self.time > POSTURE_PATIENCE:
            self.failure = f"cannot stand still at {place_text(controller)}"
        return controller.is_standing


@dataclass
class SitDown(Task):
    """Sit down on the ground.

    Attributes:
        time: since the start [s].
    """

    time: float = 0.0

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        person = controller.record
        if person.sit_blend == 0.0:
            back = 0.6 * (person.thigh + person.shin)
            x = person.at[0] - back * math.cos(person.heading)
            z = person.at[1] + back * math.sin(person.heading)
            height = controller.view.ground_height(x, z) + SEAT_HEIGHT * person.height
            person.seat[:] = back, height, -0.06
            person.has_goal, person.has_facing, person.posture = False, False, SITTING
            self.time += dt
            if self.time > POSTURE_PATIENCE:
                self.failure = f"cannot stand still at {place_text(controller)}"
        return bool(person.sit_blend >= 1.0)


@dataclass
class SitOn(Task):
    """Go to a thing, turn round and sit down on it.

    Attributes:
        owner: number of the thing, NOBODY for a member of another room.
        target: name of that member.
        stage: 0 walk there, 1 turn round, 2 sit down.
        time: since it is there [s].
        progress: of the walk.
        route: around obstacles.
    """

    owner: int
    target: str = ""
    stage: int = 0
    time: float = 0.0
    progress: TaskProgress = field(default_factory=TaskProgress)
    route: Route = field(default_factory=Route)

    @property
    def members(self) -> tuple[str, ...]:
        """See `Task`."""
        return (self.target,) if self.target else ()

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        person = controller.record
        if self.stage == 2 and person.sit_blend >= 1.0:
            return True
        seat = self._seat(controller)
        self.failure = "" if self.owner >= 0 else _seat_failure(seat.top, controller)
        if self.stage == 0:
            controller.go(seat.spot[0], seat.spot[2])
            self.stage = 1
        elif self.stage == 1 and person.has_goal:
            self._walk(controller, seat.spot, dt)
        elif self.stage == 1 and not person.stepping:
            controller.turn_to(math.atan2(-seat.ahead[2], seat.ahead[0]))
            self.stage = 2
        elif self.stage == 2:
            self._sit(controller, seat, dt)
        return bool(person.sit_blend >= 1.0)

    def _seat(self, controller: PersonController) -> _Seat:
        person = controller.record
        if self.owner >= 0:
            nodes = controller.view.nodes(self.owner)
        else:
            nodes = np.concatenate(controller.view.state(self.target).solids)
        middle = nodes.mean(axis=0)
        ahead, half_depth = _seat_front(nodes, controller)
        top = float(nodes[:, 1].max())
        if self.owner >= 0:
            back = max(0.92 * person.thigh, half_depth + 0.08 * person.height - 0.04)
            return _Seat(middle + back * ahead, ahead, back, top)
        # Solids of other rooms keep the feet farther off than those of this room.
        spot = middle + (half_depth + SEAT_STANDOFF * person.height) * ahead
        back = SEAT_STANDOFF * person.height + min(0.6 * person.thigh, half_depth)
        return _Seat(spot, ahead, back, top)

    def _walk(self, controller: PersonController, spot: Array, dt: float) -> None:
        """Go on to the place before the seat, which may move if it is of another room."""
        if self.owner < 0:
            controller.go(spot[0], spot[2])
            take_route(controller, self.route, spot[[0, 2]])
        left = controller.ground_distance(spot)
        self.failure = self.failure or walking_failure(controller, self.progress, left, dt)

    def _sit(self, controller: PersonController, seat: _Seat, dt: float) -> None:
        """Sit down once it has turned round."""
        person = controller.record
        if controller.is_standing and controller.is_facing(SEAT_TURN_TOLERANCE):
            person.has_facing, person.posture = False, SITTING
            person.seat[:] = seat.back, seat.top + SEAT_HEIGHT * person.height, 0.02
        if person.sit_blend == 0.0:
            self.time += dt
            if self.time > POSTURE_PATIENCE:
                self.failure = f"cannot turn round before it at {place_text(controller)}"


@dataclass(frozen=True, eq=False)
class _Seat:
    """Where a person sits down on something.

    Attributes:
        spot: (3,) where it stands before [m].
        ahead: (3,) direction of the seat's front.
        back: from the feet to where it sits [m].
        top: height of the seat [m].
    """

    spot: Array
    ahead: Array
    back: float
    top: float


def _seat_failure(top: float, controller: PersonController) -> str:
    """Return why a person cannot sit at a height [m], "" if it can."""
    person = controller.record
    height = top - float(person.floor)
    low, high = (share * float(person.hip_height) for share in SEAT_RANGE)
    if low <= height <= high:
        return ""
    text = "high" if height > high else "low"
    return f"too {text}: {height:.2f} m, sits at {low:.2f} to {high:.2f} m"


def _seat_front(nodes: Array, controller: PersonController) -> tuple[Array, float]:
    """Return the direction (3,) of a seat's front, across its length, and half its depth [m]."""
    flat = nodes - nodes.mean(axis=0)
    flat[:, 1] = 0.0
    xx, zz = float((flat[:, 0] ** 2).sum()), float((flat[:, 2] ** 2).sum())
    xz = float((flat[:, 0] * flat[:, 2]).sum())
    # The longer of the two principal directions; the front is across it.
    angle = 0.5 * math.atan2(2.0 * xz, xx - zz)
    ahead = np.array([-math.sin(angle), 0.0, math.cos(angle)])
    to_person = controller.record.at - nodes.mean(axis=0)[[0, 2]]
    if ahead[0] * to_person[0] + ahead[2] * to_person[1] < 0.0:
        ahead = -ahead
    return ahead, float((flat * ahead).sum(axis=1).max())


@dataclass(frozen=True, eq=False)
class HandRun:
    """The motion asked of one hand from its first key to its release.

    Attributes:
        hand: 0 left, 1 right.
        run: places (3,) over time [m], [s].
        frame: of the places.
    """

    hand: int
    run: BlendedTrack
    frame: Frame

    def place(self, controller: PersonController, time: float) -> Array:
        """Return (3,) the place of the hand in the world [m]."""
        place: Array = self.run.track(np.array([time]))[0]
        if self.frame == "world":
            return place
        person = controller.record
        c, s = math.cos(person.heading), math.sin(person.heading)
        x, y, z = place
        turned = np.array([c * x + s * z, y, -s * x + c * z])
        if self.frame == "body":
            turned += person.targets[PELVIS]
        else:
            turned += [person.at[0], person.floor, person.at[1]]
        return turned


def hand_runs(keys: Sequence[PoseKey]) -> tuple[HandRun, ...]:
    """Return the keys of a person as runs; those of each hand follow one another."""
    runs = []
    for name, hand in HANDS.items():
        taken = list[PoseKey]()
        own = [key for key in keys if name in (key.limb, key.node, key.release)]
        for key in sorted(own, key=lambda key: key.at):
            if key.release is None:
                taken.append(key)
            elif taken:
                runs.append(_hand_run(hand, taken, key.at))
                taken = []
        if taken:
            runs.append(_hand_run(hand, taken, math.inf))
    return tuple(runs)


def _hand_run(hand: int, keys: Sequence[PoseKey], end: float) -> HandRun:
    track = Track.of([(key.at, key.reach or (0.0, 0.0, 0.0), key.ease) for key in keys])
    start = keys[0].at
    return HandRun(
        hand,
        BlendedTrack(track, (max(start - keys[0].blend, 0.0), start), (end, end)),
        keys[0].frame,
    )


class PosedHands:
    """The hands of one person that are posed by keys, over whatever the person does."""

    def __init__(self, keys: Sequence[PoseKey]) -> None:
        self.runs = hand_runs(keys)
        self._posed: set[int] = set()

    def advance(self, controller: PersonController, time: float) -> None:
        """Command hands for the step that starts at `time` [s]."""
        for run in self.runs:
            if run.run.taken[0] <= time < run.run.let_go[0]:
                controller.put_hand(run.hand, run.place(controller, time))
                self._posed.add(run.hand)
            elif time >= run.run.let_go[0] and run.hand in self._posed:
                self._posed.discard(run.hand)
                controller.record.arm_mode[run.hand] = SWINGING
