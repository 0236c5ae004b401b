"""Gait timing."""

from __future__ import annotations

import math

from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY


@compiled
def sprung(x: float, rate: float, target: float, quick: float, dt: float) -> tuple[float, float]:
    """Return where something is after `dt`, and its rate.

    Args:
        x: where it is.
        rate: of x.
        target: where it goes to.
        quick: ω; it is there after about 5/ω [rad/s].
        dt: [s].
    """
    away = x - target
    both = rate + quick * away
    decay = math.exp(-quick * dt)
    return target + (away + both * dt) * decay, (rate - quick * both * dt) * decay


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


@compiled
def leg_of(person: Record) -> float:
    """Return the height of the hips, which is the length of a leg [m]."""
    height: float = person.hip_height
    return height


@compiled
def speed_of(person: Record) -> float:
    """Return how fast somebody goes over the ground [m/s]."""
    return math.hypot(person.going[0], person.going[1])


@compiled
def wrapped(angle: float) -> float:
    """Return an angle in (-π, π]."""
    return angle - 2.0 * math.pi * math.ceil((angle - math.pi) / (2.0 * math.pi))


@compiled
def pace_of(person: Record) -> tuple[float, float]:
    """Return cycles a second, and the part of a cycle for which a foot stands."""
    leg = leg_of(person)
    speed = speed_of(person)
    # Who turns or is pushed steps as briskly as one who walks slowly.
    return max(stride_rate(speed, leg), 0.29 * math.sqrt(GRAVITY / leg)), duty(speed, leg)


@compiled
def cycle_of(person: Record, k: int) -> float:
    """Return where a leg is in its own cycle: 0 when its foot may leave the ground."""
    at: float = (person.phase + 0.5 * k) % 1.0
    return at
