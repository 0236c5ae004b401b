"""Names in a scene file: comparison, patterns, and suggestions for misspelt ones."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches

MAX_LISTED = 24
"""Longer lists of allowed names are cut to those similar to the unknown one."""


def normalized_name(name: str) -> str:
    """Return a name for comparison: lower case, single spaces, no hyphens or underscores."""
    return " ".join(name.replace("_", " ").replace("-", " ").casefold().split())


def matches_pattern(name: str, pattern: str) -> bool:
    """Tell whether a name matches a pattern in which `*` stands for any letters."""
    pieces = (re.escape(piece) for piece in normalized_name(pattern).split("*"))
    return re.fullmatch(".*".join(pieces), normalized_name(name)) is not None


def nearest_name(name: str, allowed: Iterable[str]) -> str | None:
    """Return the allowed name most similar to this one, or None if none is similar."""
    return next(iter(_similar_names(name, allowed, 1, 0.5)), None)


def _similar_names(name: str, allowed: Iterable[str], count: int, cutoff: float) -> list[str]:
    originals = {normalized_name(each): each for each in allowed}
    close = get_close_matches(normalized_name(name), originals, count, cutoff)
    return [originals[each] for each in close]


def unknown_name_message(kind: str, name: str, allowed: Iterable[str]) -> str:
    """Return an error message with the nearest allowed name and the allowed names.

    Args:
        kind: of the name, such as "instrument".
        name: the unknown one.
        allowed: all known names.
    """
    allowed = list(allowed)
    near = nearest_name(name, allowed)
    hint = f"; did you mean {near!r}?" if near else ""
    if near and len(allowed) > MAX_LISTED:
        similar = ", ".join(_similar_names(name, allowed, 6, 0.3))
        return f"unknown {kind} {name!r}{hint} ({len(allowed)} names, such as {similar})"
    return f"unknown {kind} {name!r}{hint} (allowed: {', '.join(allowed)})"
