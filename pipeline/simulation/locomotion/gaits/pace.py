"""Pace: how a creature walks, with every parameter known."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.curves import cyclic
from pipeline.simulation.locomotion.gaits.gait import FlightBounce, Gait, share_of_run
from pipeline.simulation.spatial import Array
from pipeline.spec.walk import Manner

# One bounce, from one touchdown to the next: the legs give, then push.
BOUNCE_SHAPE = np.array([-1.0, -0.1, 1.0, 0.1])


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
        top_speed: the greatest that the legs can do [m/s].
        hurried_speed: of one that hurries [m/s].
        gait_name: of the gait; empty if it is written out.
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
    hurried_speed: float = 0.0
    gait_name: str = ""

    @property
    def speed(self) -> float:
        """Speed over level ground [m/s]."""
        return self.stride / self.cycle

    @cached_property
    def carrying(self) -> Gait:
        """The gait of the legs that are not held up."""
        return Gait(self.gait.up[~self.held], self.gait.down[~self.held])

    @cached_property
    def running(self) -> float:
        """How far it is a run, 0 to 1."""
        duty = self.carrying.duty
        return share_of_run(float(duty.mean())) if len(duty) and self.stride else 0.0

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


def is_same_pace(a: Pace, b: Pace) -> bool:
    """Return whether a creature goes alike in two paces."""
    names = ("cycle", "stride", "body_height", "bounciness", "step_height", "lateral_offset")
    same = all(getattr(a, name) == getattr(b, name) for name in names)
    gaits = ((a.gait.up, b.gait.up), (a.gait.down, b.gait.down), (a.held, b.held))
    return same and all(np.array_equal(x, y) for x, y in gaits)


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
