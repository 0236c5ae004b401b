"""Braking: how far a body goes that comes to rest ahead, and where who is stuck can rest."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.gaits.spread import MAX_REACH
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array, turn

PLACES = 13
"""Looked at between the nearest and the farthest place to rest at."""


def braked(way: Array, left: float, brakes: float) -> Array:
    """Return the ways (n,) gone in the phases in which a steady body would go `way` (n,) [m].

    The drive is the root of what is left over the way on which it brakes, and a cycle's way
    grows with the root of the drive (see `Going`), so with w the steady way since it brakes
    and b the way on which it does,

        d left / dw = -(left / b)^(1/4),  left = b (1 - 3 w / 4 b)^(4/3).

    Args:
        way: gone from here at the present drive [m].
        left: until it has to rest [m].
        brakes: on which it comes to rest from its present drive [m].
    """
    b = min(brakes, left)
    if b <= 0.0:
        return np.minimum(way, max(left, 0.0))
    since = np.maximum(way - (left - b), 0.0)
    rest = np.maximum(1.0 - 0.75 * since / b, 0.0)
    return np.where(since > 0.0, left - b * np.cbrt(rest) ** 4, way)


def room_to_rest(
    herd: Herd,
    c: int,
    tips: Array,
    bodies: Callable[[Array], tuple[Array, Array]],
    nearest: float,
    farthest: float,
) -> float:
    """Return how far a body may go on at most until it rests, so that its feet stay in reach [m].

    Where none can, that at which they are the least out of reach.

    Args:
        herd: whose body.
        c: which.
        tips: (n, 3) where its feet are, or come down [m].
        bodies: gives R_WB (m, 3, 3) and p_WB (m, 3) after so far (m,) [m].
        nearest: least [m].
        farthest: most [m].
    """
    if farthest <= nearest:
        return nearest
    own: NDArray[np.bool_] = herd.owner == c
    on = np.linspace(farthest, nearest, PLACES)
    R, p = bodies(on)
    hips = p[:, None] + turn(R[:, None], herd.hips[own])
    far = np.linalg.norm(tips - hips, axis=-1) / herd.legs.lengths[own]
    beyond = np.maximum(far - MAX_REACH, 0.0).max(axis=1)
    return float(on[int(np.argmin(beyond))])
