"""The name that was probably meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

MOST_LISTED = 12
MOST_COMPARED = 500
LONGEST = 64


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name closest to `name`, or None where none is close."""
    names = sorted(known, reverse=True)[:MOST_COMPARED]
    by_fold = {other.casefold()[:LONGEST]: other for other in names}
    close = get_close_matches(name.casefold()[:LONGEST], by_fold, n=1, cutoff=0.6)
    return by_fold[close[0]] if close else None


def hint(name: str, known: Iterable[str]) -> str:
    """Return what to say after naming what is unknown: the nearest name, or all there are."""
    names = sorted(known)
    close = nearest(name, names)
    if close is not None:
        return f"did you mean '{close}'?"
    if not names:
        return "there are none"
    listed = ", ".join(names[:MOST_LISTED])
    return f"known: {listed}" + (", ..." if len(names) > MOST_LISTED else "")
