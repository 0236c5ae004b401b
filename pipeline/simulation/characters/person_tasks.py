"""Person tasks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from pipeline.simulation.characters.person_controller import SLIM, PersonController
from pipeline.simulation.characters.person_record import PELVIS, SITTING, STANDING, SWINGING
from pipeline.simulation.characters.visibility_route import Route
from pipeline.simulation.keyframe_track import BlendedTrack, Track
from pipeline.simulation.spatial import Array
from pipeline.spec.character import HANDS
from pipeline.spec.keyframes import Frame, PoseKey


class Task(Protocol):
    """Something that somebody does."""

    def go_on(self, controller: PersonController, dt: float) -> bool:
        """Command somebody for the step of `dt` [s] to come; tell whether it is done."""


@dataclass
class Walk:
    """Walk to a place, round what stands on the straight way there.

    Attributes:
        goal: (2,) where to [m]; None to go as it was sent.
        route: the way round.
    """

    goal: Array | None = None
    route: Route = field(default_factory=Route)

    def go_on(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        me = controller.record
        if self.goal is not None and me.has_goal:
            middles, radii = controller.in_the_way()
            if len(radii):
                self._go_round(controller, middles, radii + SLIM * float(me.height))
        return not me.has_goal and controller.stands

    def _go_round(self, controller: PersonController, middles: Array, reaches: Array) -> None:
        assert self.goal is not None
        within, at = np.stack(controller.view.edges), np.array(controller.record.at)
        # An author's straight ways are kept wherever they can be gone.
        first, length = self.route.next(at, self.goal, middles, reaches, within, clearance=0.0)
        to = first - at
        # Nobody slows down for a corner as for the end of the way.
        straight = len(self.route.places) == 1
        controller.record.goal[:] = self.goal if straight else at + to * (length / math.hypot(*to))


@dataclass
class Turn:
    """Turn to a heading."""

    def go_on(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        done = controller.faces(math.radians(3.0)) and controller.stands
        if done:
            controller.record.has_facing = False
        return done


@dataclass
class Rise:
    """Stand up."""

    def go_on(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        controller.record.posture = STANDING
        return controller.stands


SEAT = 0.062
"""Height of the pelvis of one who sits above what it sits on, in heights."""


@dataclass
class SitDown:
    """Sit down on the ground."""

    def go_on(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        me = controller.record
        if me.sit_blend == 0.0:
            back = 0.6 * (me.thigh + me.shin)
            x, z = me.at[0] - back * math.cos(me.heading), me.at[1] + back * math.sin(me.heading)
            me.seat[:] = back, controller.view.height(x, z) + SEAT * me.height, -0.06
            me.has_goal, me.has_facing, me.posture = False, False, SITTING
        return bool(me.sit_blend >= 1.0)


@dataclass
class SitOn:
    """Go to a thing, turn round and sit down on it.

    Attributes:
        owner: what it is.
        stage: 0 goes there, 1 turns round, 2 sits down.
    """

    owner: int
    stage: int = 0

    def go_on(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        me = controller.record
        nodes = controller.view.nodes(self.owner)
        middle = nodes.mean(axis=0)
        ahead, half = _front(nodes, controller)
        back = max(0.92 * me.thigh, half + 0.08 * me.height - 0.04)
        spot = middle + back * ahead
        if self.stage == 0:
            controller.go(spot[0], spot[2])
            self.stage = 1
        elif self.stage == 1 and not me.has_goal and not me.stepping:
            controller.turn_to(math.atan2(-ahead[2], ahead[0]))
            self.stage = 2
        elif (
            self.stage == 2 and me.sit_blend == 0.0 and controller.faces(0.08) and controller.stands
        ):
            me.has_facing, me.posture = False, SITTING
            me.seat[:] = back, float(nodes[:, 1].max()) + SEAT * me.height, 0.02
        return bool(me.sit_blend >= 1.0)


def _front(nodes: Array, controller: PersonController) -> tuple[Array, float]:
    """Return the side (3,) of a thing to sit down at, across its length, and half its depth [m]."""
    flat = nodes - nodes.mean(axis=0)
    flat[:, 1] = 0.0
    xx, zz = float((flat[:, 0] ** 2).sum()), float((flat[:, 2] ** 2).sum())
    xz = float((flat[:, 0] * flat[:, 2]).sum())
    # The longer of the two principal directions; the front is across it.
    angle = 0.5 * math.atan2(2.0 * xz, xx - zz)
    ahead = np.array([-math.sin(angle), 0.0, math.cos(angle)])
    to_me = controller.record.at - nodes.mean(axis=0)[[0, 2]]
    if ahead[0] * to_me[0] + ahead[2] * to_me[1] < 0.0:
        ahead = -ahead
    return ahead, float((flat * ahead).sum(axis=1).max())


@dataclass(frozen=True, eq=False)
class HandRun:
    """What is asked of one hand from its first key to its release.

    Attributes:
        hand: 0 for the left one, 1 for the right one.
        run: where it is to be (3,), and from when to when [m], [s].
        frame: what that is relative to.
    """

    hand: int
    run: BlendedTrack
    frame: Frame

    def place(self, controller: PersonController, time: float) -> Array:
        """Return (3,) where the hand is to be in the world [m]."""
        place: Array = self.run.track(np.array([time]))[0]
        if self.frame == "world":
            return place
        me = controller.record
        c, s = math.cos(me.heading), math.sin(me.heading)
        x, y, z = place
        turned = np.array([c * x + s * z, y, -s * x + c * z])
        if self.frame == "body":
            turned += me.targets[PELVIS]
        else:
            turned += [me.at[0], me.floor, me.at[1]]
        return turned


def hand_runs(keys: Sequence[PoseKey]) -> tuple[HandRun, ...]:
    """Sort the keys of a person into runs; those of each hand follow one another."""
    runs = []
    for name, hand in HANDS.items():
        taken = list[PoseKey]()
        own = [key for key in keys if name in (key.limb, key.node, key.release)]
        for key in sorted(own, key=lambda key: key.at):
            if key.release is None:
                taken.append(key)
            elif taken:
                runs.append(_run(hand, taken, key.at))
                taken = []
        if taken:
            runs.append(_run(hand, taken, math.inf))
    return tuple(runs)


def _run(hand: int, keys: Sequence[PoseKey], until: float) -> HandRun:
    track = Track.of([(key.at, key.reach or (0.0, 0.0, 0.0), key.ease) for key in keys])
    start = keys[0].at
    taken = max(start - keys[0].blend, 0.0), start
    return HandRun(hand, BlendedTrack(track, taken, (until, until)), keys[0].frame)


class PosedHands:
    """The hands of one person that are posed."""

    def __init__(self, keys: Sequence[PoseKey]) -> None:
        self.runs = hand_runs(keys)
        self._held: set[int] = set()

    def go_on(self, controller: PersonController, time: float) -> None:
        """Command hands for the step that begins at `time` [s]."""
        for run in self.runs:
            if run.run.taken[0] <= time < run.run.let_go[0]:
                controller.put_hand(run.hand, run.place(controller, time))
                self._held.add(run.hand)
            elif time >= run.run.let_go[0] and run.hand in self._held:
                self._held.discard(run.hand)
                controller.record.arm_mode[run.hand] = SWINGING
