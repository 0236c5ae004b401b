"""Dance measurement: a dancer dances alone, and each of its moves is measured."""

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
    """Lets a dancer dance alone.

    Args:
        member: its words.
        dance: what it dances.
        path: of the dancer in its scene, for messages.
        rate: steps of the world a second.
        until: no move begins later [s].

    Raises:
        SceneError: it cannot.
    """
    who = dancer_proportions(member)
    moves = plan_moves(member, dance, until, path)
    choreography = dance_choreography(who, dance, member.dance, member.compensate_gravity)
    one = rehearsed_motion(member, choreography, moves, beat_duration(member, dance), 1.0 / rate)
    last = max((move.land for rows in moves.values() for move in rows), default=0.0)
    count = round((min(last, until) + TAIL_TIME) * rate)
    moving, palms = one.moving, [arm.palm for arm in one.arms]
    rows = [
        (moving.places[palms].copy(), moving.v.copy(), moving.torques(), one.target_distances())
    ]
    for _ in range(count):
        one.advance()
        rows.append(
            (moving.places[palms].copy(), moving.v.copy(), moving.torques(), one.target_distances())
        )
    hands, speeds, torques, distances = (np.array(column) for column in zip(*rows, strict=True))
    times = np.arange(count + 1) / rate
    return DanceRecord(
        times,
        {side: hands[:, k] for k, side in enumerate(HANDS)},
        speeds,
        torques,
        moves,
        distances,
    )


def measure_moves(danced: DanceRecord) -> list[MeasuredMove]:
    """Measures every move of a dancer, in order of time."""
    rows = [(move, side) for side, moves in danced.moves.items() for move in moves]
    rows.sort(key=lambda row: (row[0].land, row[1]))
    return [_measured(danced, move, side) for move, side in rows if _is_seen(danced, move)]


def first_of_each(measured: Sequence[MeasuredMove]) -> dict[int, MeasuredMove]:
    """Returns the first move of each subtask by its number."""
    found: dict[int, MeasuredMove] = {}
    for one in measured:
        found.setdefault(one.subtask, one)
    return found


def same_way(danced: DanceRecord, one: MeasuredMove) -> RetimedPath:
    """Returns the minimum-jerk timing of a move on its own path."""
    return retime_for_minimum_jerk(danced.times, danced.hands[one.side], *one.span)


def _is_seen(danced: DanceRecord, move: Move) -> bool:
    return move.land <= float(danced.times[-1])


def _measured(danced: DanceRecord, move: Move, side: str) -> MeasuredMove:
    times, hand = danced.times, danced.hands[side]
    span = move.begin, move.land
    inside = (times >= move.begin) & (times <= move.land)
    about = (times >= move.land - ARRIVAL_WINDOW) & (times <= move.land + ARRIVAL_WINDOW)
    h = float(times[1] - times[0])
    power = np.abs(danced.torques[inside] * danced.speeds[inside]).sum(axis=1)
    return MeasuredMove(
        move.subtask,
        side,
        span,
        measure_jerk(times, hand, *span),
        minimum_jerk_between(times, hand, *span),
        float(power.sum() * h),
        float(np.abs(danced.torques[inside]).max(initial=0.0)),
        float(danced.distances[about, HANDS.index(side)].min(initial=np.inf)),
    )
