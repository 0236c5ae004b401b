"""Sitting: the pelvis goes back and down to a seat, and comes up again over the feet."""

from __future__ import annotations

from pipeline.simulation.characters.gait import leg_of, speed_of
from pipeline.simulation.characters.record import SITTING
from pipeline.simulation.dynamics.compiled import Record, compiled

TIME = 1.5
"""That it takes to sit down or to stand up [s]."""


@compiled
def sit(person: Record, dt: float) -> None:
    """Go on with sitting down or standing up; nobody begins it before standing still."""
    down = person.posture == SITTING
    stands = not person.stepping and speed_of(person) < 0.04 * leg_of(person)
    if person.frozen or (down and person.seated == 0.0 and not stands):
        return
    step = dt / TIME if down else -dt / TIME
    person.seated = min(max(person.seated + step, 0.0), 1.0)
