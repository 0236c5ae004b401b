"""Course: which jumps a pronker is to make, by its words or as a script asks.

What a script asks for is an errand, which says jump by jump what comes next; who has none hops
on as its words say, or stands.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from pipeline.simulation.locomotion.pronking.parameters import Jump
from pipeline.simulation.terrain import Ground

if TYPE_CHECKING:
    from pipeline.simulation.locomotion.pronking.pronker import Pronker
    from pipeline.simulation.locomotion.pronking.state import State


@dataclass(frozen=True, slots=True)
class Leap:
    """The next jump of an errand.

    Attributes:
        up: speed at lift-off [m/s].
        facing: where it is to look when it has landed [rad].
        spot: (x, z) where the middle of its feet is to land [m]; straight on if None.
        forward: horizontal speed, if it goes straight on [m/s].
        last: whether the errand ends with it.
        folds: whether it draws its feet up as far as its legs fold.
    """

    up: float
    facing: float
    spot: tuple[float, float] | None = None
    forward: float = 0.0
    last: bool = True
    folds: bool = False


class Errand(Protocol):
    """What a script asks a pronker to do."""

    def leap(self, of: Pronker, state: State, ground: Ground) -> Leap | str:
        """Return the next jump of one that is about to push off; else why there is none.

        The reason is empty if there is nothing left to do.
        """


@dataclass(eq=False)
class Course:
    """The jumps that one pronker is to make.

    Attributes:
        jump: that it makes by its words.
        onward: whether it hops as its words say when it has no errand.
        errands: one after the other.
        leap: jump of the first errand that is pushed for or in the air; None for one by its words.
        made: jumps made by its words.
    """

    jump: Jump
    onward: bool = True
    errands: list[Errand] = field(default_factory=list)
    leap: Leap | None = None
    made: int = 0

    def choose(self, of: Pronker, state: State, ground: Ground) -> list[str]:
        """Decide on the jump that is pushed for next; return what cannot be done."""
        self.leap, causes = None, list[str]()
        while self.errands:
            found = self.errands[0].leap(of, state, ground)
            if isinstance(found, Leap):
                self.leap = found
                break
            self.errands.pop(0)
            if found:
                causes.append(found)
        return causes

    def took_off(self) -> None:
        """Take down that the jump is being made."""
        if self.leap is None:
            self.made += 1
        elif self.leap.last and self.errands:
            self.errands.pop(0)
