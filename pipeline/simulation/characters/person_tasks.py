"""Person tasks: walking, turning and sitting until they are done, and hands posed key by key.

A task is asked once a step, before control acts, and says whether it is done. It goes on being
asked after that for what lasts, such as a hug or a hand held out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.carousel_pose import way_off_deck
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import PELVIS, SITTING, STANDING, SWINGING
from pipeline.simulation.characters.task_progress import TaskProgress
from pipeline.simulation.characters.visibility_route import Route
from pipeline.simulation.keyframe_track import BlendedTrack, Track
from pipeline.simulation.spatial import Array
from pipeline.spec.character_kinds import HANDS
from pipeline.spec.keyframes import Frame, PoseKey

SEAT_HEIGHT = 0.062  # of the pelvis above the seat, in heights
BLOCKED_TIME = 2.0  # without getting on, after which a way is blocked [s]
THRONG_TIME = 15.0  # the same, where others are in the way who walk, too [s]
AMONG_OTHERS = 0.5  # from its goal at which a walker stops whom others let no nearer [m]
VAIN_TIME = 8.0  # without coming nearer along the way, after which a walk is in vain [s]
POSTURE_PATIENCE = 8.0  # to turn, to stand up or to come to stand [s]
TURN_TOLERANCE = math.radians(3.0)


@dataclass
class Task:
    """Something that a person does.

    Attributes:
        failure: why it cannot be done, "" while it can; one whose order it is gives it up.
        is_stuck: whether it fails because it gets no further, which may be mended from elsewhere.
        is_lost: whether what it holds on to after it is done is gone.
        pace: least walking speed that it asks for [m/s].
        most_pace: greatest walking speed that it allows [m/s].
        leads_hands: whether it leads hands that hold something.
        asked: time for which it has asked in vain for what another holds [s].
        giver: number of the person that it asks, NOBODY without any.
    """

    failure: str = field(default="", init=False)
    is_stuck: bool = field(default=False, init=False)
    is_lost: bool = field(default=False, init=False)
    pace: float = field(default=0.0, init=False)
    most_pace: float = field(default=math.inf, init=False)
    leads_hands: bool = field(default=False, init=False)
    asked: float = field(default=0.0, init=False)
    giver: int = field(default=NOBODY, init=False)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """Command the person for the coming `dt` [s]; tell whether the task is done."""
        raise NotImplementedError

    def stick(self, reason: str, approach: Approach | None = None) -> None:
        """Fail for a reason that another try from elsewhere may mend; "" is none.

        A search that finds no way at all finds none from elsewhere either.
        """
        if reason:
            self.failure = reason
            self.is_stuck = approach is None or approach.route.vain_from is None

    def leave(self, controller: PersonController) -> None:
        """Let go of what only this task holds, before another one begins or none."""

    def subject(self, controller: PersonController) -> Array | None:
        """Return (3,) the place that it is about and that the person looks at [m]."""
        owner = getattr(self, "owner", NOBODY)
        if owner >= 0:
            return controller.view.face(owner)
        return controller.view.state(self.members[0]).face if self.members else None

    @property
    def interval(self) -> int:
        """Steps from one command to the next, more than one while commands change slowly."""
        return 1

    @property
    def members(self) -> tuple[str, ...]:
        """Names of members whose states it needs."""
        return ()

    def asks_for(self, controller: PersonController) -> str:
        """Return the name of what it takes from another's hand, "" for nothing."""
        return ""

    @property
    def wants_slot(self) -> bool:
        """Whether it needs a slot of a thing and has none yet."""
        return False

    def slot_distance(self, controller: PersonController) -> float:
        """Return the distance to the thing with the slots; who is nearest chooses first [m]."""
        raise NotImplementedError

    def take_slot(self, controller: PersonController) -> None:
        """Take a slot, or fail."""
        raise NotImplementedError


@dataclass
class Walk(Task):
    """Walk to a place, around what stands on the straight way.

    Attributes:
        goal: (2,) [m]; None goes as commanded before.
        approach: to the goal.
    """

    goal: Array | None = None
    approach: Approach = field(default_factory=lambda: Approach())

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        person = controller.record
        if self.goal is not None and person.has_goal:
            self.stick(self.approach.advance(controller, self.goal, dt), self.approach)
            if person.impatience >= 1.0 and math.dist(person.at, self.goal) < AMONG_OTHERS:
                controller.stop()
        return not person.has_goal and controller.is_standing


@dataclass
class Approach:
    """The way of a person around obstacles, and how it gets on.

    Attributes:
        route: around obstacles.
        progress: of the walk.
    """

    route: Route = field(default_factory=Route)
    progress: TaskProgress = field(default_factory=TaskProgress)

    def advance(
        self,
        controller: PersonController,
        goal: Array,
        dt: float,
        circle: tuple[Array, float] | None = None,
    ) -> str:
        """Head for the goal (2,) of a person that goes there [m]; return why it gets no nearer."""
        left = take_route(controller, self.route, goal, circle)
        return walking_failure(controller, self.progress, left, dt)

    def walk_to(
        self,
        controller: PersonController,
        place: Array,
        stop: float,
        partner: int,
        dt: float,
        circle: tuple[Array, float] | None = None,
    ) -> str:
        """Go up to a place, and return why that gets no nearer, "" if it does.

        Args:
            controller: of the person.
            place: (3,) where to [m].
            stop: distance from it at which the person stops [m].
            partner: number of the character there, which is not stepped aside for.
            dt: the step [s].
            circle: middle (2,) and radius of a further obstacle [m].
        """
        controller.go(place[0], place[2], stop, partner)
        return self.advance(controller, np.array([place[0], place[2]]), dt, circle)


def take_route(
    controller: PersonController,
    route: Route,
    goal: Array,
    circle: tuple[Array, float] | None = None,
) -> float:
    """Head for the next place on the way around obstacles to where a person goes.

    Args:
        controller: of the person.
        route: of the walk; changed.
        goal: (2,) where to [m].
        circle: middle (2,) and radius of a further obstacle [m].

    Returns:
        The length of the way [m].
    """
    person = controller.record
    if (first := way_off_deck(controller, goal)) is not None:
        person.goal[:] = first
        return math.dist(person.at, first) + math.dist(first, goal)
    middles, radii = controller.obstacles()
    if circle is not None:
        middles = np.concatenate([middles, circle[0][None]])
        radii = np.append(radii, circle[1])
    if not len(radii):
        person.goal[:] = goal
        return math.dist(person.at, goal)
    reaches = radii + controller.body_radius
    bounds, at = np.stack(controller.view.edges), np.array(person.at)
    # An author's straight ways are kept wherever they can be walked.
    first, length = route.next(at, goal, middles, reaches, bounds, clearance=0.0)
    offset = first - at
    # A corner of the way is not slowed down for as its end is.
    is_straight = len(route.places) == 1
    ahead = at + offset * (length / max(math.hypot(*offset), 1e-9))
    person.goal[:] = goal if is_straight else ahead
    return length


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
    if person.frozen or person.sit_blend > 0.0 or person.group_wait > 0.0:
        return ""
    # Others go on sooner or later.
    progress.free_time = 0.0 if person.in_throng else progress.free_time + dt
    blocked_time = BLOCKED_TIME if progress.free_time > BLOCKED_TIME else THRONG_TIME
    vain_time = VAIN_TIME if progress.free_time > BLOCKED_TIME else THRONG_TIME
    if progress.update(left, dt, person.at) > blocked_time:
        return f"the way is blocked at {place_text(controller)}, {left:.1f} m from it"
    if progress.idle_time > vain_time:
        return f"has come no nearer for {vain_time:g} s at {place_text(controller)}"
    return ""


def shoulder_height(controller: PersonController) -> float:
    """Return the height of the shoulders in standing upright [m]."""
    person = controller.record
    return float(person.floor + person.hip_height + person.belly + person.chest)


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
            height = controller.floor_height(x, z) + SEAT_HEIGHT * person.height
            person.seat[:], person.seat_heel_rise = (back, height, -0.06), 0.0
            person.has_goal, person.has_facing, person.posture = False, False, SITTING
            self.time += dt
            if self.time > POSTURE_PATIENCE:
                self.failure = f"cannot stand still at {place_text(controller)}"
        return bool(person.sit_blend >= 1.0)


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
