"""Walking parameters of an inchworm."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.gaits.pace import cycle_and_stride, refuse_short_cycle
from pipeline.simulation.locomotion.inching.inchworm_chain import (
    MAX_AMPLITUDE,
    MIN_AMPLITUDE,
    REAR,
    InchwormChain,
    loop_bends,
    loop_chord,
    loop_neck,
)
from pipeline.spec.creature import Creature
from pipeline.spec.walk import Walk

MAX_STRETCH = 0.972
"""Greatest chord, in the length between the feet: the remaining low arch can still bend up or down
(Sims 1987, 6.3)."""

BEND_FRACTION = 0.85
"""Bends of the tightest loop on level ground, as a fraction of joint limits; uneven ground needs
the rest."""

MIN_LOOP_GAP = 2.05
"""Least distance of the middles of the loop's two sides, in radii of the thickest link."""

DEFAULT_STRIDE = 0.92
"""Default stride, as a fraction of the longest."""

CYCLE_PERIODS = 4.6
"""Default cycle duration, in periods of a pendulum of the worm's length, over 2π."""

FOOT_LIFTS = (0.045, 0.10)
"""Default lift of the rear and the front foot, in the worm's length."""

UNUSED_KEYS = {
    "gait": "has no legs to time: its ends take turns",
    "duty": "has no legs to time: its ends take turns",
    "body_height": "lies on the ground: its loop is as high as its stride makes it",
    "swing": "lifts its ends by its loop, and has no legs that swing",
    "body_bob": "has no body that bounces",
    "path": "goes straight on, and follows no path",
    "repeat": "goes straight on, and follows no path",
}
"""Keys of `walk` that do not apply to an inchworm, with the reason."""


@dataclass(frozen=True, slots=True)
class InchwormPace:
    """Walking parameters of one worm.

    Attributes:
        cycle: duration of a cycle, a step of either end [s].
        stride: distance of a cycle over level ground [m].
        chords: between the feet's inner ends, drawn up and stretched [m].
        bounds: of the chord on any ground [m].
        lifts: clearance of the rear and the front foot [m].
    """

    cycle: float
    stride: float
    chords: tuple[float, float]
    bounds: tuple[float, float]
    lifts: tuple[float, float]


def resolve_inchworm_pace(number: int, member: Creature, chain: InchwormChain) -> InchwormPace:
    """Return the walking parameters of a worm, with defaults for keys that are left out.

    Args:
        number: place in the cast.
        member: of the cast.
        chain: the worm.

    Raises:
        SceneError: a key does not apply to a worm, or the stride is too long.
    """
    config = member.walk or Walk()
    _refuse_unused_keys(number, member, config)
    longest = MAX_STRETCH * chain.free
    shortest = min(_shortest_chord(chain), longest)
    longest_stride = longest - shortest
    natural = CYCLE_PERIODS * math.sqrt(chain.length / GRAVITY)
    cycle, stride = cycle_and_stride(config, natural, DEFAULT_STRIDE * longest_stride)
    if member.walk is not None:
        refuse_short_cycle(f"cast[{number}].walk", cycle)
    if member.walk is not None and (stride > longest_stride or longest_stride <= 0.0):
        raise SceneError(
            [Problem(f"cast[{number}].walk", _stride_message(member, stride, longest_stride))]
        )
    # A worm that takes short steps neither stretches nor loops as far as it could.
    spare = 0.5 * (longest_stride - min(stride, longest_stride))
    step = config.step_height
    return InchwormPace(
        cycle,
        stride,
        (shortest + spare, longest - spare),
        (shortest, longest),
        (FOOT_LIFTS[0] * chain.length, FOOT_LIFTS[1] * chain.length)
        if step is None
        else (step, step),
    )


def _refuse_unused_keys(number: int, member: Creature, config: Walk) -> None:
    defaults = Walk()
    problems = [
        Problem(
            f"cast[{number}].walk.{key}",
            f"'{member.figure}' is an inchworm, which {reason}; take `{key}` away",
        )
        for key, reason in UNUSED_KEYS.items()
        if getattr(config, key) != getattr(defaults, key)
    ]
    if problems:
        raise SceneError(problems)


def _stride_message(member: Creature, stride: float, longest_stride: float) -> str:
    if longest_stride <= 0.0:
        return (
            f"'{member.figure}' cannot draw its ends together, its joints bend too little or it "
            "is too thick; widen their limits with `joints`, or take `walk` away"
        )
    return (
        f"a stride (speed × cycle) of {stride:.3g} is more than '{member.figure}' can do; "
        f"at this scale at most {longest_stride:.3g} works: lower the speed or shorten the cycle"
    )


def _shortest_chord(chain: InchwormChain) -> float:
    """Return the chord of the tightest loop that the worm can bend to on level ground [m]."""
    amplitudes = np.linspace(MIN_AMPLITUDE, MAX_AMPLITUDE, 118)
    flat = np.zeros(len(amplitudes))
    chords = loop_chord(chain, amplitudes)
    q = chain.joint_values(loop_bends(chain, chords, flat, flat, flat))
    batch = chain.batches[REAR]
    good = ((q >= BEND_FRACTION * batch.lower[0]) & (q <= BEND_FRACTION * batch.upper[0])).all(
        axis=1
    )
    good &= loop_neck(chain, amplitudes) >= MIN_LOOP_GAP * chain.thickness
    # The tightest one reached before any joint exceeds its limit.
    last = int(np.argmin(good)) - 1 if not good.all() else len(good) - 1
    return float(chords[last]) if last >= 0 else chain.free
