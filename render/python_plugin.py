"""Python plugins: objects of Mitsuba's base classes whose methods are written in Python."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

import mitsuba as mi

NO_PROPERTIES: Mapping[str, Any] = MappingProxyType({})


def plugin(methods: type, base: str, properties: Mapping[str, Any] = NO_PROPERTIES) -> Any:
    """Return a new object of Mitsuba's class `base` with these methods.

    Mitsuba's base classes differ between variants and do not exist before one is chosen, so
    the methods stand in plain classes.

    Args:
        methods: a plain class.
        base: name of Mitsuba's class.
        properties: that its constructor reads.
    """
    given = mi.Properties()
    for name, value in properties.items():
        given[name] = value
    return _plugin_class(methods, base, mi.variant())(given)


@cache
def _plugin_class(methods: type, base: str, variant: str) -> type:
    del variant
    # Mitsuba's classes allow no second base, so the methods are copied.
    found = {k: v for owner in reversed(methods.__mro__) for k, v in vars(owner).items()}
    own = {k: v for k, v in found.items() if not k.startswith("__")}
    return type(methods.__name__, (getattr(mi, base),), own)
