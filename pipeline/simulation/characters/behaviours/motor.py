"""Motor: what a behaviour asks of the controls, and what all behaviours are asked.

Source: Horswill 2008, "High-level Control".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from pipeline.simulation.characters.errands import Errand
from pipeline.simulation.characters.layout import NOBODY

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind


@dataclass(frozen=True, slots=True)
class Motor:
    """A motor vector.

    Attributes:
        goal: x and z to walk to [m], None to stand.
        pace: how fast [m/s].
        target: number of what it goes to, and looks at now and then; NOBODY for nothing.
        touching: whether it goes close to that, and does not step aside for it.
        facing: a heading to stand or step back in [rad], None for where it goes.
        reaching: whether both arms are held out ahead.
        errand: done in place of all this, such as a hug.
        sits: whether it sits down.
        frozen: whether it keeps quite still.
    """

    goal: tuple[float, float] | None = None
    pace: float = 1.0
    target: int = NOBODY
    touching: bool = False
    facing: float | None = None
    reaching: bool = False
    errand: Errand | None = None
    sits: bool = False
    frozen: bool = False


class Behaviour(Protocol):
    """Something that a character may do by itself."""

    def activation(self, mind: Mind) -> float:
        """Return how useful it would be now, from 0 to about 1; also asked while it goes on."""

    def motor(self, mind: Mind) -> Motor:
        """Return what to do, once it is chosen."""

    def end(self, mind: Mind) -> None:
        """Take leave: another was chosen."""
