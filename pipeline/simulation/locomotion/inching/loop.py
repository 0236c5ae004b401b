"""Loop: the shape that an inchworm would like to have between its feet.

Let s run from 0 at the rear foot to 1 at the front one. A chain whose links point
θ(s) = A sin 2πs upward leaves the ground along it, rises into a loop and comes back
along it; its ends are Σ l cos θ apart, in the limit of many links J₀(A) of its length.
It is close to the elastica, the shape of least bending, of a rod whose ends are clamped
and pushed together: a low arch while they are far apart, an omega when they meet.

Feet that point elsewhere than from one to the other pull θ along near them.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.locomotion.inching.chain import Chain
from pipeline.simulation.spatial import Array

GREATEST = 2.0
"""Amplitude A of the tightest loop [rad]; at 2.4 its two sides would meet."""

LEAST = 0.05
"""Least amplitude: below it a chord hardly depends on the amplitude."""

NEWTON = 12
"""Iterations; eight are enough for the last bit anywhere between the bounds."""

PULL = 3.0
"""How fast the direction of a foot is forgotten along the chain."""


def chord(chain: Chain, amplitude: Array | float) -> Array:
    """Return how far apart the feet's inner ends are in loops of `amplitude` (...) [m]."""
    wave = np.sin(2.0 * np.pi * chain.along)
    θ = np.asarray(amplitude)[..., None] * wave
    # By rows: a BLAS would let the last bit depend on how many there are.
    result: Array = (np.cos(θ) * chain.spans).sum(axis=-1)
    return result


def neck(chain: Chain, amplitude: Array) -> Array:
    """Return how far apart the two sides of loops of `amplitude` (n,) come [m].

    Where they lean over, A > π/2, that is where they stand upright.
    """
    s = chain.along
    θ = amplitude[:, None] * np.sin(2.0 * np.pi * s)
    sides = np.where(np.abs(s - 0.5) > 0.25, np.maximum(np.cos(θ), 0.0), 0.0)
    result: Array = chord(chain, amplitude) - (sides * chain.spans).sum(axis=1)
    return result


def amplitude(chain: Chain, chords: Array) -> Array:
    """Return the amplitudes (n,) of loops over `chords` (n,) [m]; see `chord`."""
    wave = np.sin(2.0 * np.pi * chain.along)
    low, high = chord(chain, np.array([GREATEST, LEAST]))
    wanted = np.clip(chords, low, high)
    # J₀(A) = 1 - A²/4 + ..., a bound from above on a curve without a turning point between.
    A = np.clip(2.0 * np.sqrt(1.0 - wanted / chain.free), LEAST, GREATEST)
    for _ in range(NEWTON):
        slope = -(np.sin(A[:, None] * wave) * wave * chain.spans).sum(axis=-1)
        A = np.clip(A - (chord(chain, A) - wanted) / slope, LEAST, GREATEST)
    return A


def bends(chain: Chain, chords: Array, slope: Array, rear: Array, front: Array) -> Array:
    """Return how each link points higher than the one behind it (n, m + 1) [rad].

    Args:
        chain: the worm.
        chords: (n,) from one foot's inner end to the other's [m].
        slope: (n,) elevation of that way [rad].
        rear: (n,) elevation of the rear foot [rad].
        front: (n,) of the front foot [rad].
    """
    s = chain.along
    θ = slope[:, None] + amplitude(chain, chords)[:, None] * np.sin(2.0 * np.pi * s)
    θ += (rear - slope)[:, None] * (1.0 - s) ** PULL + (front - slope)[:, None] * s**PULL
    result: Array = np.diff(np.column_stack([rear, θ, front]), axis=1)
    return result
