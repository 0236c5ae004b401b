"""Stick-slip friction of dry surfaces at low speed.

A spring of stiffness k is stretched at a speed v while its end sticks. When its force has grown
from that of sliding to that of sticking, F_d to F_s, the end slips for half its own oscillation
period T and sticks again. A cycle lasts 2 (F_s - F_d) / (k v) + T / 2: slow joints tick, fast
ones squeak, and the squeak is never higher than the oscillation.

Source: Bowden and Leben 1939; the closed form is that of a mass on a belt with two frictions.
"""

from __future__ import annotations

import numpy as np

from audio.dsp import Signal
from audio.time_grid import SAMPLE_RATE

SLIP_SHARE = 0.2
"""Share of a cycle that is slip, at the greatest speed."""


def slip_rate(top: Signal, relative_speed: Signal) -> Signal:
    """Return the number of slips a second: (N,).

    Args:
        top: (N,) slips a second at the greatest speed.
        relative_speed: (N,) fraction of that speed, 0 to 1.
    """
    sticking = (1 - SLIP_SHARE) / np.maximum(relative_speed, 1e-4)
    return np.asarray(top / (sticking + SLIP_SHARE))


def slip_impulses(rate: Signal, roughness: float, rng: np.random.Generator) -> Signal:
    """Return impulses at the times of slips, the first at the first sample: (N,).

    Args:
        rate: (N,) slips a second.
        roughness: random deviation of the times, as a share of a cycle.
        rng: of times and strengths.
    """
    phase = np.concatenate(([0.0], np.cumsum(rate)[:-1])) / SAMPLE_RATE
    count = int(phase[-1]) + 1
    cycles = np.arange(count) + roughness * rng.standard_normal(count)
    cycles[0] = 0.0
    position = np.interp(np.sort(cycles), phase, np.arange(phase.size))
    force = 1 + 2 * roughness * rng.standard_normal(count)
    whole = np.minimum(position.astype(np.int64), rate.size - 2)
    impulses = np.zeros(rate.size)
    # An impulse between two samples is shared by both.
    np.add.at(impulses, whole, force * (1 - (position - whole)))
    np.add.at(impulses, whole + 1, force * (position - whole))
    return impulses


def slip_pulse(pitch: float) -> Signal:
    """Return the force of one slip, of zero mean: (K,).

    Args:
        pitch: slips a second at the greatest speed.
    """
    length = max(int(SLIP_SHARE * SAMPLE_RATE / pitch), 4)
    x = 2 * np.pi * (np.arange(length) + 0.5) / length
    # The derivative of a bell: the surface accelerates and comes to rest.
    return np.asarray(np.sin(x))
