"""Programme: what a dancer dances from when on, as the script tells it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from pipeline.simulation.dancers.dance_moves import (
    Move,
    beat_duration,
    plan_moves,
    subtask_onsets,
)
from pipeline.simulation.dancers.repertoire import Repertoire
from pipeline.spec.dance import Dance
from pipeline.spec.dancer import Dancer

SLACK = 1e-9


@dataclass(frozen=True, slots=True)
class DanceRequest:
    """What a dancer is to dance.

    Attributes:
        dance: its name; None to stand still.
        tempo: beats a minute, None for its own or the dance's.
        bars: how often, None for on and on.
        is_own: whether it is just what the dancer's own words say.
    """

    dance: str | None
    tempo: float | None = None
    bars: int | None = None
    is_own: bool = False


STAND_STILL = DanceRequest(None)


@dataclass(frozen=True, slots=True)
class DancePlan:
    """What a dancer does from a time on.

    Attributes:
        wish: that it follows from.
        moves: of each hand, in the order of time.
        beat: duration of a beat [s].
        start: of its first beat [s].
        ends: when its bars are over [s].
    """

    wish: DanceRequest
    moves: Mapping[str, list[Move]] = field(default_factory=dict)
    beat: float = 1.0
    start: float = 0.0
    ends: float = math.inf


class DanceSchedule:
    """What a dancer dances.

    Args:
        member: its words.
        repertoire: all that it may do.
        until: no move begins later [s].
        path: of the dancer in its scene, for messages.

    Attributes:
        plan: what it does now.

    Raises:
        SceneError: durations and tempo contradict one another.
    """

    def __init__(self, member: Dancer, repertoire: Repertoire, until: float, path: str) -> None:
        self.member, self.repertoire = member, repertoire
        self.until, self.path = until, path
        self.own = DanceRequest(member.dance, None, member.bars, is_own=True)
        self.plan = self._planned(self.own, member.start)
        self._after = STAND_STILL
        self._goes_back = self._is_over = False
        self._paused: tuple[DanceRequest, DanceRequest, bool] | None = None

    def over(self, now: float) -> bool:
        """Tell, once, whether the bars of what it dances are over."""
        is_over = now >= self.plan.ends - SLACK and not self._is_over
        self._is_over |= is_over
        return is_over

    def back(self, now: float) -> DancePlan | None:
        """Return what it does after so many bars, if that is anything else."""
        if not self._goes_back:
            return None
        wish, self._goes_back = self._after, False
        return self.change(wish, now)

    def change(self, wish: DanceRequest, now: float) -> DancePlan:
        """Do something else from now on."""
        goes_back = wish.bars is not None and not wish.is_own
        if goes_back and not self._goes_back:
            self._after = STAND_STILL if self._is_over else self.plan.wish
        self._goes_back, self._is_over, self._paused = goes_back, False, None
        self.plan = self.planned(wish, now)
        return self.plan

    def pause(self, now: float) -> None:
        """Stand still, to go on later with what it dances now."""
        paused = self.plan.wish, self._after, self._goes_back
        self.change(STAND_STILL, now)
        self._paused = paused

    def resume(self, now: float) -> DancePlan | None:
        """Go on after a pause, unless something else was told meanwhile."""
        if self._paused is None:
            return None
        wish, after, goes_back = self._paused
        self.change(wish, now)
        self._after, self._goes_back = after, goes_back
        return self.plan

    def planned(self, wish: DanceRequest, now: float) -> DancePlan:
        """Return what follows from a wish, beginning as soon as can be."""
        if wish.dance is None:
            return DancePlan(wish)
        member, dance = self._words(wish), self.repertoire.dances[wish.dance]
        beat, start = beat_duration(member, dance), now
        if not wish.is_own or member.durations is None or member.tempo_bpm is not None:
            start += _lead(dance) * beat
            if member.beat is not None:
                # Locked to the score it waits for the next beat.
                beats = math.ceil((start - self.member.start) / beat - SLACK)
                start = self.member.start + beats * beat
        return self._planned(wish, start)

    def _planned(self, wish: DanceRequest, start: float) -> DancePlan:
        assert wish.dance is not None
        dance, first = self.repertoire.dances[wish.dance], self.repertoire.first[wish.dance]
        member = self._words(wish).model_copy(update={"start": start})
        beat = beat_duration(member, dance)
        moves = {
            side: [replace(m, subtask=m.subtask + first) for m in rows]
            for side, rows in plan_moves(member, dance, self.until, self.path).items()
        }
        ends = math.inf
        if wish.bars is not None:
            lands = [m.land for rows in moves.values() for m in rows]
            ends = max(lands, default=start)
            if member.durations is None or member.tempo_bpm is not None:
                ends = max(ends, start + wish.bars * dance.length * beat)
        return DancePlan(wish, moves, beat, start, ends)

    def _words(self, wish: DanceRequest) -> Dancer:
        """Return the words of a dancer that dances what is wished."""
        if wish.is_own:
            return self.member
        tempo = wish.tempo or self.member.tempo_bpm
        changed = {"dance": wish.dance, "tempo_bpm": tempo, "durations": None, "bars": wish.bars}
        return self.member.model_copy(update=changed)


def _lead(dance: Dance) -> float:
    """Return how many beats before a dance's first its hands set out at the earliest."""
    early = [dance.subtasks[i].beats - on for i, _, on in subtask_onsets(dance)]
    return max(0.0, *early)
