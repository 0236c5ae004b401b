"""Dancer script: carries out the instructions of a script for one dancer."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.dancers.dance_schedule import (
    STAND_STILL,
    DancePlan,
    DanceRequest,
    DanceSchedule,
)
from pipeline.simulation.dancers.dancer_motion import DancerMotion
from pipeline.simulation.dancers.dancer_poses import Place
from pipeline.simulation.dancers.practice import measure_lateness
from pipeline.simulation.dancers.repertoire import SIDES
from pipeline.simulation.dancers.torso import HANDS
from pipeline.simulation.expressions import told_emotions
from pipeline.simulation.members import MemberState
from pipeline.spec.expression import EMOTIONS
from pipeline.spec.script import Do, Express, LetGo, LookAhead, LookAt, Perform, Reach, Wait

DANCING_JOY = 0.5
"""Joy that a face shows of its own while dancing."""

PRACTICE_START = 0.5
"""Time before the first beat of practice [s]."""

LOWER_TIME, REACH_TIME = 1.2, 0.9
"""Time in which arms are lowered, and in which hands reach a place [s]."""


class ScriptedDancer:
    """A dancer that follows instructions.

    Args:
        dancing: its motion.
        programme: its schedule.
        own: converts a world position to the dancer's frame [m].
        dt: duration of a world step [s].

    Attributes:
        watched: member that it is to look at, wherever it goes; None without any.
        seen: states of members, of the watched one at least.
        told: (6,) emotions that it is told to show, NaN where it shows its own.
    """

    def __init__(
        self,
        dancing: DancerMotion,
        programme: DanceSchedule,
        own: Callable[[Place], Place],
        dt: float,
    ) -> None:
        self.dancing, self.programme, self.own, self.dt = dancing, programme, own, dt
        self.watched: str | None = None
        self.seen: Mapping[str, MemberState] = {}
        self.told = [math.nan] * len(EMOTIONS)
        self._practised = {programme.plan.request}
        self._reaching: list[tuple[Reach, float]] = []

    @property
    def joy(self) -> float:
        """Joy that it feels: that of dancing."""
        return 0.0 if self.programme.plan.request.dance is None else DANCING_JOY

    def follow(self, orders: Sequence[Do]) -> None:
        """Starts to carry out instructions."""
        for do in orders:
            self._follow(do)
        if self.watched is not None:
            x, y, z = self.seen[self.watched].face.tolist()
            self.dancing.look(np.array(self.own((x, y, z))))

    def finish_bars(self) -> bool:
        """Returns whether the bars of the plan have just ended; starts what comes next."""
        if not self.programme.has_ended(self.dancing.now):
            return False
        plan = self.programme.resume_previous(self.dancing.now)
        if plan is not None:
            self._start(plan)
        return True

    def finish_reaches(self) -> list[Reach]:
        """Returns the orders whose hands have just arrived, as they have practised to."""
        ended = [do for do, land in self._reaching if land <= self.dancing.now]
        self._reaching = [(do, land) for do, land in self._reaching if land > self.dancing.now]
        return ended

    def _follow(self, do: Do) -> None:
        now, programme = self.dancing.now, self.programme
        if isinstance(do, str):
            self._follow_word(do)
        elif isinstance(do, Perform):
            self._start(programme.change(DanceRequest(do.dance, do.tempo_bpm, do.bars), now))
        elif isinstance(do, Wait):
            programme.pause(now)
            self.dancing.freeze()
        elif isinstance(do, Reach):
            self._reaching.append((do, now + REACH_TIME))
            for side in SIDES[do.hand]:
                number = programme.repertoire.reaches[do.reach, side]
                self.dancing.hold_at(side, number, now + REACH_TIME)
        elif isinstance(do, LetGo):
            self._release(SIDES[do.let_go])
        elif isinstance(do, LookAt | LookAhead):
            self._look(do)
        elif isinstance(do, Express):
            self.told = told_emotions(do)

    def _look(self, do: LookAt | LookAhead) -> None:
        """Looks at a member or a place, or ahead."""
        target = do.look_at if isinstance(do, LookAt) else None
        self.watched = target if isinstance(target, str) else None
        if not isinstance(target, str):
            self.dancing.look(None if target is None else np.array(self.own(target)))

    def _follow_word(self, do: str) -> None:
        """Carries out an instruction of one word."""
        now, programme = self.dancing.now, self.programme
        if do == "stop":
            programme.change(STAND_STILL, now)
            self._release(HANDS)
            self.dancing.hang(now + LOWER_TIME)
        elif do == "freeze":
            programme.change(STAND_STILL, now)
            self.dancing.freeze()
        elif do == "dance":
            self._start(programme.change(programme.default, now))
        elif do == "walk" and (plan := programme.resume(now)) is not None:
            # `wait` is followed by `walk`.
            self._start(plan)
        elif do == "let_go":
            self._release(HANDS)

    def _start(self, plan: DancePlan) -> None:
        if plan.request.dance is None:
            self.dancing.hang(self.dancing.now + LOWER_TIME)
            return
        self._practise(plan.request)
        self.dancing.change(plan.moves, plan.beat, plan.start)

    def _practise(self, request: DanceRequest) -> None:
        """Measures lateness in a dance that is danced for the first time.

        The result depends on nothing that happened before, so it is the same whether the script or
        another program gives the instruction.
        """
        if request in self._practised:
            return
        self._practised.add(request)
        plan = self.programme.planned(replace(request, bars=None), PRACTICE_START)
        # A dance that is requested is danced on its beats.
        member = self.programme.member.model_copy(update={"durations": None})
        choreography = self.programme.repertoire.choreography
        late = measure_lateness(member, choreography, plan.moves, plan.beat, self.dt)
        self.dancing.set_lateness(late)

    def _release(self, hands: Sequence[str]) -> None:
        for side in hands:
            self.dancing.release(side, self.dancing.now + REACH_TIME)
