"""Happenings: what those who direct a scene hear of, beside its sounds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

SIGNAL_KINDS: Mapping[str, str] = {
    "arrived": "somebody has come to the end of its way, or has done what it was told",
    "touch": "a character begins to touch another, or something that is in its way",
    "pain": "somebody is hurt, by whom or what",
    "hug": "somebody has its arms around somebody",
    "cry": "somebody cries, for pain or for fear",
}
"""Kinds of happenings; a new one is a line here."""


@dataclass(frozen=True, slots=True)
class Signal:
    """Something that happened in a step.

    Attributes:
        kind: one of `SIGNAL_KINDS`.
        who: a performer.
        other: with whom, or by what; "" for nobody.
        part: of `who`, of what is heard.
        place: where, of what is heard [m].
        strength: of what is heard, as a speed [m/s].
        size: of what is heard [m].
    """

    kind: str
    who: str
    other: str = ""
    part: str = ""
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    strength: float = 0.0
    size: float = 0.0
