"""Moods: how they change a creature's pace and the style of its motion.

A mood asks and the legs decide: a stride or a body height that they cannot do becomes the largest
that they can.

Source: Sims 1987, 3.2.4 and 9.1.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from pipeline.errors import SceneError
from pipeline.simulation.curves import ease
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.pace import Pace
from pipeline.simulation.locomotion.gaits.pace_choice import choose_pace
from pipeline.simulation.locomotion.gaits.scaling_laws import comfortable_speed, ladder
from pipeline.simulation.locomotion.gaits.stride_limits import LegLayout
from pipeline.simulation.locomotion.gaits.stride_plan import (
    BODY_HEIGHTS,
    STRIDE_OF_LONGEST,
    build_of,
)
from pipeline.simulation.spatial import Array
from pipeline.spec.creature import Creature
from pipeline.spec.mood import Mood
from pipeline.spec.script import ChangeGait
from pipeline.spec.walk import AUTO, Manner

# Duty factors that a mood may lead to.
MIN_DUTY, MAX_DUTY = 0.3, 0.85

# Time in which the style of motion follows a change of mood [s].
STYLE_CHANGE_TIME = 0.9


@dataclass(frozen=True, eq=False)
class MotionStyle:
    """The motion style of C creatures, at one moment (C,) or at several (n, C).

    Changes are followed at once, so they must be gradual. Joint limits hold whatever it asks for.

    Attributes:
        head_raise: angle by which necks are raised [rad].
        head_turn: factor on how far heads turn to where they look.
        tail_raise: angle by which tails are raised [rad].
        body_pitch: angle by which bodies are held nose up [rad].
        sway: factor on motions of the gait.
        wander: factor on idle motions.
        looseness: factor on follow-through: 0 stiff, 1 as usual, 2 floppy.
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
        """Return the style of `count` creatures in no mood."""
        none, one = np.zeros(count), np.ones(count)
        return MotionStyle(none, one, none, none, one, one, one)

    @staticmethod
    def stacked(moments: Sequence[MotionStyle]) -> MotionStyle:
        """Return the styles of several moments as one (n, C)."""
        first, names = moments[0], [f.name for f in fields(MotionStyle)]
        if all(style is first for style in moments):
            # No mood changes in most films.
            shape = len(moments), len(first.sway)
            return MotionStyle(*(np.broadcast_to(getattr(first, name), shape) for name in names))
        return MotionStyle(*(np.stack([getattr(m, name) for m in moments]) for name in names))


@dataclass(frozen=True, slots=True)
class MoodEffect:
    """The effect of several weighted moods.

    Attributes:
        stride, cycle, body_bob, body_height, step_height, sway, wander, looseness: factors.
        duty: added to the duty factor.
        pitch, head, tail: angles by which they are raised [rad].
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


FACTORS = tuple(f.name for f in fields(MoodEffect) if f.default == 1.0)
ANGLES = ("pitch", "head", "tail")


def blend_moods(weights: Mapping[str, float], moods: Mapping[str, Mood]) -> MoodEffect:
    """Return the effect of several moods together.

    Args:
        weights: by the names of moods.
        moods: all known moods.
    """
    values = dict.fromkeys(FACTORS, 1.0) | dict.fromkeys(("duty", *ANGLES), 0.0)
    for name, weight in weights.items():
        mood = moods[name]
        for factor in FACTORS:
            values[factor] *= getattr(mood, factor) ** weight
        for angle in ANGLES:
            values[angle] += math.radians(getattr(mood, f"{angle}_deg")) * weight
        values["duty"] += mood.duty * weight
    return MoodEffect(**values)


def apply_mood(pace: Pace, effect: MoodEffect, figure: Figure, legs: LegLayout) -> Pace:
    """Return the pace of a creature in a mood.

    Args:
        pace: without a mood.
        effect: of its moods.
        figure: its figure at its scale.
        legs: at rest.
    """
    if not pace.stride:
        return pace
    carrying = [leg for leg, held in enumerate(pace.held) if not held]
    legs = legs.only(carrying, pace.lateral_offset)
    lowest = BODY_HEIGHTS.lowest * figure.belly
    tallest = BODY_HEIGHTS.walk * legs.tallest()
    height = pace.body_height * effect.body_height
    # An author may have asked for more than the defaults allow.
    height = min(max(height, min(lowest, pace.body_height)), max(tallest, pace.body_height))
    gait = _with_longer_stance(pace.carrying, effect.duty)
    longest = legs.longest_stride(gait, height)
    cycle, bounce = pace.cycle * effect.cycle, pace.bounciness * effect.body_bob
    if pace.flight is not None:
        # No faster than free fall, unless the author asked for it.
        free = pace.flight.amplitude * GRAVITY * cycle * cycle
        bounce = min(bounce, max(free, pace.bounciness * effect.cycle**2))
    most = max(STRIDE_OF_LONGEST * longest, min(pace.stride, longest))
    return replace(
        pace,
        gait=gait.among(~pace.held),
        body_height=height,
        cycle=cycle,
        stride=min(pace.stride * effect.stride, most),
        longest=longest,
        bounciness=bounce,
        step_height=pace.step_height * effect.step_height,
    )


def _with_longer_stance(gait: Gait, duty: float) -> Gait:
    """Return a gait with `duty` added to its duty factor, without new flights."""
    if not duty or len(gait.flights()):
        return gait
    longer = gait.with_duty(min(max(float(gait.duty.mean()) + duty, MIN_DUTY), MAX_DUTY))
    return gait if len(longer.flights()) else longer


class MoodSchedule:
    """The paces without moods, and the moods, of a herd.

    Attributes:
        neutral: last pace of each creature without its mood.
        manners: how each walks without its mood; None for one that stands.
        effects: start time [s] and effect of all moods of each creature, in order.
    """

    def __init__(
        self,
        cast: Sequence[tuple[int, Creature, Figure]],
        neutral: Sequence[Pace],
        legs: Sequence[LegLayout],
        moods: Mapping[str, Mood],
    ) -> None:
        self.figures = [figure for _, _, figure in cast]
        self.legs, self.moods = legs, moods
        self.neutral = list(neutral)
        self.manners: list[Manner | None] = [member.walk for _, member, _ in cast]
        start = -2.0 * STYLE_CHANGE_TIME
        self.effects = [[(start, blend_moods(member.mood, moods))] for _, member, _ in cast]
        self._style: MotionStyle | None = None

    def neutral_pace(self, c: int, order: ChangeGait, where: str = "do") -> Pace:
        """Return the pace of an order without the creature's mood.

        Args:
            c: number of the creature.
            order: to change the gait.
            where: path of the order in the scene.

        Raises:
            SceneError: if the legs cannot walk so.
        """
        return choose_pace(where, order, self.figures[c], self.legs[c])

    def change_gait(self, c: int, order: ChangeGait) -> None:
        """Follow an order to change the gait, at its own speed.

        Raises:
            SceneError: if the legs cannot walk so.
        """
        self.neutral[c] = self.neutral_pace(c, order)
        self.manners[c] = order

    def keep_speed(self, c: int, speed: float) -> None:
        """Let a creature keep a speed that holds without its mood, or the greatest [m/s]."""
        self.neutral[c] = self.neutral_at(c, min(speed, self.neutral[c].top_speed))

    def neutral_at(self, c: int, speed: float) -> Pace:
        """Return the pace of a creature without its mood at a speed that it can do [m/s]."""
        manner, last = self.manners[c], self.neutral[c]
        if manner is None or not last.stride:
            return last
        asked = manner.model_copy(update={"speed": speed, "stride": None, "cycle": None})
        where, figure, legs = "do", self.figures[c], self.legs[c]
        try:
            return choose_pace(where, asked, figure, legs, last.gait_name)
        except SceneError:
            return choose_pace(where, asked, figure, legs)

    def between(self, c: int, last: Pace, pace: Pace) -> list[Pace]:
        """Return the paces without its mood that lead a creature from one to another."""
        manner = self.manners[c]
        if manner is None or manner.gait != AUTO:
            return []
        build = build_of(self.figures[c], self.legs[c])
        gaits, _ = ladder(build, len(last.held))
        if last.gait_name not in gaits or pace.gait_name not in gaits:
            return []
        first, after = gaits.index(last.gait_name), gaits.index(pace.gait_name)
        step = 1 if after > first else -1
        names = gaits[first + step : after : step] if after != first else ()
        return [self.neutral_at(c, comfortable_speed(build, name)) for name in names]

    def change_mood(self, c: int, weights: Mapping[str, float], time: float) -> None:
        """Follow an order to change the mood at `time` [s]."""
        self.effects[c].append((time, blend_moods(weights, self.moods)))

    def pace(self, c: int) -> Pace:
        """Return the pace of a creature in its gait and mood."""
        return self.in_mood(c, self.neutral[c])

    def in_mood(self, c: int, neutral: Pace) -> Pace:
        """Return what becomes of a pace in a creature's mood."""
        return apply_mood(neutral, self.effects[c][-1][1], self.figures[c], self.legs[c])

    def style(self, time: float) -> MotionStyle:
        """Return the motion style at `time` [s]; the same object while nothing changes."""
        settled = max(since for own in self.effects for since, _ in own) + 2.0 * STYLE_CHANGE_TIME
        if self._style is None or time <= settled:
            self._style = MotionStyle(
                head_raise=self._value("head", time),
                head_turn=np.ones(len(self.effects)),
                tail_raise=self._value("tail", time),
                body_pitch=self._value("pitch", time),
                sway=self._value("sway", time),
                wander=self._value("wander", time),
                looseness=self._value("looseness", time),
            )
        return self._style

    def _value(self, name: str, time: float) -> Array:
        """Return one parameter of the effects (C,) at `time` [s]."""
        result = np.empty(len(self.effects))
        for c, own in enumerate(self.effects):
            before = own[0][1]
            result[c] = getattr(before, name)
            for since, effect in own[1:]:
                step = getattr(effect, name) - getattr(before, name)
                done = min(max((time - since) / STYLE_CHANGE_TIME, 0.0), 1.0)
                result[c] += step * ease(np.array(done))
                before = effect
        return result
