"""Minding: names in the behaviours of characters that must name somebody fit for them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel

from pipeline.spec.acting import faults_of_whom
from pipeline.spec.behaviour import NAMES, WHOM
from pipeline.spec.faults import Fault, Step
from pipeline.spec.nearest import hint

Path = tuple[Step, ...]


def faults_of_minds(names: Sequence[str], members: Mapping[str, object]) -> Iterator[Fault]:
    """Find behaviours towards nobody, towards oneself, or towards what they are not for.

    Args:
        names: of the cast, in its order.
        members: the cast by name, typed or raw.
    """
    for i, name in enumerate(names):
        behaviours = _get(members[name], "behaviours")
        for k, one in enumerate(behaviours if isinstance(behaviours, list | tuple) else ()):
            for key, (kinds, what) in WHOM.items():
                if isinstance(whom := _get(one, key), str):
                    path = ("cast", i, "behaviours", k, key)
                    yield from faults_of_whom(whom, name, kinds, what, path, members)


def faults_of_urges(member: object, name: str, do: object, path: Path) -> Iterator[Fault]:
    """Find urges of one who has no mind, and towards no behaviour."""
    urges = _get(do, "urge")
    if not isinstance(urges, Mapping):
        return
    if not _get(member, "behaviours") and _get(member, "traits") is None:
        message = f"'{name}' does only what it is told; give it traits: {{}} to act by itself"
        yield Fault((*path, "urge"), message, at_key=True)
    for key in urges:
        if key not in NAMES:
            message = f"no behaviour is called '{key}', {hint(str(key), NAMES)}"
            yield Fault((*path, "urge", str(key)), message, at_key=True)


def _get(thing: object, key: str) -> Any:
    if isinstance(thing, Mapping):
        return thing.get(key)
    return getattr(thing, key, None) if isinstance(thing, BaseModel) else None
