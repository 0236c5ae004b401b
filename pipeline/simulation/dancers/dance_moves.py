"""Dance moves: start and arrival of each subtask, from the beats or durations of a dance."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.errors import Problem, SceneError
from pipeline.simulation.dancers.torso import HANDS
from pipeline.spec.dance import Dance
from pipeline.spec.dancer import Dancer

SLACK = 1e-6
"""Times nearer than this are the same [s]."""


BarPosition = tuple[int, int, bool]
"""Subtask, index of its beat in the bar, and whether it is in a later bar."""


@dataclass(frozen=True, slots=True)
class Move:
    """One performance of a subtask.

    Attributes:
        subtask: number of the subtask.
        bar: number of the bar, from 0.
        begin: start [s].
        land: arrival [s].
        beat: index of its beat in `on`.
    """

    subtask: int
    bar: int
    begin: float
    land: float
    beat: int = 0

    @property
    def place(self) -> BarPosition:
        """Position in the bar; the first bar is separate, since it starts from rest."""
        return self.subtask, self.beat, self.bar > 0


def beat_duration(dancer: Dancer, dance: Dance) -> float:
    """Returns the duration of a beat [s]."""
    return 60.0 / (dancer.tempo_bpm or dance.tempo_bpm)


def plan_moves(dancer: Dancer, dance: Dance, until: float, path: str) -> dict[str, list[Move]]:
    """Returns the moves of each hand, in order of time.

    Args:
        dancer: the dancer in the scene.
        dance: its dance.
        until: latest start of a move [s].
        path: path of the dancer in the scene, for messages.

    Raises:
        SceneError: if durations and tempo conflict.
    """
    times = _durations(dancer, dance, path)
    found = (
        _by_durations(dancer, dance, times, until)
        if times is not None and dancer.tempo_bpm is None
        else _by_beats(dancer, dance, times, until, path)
    )
    return {side: [m for m in found if dance.subtasks[m.subtask].hand == side] for side in HANDS}


def _durations(dancer: Dancer, dance: Dance, path: str) -> tuple[float | None, ...] | None:
    """Returns the duration of each subtask [s]; None for those left out."""
    given = dancer.durations
    if given is None:
        return None
    if isinstance(given, float | int):
        return (float(given),) * len(dance.subtasks)
    times = dance.durations.get(given) if isinstance(given, str) else given
    if times is None:
        known = ", ".join(dance.durations) or "none"
        message = f"'{dancer.dance}' has no durations called '{given}'; it has {known}"
        raise SceneError([Problem(f"{path}.durations", message)])
    if len(times) != len(dance.subtasks):
        message = f"{len(times)} times are given for the {len(dance.subtasks)} subtasks"
        raise SceneError([Problem(f"{path}.durations", f"{message} of '{dancer.dance}'")])
    return times


def _by_durations(
    dancer: Dancer, dance: Dance, times: tuple[float | None, ...], until: float
) -> list[Move]:
    moves, now, bar = list[Move](), dancer.start, 0
    while now < until and (dancer.bars is None or bar < dancer.bars):
        for i, time in enumerate(times):
            if time is not None and now < until:
                moves.append(Move(i, bar, now, now + time))
                now += time
        bar += 1
    return moves


def _by_beats(
    dancer: Dancer,
    dance: Dance,
    times: tuple[float | None, ...] | None,
    until: float,
    path: str,
) -> list[Move]:
    beat = beat_duration(dancer, dance)
    landings, bar = list[tuple[float, int, int, int]](), 0
    while dancer.bars is None or bar < dancer.bars:
        first = dancer.start + bar * dance.length * beat
        if first > until + dance.length * beat:
            break
        landings += [
            (first + on * beat, i, k, bar)
            for i, k, on in subtask_onsets(dance)
            if times is None or times[i] is not None
        ]
        bar += 1
    landings.sort()
    moves, last = list[Move](), dict.fromkeys(HANDS, 0.0)
    for land, i, k, number in landings:
        subtask = dance.subtasks[i]
        time = subtask.beats * beat
        given = times[i] if times is not None else None
        if given is not None:
            if given > time + SLACK:
                raise SceneError([_conflict(dancer, i, given, time, path)])
            time = given
        begin = max(land - time, last[subtask.hand], 0.0)
        last[subtask.hand] = land
        if begin < until and land - begin > SLACK:
            moves.append(Move(i, number, begin, land, k))
    return moves


def subtask_onsets(dance: Dance) -> list[tuple[int, int, float]]:
    """Returns (subtask, index of its beat, time in beats from the start of the bar)."""
    found, now = list[tuple[int, int, float]](), 0.0
    for i, subtask in enumerate(dance.subtasks):
        if subtask.on is not None:
            found += [(i, k, beat - 1.0) for k, beat in enumerate(subtask.on)]
        else:
            now += subtask.beats
            found.append((i, 0, now))
    return found


def _conflict(dancer: Dancer, i: int, given: float, time: float, path: str) -> Problem:
    message = (
        f"subtask {i + 1} of '{dancer.dance}' takes {given:g} s, but its beats last only "
        f"{time:.3g} s; remove tempo_bpm or durations, or lower the tempo"
    )
    return Problem(f"{path}.tempo_bpm", message)
