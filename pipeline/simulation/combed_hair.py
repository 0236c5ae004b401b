"""Combed hair: how it lies on a surface, as the vector from root to tip at each vertex."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.spatial import Array, normalized


def combed(flow: Array, normals: Array, length: float | Array, lift: float | Array) -> Array:
    """Return hair (V, 3) that lies along a flow and stands off the surface [m].

    Args:
        flow: (V, 3) directions, of which what points into or out of the surface does not count.
        normals: (V, 3) of the surface.
        length: of the hair, of all or (V,) of each [m].
        lift: angle by which it stands off, of all or (V,) of each [rad].
    """
    flat = normalized(flow - (flow * normals).sum(axis=-1, keepdims=True) * normals)
    long = np.broadcast_to(length, (len(normals),))[:, None]
    off = np.broadcast_to(lift, (len(normals),))[:, None]
    result: Array = long * (np.cos(off) * flat + np.sin(off) * normals)
    return result
