"""Names that an author may get wrong, and the nearest right one."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def folded(name: str) -> str:
    """Return a name as it is compared: lower case, single spaces, no hyphens or underscores."""
    return " ".join(name.replace("_", " ").replace("-", " ").casefold().split())


def nearest(name: str, allowed: Iterable[str]) -> str | None:
    """Return the allowed name most like this one, or None where nothing is like it."""
    return next(iter(_like(name, allowed, 1, 0.5)), None)


def _like(name: str, allowed: Iterable[str], most: int, cutoff: float) -> list[str]:
    by_fold = {folded(each): each for each in allowed}
    return [by_fold[each] for each in get_close_matches(folded(name), by_fold, most, cutoff)]


_LISTED = 24
"""Longer lists are not read; then the names most like the wrong one are told."""


def unknown(what: str, name: str, allowed: Iterable[str]) -> str:
    """Say that a name is unknown, what is allowed, and which is nearest."""
    allowed = list(allowed)
    near = nearest(name, allowed)
    hint = f"; did you mean {near!r}?" if near else ""
    like = _like(name, allowed, 6, 0.3) if near and len(allowed) > _LISTED else allowed
    some = f"{len(allowed)} names, such as" if like != allowed else "allowed:"
    return f"unknown {what} {name!r}{hint} ({some} {', '.join(like)})"
