"""Plugins of Mitsuba in Python: classes that are made for the variant in use.

Mitsuba has other base classes in every variant, and none before one is chosen. So the
methods stand in plain classes, and what Mitsuba is given is made of them here.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import mitsuba as mi


def plugin(methods: type, base: str) -> Any:
    """Return a new object of Mitsuba's class `base` that has these methods."""
    return _made(methods, base, mi.variant())(mi.Properties())


@cache
def _made(methods: type, base: str, variant: str) -> type:
    del variant
    # Mitsuba's classes allow no second base, so the methods are copied.
    kept = {k: v for k, v in vars(methods).items() if not k.startswith("__")}
    return type(methods.__name__, (getattr(mi, base),), kept)
