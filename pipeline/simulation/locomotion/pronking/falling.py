"""Falling: what a pronker that has toppled does, limp or stiff.

Source: Sims 1987, 9.4.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from pipeline.simulation.locomotion.pronking.happening import Happening
from pipeline.simulation.locomotion.pronking.pronker import Pronker
from pipeline.simulation.locomotion.pronking.state import State
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground


@dataclass(frozen=True, eq=False)
class Limbs:
    """The joints of one creature.

    Attributes:
        q: (J,) values, numbered as in its skeleton [rad or m].
        speeds: (J,) of them [rad/s or m/s].
    """

    q: Array
    speeds: Array


class Fall(Protocol):
    """One creature as it falls."""

    def begin(self, of: Pronker, ground: Ground, state: State, limbs: Limbs) -> None:
        """Let it fall from now on, as it is."""

    def advance(self, state: State, h: float) -> list[Happening]:
        """Go on by `h` [s]; return what struck the ground."""

    @property
    def q(self) -> Array | None:
        """(J,) values of its joints, None if they hold what they were at [rad or m]."""
