"""Signals: what a director hears of a scene, beside its sounds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

SIGNAL_KINDS: Mapping[str, str] = {
    "arrived": "somebody has come to the end of its way, or has done what it was told",
    "touch": "a character begins to touch another, or something that is in its way",
    "pain": "somebody is hurt, by whom or what",
    "hug": "somebody has its arms around somebody",
    "served": "somebody has been served at the head of a queue",
    "cry": "somebody cries, for pain or for fear",
    "laugh": "somebody laughs at play",
    "gasp": "somebody takes fright",
}
"""Kinds of signals and their meaning."""


@dataclass(frozen=True, slots=True)
class Signal:
    """Something that happened in a step.

    Attributes:
        kind: one of `SIGNAL_KINDS`.
        who: name of the performer.
        other: the other performer or thing involved; "" for none.
        part: part of `who` that is heard.
        place: position of the sound [m].
        strength: of the sound, as a speed [m/s].
        size: of the sound's source [m].
    """

    kind: str
    who: str
    other: str = ""
    part: str = ""
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    strength: float = 0.0
    size: float = 0.0
