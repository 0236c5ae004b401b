"""Stride limits: the longest stride of legs, and the error for a stride that is too long."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.named_gaits import join_choices
from pipeline.simulation.spatial import Array
from pipeline.spec.walk import Manner

# Greatest extension of a leg, as a fraction of its length: beyond lies the singularity of full
# extension (Sims 1987, 6.3).
MAX_REACH = 0.97

# Least duty factor that is suggested.
MIN_DUTY = 0.05


@dataclass(frozen=True, eq=False)
class LegLayout:
    """The legs of one creature at rest.

    Attributes:
        hips, feet: (n, 3) relative to the body [m].
        lengths: (n,) stretched out [m].
    """

    hips: Array
    feet: Array
    lengths: Array

    def only(self, legs: Sequence[int], lateral_offset: float = 0.0) -> LegLayout:
        """Return some of the legs, their feet `lateral_offset` to the right [m]."""
        feet = self.feet[legs] + [0.0, 0.0, lateral_offset]
        return LegLayout(self.hips[legs], feet, self.lengths[legs])

    def tallest(self) -> float:
        """Return the greatest body height from which all feet reach level ground [m]."""
        across = np.abs(self.feet[:, 2] - self.hips[:, 2])
        room = (MAX_REACH * self.lengths) ** 2 - across**2
        return float((np.sqrt(np.maximum(room, 0.0)) - self.hips[:, 1]).min())

    def longest_stride(self, gait: Gait, height: float, trailing: float = 0.0) -> float:
        """Return the longest stride over level ground [m].

        Args:
            gait: of the legs.
            height: of the body [m].
            trailing: fraction of its swing for which a foot must stay within reach of its foothold.
        """
        across = np.abs(self.feet[:, 2] - self.hips[:, 2])
        drop = height + self.hips[:, 1]
        room = (MAX_REACH * self.lengths) ** 2 - drop**2 - across**2
        # Half of the ground covered in stance lies before the foot at rest, half behind it.
        forward = np.sqrt(np.maximum(room, 0.0)) - np.abs(self.feet[:, 0] - self.hips[:, 0])
        through = gait.duty + 2.0 * trailing * gait.swing
        return max(float((2.0 * forward / through).min()), 0.0)


def stride_too_long(
    where: str,
    walk: Manner,
    gait: Gait,
    legs: LegLayout,
    height: float,
    rhythm: tuple[float, float],
) -> Problem:
    """Return the error for a stride that the legs cannot do, with the nearest values that work.

    Args:
        where: path of `walk` in the scene.
        walk: its config.
        gait: of the legs.
        legs: at rest.
        height: of the body [m].
        rhythm: duration [s] and length [m] of a cycle.
    """
    cycle, stride = rhythm
    most = legs.longest_stride(gait, height)
    choices = _possible_timings(walk, cycle, most)
    # The duty factor decides how much of the stride a foot has to stand through.
    duty = float(gait.duty.max()) * most / stride
    if duty >= MIN_DUTY:
        choices.append(f"duty: {_rounded_down(duty)}")
    heights = [float(h) for h in np.linspace(height, 0.5 * height, 51)[1:]]
    lower = next((h for h in heights if legs.longest_stride(gait, h) >= stride), None)
    if lower is not None:
        choices.append(f"body_height: {_rounded_down(lower)}")
    message = (
        f"a stride (speed × cycle) of {stride:.3g} is more than the legs can do: at a body height "
        f"of {height:.3g} they reach over {_rounded_down(most * float(gait.duty.max()))} of "
        f"ground, and stride = reach / duty, at most {_rounded_down(most)}; "
        f"take {join_choices(choices)}"
    )
    return Problem(where, message)


def _possible_timings(walk: Manner, cycle: float, most: float) -> list[str]:
    """Return what to write instead of the author's stride, speed or cycle."""
    stride = _rounded_down(most)
    if walk.stride is not None and walk.speed is not None and walk.cycle is not None:
        return [f"stride: {stride} with speed: {float(stride) / cycle:.9g}"]
    if walk.stride is not None:
        return [f"stride: {stride}"]
    if walk.speed is not None and walk.cycle is not None:
        speed, cycle = _rounded_down(most / walk.cycle), most / walk.speed
        return [f"speed: {speed}", f"cycle: {_rounded_down(cycle)}"]
    return []


def _rounded_down(value: float) -> str:
    """Return `value` in three digits, never more than it is."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2) if value > 0.0 else 1.0
    return f"{math.floor(value / step + 1e-9) * step:.3g}"
