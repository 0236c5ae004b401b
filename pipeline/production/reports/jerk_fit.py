"""Jerk fit: gains with which a dancer moves more smoothly and still gets where it is to be.

One gain after the other is tried a step higher and lower, and kept where it helps; the steps
become smaller. What is lowered is the mean of the logarithms of the dimensionless jerk over
the subtasks, so that each of them counts alike.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pipeline.production.reports.jerk_trials import dancer_of
from pipeline.production.run.progress import Reporter, stage, step
from pipeline.simulation.dancers.measuring import Measured, dance_through, first_of_each, measure
from pipeline.spec import Dance, Dancer, Scene
from pipeline.spec.dancer import Arms, Gains

STEPS = (1.6, 1.25)
"""Factors by which a gain is made higher or lower, round after round."""

OF = {"joint-torque": ("stiffness", "damping"), "force-field": ("drag", "rate")}
"""Gains that matter to a controller."""

REACHED = 0.02
"""How much farther from its place than before a hand may be [m]."""

STILL = 0.05
"""What goes less far is not measured [m]."""


@dataclass(frozen=True, slots=True)
class Fitted:
    """What came of it.

    Attributes:
        text: for people.
        facts: for programs.
    """

    text: str
    facts: dict[str, Any]


def fit_jerk(scene: Scene, reporter: Reporter) -> Fitted:
    """Find gains that lower the jerk of the first dancer of a scene, as it dances there.

    Raises:
        PronkError: nobody dances, or it cannot.
    """
    i, member, dance = dancer_of(scene)
    until = float(scene.n_frames / scene.rate)
    trial = _Trials(dance, f"cast[{i}]", float(scene.rate * scene.steps), until)
    gains = _gains_of(member)
    with stage(reporter, "fit", 2 * len(gains) * len(STEPS)) as current:
        best, before = member, trial.of(member)
        found, done = before, 0
        for factor in STEPS:
            for gain in gains:
                for by in (factor, 1.0 / factor):
                    other = _changed(best, gain, by)
                    measured = trial.of(other)
                    if _is_better(measured, found, before):
                        best, found = other, measured
                    done += 1
                    step(reporter, current, done)
        current.result = f"danced {done + 1} times"
    return _told(member, best, dance, before, found)


@dataclass(slots=True)
class _Trials:
    dance: Dance
    path: str
    rate: float
    until: float

    def of(self, member: Dancer) -> dict[int, Measured]:
        """Let a dancer dance, and measure each subtask."""
        alone = member.model_copy(update={"bars": 1})
        danced = dance_through(alone, self.dance, self.path, self.rate, self.until)
        return first_of_each(measure(danced))


def _gains_of(member: Dancer) -> list[str]:
    given = member.controller
    used = {given.r, given.l} if isinstance(given, Arms) else {given}
    return [gain for controller in sorted(used) for gain in OF[controller]]


def _changed(member: Dancer, gain: str, by: float) -> Dancer:
    value = round(min(max(getattr(member.gains, gain) * by, 0.05), 20.0), 3)
    return member.model_copy(update={"gains": member.gains.model_copy(update={gain: value})})


def _score(found: dict[int, Measured]) -> float:
    """Return the mean logarithm of the dimensionless jerk."""
    values = [
        math.log(max(one.jerk.dimensionless, 1.0))
        for one in found.values()
        if one.jerk.distance > STILL
    ]
    return sum(values) / max(len(values), 1)


def _is_better(
    other: dict[int, Measured], found: dict[int, Measured], before: dict[int, Measured]
) -> bool:
    reached = all(one.missed <= before[k].missed + REACHED for k, one in other.items())
    return reached and _score(other) < _score(found)


def _told(
    member: Dancer,
    best: Dancer,
    dance: Dance,
    before: dict[int, Measured],
    found: dict[int, Measured],
) -> Fitted:
    changed = {
        name: getattr(best.gains, name)
        for name in Gains.model_fields
        if getattr(best.gains, name) != getattr(member.gains, name)
    }
    words = ", ".join(f"{name}: {value:g}" for name, value in changed.items())
    less = 1.0 - math.exp(_score(found) - _score(before))
    head = f"{member.name}: jerk lower by {100 * less:.0f}% (mean of all subtasks)"
    lines = [f"{head}; write gains: {{{words}}}" if words else f"{member.name}: none is better"]
    lines += [
        f"  {k + 1:2d} {dance.subtasks[k].name:<30} C {before[k].jerk.integral:9.0f} -> "
        f"{one.jerk.integral:9.0f} m²/s⁵, {100 * one.missed:.1f} cm from its place"
        for k, one in sorted(found.items())
    ]
    facts = {"gains": changed, "less": less}
    return Fitted("\n".join(lines), facts)
