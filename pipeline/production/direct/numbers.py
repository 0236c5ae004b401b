"""Numbers as JSON has them, which knows none that are not finite."""

from __future__ import annotations

import math
from collections.abc import Iterable


def number(value: float) -> float | None:
    """Return a number, None if it is not finite."""
    return float(value) if math.isfinite(value) else None


def numbers(values: Iterable[float]) -> list[float | None]:
    """Return several."""
    return [number(value) for value in values]
