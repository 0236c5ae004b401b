"""Jerk fit: gains with which a dancer moves more smoothly and still reaches its places.

Coordinate search: one gain after the other is tried a factor higher and lower and kept where it
helps, with smaller factors round by round. The score is the mean logarithm of the dimensionless
jerk over the subtasks, so that each of them counts alike.
"""

from __future__ import annotations

import math

from pipeline.production.reports.jerk_trials import RESTING_DISTANCE, dancer_of
from pipeline.production.reports.tables import Report
from pipeline.production.run.progress import Reporter, stage
from pipeline.simulation.dance_trials import (
    MeasuredMove,
    first_of_each_subtask,
    measure_moves,
    record_dance,
)
from pipeline.spec import Dance, Dancer, Scene
from pipeline.spec.dancer import Arms, Gains

FACTORS = (1.6, 1.25)
"""Factor of a gain in each round."""

GAINS = {"joint-torque": ("stiffness", "damping"), "force-field": ("drag", "rate")}
"""Gains of each controller."""

MIN_GAIN, MAX_GAIN = 0.05, 20.0

MAX_EXTRA_MISS = 0.02
"""Distance by which a hand may end farther from its place than before [m]."""

Movements = dict[int, MeasuredMove]


def fit_jerk(scene: Scene, reporter: Reporter) -> Report:
    """Return gains that lower the jerk of the first dancer of a scene.

    Raises:
        PronkError: the scene has no dancer, or the dance cannot be danced.
    """
    i, member, dance = dancer_of(scene)
    rate, until = float(scene.rate * scene.steps), float(scene.n_frames / scene.rate)

    def movements_of(dancer: Dancer) -> Movements:
        alone = dancer.model_copy(update={"bars": 1})
        return first_of_each_subtask(
            measure_moves(record_dance(alone, dance, f"cast[{i}]", rate, until))
        )

    gains = _gains_of(member)
    with stage(reporter, "fit", 2 * len(gains) * len(FACTORS)) as current:
        best, before = member, movements_of(member)
        found, done = before, 0
        for factor in FACTORS:
            for gain in gains:
                for ratio in (factor, 1.0 / factor):
                    other = _changed(best, gain, ratio)
                    movements = movements_of(other)
                    if _is_better(movements, found, before):
                        best, found = other, movements
                    done += 1
                    current.advance(done)
        current.result = f"danced {done + 1} times"
    return _report(member, best, dance, before, found)


def _gains_of(member: Dancer) -> list[str]:
    given = member.controller
    used = {given.r, given.l} if isinstance(given, Arms) else {given}
    return [gain for controller in sorted(used) for gain in GAINS[controller]]


def _changed(member: Dancer, gain: str, ratio: float) -> Dancer:
    value = round(min(max(getattr(member.gains, gain) * ratio, MIN_GAIN), MAX_GAIN), 3)
    return member.model_copy(update={"gains": member.gains.model_copy(update={gain: value})})


def _score(movements: Movements) -> float:
    """Return the mean logarithm of the dimensionless jerk."""
    values = [
        math.log(max(movement.jerk.dimensionless, 1.0))
        for movement in movements.values()
        if movement.jerk.distance > RESTING_DISTANCE
    ]
    return sum(values) / max(len(values), 1)


def _is_better(other: Movements, found: Movements, before: Movements) -> bool:
    reached = all(m.missed <= before[k].missed + MAX_EXTRA_MISS for k, m in other.items())
    return reached and _score(other) < _score(found)


def _report(
    member: Dancer, best: Dancer, dance: Dance, before: Movements, found: Movements
) -> Report:
    changed = {
        name: getattr(best.gains, name)
        for name in Gains.model_fields
        if getattr(best.gains, name) != getattr(member.gains, name)
    }
    gains = ", ".join(f"{name}: {value:g}" for name, value in changed.items())
    less = 1.0 - math.exp(_score(found) - _score(before))
    head = f"{member.name}: jerk lower by {100 * less:.0f}% (mean of all subtasks)"
    lines = [f"{head}; write gains: {{{gains}}}" if gains else f"{member.name}: none is better"]
    lines += [
        f"  {k + 1:2d} {dance.subtasks[k].name:<30} C {before[k].jerk.integral:9.0f} -> "
        f"{movement.jerk.integral:9.0f} m²/s⁵, {100 * movement.missed:.1f} cm from its place"
        for k, movement in sorted(found.items())
    ]
    return Report("\n".join(lines), [{"gains": changed, "less": less}])
