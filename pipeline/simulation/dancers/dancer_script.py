"""Telling: what a script asks of a dancer, and what becomes of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.dancers.dance_schedule import (
    STAND_STILL,
    DancePlan,
    DanceRequest,
    DanceSchedule,
)
from pipeline.simulation.dancers.dancer_motion import DancerMotion, measure_lateness
from pipeline.simulation.dancers.dancer_poses import Place
from pipeline.simulation.dancers.repertoire import SIDES
from pipeline.simulation.dancers.torso import HANDS
from pipeline.spec import script as words
from pipeline.spec.script import Do

PAUSE = 0.5
"""How long a dancer stands before it practises what it is told [s]."""

LOWERS, REACHES = 1.2, 0.9
"""How long arms take to hang, and to a place that they are told [s]."""


class ScriptedDancer:
    """A dancer that is told what to do.

    Args:
        dancing: the dancer.
        programme: what it dances.
        own: from a place in the world to where that is as the dancer stands [m].
        dt: that it is advanced by at once [s].
    """

    def __init__(
        self,
        dancing: DancerMotion,
        programme: DanceSchedule,
        own: Callable[[Place], Place],
        dt: float,
    ) -> None:
        self.dancing, self.programme, self.own, self.dt = dancing, programme, own, dt
        self._practised = {programme.plan.wish}

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
            self._begin(programme.change(DanceRequest(do.dance, do.tempo_bpm, do.bars), now))
        elif isinstance(do, words.Wait):
            programme.pause(now)
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
            programme.change(STAND_STILL, now)
            self._let_go(HANDS)
            self.dancing.hang(now + LOWERS)
        elif do == "freeze":
            programme.change(STAND_STILL, now)
            self.dancing.freeze()
        elif do == "dance":
            self._begin(programme.change(programme.own, now))
        elif do == "walk" and (plan := programme.resume(now)) is not None:
            # What follows a wait.
            self._begin(plan)
        elif do == "let_go":
            self._let_go(HANDS)

    def _begin(self, plan: DancePlan) -> None:
        if plan.wish.dance is None:
            self.dancing.hang(self.dancing.now + LOWERS)
            return
        self._practise(plan.wish)
        self.dancing.change(plan.moves, plan.beat, plan.start)

    def _practise(self, wish: DanceRequest) -> None:
        """Learn how late hands come in what is danced for the first time.

        That is found when it is told, and depends on nothing that happened before: it is the
        same whoever tells it.
        """
        if wish in self._practised:
            return
        self._practised.add(wish)
        one = self.dancing
        plan = self.programme.planned(replace(wish, bars=None), PAUSE)
        # What it is told is danced on beats.
        member = self.programme.member.model_copy(update={"durations": None})
        late = measure_lateness(
            member, self.programme.repertoire.choreography, plan.moves, plan.beat, self.dt
        )
        one.hears(late)

    def _let_go(self, hands: Sequence[str]) -> None:
        for side in hands:
            self.dancing.release(side, self.dancing.now + REACHES)
