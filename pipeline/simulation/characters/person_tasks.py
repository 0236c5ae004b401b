"""Person tasks: walking, turning and sitting until they are done, and hands posed key by key.

A task is asked once a step, before control acts, and says whether it is done. It goes on being
asked after that for what lasts, such as a hug or a hand held out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from pipeline.simulation.characters.person_controller import BODY_RADIUS, PersonController
from pipeline.simulation.characters.person_record import PELVIS, SITTING, STANDING, SWINGING
from pipeline.simulation.characters.visibility_route import Route
from pipeline.simulation.keyframe_track import BlendedTrack, Track
from pipeline.simulation.spatial import Array
from pipeline.spec.character_kinds import HANDS
from pipeline.spec.keyframes import Frame, PoseKey

SEAT_HEIGHT = 0.062  # of the pelvis above the seat, in heights
TURN_TOLERANCE, SEAT_TURN_TOLERANCE = math.radians(3.0), 0.08  # [rad]


class Task(Protocol):
    """Something that a person does."""

    def advance(self, controller: PersonController, dt: float) -> bool:
        """Command the person for the coming step of `dt` [s]; tell whether the task is done."""


@dataclass
class Walk:
    """Walk to a place, around what stands on the straight way.

    Attributes:
        goal: (2,) [m]; None goes as commanded before.
        route: the way around obstacles.
    """

    goal: Array | None = None
    route: Route = field(default_factory=Route)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        person = controller.record
        if self.goal is not None and person.has_goal:
            middles, radii = controller.obstacles()
            if len(radii):
                reaches = radii + BODY_RADIUS * float(person.height)
                bounds, at = np.stack(controller.view.edges), np.array(person.at)
                # An author's straight ways are kept wherever they can be walked.
                first, length = self.route.next(
                    at, self.goal, middles, reaches, bounds, clearance=0.0
                )
                offset = first - at
                # A corner of the way is not slowed down for as its end is.
                is_straight = len(self.route.places) == 1
                ahead = at + offset * (length / math.hypot(*offset))
                person.goal[:] = self.goal if is_straight else ahead
        return not person.has_goal and controller.is_standing


@dataclass
class Turn:
    """Turn to the facing asked for."""

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        is_done = controller.is_facing(TURN_TOLERANCE) and controller.is_standing
        if is_done:
            controller.record.has_facing = False
        return is_done


@dataclass
class StandUp:
    """Stand up."""

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        controller.record.posture = STANDING
        return controller.is_standing


@dataclass
class SitDown:
    """Sit down on the ground."""

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
        return bool(person.sit_blend >= 1.0)


@dataclass
class SitOn:
    """Go to a thing, turn round and sit down on it.

    Attributes:
        owner: number of the thing.
        stage: 0 walk there, 1 turn round, 2 sit down.
    """

    owner: int
    stage: int = 0

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        person = controller.record
        nodes = controller.view.nodes(self.owner)
        middle = nodes.mean(axis=0)
        ahead, half_depth = _seat_front(nodes, controller)
        back = max(0.92 * person.thigh, half_depth + 0.08 * person.height - 0.04)
        spot = middle + back * ahead
        if self.stage == 0:
            controller.go(spot[0], spot[2])
            self.stage = 1
        elif self.stage == 1 and not person.has_goal and not person.stepping:
            controller.turn_to(math.atan2(-ahead[2], ahead[0]))
            self.stage = 2
        elif self.stage == 2 and controller.is_standing:
            if controller.is_facing(SEAT_TURN_TOLERANCE):
                person.has_facing, person.posture = False, SITTING
                height = float(nodes[:, 1].max()) + SEAT_HEIGHT * person.height
                person.seat[:] = back, height, 0.02
        return bool(person.sit_blend >= 1.0)


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
