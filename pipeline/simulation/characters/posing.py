"""Posing: hands that go along keys of their author, over whatever their owner does."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.characters.actor import Actor
from pipeline.simulation.characters.record import PELVIS, SWINGING
from pipeline.simulation.spatial import Array
from pipeline.simulation.tracks import Run, Track
from pipeline.spec.character import HANDS
from pipeline.spec.keyframes import Frame, PoseKey


@dataclass(frozen=True, eq=False)
class HandRun:
    """What is asked of one hand from its first key to its release.

    Attributes:
        hand: 0 for the left one, 1 for the right one.
        run: where it is to be (3,), and from when to when [m], [s].
        frame: what that is relative to.
    """

    hand: int
    run: Run
    frame: Frame

    def place(self, actor: Actor, time: float) -> Array:
        """Return (3,) where the hand is to be in the world [m]."""
        place: Array = self.run.track(np.array([time]))[0]
        if self.frame == "world":
            return place
        me = actor.me
        c, s = math.cos(me.heading), math.sin(me.heading)
        x, y, z = place
        turned = np.array([c * x + s * z, y, -s * x + c * z])
        if self.frame == "body":
            turned += me.wanted[PELVIS]
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
    return HandRun(hand, Run(track, taken, (until, until)), keys[0].frame)


class Posing:
    """The hands of one person that are posed."""

    def __init__(self, keys: Sequence[PoseKey]) -> None:
        self.runs = hand_runs(keys)
        self._held: set[int] = set()

    def go_on(self, actor: Actor, time: float) -> None:
        """Command hands for the step that begins at `time` [s]."""
        for run in self.runs:
            if run.run.taken[0] <= time < run.run.let_go[0]:
                actor.put_hand(run.hand, run.place(actor, time))
                self._held.add(run.hand)
            elif time >= run.run.let_go[0] and run.hand in self._held:
                self._held.discard(run.hand)
                actor.me.arm[run.hand] = SWINGING
