"""Forbidden zones: where a foot would be hurt.

A place is forbidden where the slope cannot be stepped on, and within one foot
radius downhill of such a slope, where a foot would touch the wall. The zones are
kept as a field of one truth value a cell, computed to the safe side: a cell is
forbidden if any of its points may be.

Source: Sims 1987, 8.2.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField


def forbidden_cells(
    field: HeightField, unsteppable_slope: float, foot_radius: float
) -> NDArray[np.bool_]:
    """Return the cells (n_z, n_x) that no foot may be put on.

    Args:
        field: the surface.
        unsteppable_slope: slopes at or above this angle cannot be stepped on [rad].
        foot_radius: how far downhill of them it is still forbidden [m].
    """
    steep = np.linalg.norm(field.gradients, axis=-1) >= math.tan(unsteppable_slope)
    zones: NDArray[np.bool_] = steep.any(axis=0)
    if foot_radius == 0.0 or not zones.any():
        return zones
    # The two triangles of a cell may fall to different sides.
    for gradient, source in zip(field.gradients, steep, strict=True):
        _mark_downhill(zones, field.cell, gradient, source, foot_radius)
    return zones


def _mark_downhill(
    zones: NDArray[np.bool_],
    cell: tuple[float, float],
    gradient: Array,
    source: NDArray[np.bool_],
    foot_radius: float,
) -> None:
    """Set `zones` within `foot_radius` downhill of where `source` is set."""
    dx, dz = cell
    reach_x, reach_z = math.ceil(foot_radius / dx), math.ceil(foot_radius / dz)
    for j in range(-reach_z, reach_z + 1):
        for i in range(-reach_x, reach_x + 1):
            # The nearest points of two cells (i, j) apart.
            gap = math.hypot(max(abs(i) - 1, 0) * dx, max(abs(j) - 1, 0) * dz)
            if (i, j) == (0, 0) or gap > foot_radius:
                continue
            # Some point of that cell lies downhill of some point of this one.
            fall = -(gradient[..., 0] * i * dx + gradient[..., 1] * j * dz)
            across = np.abs(gradient[..., 0]) * dx + np.abs(gradient[..., 1]) * dz
            _mark(zones, source & (fall + across > 0.0), i, j)


def _mark(zones: NDArray[np.bool_], source: NDArray[np.bool_], i: int, j: int) -> None:
    """Set `zones` where `source`, moved by i columns and j rows, is set."""
    rows, columns = zones.shape
    to_j, to_i = slice(max(j, 0), rows + min(j, 0)), slice(max(i, 0), columns + min(i, 0))
    from_j, from_i = slice(max(-j, 0), rows + min(-j, 0)), slice(max(-i, 0), columns + min(-i, 0))
    zones[to_j, to_i] |= source[from_j, from_i]
