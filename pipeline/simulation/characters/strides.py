"""Strides: how quickly legs step at a speed, and for how long a foot stands.

Speeds are compared as Alexander does, as parts of √(g l) of a leg of length l: people of any
size walk alike at equal ones, and run from about 0.7 on.

Source: Grieve and Gear 1966 (the rate of strides grows with speed to the power 0.57); Alexander
1989 (dynamic similarity; when walkers begin to run); Heglund and Taylor 1988 (those who run
lengthen their strides and hardly quicken them).
"""

from __future__ import annotations

import math

from pipeline.simulation.dynamics.compiled import compiled
from pipeline.simulation.dynamics.gravity import GRAVITY

RATE, POWER = 0.4512, 0.57
"""Of strides: 115 steps a minute at 1.4 m/s for a leg of 0.91 m, as grown-ups have."""

SLOWEST = 0.15
"""Speed below which steps become shorter and not rarer, as a part of √(g l)."""

RUN, BLEND = 0.68, 0.16
"""Where running begins, and over what span of speed it takes over from walking."""

RUN_RATE = 0.395
"""Strides of those who run, as a part of √(g / l)."""


@compiled
def relative(speed: float, leg: float) -> float:
    """Return a speed as a part of √(g l)."""
    return speed / math.sqrt(GRAVITY * leg)


@compiled
def eased(x: float) -> float:
    """Go from 0 to 1 as x does, beginning and ending level."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@compiled
def running(speed: float, leg: float) -> float:
    """Return how much of a run it is, 0 to 1."""
    return eased((relative(speed, leg) - RUN) / BLEND)


@compiled
def stride_rate(speed: float, leg: float) -> float:
    """Return cycles a second, two steps each."""
    slow = max(relative(speed, leg), SLOWEST)
    run = running(speed, leg)
    own = (1.0 - run) * RATE * math.pow(slow, POWER) + run * (RUN_RATE + 0.03 * (slow - RUN))
    return own * math.sqrt(GRAVITY / leg)


@compiled
def duty(speed: float, leg: float) -> float:
    """Return for which part of a cycle a foot stands; below one half there is flight."""
    slow = relative(speed, leg)
    run = running(speed, leg)
    walk = 0.72 - 0.21 * min(slow, 0.75)
    return (1.0 - run) * walk + run * max(0.46 - 0.09 * slow, 0.28)
