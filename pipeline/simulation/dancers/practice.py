"""Practice: a dancer measures how late its hands arrive, and sets out earlier by that much."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipeline.simulation.dancers.dance_goals import Choreography
from pipeline.simulation.dancers.dance_moves import BarPosition, Move
from pipeline.simulation.dancers.dancer_motion import (
    MATCH_WINDOW,
    TOUCH_TOLERANCE,
    DancerMotion,
)
from pipeline.spec.dancer import Dancer

ROUNDS = 5
"""Largest number of trials."""

BARS = 2
"""Number of bars that are practised."""

CONVERGED = 0.004
"""Largest error of any touch at which practice ends [s]."""

PRACTICE_STEP_RATE = 1000
"""Largest number of steps a second in practice: finer steps then dance the same way."""


def rehearsed_motion(
    config: Dancer,
    choreography: Choreography,
    moves: Mapping[str, Sequence[Move]],
    beat: float,
    dt: float,
) -> DancerMotion:
    """Returns a dancer at its start that has practised the touches of its moves."""
    late = measure_lateness(config, choreography, moves, beat, dt)
    tolerance = TOUCH_TOLERANCE if late else 0.0
    return DancerMotion(config, choreography, moves, beat, dt, late, tolerance)


def measure_lateness(
    config: Dancer,
    choreography: Choreography,
    moves: Mapping[str, Sequence[Move]],
    beat: float,
    dt: float,
) -> dict[BarPosition, float]:
    """Returns how late the hands of a dancer arrive at each touch [s].

    The dancer repeats the first two bars, for the second begins in the postures in which the first
    ends, and keeps the attempt with the smallest error: a hand that grazes its target touches
    early or late but hardly ever in between.
    """
    numbers = {move.subtask for rows in moves.values() for move in rows}
    goals = [choreography.goals[number] for number in sorted(numbers)]
    strikes = any(goal.subtask.on is not None for goal in goals)
    touches = any(goal.surface is not None for goal in goals)
    follows_beats = config.durations is None or config.tempo_bpm is not None
    if not strikes and not (touches and follows_beats):
        return {}
    steps = min(config.steps_a_second, PRACTICE_STEP_RATE)
    config = config.model_copy(update={"steps_a_second": steps})
    late = dict[BarPosition, float]()
    attempts = dict[BarPosition, list[tuple[float, float]]]()
    for _ in range(ROUNDS):
        trial = DancerMotion(config, choreography, moves, beat, dt, late)
        _dance_bars(trial)
        for position, error in trial.timing_errors.items():
            attempts.setdefault(position, []).append((late.get(position, 0.0), error))
        if max(map(abs, trial.timing_errors.values()), default=0.0) < CONVERGED:
            break
        late = {
            position: _next_lead(attempts.get(position, ()), learnt)
            for position, learnt in trial.late.items()
        }
    best = {
        position: min(rows, key=lambda row: (abs(row[1]), row))[0]
        for position, rows in attempts.items()
    }
    # Later bars start with the values of the first.
    return {(subtask, k, True): lead for (subtask, k, _), lead in best.items()} | best


def _next_lead(attempts: Sequence[tuple[float, float]], learnt: float) -> float:
    """Returns the next lead: interpolated between a too small and a too large one.

    Args:
        attempts: (lead, lateness) of earlier trials [s].
        learnt: lead that follows from the last trial alone [s].
    """
    late = max((row for row in attempts if row[1] >= 0.0), default=None)
    early = min((row for row in attempts if row[1] < 0.0), default=None)
    if late is None or early is None or late[0] >= early[0]:
        return learnt
    (low, over), (high, under) = late, early
    return low + (high - low) * over / (over - under)


def _dance_bars(trial: DancerMotion) -> None:
    """Advances a dancer through its bars and the time in which their last touch may come."""
    lands = [m.land for rows in trial.moves for m in rows if m.bar < BARS]
    until = max(lands, default=0.0) + MATCH_WINDOW
    while trial.now < until:
        trial.advance()
