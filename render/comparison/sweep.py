"""Sweep: a filter that is one kernel along the rows and another one along the columns."""

from __future__ import annotations

import numpy as np

from render.comparison.opponent import Plane


def swept(values: Plane, along_x: Plane, along_y: Plane) -> Plane:
    """Return values (H, W) filtered by two kernels of one odd length; borders are repeated."""
    return _swept_down(_swept_down(values, along_y).T, along_x).T


def _swept_down(values: Plane, kernel: Plane) -> Plane:
    radius = len(kernel) // 2
    padded = np.pad(values, ((radius, radius), (0, 0)), mode="edge")
    result = np.zeros_like(values)
    for k, weight in enumerate(kernel.tolist()):
        result += weight * padded[k : k + len(values)]
    return result
