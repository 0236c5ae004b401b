"""Stick and slip: what dry surfaces do when they rub slowly.

A spring of stiffness k is stretched at a speed v while its end sticks; when its force has grown
from that of sliding to that of sticking, F_d to F_s, it lets go, slips for half its own
oscillation T, and sticks again. A cycle lasts 2 (F_s - F_d) / (k v) + T / 2: slow joints tick,
quick ones squeak, and none squeaks higher than it can swing.

Source: Bowden and Leben 1939; the closed form is that of a mass on a belt with two frictions.
"""

from __future__ import annotations

import numpy as np

from audio.banks import Signal
from audio.grid import SAMPLE_RATE

SLIPPING = 0.2
"""Share of a cycle that is slip, at the greatest speed."""


def slips_a_second(top: Signal, share: Signal) -> Signal:
    """Return how often a joint slips [1/s]: (N,).

    Args:
        top: (N,) slips a second at the greatest speed.
        share: (N,) of that speed, 0 to 1.
    """
    sticking = (1 - SLIPPING) / np.maximum(share, 1e-4)
    return np.asarray(top / (sticking + SLIPPING))


def slipped(rate: Signal, rough: float, rng: np.random.Generator) -> Signal:
    """Return impulses at the times of slips, the first at the first sample: (N,).

    Args:
        rate: (N,) slips a second.
        rough: share of a cycle by which they come early or late, as surfaces are not even.
        rng: of that, and of how much each lets go.
    """
    phase = np.concatenate(([0.0], np.cumsum(rate)[:-1])) / SAMPLE_RATE
    count = int(phase[-1]) + 1
    wanted = np.arange(count) + rough * rng.standard_normal(count)
    wanted[0] = 0.0
    at = np.interp(np.sort(wanted), phase, np.arange(phase.size))
    force = 1 + 2 * rough * rng.standard_normal(count)
    whole = np.minimum(at.astype(np.int64), rate.size - 2)
    impulses = np.zeros(rate.size)
    # Between samples an impulse is shared by both.
    np.add.at(impulses, whole, force * (1 - (at - whole)))
    np.add.at(impulses, whole + 1, force * (at - whole))
    return impulses


def jolt(pitch: float) -> Signal:
    """Return the push that a slip gives, without any constant part: (K,).

    Args:
        pitch: slips a second at the greatest speed.
    """
    length = max(int(SLIPPING * SAMPLE_RATE / pitch), 4)
    x = 2 * np.pi * (np.arange(length) + 0.5) / length
    # The slope of a bell: what is let go moves on and comes to rest.
    return np.asarray(np.sin(x))
