"""Moods: what they change of a pace, and of how a creature carries itself.

A mood asks; the legs decide. A stride that they cannot do becomes the longest that they
can, a height that they do not reach the tallest that they do.

Source: Sims 1987, 3.2.4 and 9.1.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.pace import CLEARANCE, EASY, GRAVITY, WALKS_AT, Pace
from pipeline.simulation.locomotion.gaits.spread import Spread
from pipeline.spec.mood import Mood

LEAST_DUTY, MOST_DUTY = 0.3, 0.85
"""Parts of a cycle that a foot may be down in a mood."""


@dataclass(frozen=True, slots=True)
class Feeling:
    """Several moods by their weights, as one.

    Attributes:
        stride, cycle, bounciness, body_height, step_height, sway, wander, looseness: factors.
        duty: part of the cycle that feet stay down longer.
        pitch, head, tail: by how much they are raised [rad].
    """

    stride: float = 1.0
    cycle: float = 1.0
    bounciness: float = 1.0
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
    "bounciness",
    "body_height",
    "step_height",
    "sway",
    "wander",
    "looseness",
)
ANGLES = ("pitch", "head", "tail")


def blended(mix: Mapping[str, float], moods: Mapping[str, Mood]) -> Feeling:
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
    return Feeling(**values)


def in_mood(pace: Pace, feeling: Feeling, figure: Figure, legs: Spread) -> Pace:
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
    cycle, bounce = pace.cycle * feeling.cycle, pace.bounciness * feeling.bounciness
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
