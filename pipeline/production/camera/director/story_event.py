"""Story event: something that happens in a take and is worth a shot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

StoryKind = Literal[
    "hug", "break", "fall", "strike", "order", "meeting", "arrival", "landing", "cry"
]

WEIGHTS: dict[StoryKind, float] = {
    "hug": 10.0,
    "break": 9.0,
    "fall": 8.0,
    "order": 7.0,
    "strike": 6.0,
    "meeting": 6.0,
    "arrival": 5.0,
    "cry": 5.0,
    "landing": 3.0,
}
"""What is shown where two events are too near each other for a shot each."""


@dataclass(frozen=True, slots=True)
class StoryEvent:
    """Something that happens in a take.

    Attributes:
        kind: what it is.
        time: when it begins [s].
        until: when it ends [s].
        who: performers that it happens to, the first acts.
        text: as the reason of a cut tells it.
    """

    kind: StoryKind
    time: float
    until: float
    who: tuple[str, ...]
    text: str

    @property
    def weight(self) -> float:
        """How much it counts, see `WEIGHTS`."""
        return WEIGHTS[self.kind]
