"""Happening: what is known of an event of a pronker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pipeline.simulation.spatial import Array

Kind = Literal[
    "touch", "lift", "body", "toppled", "saturated", "stopped", "misplaced", "tripped", "dropped"
]


@dataclass(frozen=True, eq=False)
class Happening:
    """An event.

    Attributes:
        kind: of it.
        time: when [s].
        leg: whose foot it is, -1 for the body.
        place: (3,) where [m].
        normal: (3,) of the ground.
        speed: with which it came or went [m/s].
        energy: of what came or went at this speed [J].
        text: what there is to say.
        link: number of the link that it is about, if it is of the body.
    """

    kind: Kind
    time: float
    leg: int
    place: Array
    normal: Array
    speed: float
    energy: float
    text: str = ""
    link: int = 0


Events = list[Happening]
"""What has happened, in the order of time."""
