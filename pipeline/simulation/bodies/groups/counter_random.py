"""Counter-based random numbers: they depend on their purpose, not on when they are asked for.

The tenth drop of a slot falls on one place whatever the frame rate, and whether or not the ninth
was ever computed.

Source: Steele, Lea and Flood 2014 (SplitMix64).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array

GAMMA = np.uint64(0x9E3779B97F4A7C15)
MIX_FACTORS = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)

MANTISSA_UNIT = 2.0**-53


class CounterRandom:
    """Random numbers of one group.

    Args:
        seed: of the scene.
        name: of the group.
    """

    def __init__(self, seed: int, name: str) -> None:
        self._key = np.uint64(generator(seed, name).integers(2**63))

    def uniform(
        self, slot: NDArray[np.int64], generation: NDArray[np.int64] | int, draw: int
    ) -> Array:
        """Returns numbers in [0, 1), the shape of `slot`.

        Args:
            slot: number of the member.
            generation: number of its life.
            draw: number of the purpose; another one for each use.
        """
        state = _mix(np.asarray(slot).astype(np.uint64) + self._key)
        state = _mix(state + np.asarray(generation).astype(np.int64).astype(np.uint64))
        state = _mix(state + np.uint64(draw))
        return (state >> np.uint64(11)).astype(float) * MANTISSA_UNIT


def _mix(state: NDArray[np.uint64]) -> NDArray[np.uint64]:
    # Wrap-around of 64-bit integers is intended.
    with np.errstate(over="ignore"):
        state = state + GAMMA
        state = (state ^ (state >> np.uint64(30))) * MIX_FACTORS[0]
        state = (state ^ (state >> np.uint64(27))) * MIX_FACTORS[1]
    return state ^ (state >> np.uint64(31))
