"""Stance: what legs that are on the ground carry, and how high."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.pronker import HOLDS, Pronker
from pipeline.simulation.locomotion.pronking.state import State
from pipeline.simulation.spatial import Array


def gives_way(of: Pronker, state: State) -> bool:
    """Tell whether it stands, or sinks and rises slowly, on fewer legs than can carry it."""
    if state.phase not in ("standing", "crouching", "rising", "straightening"):
        return False
    force = of.mass.mass * float(state.a[1] + GRAVITY)
    return force > most_of(of, state) * (1.0 + 1e-9)


def standing_height(
    of: Pronker,
    R: Array,
    feet: Array,
    height: float,
    x: float,
    z: float,
    down: NDArray[np.bool_] | None = None,
) -> float:
    """Return the height of a body at which all feet that are down reach the ground [m].

    Args:
        of: whose body.
        R: (3, 3) its attitude.
        feet: (n, 3) of those that are down [m].
        height: at most [m].
        x: place of the body [m].
        z: likewise.
        down: (n,) which feet they are, all if left out.
    """
    own = slice(None) if down is None else down
    hips = of.hips[own] @ R.T + [x, 0.0, z]
    across = ((hips - feet)[:, [0, 2]] ** 2).sum(axis=-1)
    room = np.sqrt(np.maximum((HOLDS * 0.995 * of.lengths[own]) ** 2 - across, 0.0))
    return min(height, float((feet[:, 1] + room - hips[:, 1]).min()))


def floor_of(of: Pronker, state: State) -> float:
    """Return the mean height of the footholds, of the ground without them [m]."""
    if not state.down.any():
        return 0.0
    return float((state.tips[:, 1] - of.soles)[state.down].mean())


def most_of(of: Pronker, state: State) -> float:
    """Return the greatest force that the legs on the ground give together [N]."""
    return of.most * int(state.down.sum())
