"""Pace: how a creature walks, with every parameter known."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.curves import cyclic
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits.gait import FlightBounce, Gait
from pipeline.simulation.locomotion.gaits.named_gaits import choose_gait, walking_legs
from pipeline.simulation.locomotion.gaits.stride_limits import LegLayout, stride_too_long
from pipeline.simulation.spatial import Array
from pipeline.spec.walk import Manner, Walk


@dataclass(frozen=True, slots=True)
class BodyHeights:
    """Bounds of default body heights.

    Attributes:
        lowest: over level ground, in depths of the belly.
        run, walk, stand: greatest height with flights, without, and standing, as fractions of the
            tallest that the legs reach: straight legs have no room for a stride.
    """

    lowest: float = 1.25
    run: float = 0.92
    walk: float = 0.94
    stand: float = 0.99


@dataclass(frozen=True, slots=True)
class FlightRhythm:
    """Defaults of gaits with flights.

    Attributes:
        periods: duration of a cycle with one flight and with more, in periods of a pendulum of the
            legs' length, over 2π, as a horse gallops and trots (Heglund and Taylor 1988).
        max_stride: in leg lengths.
        max_bounce: in leg lengths.
        trailing_fraction: fraction of its swing in which a foot has hardly left its place: reach is
            needed for it.
    """

    periods: tuple[float, float] = (1.5, 1.85)
    max_stride: float = 1.3
    max_bounce: float = 0.1
    trailing_fraction: float = 0.2


BODY_HEIGHTS, FLIGHT_RHYTHM = BodyHeights(), FlightRhythm()

# Default stride, as a fraction of the longest that the legs can do.
STRIDE_OF_LONGEST = 0.85

# Default duration of a cycle without flights, in periods of a pendulum of the legs' length, over
# 2π.
PERIODS = {"insect": 2.6, "mammal": 3.1}

# Longest default stride without flights, in leg lengths: upright legs swing farther than sprawling
# ones.
MAX_STRIDE = {"insect": 0.55, "mammal": 0.95}

# Default step height, in leg lengths.
STEP_HEIGHT = 0.13

# One bounce, from one touchdown to the next: the legs give, then push.
BOUNCE_SHAPE = np.array([-1.0, -0.1, 1.0, 0.1])

# Greatest factor on a stride by speed: the outer legs on a curve, and all while the body speeds up,
# need the rest of their reach.
STRIDE_GROWTH = 1.25

# Greatest factor of hurrying on the speed that suits the legs: longer strides of gaits with flights
# would take cycles in which legs hardly swing.
MAX_HURRY = 2.5

# How far feet that carry a body alone stand under its middle, as a fraction of the way.
CENTERING = 0.9


@dataclass(frozen=True, eq=False)
class Pace:
    """How one creature walks.

    Attributes:
        gait: of its legs.
        cycle: duration of a cycle [s].
        stride: length of a cycle over the ground [m]; 0 for a creature that stands.
        body_height: of the hips over the ground [m].
        bounciness: amplitude of the bounce [m].
        step_height: of the swings [m].
        longest: stride that the legs can do from that height [m].
        flight: bounce of its body if its gait has flights.
        held: (n,) legs that are held up and carry nothing.
        lateral_offset: distance of each foot to the right of its rest position [m].
        top_speed: of legs that hurry [m/s].
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
    lateral_offset: float = 0.0
    top_speed: float = 0.0

    @property
    def speed(self) -> float:
        """Speed over level ground [m/s]."""
        return self.stride / self.cycle

    @property
    def fastest_stride(self) -> float:
        """Stride up to which it grows with the speed; beyond, cadence alone grows [m]."""
        longest = min(STRIDE_OF_LONGEST * self.longest, STRIDE_GROWTH * self.stride)
        return max(longest, self.stride)

    @cached_property
    def carrying(self) -> Gait:
        """The gait of the legs that are not held up."""
        return Gait(self.gait.up[~self.held], self.gait.down[~self.held])

    @cached_property
    def first_down(self) -> float:
        """Phase at which the first foot comes down."""
        return float(self.carrying.down.min(initial=1.0))

    def heave(self, phase: Array) -> Array:
        """Return the body's bounce above its height at `phase`, whole cycles counted [m]."""
        if self.flight is not None:
            return self.bounciness * self.flight.beat(phase)
        turns = self.carrying.beats * (phase - self.first_down)
        return self.bounciness * cyclic(BOUNCE_SHAPE, turns)


def choose_pace(where: str, walk: Manner | None, figure: Figure, legs: LegLayout) -> Pace:
    """Return the pace of a config; what it leaves open suits the legs.

    Args:
        where: path of `walk` in the scene.
        walk: the config; None for a creature that stands.
        figure: at its scale.
        legs: at rest.

    Raises:
        SceneError: if the legs cannot follow the stride or the body height on level ground.
    """
    if not len(legs.lengths):
        return _legless_pace(where, walk, figure)
    walks, walk = walk is not None, walk or Walk()
    own = walking_legs(where, walk, figure)
    held = np.isin(np.arange(len(legs.lengths)), own, invert=True)
    lateral_offset = -CENTERING * float(legs.feet[own, 2].mean()) if held.any() else 0.0
    legs = legs.only(own, lateral_offset)
    leg = float(legs.lengths.mean())
    gait = choose_gait(where, walk, figure, own, legs.hips[:, 0].tolist())
    flight = FlightBounce.of(gait) if walks else None
    height = _body_height(where, walk, walks, figure, gait, flight, legs)
    usual = _usual_rhythm(gait, legs, height, flight, figure.style)
    cycle, stride = cycle_and_stride(walk, *usual)
    longest = legs.longest_stride(gait, height)
    if walks:
        refuse_short_cycle(where, cycle)
    if walks and stride > longest:
        raise SceneError([stride_too_long(where, walk, gait, legs, height, (cycle, stride))])
    return Pace(
        gait.among(~held),
        cycle,
        stride if walks else 0.0,
        height,
        _bounce(gait, flight, leg, cycle) if walk.body_bob is None else walk.body_bob,
        STEP_HEIGHT * leg if walk.step_height is None else walk.step_height,
        longest,
        flight,
        held,
        lateral_offset,
        _top_speed(longest, *usual) if walks else 0.0,
    )


def _body_height(
    where: str,
    walk: Manner,
    walks: bool,
    figure: Figure,
    gait: Gait,
    flight: FlightBounce | None,
    legs: LegLayout,
) -> float:
    height = max(-float(legs.feet[:, 1].mean()), BODY_HEIGHTS.lowest * figure.belly)
    most = BODY_HEIGHTS.stand
    if walks:
        most = BODY_HEIGHTS.walk if flight is None else BODY_HEIGHTS.run
    rise = _rise_while_trailing(gait, flight, float(legs.lengths.mean()))
    height = min(height, most * legs.tallest() - rise)
    height = height if walk.body_height is None else walk.body_height
    if height >= legs.tallest():
        message = f"the legs do not reach the ground from {height:g}; "
        message += f"at this scale less than {legs.tallest():.3g} works"
        raise SceneError([Problem(f"{where}.body_height", message)])
    return height


def _usual_rhythm(
    gait: Gait, legs: LegLayout, height: float, flight: FlightBounce | None, style: str
) -> tuple[float, float]:
    """Return the duration [s] and length [m] of a cycle that suit the legs."""
    leg = float(legs.lengths.mean())
    if flight is None:
        most = STRIDE_OF_LONGEST * legs.longest_stride(gait, height)
        return PERIODS[style] * math.sqrt(leg / GRAVITY), min(MAX_STRIDE[style] * leg, most)
    highest = height + _rise_while_trailing(gait, flight, leg)
    longest = legs.longest_stride(gait, highest, FLIGHT_RHYTHM.trailing_fraction)
    most = STRIDE_OF_LONGEST * longest
    return _flight_cycle(flight, leg), min(FLIGHT_RHYTHM.max_stride * leg, most)


def _bounce(gait: Gait, flight: FlightBounce | None, leg: float, cycle: float) -> float:
    """Return the bounce that suits a cycle [s] of legs of a length [m]."""
    if flight is None:
        # The more beats, the smaller: the body is shaken no harder.
        return 0.018 * leg * min((2.0 / gait.beats) ** 2, 1.0)
    # In flight the body falls freely, unless that would throw it out of its legs' reach.
    return min(flight.amplitude * GRAVITY * cycle * cycle, FLIGHT_RHYTHM.max_bounce * leg)


def _top_speed(longest: float, cycle: float, stride: float) -> float:
    """Return the speed of legs that hurry [m/s].

    Cadence grows as much as a stride that became the longest would.

    Args:
        longest: stride [m].
        cycle: that suits the legs [s].
        stride: that suits the legs [m].
    """
    if not stride:
        return 0.0
    return min((longest / stride) ** 2, MAX_HURRY) * stride / cycle


def quickened(pace: Pace, quickness: float) -> Pace:
    """Return a pace with a factor on its cadence."""
    # A body in flight rises less in less time.
    fall = 1.0 if pace.flight is None else quickness**-2
    return replace(pace, cycle=pace.cycle / quickness, bounciness=pace.bounciness * fall)


def _flight_cycle(flight: FlightBounce, leg: float) -> float:
    """Return the default duration of a cycle with flights [s]."""
    return FLIGHT_RHYTHM.periods[min(len(flight.flights), 2) - 1] * math.sqrt(leg / GRAVITY)


def _rise_while_trailing(gait: Gait, flight: FlightBounce | None, leg: float) -> float:
    """Return the rise of a body in flight while feet still trail [m]."""
    if flight is None:
        return 0.0
    heights = flight.height(gait.up + FLIGHT_RHYTHM.trailing_fraction * gait.swing)
    return max(float(heights.max()), 0.0) * GRAVITY * _flight_cycle(flight, leg) ** 2


def cycle_and_stride(walk: Manner, cycle: float, stride: float) -> tuple[float, float]:
    """Return the duration [s] and the length [m] of a cycle.

    Args:
        walk: config.
        cycle: default duration [s].
        stride: default length [m].
    """
    if walk.stride is not None:
        stride = walk.stride
    elif walk.speed is not None and walk.cycle is not None:
        stride = walk.speed * walk.cycle
    if walk.cycle is not None:
        cycle = walk.cycle
    elif walk.speed is not None:
        cycle = stride / walk.speed
    return cycle, stride


MIN_CYCLE = 0.005
"""Shortest gait cycle [s]: half of a step of the world at 24 frames a second."""


def refuse_short_cycle(where: str, cycle: float) -> None:
    """Refuse a cycle [s] of which the steps of the world would miss all.

    Raises:
        SceneError: it is too short.
    """
    if cycle < MIN_CYCLE:
        message = (
            f"a gait cycle of {cycle:.3g} s is shorter than {MIN_CYCLE:g} s; take a larger scale, "
            "a longer stride or a lower speed"
        )
        raise SceneError([Problem(where, message)])


def _legless_pace(where: str, walk: Manner | None, figure: Figure) -> Pace:
    if walk is not None:
        message = f"figure '{figure.name}' has no legs to walk on; remove `walk`"
        raise SceneError([Problem(where, message)])
    lying = figure.skeleton.links[0].radii[0]
    none = np.zeros(0)
    return Pace(Gait(none, none), 1.0, 0.0, lying, 0.0, 0.0, 0.0, None, none.astype(bool))
