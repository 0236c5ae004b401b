"""Strata: into how many cells the samples of a pixel are spread."""

from __future__ import annotations

import math


def grid(count: int) -> tuple[int, int]:
    """Return the columns and rows, as near to a square as can be, of exactly `count` cells."""
    rows = next(k for k in range(math.isqrt(count), 0, -1) if count % k == 0)
    return count // rows, rows
