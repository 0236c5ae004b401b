"""Pace: how a creature was asked to walk, every parameter known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits import Gait
from pipeline.simulation.locomotion.gaits_choice import chosen
from pipeline.simulation.locomotion.gaits_flight import Bounce
from pipeline.simulation.locomotion.pace_remedies import too_long
from pipeline.simulation.locomotion.spread import Spread
from pipeline.spec.cast import Creature
from pipeline.spec.walk import Walk

CLEARANCE = 1.25
"""Least height of a body over level ground, as a multiple of the depth of its belly."""

EASY = 0.85
"""A stride that nobody asked for, as a part of the longest that the legs can do."""

RUNS_AT, WALKS_AT, STANDS_AT = 0.92, 0.94, 0.99
"""Greatest body height that is chosen by itself, as a part of the tallest possible."""

GRAVITY = 9.81

PERIODS, QUICK_PERIODS = 2.6, (1.5, 1.85)
"""Duration of a cycle in the periods of a pendulum of the legs' length, over 2π: of a gait
that always has a foot down, and of gaits with one flight a cycle and with more. A horse
gallops and trots about so (Heglund and Taylor 1988)."""

EASY_STRIDE, QUICK_STRIDE = 0.55, 1.3
"""Longest stride that nobody asked for in leg lengths, without and with flights."""

TRAILS = 0.2
"""Part of its swing in which a foot has hardly left its place: a quick gait needs reach
for it."""

HIGHEST_BOUNCE = 0.1
"""Greatest bounce of a gait with flights that nobody asked for, in leg lengths."""


@dataclass(frozen=True, slots=True)
class Pace:
    """How one creature walks, every parameter known.

    Attributes:
        gait: phases of its legs.
        cycle: duration of a cycle [s].
        stride: length of a cycle over the ground [m]; 0 for one that stands.
        body_height: of the hips over the ground [m].
        bounciness: amplitude of the bounce [m].
        step_height: how high feet are lifted [m].
        longest: stride that the legs can do from that height [m].
        flight: how its body bounces if its gait has flights.
    """

    gait: Gait
    cycle: float
    stride: float
    body_height: float
    bounciness: float
    step_height: float
    longest: float
    flight: Bounce | None = None


def pace_of(number: int, member: Creature, figure: Figure, legs: Spread) -> Pace:
    """Choose what the author left open so that it suits the legs.

    Args:
        number: place in the cast.
        member: words.
        figure: at its scale.
        legs: at rest.

    Raises:
        SceneError: if the legs cannot follow the stride or the body height on level ground.
    """
    words = member.walk or Walk()
    if not len(legs.lengths):
        return _legless(number, member, figure)
    leg = float(legs.lengths.mean())
    gait = chosen(number, member, words, figure, legs.hips[:, 0].tolist())
    height = max(-float(legs.feet[:, 1].mean()), CLEARANCE * figure.belly)
    flight = Bounce.of(gait) if member.walk else None
    # Straight legs have no room for a stride: who walks stands a little lower.
    least = STANDS_AT if member.walk is None else WALKS_AT if flight is None else RUNS_AT
    height = min(height, least * legs.tallest() - _rise(gait, flight, leg))
    height = height if words.body_height is None else words.body_height
    if height >= legs.tallest():
        message = f"the legs do not reach the ground from {height:g}; "
        message += f"at this scale less than {legs.tallest():.3g} works"
        raise SceneError([Problem(f"cast[{number}].walk.body_height", message)])
    cycle, stride, bounce = _rhythm(words, gait, legs, height, flight)
    longest = legs.longest_stride(gait, height)
    if member.walk and stride > longest:
        raise SceneError([too_long(number, words, gait, legs, height, (cycle, stride))])
    return Pace(
        gait,
        cycle,
        stride if member.walk else 0.0,
        height,
        bounce if words.bounciness is None else words.bounciness,
        0.13 * leg if words.step_height is None else words.step_height,
        longest,
        flight,
    )


def _rhythm(
    words: Walk, gait: Gait, legs: Spread, height: float, flight: Bounce | None
) -> tuple[float, float, float]:
    """Return the duration [s] and length [m] of a cycle, and the bounce that suits it [m]."""
    leg = float(legs.lengths.mean())
    pendulum = math.sqrt(leg / GRAVITY)
    if flight is None:
        most = EASY * legs.longest_stride(gait, height)
        # The more beats, the smaller: the body is shaken no harder.
        bounce = 0.018 * leg * min((2.0 / gait.beats) ** 2, 1.0)
        return *timing(words, PERIODS * pendulum, min(EASY_STRIDE * leg, most)), bounce
    most = EASY * legs.longest_stride(gait, height + _rise(gait, flight, leg), TRAILS)
    cycle, stride = timing(words, _quick(flight, leg), min(QUICK_STRIDE * leg, most))
    # In flight the body falls freely, unless that would throw it out of its legs' reach.
    return cycle, stride, min(flight.amplitude * GRAVITY * cycle * cycle, HIGHEST_BOUNCE * leg)


def _quick(flight: Bounce, leg: float) -> float:
    """Return the duration of a cycle with flights that nobody asked for [s]."""
    return QUICK_PERIODS[min(len(flight.flights), 2) - 1] * math.sqrt(leg / GRAVITY)


def _rise(gait: Gait, flight: Bounce | None, leg: float) -> float:
    """Return how far a body has flown up while feet still trail [m]."""
    if flight is None:
        return 0.0
    heights = flight.height(gait.up + TRAILS * gait.swing)
    return max(float(heights.max()), 0.0) * GRAVITY * _quick(flight, leg) ** 2


def timing(words: Walk, cycle: float, stride: float) -> tuple[float, float]:
    """Return the duration [s] and the length [m] of a cycle.

    Args:
        words: what the author said of them.
        cycle: duration if nothing is said [s].
        stride: length if nothing is said [m].
    """
    if words.stride is not None:
        stride = words.stride
    elif words.speed is not None and words.cycle is not None:
        stride = words.speed * words.cycle
    if words.cycle is not None:
        cycle = words.cycle
    elif words.speed is not None:
        cycle = stride / words.speed
    return cycle, stride


def _legless(number: int, member: Creature, figure: Figure) -> Pace:
    if member.walk is not None:
        message = f"figure '{member.figure}' has no legs to walk on; take `walk` away"
        raise SceneError([Problem(f"cast[{number}].walk", message)])
    lying = figure.skeleton.links[0].radii[0]
    return Pace(Gait(np.zeros(0), np.zeros(0)), 1.0, 0.0, lying, 0.0, 0.0, 0.0)
