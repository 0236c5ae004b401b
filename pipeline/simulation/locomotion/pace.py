"""Pace: how a creature was asked to walk, every parameter known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits import Gait
from pipeline.simulation.locomotion.gaits_choice import chosen, listed
from pipeline.simulation.locomotion.gaits_flight import Bounce
from pipeline.simulation.spatial import Array
from pipeline.spec.cast import Creature
from pipeline.spec.walk import Walk

REACH = 0.97
"""How far a leg may stretch, as a part of its length: beyond lies the singularity of
full extension (Sims 1987, 6.3)."""

CLEARANCE = 1.25
"""Least height of a body over level ground, as a multiple of the depth of its belly."""

EASY = 0.85
"""A stride that nobody asked for, as a part of the longest that the legs can do."""

RUNS_AT, WALKS_AT, STANDS_AT = 0.92, 0.94, 0.99
"""Greatest body height that is chosen by itself, as a part of the tallest possible."""

GRAVITY = 9.81

LEAST_DUTY = 0.05
"""Part of the cycle that a foot has to be down at least."""

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
        flight: how its body bounces if its gait has flights.
    """

    gait: Gait
    cycle: float
    stride: float
    body_height: float
    bounciness: float
    step_height: float
    flight: Bounce | None = None


@dataclass(frozen=True, eq=False)
class Spread:
    """The legs of one creature at rest.

    Attributes:
        hips, feet: (n, 3) relative to the body [m].
        lengths: (n,) stretched out [m].
    """

    hips: Array
    feet: Array
    lengths: Array

    def tallest(self) -> float:
        """Return the greatest body height from which all feet reach level ground [m]."""
        across = np.abs(self.feet[:, 2] - self.hips[:, 2])
        room = (REACH * self.lengths) ** 2 - across**2
        return float((np.sqrt(np.maximum(room, 0.0)) - self.hips[:, 1]).min())

    def longest_stride(self, gait: Gait, height: float, trails: float = 0.0) -> float:
        """Return the longest cycle over level ground that the legs can do [m].

        Args:
            gait: phases of the legs.
            height: of the body [m].
            trails: part of its swing for which a foot is to stay within reach of its place.
        """
        across = np.abs(self.feet[:, 2] - self.hips[:, 2])
        drop = height + self.hips[:, 1]
        room = (REACH * self.lengths) ** 2 - drop**2 - across**2
        # Half of the ground covered in stance lies before the foot at rest, half behind it.
        forward = np.sqrt(np.maximum(room, 0.0)) - np.abs(self.feet[:, 0] - self.hips[:, 0])
        through = gait.duty + 2.0 * trails * gait.swing
        return max(float((2.0 * forward / through).min()), 0.0)


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
    if member.walk and stride > legs.longest_stride(gait, height):
        raise SceneError([too_long(number, words, gait, legs, height, (cycle, stride))])
    return Pace(
        gait,
        cycle,
        stride if member.walk else 0.0,
        height,
        bounce if words.bounciness is None else words.bounciness,
        0.13 * leg if words.step_height is None else words.step_height,
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


def too_long(
    number: int,
    words: Walk,
    gait: Gait,
    legs: Spread,
    height: float,
    rhythm: tuple[float, float],
) -> Problem:
    """Return what is wrong with a stride that the legs cannot do, and what they could do.

    Args:
        number: place in the cast.
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
        f"stride = reach / duty, at most {_below(most)}; take {listed(ways)}"
    )
    return Problem(f"cast[{number}].walk", message)


def _other_timings(words: Walk, cycle: float, most: float) -> list[str]:
    """Return what to write instead of the author's stride, speed or cycle so that it works."""
    stride = _below(most)
    if words.stride is not None and words.speed is not None and words.cycle is not None:
        return [f"stride: {stride} with speed: {float(stride) / cycle:.9g}"]
    if words.stride is not None:
        return [f"stride: {stride}"]
    if words.speed is not None and words.cycle is not None:
        return [f"speed: {_below(most / cycle)}", f"cycle: {_below(most / words.speed)}"]
    return []


def _height_for(stride: float, gait: Gait, legs: Spread, height: float) -> float | None:
    """Return the greatest body height below `height` from which a stride can be done [m]."""
    heights = np.linspace(height, 0.5 * height, 51)[1:]
    good = [float(h) for h in heights if legs.longest_stride(gait, float(h)) >= stride]
    return good[0] if good else None


def _below(value: float) -> str:
    """Return `value` in three digits, never more than it is."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2) if value > 0.0 else 1.0
    return f"{math.floor(value / step + 1e-9) * step:.3g}"


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
    return Pace(Gait(np.zeros(0), np.zeros(0)), 1.0, 0.0, lying, 0.0, 0.0)
