"""Measuring: a dancer dances alone, and each of its movements is measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dancers.build import dancer_proportions
from pipeline.simulation.dancers.dance_goals import dance_choreography
from pipeline.simulation.dancers.dance_moves import Move, beat_duration, plan_moves
from pipeline.simulation.dancers.dancer_motion import rehearsed_motion
from pipeline.simulation.dancers.jerk import Jerk, measure_jerk, minimum_jerk_between
from pipeline.simulation.dancers.minimum_jerk_retiming import (
    RetimedPath,
    retime_for_minimum_jerk,
)
from pipeline.simulation.dancers.torso import HANDS
from pipeline.simulation.spatial import Array
from pipeline.spec.dance import Dance
from pipeline.spec.dancer import Dancer

ABOUT = 0.1
"""How much earlier or later than its time a hand may be where it goes [s]."""

AFTER = 1.0
"""How long it is watched after the last move [s]."""


@dataclass(frozen=True, eq=False)
class DanceRecord:
    """What a dancer did.

    Attributes:
        times: (K,) [s].
        hands: side -> (K, 3) middle of the palm, where the dancer stands [m].
        speeds: (K, 20) of the joints [rad/s].
        torques: (K, 20) that drove them [N m].
        moves: side -> what it was to do.
        missed: (K, 2) how far each palm is from where its last move goes, none yet: 0 [m].
    """

    times: Array
    hands: dict[str, Array]
    speeds: Array
    torques: Array
    moves: dict[str, list[Move]]
    missed: Array


@dataclass(frozen=True, slots=True)
class MeasuredMove:
    """One movement.

    Attributes:
        subtask: its number in the dance.
        side: of the hand.
        span: when it begins and when it ends [s].
        jerk: of the hand.
        floor: least that any movement between the same ends has [m²/s⁵].
        energy: that went through the joints, ∫ |τ · q'| dt [J].
        torque: greatest of any joint [N m].
        missed: how far from its place the hand is when it is nearest, about its time [m].
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
    """Let a dancer dance alone.

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
    count = round((min(last, until) + AFTER) * rate)
    moving, palms = one.moving, [arm.palm for arm in one.arms]
    rows = [(moving.places[palms].copy(), moving.v.copy(), moving.torques(), one.missed())]
    for _ in range(count):
        one.advance()
        rows.append((moving.places[palms].copy(), moving.v.copy(), moving.torques(), one.missed()))
    hands, speeds, torques, missed = (np.array(column) for column in zip(*rows, strict=True))
    times = np.arange(count + 1) / rate
    return DanceRecord(
        times, {side: hands[:, k] for k, side in enumerate(HANDS)}, speeds, torques, moves, missed
    )


def measure_moves(danced: DanceRecord) -> list[MeasuredMove]:
    """Measure every move of a dancer, in the order of time."""
    rows = [(move, side) for side, moves in danced.moves.items() for move in moves]
    rows.sort(key=lambda row: (row[0].land, row[1]))
    return [_measured(danced, move, side) for move, side in rows if _is_seen(danced, move)]


def first_of_each(measured: Sequence[MeasuredMove]) -> dict[int, MeasuredMove]:
    """Return the first movement of each subtask, by its number."""
    found: dict[int, MeasuredMove] = {}
    for one in measured:
        found.setdefault(one.subtask, one)
    return found


def same_way(danced: DanceRecord, one: MeasuredMove) -> RetimedPath:
    """Return the timing of least jerk of a movement, on the path on which it was danced."""
    return retime_for_minimum_jerk(danced.times, danced.hands[one.side], *one.span)


def _is_seen(danced: DanceRecord, move: Move) -> bool:
    return move.land <= float(danced.times[-1])


def _measured(danced: DanceRecord, move: Move, side: str) -> MeasuredMove:
    times, hand = danced.times, danced.hands[side]
    span = move.begin, move.land
    inside = (times >= move.begin) & (times <= move.land)
    about = (times >= move.land - ABOUT) & (times <= move.land + ABOUT)
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
        float(danced.missed[about, HANDS.index(side)].min(initial=np.inf)),
    )
