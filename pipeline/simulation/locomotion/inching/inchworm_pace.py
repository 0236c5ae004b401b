"""Pace of an inchworm: how it was asked to walk, every parameter known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.gaits.pace import cycle_and_stride
from pipeline.simulation.locomotion.inching.inchworm_chain import (
    MAX_AMPLITUDE,
    MIN_AMPLITUDE,
    REAR,
    InchwormChain,
    loop_bends,
    loop_chord,
    loop_neck,
)
from pipeline.spec.cast import Creature
from pipeline.spec.walk import Walk

MAX_STRETCH = 0.972
"""How far the feet may be apart, as a part of the chain's length between them: a low arch
is left, which can still be bent up or down (Sims 1987, 6.3)."""

BEND_FRACTION = 0.85
"""How far joints bend in the tightest loop on level ground, as a part of their limits;
the rest is for ground that is not level."""

MIN_LOOP_GAP = 2.05
"""Least distance of the middles of the loop's two sides, in radii of the thickest link."""

DEFAULT_STRIDE = 0.92
"""A stride that nobody asked for, as a part of the longest that the chain can do."""

CYCLE_PERIODS = 4.6
"""Duration of a cycle in the periods of a pendulum of the worm's length, over 2π."""

FOOT_LIFTS = (0.045, 0.10)
"""How high the rear and the front foot are lifted, as parts of the worm's length."""

UNUSED_KEYS = {
    "gait": "has no legs to time: its ends take turns",
    "duty": "has no legs to time: its ends take turns",
    "body_height": "lies on the ground: its loop is as high as its stride makes it",
    "swing": "lifts its ends by its loop, and has no legs that swing",
    "bounciness": "has no body that bounces",
    "path": "goes straight on, and follows no path",
    "repeat": "goes straight on, and follows no path",
}
"""Words of walking that mean nothing to an inchworm, and why."""


@dataclass(frozen=True, slots=True)
class InchwormPace:
    """How one worm goes.

    Attributes:
        cycle: duration of a cycle, a step of either end [s].
        stride: way of a cycle over level ground [m].
        chords: from one foot's inner end to the other's, drawn up and stretched [m].
        bounds: of these on any ground [m].
        lifts: how high the rear and the front foot clear the ground [m].
    """

    cycle: float
    stride: float
    chords: tuple[float, float]
    bounds: tuple[float, float]
    lifts: tuple[float, float]


def resolve_inchworm_pace(number: int, member: Creature, chain: InchwormChain) -> InchwormPace:
    """Choose what the author left open so that it suits the worm.

    Args:
        number: place in the cast.
        member: words.
        chain: the worm.

    Raises:
        SceneError: if a word means nothing to a worm, or the stride is more than it can do.
    """
    words = member.walk or Walk()
    _refuse_unused_keys(number, member, words)
    longest = MAX_STRETCH * chain.free
    shortest = min(_shortest_chord(chain), longest)
    most = longest - shortest
    natural = CYCLE_PERIODS * math.sqrt(chain.length / GRAVITY)
    cycle, stride = cycle_and_stride(words, natural, DEFAULT_STRIDE * most)
    if member.walk is not None and (stride > most or most <= 0.0):
        raise SceneError([Problem(f"cast[{number}].walk", _stride_message(member, stride, most))])
    # A worm that takes short steps neither stretches nor loops as far as it could.
    spare = 0.5 * (most - min(stride, most))
    step = words.step_height
    return InchwormPace(
        cycle,
        stride,
        (shortest + spare, longest - spare),
        (shortest, longest),
        (FOOT_LIFTS[0] * chain.length, FOOT_LIFTS[1] * chain.length)
        if step is None
        else (step, step),
    )


def _refuse_unused_keys(number: int, member: Creature, words: Walk) -> None:
    defaults = Walk()
    problems = [
        Problem(
            f"cast[{number}].walk.{word}",
            f"'{member.figure}' is an inchworm, which {reason}; take `{word}` away",
        )
        for word, reason in UNUSED_KEYS.items()
        if getattr(words, word) != getattr(defaults, word)
    ]
    if problems:
        raise SceneError(problems)


def _stride_message(member: Creature, stride: float, most: float) -> str:
    if most <= 0.0:
        return (
            f"'{member.figure}' cannot draw its ends together, its joints bend too little or it "
            "is too thick; widen their limits with `joints`, or take `walk` away"
        )
    return (
        f"a stride (speed × cycle) of {stride:.3g} is more than '{member.figure}' can do; "
        f"at this scale at most {most:.3g} works: lower the speed or shorten the cycle"
    )


def _shortest_chord(chain: InchwormChain) -> float:
    """Return the shortest chord of a loop on level ground that the worm can bend to [m]."""
    amplitudes = np.linspace(MIN_AMPLITUDE, MAX_AMPLITUDE, 118)
    flat = np.zeros(len(amplitudes))
    chords = loop_chord(chain, amplitudes)
    q = chain.joint_values(loop_bends(chain, chords, flat, flat, flat))
    batch = chain.batches[REAR]
    good = ((q >= BEND_FRACTION * batch.lower[0]) & (q <= BEND_FRACTION * batch.upper[0])).all(
        axis=1
    )
    good &= loop_neck(chain, amplitudes) >= MIN_LOOP_GAP * chain.thickness
    # The tightest of those that lead there without a joint at its limit.
    last = int(np.argmin(good)) - 1 if not good.all() else len(good) - 1
    return float(chords[last]) if last >= 0 else chain.free
