"""Plant bend: how plants give way to the wind and to feet.

A bend is a vector over the ground, along x and z: its length is the angle by which the tip turns
from the upright [rad], its direction that to which it turns. The root turns less.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.production.surroundings.lattice_noise import fractal
from pipeline.simulation.spatial import Array

Singles = NDArray[np.float32]

ROOT_SHARE = 0.35
"""Part of the bend at the root."""

MOST = 1.45
"""Greatest bend [rad]."""

LEAN, MOST_LEAN = 0.035, 0.5
"""Mean bend by the wind, per metre a second near the ground [rad s/m], and the greatest [rad]."""

GUST = 4.0
"""Width of a gust [m]."""

_GUST_SEED = 7919


def bent(offsets: Singles, tall: Singles, bend: Singles) -> Singles:
    """Return the vertices of bent plants, as offsets from their roots (..., 3) [m].

    Heights become arcs of the same length.

    Args:
        offsets: (..., 3) of the upright plants [m].
        tall: (...) heights of the plants [m].
        bend: (..., 2) of the plants [rad].
    """
    angle = np.sqrt((bend * bend).sum(axis=-1))
    way = bend / np.maximum(angle, 1e-9)[..., None]
    up = offsets[..., 1]
    share = np.clip(up / np.maximum(tall, 1e-6), 0.0, 1.0)
    turn = np.minimum(angle, MOST) * (ROOT_SHARE + (1.0 - ROOT_SHARE) * share)
    # What lies below the root is in the ground, and stays there.
    rise = np.maximum(up, 0.0)
    result = offsets.copy()
    result[..., 1] += rise * (np.cos(turn) - 1.0)
    aside = rise * np.sin(turn)
    result[..., 0] += aside * way[..., 0]
    result[..., 2] += aside * way[..., 1]
    return result


def wind_bends(places: Array, wind: tuple[float, float], time: float = 0.0) -> Array:
    """Return the bends (N, 2) of plants in the wind, which comes in gusts [rad].

    Args:
        places: (N, 2) x and z [m].
        wind: near the ground, along x and z [m/s].
        time: since the film began [s].
    """
    speed = float(np.hypot(*wind))
    if speed == 0.0:
        return np.zeros_like(places)
    gust = fractal((places - time * np.asarray(wind)) / GUST, _GUST_SEED, 2)
    lean = min(LEAN * speed, MOST_LEAN) * (1.0 + 0.6 * np.clip(gust, -1.0, 1.0))
    return np.asarray(lean[:, None] * np.asarray(wind) / speed)
