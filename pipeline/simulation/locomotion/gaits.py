"""Gaits: when each foot goes up and comes down within the cycle.

Phases run from 0 to 1. A foot swings from its foot-up to its foot-down phase and
stands from there to its next foot-up.

Source: Sims 1987, 9.2 and 10.3.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.spec.walk import GaitWords

TROT_SWING = 0.42
"""Part of the cycle that a trotting foot is in the air: under a half, so that feet
coming down are firm before the others leave."""


@dataclass(frozen=True, eq=False)
class Gait:
    """A gait for certain legs.

    Attributes:
        up: (n,) foot-up phases, 0 to 1.
        down: (n,) foot-down phases, 0 to 1.
    """

    up: Array
    down: Array

    @property
    def swing(self) -> Array:
        """(n,) part of the cycle that each foot is in the air."""
        result: Array = np.mod(self.down - self.up, 1.0)
        return result

    @property
    def beats(self) -> int:
        """How many times a cycle feet come down."""
        return len(np.unique(np.round(self.down, 6)))


def trot(sides: Sequence[str], ranks: Sequence[int]) -> Gait:
    """Return the gait in which diagonal neighbours move together.

    A walk for two legs, a trot for four, a tripod gait for six.

    Args:
        sides: "l", "r" or "m" of each leg.
        ranks: place of each leg on its side, front to back.
    """
    up = np.array([((rank + (side == "r")) % 2) * 0.5 for side, rank in _pairs(sides, ranks)])
    return Gait(up, np.mod(up + TROT_SWING, 1.0))


def wave(sides: Sequence[str], ranks: Sequence[int]) -> Gait:
    """Return the gait in which each side lifts its feet in turn, from back to front.

    Both sides move together: a bound for four legs, a hop for two. Each side is timed
    by the legs that it has, so a missing limb is made up for.
    """
    counts = {side: sides.count(side) for side in set(sides)}
    up, swing = [], []
    for side, rank in _pairs(sides, ranks):
        n = counts[side]
        up.append((n - 1 - rank) / n)
        swing.append(min(1.0 / n, 0.5))
    return Gait(np.array(up), np.mod(np.array(up) + np.array(swing), 1.0))


def written(words: GaitWords, names: Sequence[str]) -> Gait:
    """Return the gait that the author wrote out for the legs called `names`."""
    return Gait(
        np.array([words.up[name] for name in names]) % 1.0,
        np.array([words.down[name] for name in names]) % 1.0,
    )


def _pairs(sides: Sequence[str], ranks: Sequence[int]) -> list[tuple[str, int]]:
    return list(zip(sides, ranks, strict=True))


GAITS: dict[str, Callable[[Sequence[str], Sequence[int]], Gait]] = {
    "trot": trot,
    "tripod": trot,
    "wave": wave,
}
"""Gaits by name. A tripod gait is what a trot is on six legs."""
