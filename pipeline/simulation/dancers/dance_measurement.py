"""Records a dancer dancing alone, and measures each move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dancers.dance_goals import dance_choreography
from pipeline.simulation.dancers.dance_moves import Move, beat_duration, plan_moves
from pipeline.simulation.dancers.jerk import Jerk, measure_jerk, minimum_jerk_between
from pipeline.simulation.dancers.minimum_jerk_retiming import (
    RetimedPath,
    retime_for_minimum_jerk,
)
from pipeline.simulation.dancers.practice import rehearsed_motion
from pipeline.simulation.dancers.torso import HANDS, dancer_proportions
from pipeline.simulation.spatial import Array
from pipeline.spec.dance import Dance
from pipeline.spec.dancer import Dancer

ARRIVAL_WINDOW = 0.1
"""Time around the planned arrival in which a hand may reach its target [s]."""

TAIL_TIME = 1.0
"""Recorded time after the last move [s]."""


@dataclass(frozen=True, eq=False)
class DanceRecord:
    """Motion of a dancer.

    Attributes:
        times: (K,) [s].
        hands: side -> (K, 3) centre of the palm in the dancer's frame [m].
        speeds: (K, 20) joint speeds [rad/s].
        torques: (K, 20) joint torques [N m].
        moves: side -> planned moves.
        distances: (K, 2) distance of each palm to the target of its move [m]; 0 before the first.
    """

    times: Array
    hands: dict[str, Array]
    speeds: Array
    torques: Array
    moves: dict[str, list[Move]]
    distances: Array


@dataclass(frozen=True, slots=True)
class MeasuredMove:
    """Measures of one move.

    Attributes:
        subtask: number of the subtask in the dance.
        side: side of the hand.
        span: start and end [s].
        jerk: jerk of the hand.
        floor: least jerk of any move between the same end states [m²/s⁵].
        energy: energy through the joints, ∫ |τ · q'| dt [J].
        torque: largest joint torque [N m].
        missed: least distance of the hand to its target around the arrival [m].
    """

    subtask: int
    side: str
    span: tuple[float, float]
    jerk: Jerk
    floor: float
    energy: float
    torque: float
    missed: float


def record_dance(member: Dancer, dance: Dance, path: str, rate: float, until: float) -> DanceRecord:
    """Records the motion of a dancer that dances alone.

    Args:
        member: configuration of the dancer.
        dance: dance.
        path: path of the dancer in its scene, for messages.
        rate: steps of the world a second.
        until: latest start of a move [s].

    Raises:
        SceneError: The dance cannot be record.
    """
    person = dancer_proportions(member)
    moves = plan_moves(member, dance, until, path)
    choreography = dance_choreography(person, dance, member.dance, member.compensate_gravity)
    motion = rehearsed_motion(member, choreography, moves, beat_duration(member, dance), 1.0 / rate)
    last = max((move.land for rows in moves.values() for move in rows), default=0.0)
    count = round((min(last, until) + TAIL_TIME) * rate)
    moving, palms = motion.moving, [arm.palm for arm in motion.arms]
    rows = []
    for k in range(count + 1):
        if k:
            motion.advance()
        distances = motion.target_distances()
        rows.append((moving.places[palms].copy(), moving.v.copy(), moving.torques(), distances))
    hands, speeds, torques, gaps = (np.array(column) for column in zip(*rows, strict=True))
    times = np.arange(count + 1) / rate
    return DanceRecord(
        times,
        {side: hands[:, k] for k, side in enumerate(HANDS)},
        speeds,
        torques,
        moves,
        gaps,
    )


def measure_moves(record: DanceRecord) -> list[MeasuredMove]:
    """Measures every recorded move, in order of arrival."""
    rows = [(move, side) for side, moves in record.moves.items() for move in moves]
    rows.sort(key=lambda row: (row[0].land, row[1]))
    return [_measured(record, move, side) for move, side in rows if _is_recorded(record, move)]


def first_of_each_subtask(measured: Sequence[MeasuredMove]) -> dict[int, MeasuredMove]:
    """Returns the first move of each subtask, by number."""
    first: dict[int, MeasuredMove] = {}
    for move in measured:
        first.setdefault(move.subtask, move)
    return first


def minimum_jerk_timing(record: DanceRecord, move: MeasuredMove) -> RetimedPath:
    """Returns the minimum-jerk timing of a move on its own path."""
    return retime_for_minimum_jerk(record.times, record.hands[move.side], *move.span)


def _is_recorded(record: DanceRecord, move: Move) -> bool:
    return move.land <= float(record.times[-1])


def _measured(record: DanceRecord, move: Move, side: str) -> MeasuredMove:
    times, hand = record.times, record.hands[side]
    span = move.begin, move.land
    inside = (times >= move.begin) & (times <= move.land)
    about = (times >= move.land - ARRIVAL_WINDOW) & (times <= move.land + ARRIVAL_WINDOW)
    h = float(times[1] - times[0])
    power = np.abs(record.torques[inside] * record.speeds[inside]).sum(axis=1)
    return MeasuredMove(
        move.subtask,
        side,
        span,
        measure_jerk(times, hand, *span),
        minimum_jerk_between(times, hand, *span),
        float(power.sum() * h),
        float(np.abs(record.torques[inside]).max(initial=0.0)),
        float(record.distances[about, HANDS.index(side)].min(initial=np.inf)),
    )
