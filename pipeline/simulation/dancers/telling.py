"""Telling: what a script asks of a dancer, and what becomes of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pipeline.simulation.dancers.dancing import Dancing
from pipeline.simulation.dancers.posing import Place
from pipeline.simulation.dancers.programme import STILL, Plan, Programme, Wish
from pipeline.simulation.dancers.repertoire import SIDES
from pipeline.simulation.dancers.torso import HANDS
from pipeline.spec import script as words
from pipeline.spec.script import Do

LOWERS, REACHES = 1.2, 0.9
"""How long arms take to hang, and to a place that they are told [s]."""


class Directed:
    """A dancer that is told what to do.

    Args:
        dancing: the dancer.
        programme: what it dances.
        own: from a place in the world to where that is as the dancer stands [m].
    """

    def __init__(
        self, dancing: Dancing, programme: Programme, own: Callable[[Place], Place]
    ) -> None:
        self.dancing, self.programme, self.own = dancing, programme, own
        self._waits_with: Wish | None = None

    def tell(self, orders: Sequence[Do]) -> None:
        """Do what is asked from now on."""
        for do in orders:
            self._tell(do)

    def go_on(self) -> bool:
        """Do what is due; tell whether the bars of what it dances are over by now."""
        if not self.programme.over(self.dancing.now):
            return False
        plan = self.programme.back(self.dancing.now)
        if plan is not None:
            self._begin(plan)
        return True

    def _tell(self, do: Do) -> None:
        now, programme = self.dancing.now, self.programme
        if isinstance(do, str):
            self._say(do)
        elif isinstance(do, words.Perform):
            self._begin(programme.change(Wish(do.dance, do.tempo_bpm, do.bars), now))
        elif isinstance(do, words.Wait):
            self._waits_with = programme.plan.wish
            programme.change(STILL, now)
            self.dancing.freeze()
        elif isinstance(do, words.Reach) and not isinstance(do.reach, str):
            for side in SIDES[do.hand]:
                number = programme.repertoire.told[do.reach, side]
                self.dancing.hold_at(side, number, now + REACHES)
        elif isinstance(do, words.LetGo):
            self._let_go(SIDES[do.let_go])
        elif isinstance(do, words.LookAt) and not isinstance(do.look_at, str):
            self.dancing.look(np.array(self.own(do.look_at)))
        elif isinstance(do, words.LookAhead):
            self.dancing.look(None)

    def _say(self, do: str) -> None:
        """Do what one word says."""
        now, programme = self.dancing.now, self.programme
        if do == "stop":
            programme.change(STILL, now)
            self._let_go(HANDS)
            self.dancing.hang(now + LOWERS)
        elif do == "freeze":
            programme.change(STILL, now)
            self.dancing.freeze()
        elif do == "dance":
            self._begin(programme.change(programme.own, now))
        elif do == "walk" and self._waits_with is not None:
            # What follows a wait.
            self._begin(programme.change(self._waits_with, now))
        elif do == "let_go":
            self._let_go(HANDS)

    def _begin(self, plan: Plan) -> None:
        self._waits_with = None
        if plan.wish.dance is None:
            self.dancing.hang(self.dancing.now + LOWERS)
        else:
            self.dancing.change(plan.moves, plan.beat, plan.start)

    def _let_go(self, hands: Sequence[str]) -> None:
        for side in hands:
            self.dancing.release(side, self.dancing.now + REACHES)
