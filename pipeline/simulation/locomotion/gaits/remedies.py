"""Remedies for a pace that legs cannot keep: the nearest words that work."""

from __future__ import annotations

import math

import numpy as np

from pipeline.errors import Problem
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.named_gaits import join_choices
from pipeline.simulation.locomotion.gaits.spread import LegLayout
from pipeline.spec.walk import Manner

LEAST_DUTY = 0.05
"""Part of the cycle that a foot has to be down at least."""


def too_long(
    where: str,
    words: Manner,
    gait: Gait,
    legs: LegLayout,
    height: float,
    rhythm: tuple[float, float],
) -> Problem:
    """Return what is wrong with a stride that the legs cannot do, and what they could do.

    Args:
        where: path of the words in the scene.
        words: what was asked.
        gait: phases of the legs.
        legs: at rest.
        height: of the body [m].
        rhythm: duration [s] and length [m] of a cycle.
    """
    cycle, stride = rhythm
    most = legs.longest_stride(gait, height)
    ways = _other_timings(words, cycle, most)
    # All that the duty changes is how much of the stride a foot has to stand through.
    duty = float(gait.duty.max()) * most / stride
    if duty >= LEAST_DUTY:
        ways.append(f"duty: {_below(duty)}")
    lower = _height_for(stride, gait, legs, height)
    if lower is not None:
        ways.append(f"body_height: {_below(lower)}")
    message = (
        f"a stride (speed × cycle) of {stride:.3g} is more than the legs can do: at a body height "
        f"of {height:.3g} they reach over {_below(most * float(gait.duty.max()))} of ground, and "
        f"stride = reach / duty, at most {_below(most)}; take {join_choices(ways)}"
    )
    return Problem(where, message)


def _other_timings(words: Manner, cycle: float, most: float) -> list[str]:
    """Return what to write instead of the author's stride, speed or cycle so that it works."""
    stride = _below(most)
    if words.stride is not None and words.speed is not None and words.cycle is not None:
        return [f"stride: {stride} with speed: {float(stride) / cycle:.9g}"]
    if words.stride is not None:
        return [f"stride: {stride}"]
    if words.speed is not None and words.cycle is not None:
        return [f"speed: {_below(most / cycle)}", f"cycle: {_below(most / words.speed)}"]
    return []


def _height_for(stride: float, gait: Gait, legs: LegLayout, height: float) -> float | None:
    """Return the greatest body height below `height` from which a stride can be done [m]."""
    heights = np.linspace(height, 0.5 * height, 51)[1:]
    good = [float(h) for h in heights if legs.longest_stride(gait, float(h)) >= stride]
    return good[0] if good else None


def _below(value: float) -> str:
    """Return `value` in three digits, never more than it is."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2) if value > 0.0 else 1.0
    return f"{math.floor(value / step + 1e-9) * step:.3g}"
