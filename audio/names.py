"""Names in a scene file: comparison, patterns, and suggestions for misspelt ones."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches
from functools import lru_cache

# Of a file's name [characters]; a file system holds 255 bytes.
_LONGEST_STEM = 40


class UnknownName(ValueError):
    """A name that nothing has.

    Attributes:
        kind: what the name should be of, such as "instrument".
        name: the unknown name.
        known: all known names.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.kind, self.name, self.known = kind, name, tuple(known)
        near = nearest_name(name, self.known)
        hint = f"did you mean {near!r}?" if near else f"known: {', '.join(self.known)}"
        super().__init__(f"no {kind} is called {name!r}, {hint}")


@lru_cache(maxsize=4096)
def normalized_name(name: str) -> str:
    """Return a name for comparison: lower case, single spaces, no hyphens or underscores."""
    return " ".join(name.replace("_", " ").replace("-", " ").casefold().split())


def matches_pattern(name: str, pattern: str) -> bool:
    """Tell whether a name matches a pattern in which `*` stands for any letters."""
    pieces = (re.escape(piece) for piece in normalized_name(pattern).split("*"))
    return re.fullmatch(".*".join(pieces), normalized_name(name)) is not None


def nearest_name(name: str, allowed: Iterable[str]) -> str | None:
    """Return the allowed name most similar to this one, or None if none is similar."""
    originals = {normalized_name(each): each for each in allowed}
    close = get_close_matches(normalized_name(name), originals, 1, 0.5)
    return originals[close[0]] if close else None


def file_stems(names: Iterable[str]) -> dict[str, str]:
    """Return names of files for names of performers: letters, digits and hyphens, each once.

    Args:
        names: in an order that does not change.
    """
    stems: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        plain = re.sub(r"[^\w.-]+", "_", name).strip("._")[:_LONGEST_STEM] or "unnamed"
        stem, number = plain, 1
        # File systems may ignore case.
        while stem.casefold() in taken:
            number += 1
            stem = f"{plain}_{number}"
        taken.add(stem.casefold())
        stems[name] = stem
    return stems
