"""Moods: what they change of a pace, and of how a creature carries itself.

A mood asks; the legs decide. A stride that they cannot do becomes the longest that they
can, a height that they do not reach the tallest that they do.

Source: Sims 1987, 3.2.4 and 9.1.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from pipeline.simulation.curves import ease
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.pace import (
    CLEARANCE,
    EASY,
    WALKS_AT,
    Pace,
    choose_pace,
)
from pipeline.simulation.locomotion.gaits.spread import LegLayout
from pipeline.simulation.spatial import Array
from pipeline.spec.creature import Creature
from pipeline.spec.mood import Mood
from pipeline.spec.script import ChangeGait


@dataclass(frozen=True, eq=False)
class MotionStyle:
    """The bearing of C creatures, at one moment (C,) or at several (n, C).

    Whoever changes it while they go does so little by little: it is followed at once. Joints
    keep their limits and bodies `MOST_PITCH` whatever it asks for.

    Attributes:
        head_raise: by how much necks are raised [rad].
        head_turn: how far heads look where they go, as a factor; 1 all the way.
        tail_raise: by how much tails are raised [rad].
        body_pitch: by how much bodies are held nose up [rad].
        sway: factor on what swings with the gait.
        wander: factor on what moves of its own accord.
        looseness: factor on what trails behind and swings on: 0 stiff, 1 as usual, 2 floppy.
    """

    head_raise: Array
    head_turn: Array
    tail_raise: Array
    body_pitch: Array
    sway: Array
    wander: Array
    looseness: Array

    @staticmethod
    def neutral(count: int) -> MotionStyle:
        """Return the bearing of `count` creatures in no mood."""
        none, one = np.zeros(count), np.ones(count)
        return MotionStyle(none, one, none, none, one, one, one)

    @staticmethod
    def stacked(moments: Sequence[MotionStyle]) -> MotionStyle:
        """Return those of several moments as one (n, C)."""
        first, names = moments[0], [f.name for f in fields(MotionStyle)]
        if all(one is first for one in moments):
            # No mood changes in most films, nor in most dozens of rows.
            shape = len(moments), len(first.sway)
            return MotionStyle(*(np.broadcast_to(getattr(first, name), shape) for name in names))
        return MotionStyle(*(np.stack([getattr(one, name) for one in moments]) for name in names))


LEAST_DUTY, MOST_DUTY = 0.3, 0.85
"""Parts of a cycle that a foot may be down in a mood."""


@dataclass(frozen=True, slots=True)
class MoodEffect:
    """Several moods by their weights, as one.

    Attributes:
        stride, cycle, body_bob, body_height, step_height, sway, wander, looseness: factors.
        duty: part of the cycle that feet stay down longer.
        pitch, head, tail: by how much they are raised [rad].
    """

    stride: float = 1.0
    cycle: float = 1.0
    body_bob: float = 1.0
    body_height: float = 1.0
    step_height: float = 1.0
    sway: float = 1.0
    wander: float = 1.0
    looseness: float = 1.0
    duty: float = 0.0
    pitch: float = 0.0
    head: float = 0.0
    tail: float = 0.0


FACTORS = (
    "stride",
    "cycle",
    "body_bob",
    "body_height",
    "step_height",
    "sway",
    "wander",
    "looseness",
)
ANGLES = ("pitch", "head", "tail")


def blend_moods(mix: Mapping[str, float], moods: Mapping[str, Mood]) -> MoodEffect:
    """Return what moods come to together.

    Args:
        mix: weights by the names of moods.
        moods: all that may be named.
    """
    values = dict.fromkeys(FACTORS, 1.0) | dict.fromkeys(("duty", *ANGLES), 0.0)
    for name, weight in mix.items():
        mood = moods[name]
        for factor in FACTORS:
            values[factor] *= getattr(mood, factor) ** weight
        for angle in ANGLES:
            values[angle] += math.radians(getattr(mood, f"{angle}_deg")) * weight
        values["duty"] += mood.duty * weight
    return MoodEffect(**values)


def apply_mood(pace: Pace, feeling: MoodEffect, figure: Figure, legs: LegLayout) -> Pace:
    """Return how a creature walks that feels so.

    Args:
        pace: how it walks otherwise.
        feeling: its moods.
        figure: its figure at its scale.
        legs: at rest.
    """
    if not pace.stride:
        return pace
    carrying = [leg for leg, held in enumerate(pace.held) if not held]
    legs = legs.only(carrying, pace.aside)
    lowest, tallest = CLEARANCE * figure.belly, WALKS_AT * legs.tallest()
    height = pace.body_height * feeling.body_height
    # What an author asked for may be beyond what is chosen by itself.
    height = min(max(height, min(lowest, pace.body_height)), max(tallest, pace.body_height))
    gait = _firmer(pace.carrying, feeling.duty)
    longest = legs.longest_stride(gait, height)
    cycle, bounce = pace.cycle * feeling.cycle, pace.bounciness * feeling.body_bob
    if pace.flight is not None:
        # Nobody falls faster than freely, but who was asked to.
        free = pace.flight.amplitude * GRAVITY * cycle * cycle
        bounce = min(bounce, max(free, pace.bounciness * feeling.cycle**2))
    stride = min(pace.stride * feeling.stride, max(EASY * longest, min(pace.stride, longest)))
    return replace(
        pace,
        gait=gait.among(~pace.held),
        body_height=height,
        cycle=cycle,
        stride=stride,
        longest=longest,
        bounciness=bounce,
        step_height=pace.step_height * feeling.step_height,
    )


def _firmer(gait: Gait, duty: float) -> Gait:
    """Return a gait whose feet stay down for `duty` of the cycle longer, without new flights."""
    if not duty or len(gait.flights()):
        return gait
    firmer = gait.with_duty(min(max(float(gait.duty.mean()) + duty, LEAST_DUTY), MOST_DUTY))
    return gait if len(firmer.flights()) else firmer


MOMENT = 0.9
"""Time in which a creature comes to carry itself otherwise [s]."""


class MoodSchedule:
    """Paces without moods, and moods, of a herd.

    Attributes of the state:
        plain: pace of each creature as it was last told, without its mood.
        feelings: of each creature: since when it has felt how, in order [s].
    """

    def __init__(
        self,
        cast: Sequence[tuple[int, Creature, Figure]],
        plain: Sequence[Pace],
        legs: Sequence[LegLayout],
        moods: Mapping[str, Mood],
    ) -> None:
        self.figures = [figure for _, _, figure in cast]
        self.legs = legs
        self.moods = moods
        self.plain = list(plain)
        self._bearing: MotionStyle | None = None
        self.feelings = [
            [(-2.0 * MOMENT, blend_moods(member.mood, moods))] for _, member, _ in cast
        ]

    def possible(self, c: int, order: ChangeGait, where: str = "do") -> Pace:
        """Return the pace that a creature is asked to have, without its mood.

        Args:
            c: who.
            order: what it is told.
            where: path of the order in the scene.

        Raises:
            SceneError: if its legs cannot do so.
        """
        return choose_pace(where, order, self.figures[c], self.legs[c])

    def told(self, c: int, order: ChangeGait) -> Pace:
        """Return the pace of a creature that is told to change its gait.

        Raises:
            SceneError: if its legs cannot do so.
        """
        self.plain[c] = self.possible(c, order)
        return self._in_mood(c)

    def felt(self, c: int, mix: Mapping[str, float], time: float) -> Pace:
        """Return the pace of a creature that is in other moods from `time` on [s]."""
        self.feelings[c].append((time, blend_moods(mix, self.moods)))
        return self._in_mood(c)

    def _in_mood(self, c: int) -> Pace:
        feeling = self.feelings[c][-1][1]
        return apply_mood(self.plain[c], feeling, self.figures[c], self.legs[c])

    def bearing(self, time: float) -> MotionStyle:
        """Return how all carry themselves at `time` [s]; the same object while nothing changes."""
        if self._bearing is None or time <= self._settled:
            self._bearing = MotionStyle(
                head_raise=self._felt("head", time),
                head_turn=np.ones(len(self.feelings)),
                tail_raise=self._felt("tail", time),
                body_pitch=self._felt("pitch", time),
                sway=self._felt("sway", time),
                wander=self._felt("wander", time),
                looseness=self._felt("looseness", time),
            )
        return self._bearing

    @property
    def _settled(self) -> float:
        """Time from which on nobody carries itself otherwise [s]."""
        return max(since for course in self.feelings for since, _ in course) + 2.0 * MOMENT

    def _felt(self, name: str, time: float) -> Array:
        """Return a part of what creatures (C,) feel at `time` [s]."""
        result = np.empty(len(self.feelings))
        for c, course in enumerate(self.feelings):
            before: MoodEffect = course[0][1]
            result[c] = getattr(before, name)
            for since, feeling in course[1:]:
                step = getattr(feeling, name) - getattr(before, name)
                done = min(max((time - since) / MOMENT, 0.0), 1.0)
                result[c] += step * ease(np.array(done))
                before = feeling
        return result
