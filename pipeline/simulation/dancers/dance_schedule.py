"""Dance schedule: the dance of one dancer over time, as the script changes it."""

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
"""Times nearer than this are the same [s]."""


@dataclass(frozen=True, slots=True)
class DanceRequest:
    """A request to dance.

    Attributes:
        dance: name of the dance; None to stand still.
        tempo: beats a minute; None for the dancer's or the dance's own.
        bars: number of bars; None for no end.
        is_default: whether it is the dance of the cast entry.
    """

    dance: str | None
    tempo: float | None = None
    bars: int | None = None
    is_default: bool = False


STAND_STILL = DanceRequest(None)


@dataclass(frozen=True, slots=True)
class DancePlan:
    """The moves of a request.

    Attributes:
        request: the request.
        moves: moves of each hand, in order of time.
        beat: duration of a beat [s].
        start: time of the first beat [s].
        ends: end of its bars [s].
    """

    request: DanceRequest
    moves: Mapping[str, list[Move]] = field(default_factory=dict)
    beat: float = 1.0
    start: float = 0.0
    ends: float = math.inf


class DanceSchedule:
    """The schedule of a dancer.

    Args:
        member: the dancer in the scene.
        repertoire: all its dances and poses.
        until: latest start of a move [s].
        path: path of the dancer in the scene, for messages.

    Attributes:
        plan: present plan.
        default: request of the cast entry.

    Raises:
        SceneError: if durations and tempo conflict.
    """

    def __init__(self, member: Dancer, repertoire: Repertoire, until: float, path: str) -> None:
        self.member, self.repertoire = member, repertoire
        self.until, self.path = until, path
        self.default = DanceRequest(member.dance, None, member.bars, is_default=True)
        self.plan = self._planned(self.default, member.start)
        self._previous = STAND_STILL
        self._resumes = self._has_ended = False
        self._paused: tuple[DanceRequest, DanceRequest, bool] | None = None

    def has_ended(self, now: float) -> bool:
        """Returns, once, whether the bars of the plan have ended."""
        has_ended = now >= self.plan.ends - SLACK and not self._has_ended
        self._has_ended |= has_ended
        return has_ended

    def resume_previous(self, now: float) -> DancePlan | None:
        """Returns the plan to resume after the bars of a request; None if there is none."""
        if not self._resumes:
            return None
        self._resumes = False
        return self.change(self._previous, now)

    def change(self, request: DanceRequest, now: float) -> DancePlan:
        """Changes to another request."""
        resumes = request.bars is not None and not request.is_default
        if resumes and not self._resumes:
            self._previous = STAND_STILL if self._has_ended else self.plan.request
        self._resumes, self._has_ended, self._paused = resumes, False, None
        self.plan = self.planned(request, now)
        return self.plan

    def pause(self, now: float) -> None:
        """Stands still until `resume`."""
        paused = self.plan.request, self._previous, self._resumes
        self.change(STAND_STILL, now)
        self._paused = paused

    def resume(self, now: float) -> DancePlan | None:
        """Resumes after a pause; None if another request has replaced it."""
        if self._paused is None:
            return None
        request, previous, resumes = self._paused
        self.change(request, now)
        self._previous, self._resumes = previous, resumes
        return self.plan

    def planned(self, request: DanceRequest, now: float) -> DancePlan:
        """Returns the earliest plan of a request."""
        if request.dance is None:
            return DancePlan(request)
        member, dance = self._config(request), self.repertoire.dances[request.dance]
        beat, start = beat_duration(member, dance), now
        if not request.is_default or member.durations is None or member.tempo_bpm is not None:
            start += lead_beats(dance) * beat
            if member.beat is not None:
                # Locked to the score: wait for the next beat.
                beats = math.ceil((start - self.member.start) / beat - SLACK)
                start = self.member.start + beats * beat
        return self._planned(request, start)

    def _planned(self, request: DanceRequest, start: float) -> DancePlan:
        assert request.dance is not None
        dance, first = self.repertoire.dances[request.dance], self.repertoire.first[request.dance]
        member = self._config(request).model_copy(update={"start": start})
        beat = beat_duration(member, dance)
        moves = {
            side: [replace(m, subtask=m.subtask + first) for m in rows]
            for side, rows in plan_moves(member, dance, self.until, self.path).items()
        }
        ends = math.inf
        if request.bars is not None:
            lands = [m.land for rows in moves.values() for m in rows]
            ends = max(lands, default=start)
            if member.durations is None or member.tempo_bpm is not None:
                ends = max(ends, start + request.bars * dance.length * beat)
        return DancePlan(request, moves, beat, start, ends)

    def _config(self, request: DanceRequest) -> Dancer:
        """Returns the dancer's config with the requested dance."""
        if request.is_default:
            return self.member
        tempo = request.tempo or self.member.tempo_bpm
        changed = {
            "dance": request.dance,
            "tempo_bpm": tempo,
            "durations": None,
            "bars": request.bars,
        }
        return self.member.model_copy(update=changed)


def lead_beats(dance: Dance) -> float:
    """Returns the number of beats by which the first move precedes the first beat."""
    early = [dance.subtasks[i].beats - on for i, _, on in subtask_onsets(dance)]
    return max(0.0, *early)
