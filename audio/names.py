"""Names that an author may get wrong, and the nearest right one."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def folded(name: str) -> str:
    """Return a name as it is compared: lower case, single spaces, no hyphens or underscores."""
    return " ".join(name.replace("_", " ").replace("-", " ").casefold().split())


def nearest(name: str, allowed: Iterable[str]) -> str | None:
    """Return the allowed name most like this one, or None where nothing is like it."""
    by_fold = {folded(each): each for each in allowed}
    found = get_close_matches(folded(name), by_fold, n=1, cutoff=0.5)
    return by_fold[found[0]] if found else None


def unknown(what: str, name: str, allowed: Iterable[str]) -> str:
    """Say that a name is unknown, what is allowed, and which is nearest."""
    allowed = list(allowed)
    near = nearest(name, allowed)
    hint = f"; did you mean {near!r}?" if near else ""
    return f"unknown {what} {name!r}{hint} (allowed: {', '.join(allowed)})"
