"""Pace: how a creature was asked to walk, every parameter known."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.curves import cyclic
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits.gait import FlightBounce, Gait
from pipeline.simulation.locomotion.gaits.named_gaits import choose_gait, walking_legs
from pipeline.simulation.locomotion.gaits.remedies import too_long
from pipeline.simulation.locomotion.gaits.spread import LegLayout
from pipeline.simulation.spatial import Array
from pipeline.spec.walk import Manner, Walk

CLEARANCE = 1.25
"""Least height of a body over level ground, as a multiple of the depth of its belly."""

EASY = 0.85
"""A stride that nobody asked for, as a part of the longest that the legs can do."""

RUNS_AT, WALKS_AT, STANDS_AT = 0.92, 0.94, 0.99
"""Greatest body height that is chosen by itself, as a part of the tallest possible."""

PERIODS = {"insect": 2.6, "mammal": 3.1}
"""Duration of a cycle in the periods of a pendulum of the legs' length, over 2π, of a gait
that always has a foot down."""

QUICK_PERIODS = 1.5, 1.85
"""Likewise of gaits with one flight a cycle and with more. A horse gallops and trots about so
(Heglund and Taylor 1988)."""

EASY_STRIDE, QUICK_STRIDE = {"insect": 0.55, "mammal": 0.95}, 1.3
"""Longest stride that nobody asked for in leg lengths, without and with flights. Legs that
hang down swing farther than those that sprawl."""

TRAILS = 0.2
"""Part of its swing in which a foot has hardly left its place: a quick gait needs reach
for it."""

HIGHEST_BOUNCE = 0.1
"""Greatest bounce of a gait with flights that nobody asked for, in leg lengths."""

BOUNCE = np.array([-1.0, -0.1, 1.0, 0.1])
"""One bounce, from one coming down of feet to the next: they give, then push."""

UNDER = 0.9
"""How far feet that carry a body alone come under its middle."""


@dataclass(frozen=True, eq=False)
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
        held: (n,) which legs are held up and carry nothing.
        aside: how far to the right of its place at rest each foot is set [m].
    """

    gait: Gait
    cycle: float
    stride: float
    body_height: float
    bounciness: float
    step_height: float
    longest: float
    flight: FlightBounce | None
    held: NDArray[np.bool_]
    aside: float = 0.0

    @cached_property
    def carrying(self) -> Gait:
        """The gait of the legs that are not held up."""
        return Gait(self.gait.up[~self.held], self.gait.down[~self.held])

    @cached_property
    def first_down(self) -> float:
        """Phase at which the first foot comes down."""
        return float(self.carrying.down.min(initial=1.0))

    def heave(self, phase: Array) -> Array:
        """Return how far the body is above its height at `phase`, whole cycles counted [m]."""
        if self.flight is not None:
            return self.bounciness * self.flight.beat(phase)
        return self.bounciness * cyclic(BOUNCE, self.carrying.beats * (phase - self.first_down))


def choose_pace(where: str, words: Manner | None, figure: Figure, legs: LegLayout) -> Pace:
    """Choose what the author left open so that it suits the legs.

    Args:
        where: path of the words in the scene.
        words: how it walks; None if it stands.
        figure: at its scale.
        legs: at rest.

    Raises:
        SceneError: if the legs cannot follow the stride or the body height on level ground.
    """
    if not len(legs.lengths):
        return _legless(where, words, figure)
    walks, words = words is not None, words or Walk()
    own = walking_legs(where, words, figure)
    held = np.isin(np.arange(len(legs.lengths)), own, invert=True)
    aside = -UNDER * float(legs.feet[own, 2].mean()) if held.any() else 0.0
    legs = legs.only(own, aside)
    leg = float(legs.lengths.mean())
    gait = choose_gait(where, words, figure, own, legs.hips[:, 0].tolist())
    height = max(-float(legs.feet[:, 1].mean()), CLEARANCE * figure.belly)
    flight = FlightBounce.of(gait) if walks else None
    # Straight legs have no room for a stride: who walks stands a little lower.
    least = STANDS_AT if not walks else WALKS_AT if flight is None else RUNS_AT
    height = min(height, least * legs.tallest() - _rise(gait, flight, leg))
    height = height if words.body_height is None else words.body_height
    if height >= legs.tallest():
        message = f"the legs do not reach the ground from {height:g}; "
        message += f"at this scale less than {legs.tallest():.3g} works"
        raise SceneError([Problem(f"{where}.body_height", message)])
    cycle, stride, bounce = _rhythm(words, gait, legs, height, flight, figure.style)
    longest = legs.longest_stride(gait, height)
    if walks and stride > longest:
        raise SceneError([too_long(where, words, gait, legs, height, (cycle, stride))])
    return Pace(
        gait.among(~held),
        cycle,
        stride if walks else 0.0,
        height,
        bounce if words.body_bob is None else words.body_bob,
        0.13 * leg if words.step_height is None else words.step_height,
        longest,
        flight,
        held,
        aside,
    )


def _rhythm(
    words: Manner,
    gait: Gait,
    legs: LegLayout,
    height: float,
    flight: FlightBounce | None,
    style: str,
) -> tuple[float, float, float]:
    """Return the duration [s] and length [m] of a cycle, and the bounce that suits it [m]."""
    leg = float(legs.lengths.mean())
    pendulum = math.sqrt(leg / GRAVITY)
    if flight is None:
        most = EASY * legs.longest_stride(gait, height)
        # The more beats, the smaller: the body is shaken no harder.
        bounce = 0.018 * leg * min((2.0 / gait.beats) ** 2, 1.0)
        stride = min(EASY_STRIDE[style] * leg, most)
        return *cycle_and_stride(words, PERIODS[style] * pendulum, stride), bounce
    most = EASY * legs.longest_stride(gait, height + _rise(gait, flight, leg), TRAILS)
    cycle, stride = cycle_and_stride(words, _quick(flight, leg), min(QUICK_STRIDE * leg, most))
    # In flight the body falls freely, unless that would throw it out of its legs' reach.
    return cycle, stride, min(flight.amplitude * GRAVITY * cycle * cycle, HIGHEST_BOUNCE * leg)


def _quick(flight: FlightBounce, leg: float) -> float:
    """Return the duration of a cycle with flights that nobody asked for [s]."""
    return QUICK_PERIODS[min(len(flight.flights), 2) - 1] * math.sqrt(leg / GRAVITY)


def _rise(gait: Gait, flight: FlightBounce | None, leg: float) -> float:
    """Return how far a body has flown up while feet still trail [m]."""
    if flight is None:
        return 0.0
    heights = flight.height(gait.up + TRAILS * gait.swing)
    return max(float(heights.max()), 0.0) * GRAVITY * _quick(flight, leg) ** 2


def cycle_and_stride(words: Manner, cycle: float, stride: float) -> tuple[float, float]:
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


def _legless(where: str, words: Manner | None, figure: Figure) -> Pace:
    if words is not None:
        message = f"figure '{figure.name}' has no legs to walk on; take `walk` away"
        raise SceneError([Problem(where, message)])
    lying = figure.skeleton.links[0].radii[0]
    none = np.zeros(0)
    return Pace(Gait(none, none), 1.0, 0.0, lying, 0.0, 0.0, 0.0, None, none.astype(bool))
