"""Grasp: which places the joints of a leg bring its tip to.

A leg reaches less than its length says: knees fold only so far, and hips turn only so far
to the side. Inverse kinematics knows; it is asked only where a place is not beside those
that the leg comes to on level ground anyway.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.limb_chains import group_chains
from pipeline.simulation.figures.rest_ik import solve_each_near_rest, solve_near_rest
from pipeline.simulation.locomotion.gaits.spread import MAX_REACH
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array

MISSES = 1e-4
"""Distance of tip from place that is none, in the leg's length."""

JUMP = 0.8
"""Greatest change of a joint between two of the places along its way that a leg is asked for
[rad]: there are a dozen of them in a swing, in which no joint turns by more than half a turn
to and fro."""

BESIDE = np.array([0.12, 0.12, 0.1])
"""How far from its places on level ground a leg is sure to reach, in its length: along,
upward and across. Downward its length alone is the bound."""


class LegReachability:
    """Tells which places the legs of a herd reach.

    Attributes:
        herd: whose legs.
    """

    def __init__(self, herd: Herd) -> None:
        self.herd = herd
        half = 0.5 * herd.stride[herd.owner] * (1.0 - 0.5 * herd.swings)
        x, z = herd.rest.T
        room = BESIDE * herd.legs.lengths[:, None]
        floor = herd.sole - herd.body_height[herd.owner]
        self._low = np.stack([x - half, floor - herd.legs.lengths, z], axis=-1) - room
        self._high = np.stack([x + half, floor, z], axis=-1) + room

    def beside(self, leg: int, goals: Array) -> bool:
        """Tell whether all `goals` (..., 3) are beside where the leg comes to on level ground."""
        return bool(((goals >= self._low[leg]) & (goals <= self._high[leg])).all())

    def follows(self, leg: int, ways: Array) -> bool:
        """Tell whether the leg's tip can go all of `ways` (n, m, 3), see `follows_each`."""
        return bool(self.follows_each(np.full(len(ways), leg), ways).all())

    def follows_each(self, legs: NDArray[np.int64], ways: Array) -> NDArray[np.bool_]:
        """Say which tips of legs (N,) can go their `ways` (N, m, 3), relative to bodies.

        At the rim of what it reaches a leg comes to its goals now in one way, now in another;
        so no joint may jump from one place to the next.
        """
        herd, shape = self.herd, ways.shape[:2]
        rows = np.repeat(legs, shape[1])
        q, residual = solve_each_near_rest(herd.legs, herd.chains, rows, ways.reshape(-1, 3))
        reached = (residual <= MISSES * herd.legs.lengths[rows]).reshape(shape).all(axis=1)
        turned = np.abs(np.diff(q.reshape(*shape, -1), axis=1))
        return np.asarray(reached & (turned < JUMP).all(axis=(1, 2)))

    def beside_each(self, legs: NDArray[np.int64], goals: Array) -> NDArray[np.bool_]:
        """Say which `goals` (N, 3) are beside where legs (N,) come to on level ground."""
        inside: NDArray[np.bool_] = (goals >= self._low[legs]) & (goals <= self._high[legs])
        return np.asarray(inside.all(axis=-1))

    def holds(self, leg: int, goals: Array) -> NDArray[np.bool_]:
        """Say to which of `goals` (n, m, 3), relative to the body, the leg's tip comes."""
        return self.holds_each(np.full(len(goals), leg), goals)

    def holds_each(self, legs: NDArray[np.int64], goals: Array) -> NDArray[np.bool_]:
        """Say to which of their `goals` (N, m, 3), relative to bodies, tips of legs (N,) come."""
        low, high = self._low[legs, None], self._high[legs, None]
        inside: NDArray[np.bool_] = (goals >= low) & (goals <= high)
        known: NDArray[np.bool_] = np.asarray(inside.all(axis=-1))
        row, moment = np.nonzero(~known)
        if len(row):
            herd, asked = self.herd, legs[row]
            _, residual = solve_each_near_rest(herd.legs, herd.chains, asked, goals[row, moment])
            known[row, moment] = residual <= MISSES * herd.legs.lengths[asked]
        return known


DISTANCES = np.linspace(MAX_REACH, 0.1, 30)
"""At which it is asked, in lengths of the leg."""

FOLD_MISSES = 1e-4
"""Distance of tip from place that is none, in the leg's length."""


def shortest_reaches(herd: Herd) -> Array:
    """Return the least distances (L,) from hips to feet at which all farther ones are reached [m].

    Args:
        herd: whose legs.
    """
    found, known = np.zeros(len(herd.owner)), dict[tuple[str, float, float], Array]()
    for c, figure in enumerate(herd.figures):
        own = np.flatnonzero(herd.owner == c)
        key = figure.name, figure.scale, float(herd.body_height[c])
        if len(own):
            found[own] = known[key] = known[key] if key in known else _folds(herd, own)
    return found


def _folds(herd: Herd, own: NDArray[np.int64]) -> Array:
    """Return the folds of some legs (n,) [m]."""
    legs, (x, z) = herd.legs.rows(own), herd.rest[own].T
    way = np.stack([x, -herd.body_height[herd.owner[own]], z], axis=-1) - herd.hips[own]
    at_rest = np.linalg.norm(way, axis=-1)
    way /= np.maximum(at_rest, 1e-9)[:, None]
    goals = herd.hips[own] + (DISTANCES[:, None] * legs.lengths)[..., None] * way
    residual = solve_near_rest(legs, group_chains(legs, herd.owner[own]), goals).residual
    # Where a foot rests it is, whatever limits stretched legs come to.
    nearer = DISTANCES[:, None] * legs.lengths < at_rest
    missed = nearer & (residual > FOLD_MISSES * legs.lengths)
    # The last one before the first that is missed; those that miss none fold up wholly.
    first = np.where(missed.any(axis=0), missed.argmax(axis=0), len(DISTANCES))
    result: Array = DISTANCES[np.maximum(first - 1, 0)] * legs.lengths
    return result
