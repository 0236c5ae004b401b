"""Rubs: what is heard of one thing that is dragged over another."""

from __future__ import annotations

from dataclasses import dataclass

from audio.names import folded


@dataclass(frozen=True, slots=True)
class Rub:
    """How a kind of rub sounds.

    Attributes:
        instrument: of General MIDI that plays its notes.
        seconds: how long it lasts where the event does not say [s].
        level: against a blow of the same speed [dB]: what glides off gives little of its
            energy away.
    """

    instrument: str
    seconds: float
    level: float


RUBS: dict[str, Rub] = {
    "scuff": Rub("guitar fret noise", 0.14, -12.0),
    "slide": Rub("breath noise", 0.3, -12.0),
    "roll": Rub("seashore", 0.3, -18.0),
}
"""By their folded names."""


def rub_of(cause: str) -> Rub | None:
    """Return the rub that a cause names, None if it names another sound."""
    return RUBS.get(folded(cause))
