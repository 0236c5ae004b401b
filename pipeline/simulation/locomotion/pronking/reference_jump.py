"""The jump that a hopper makes on level ground, and what it requires of the legs.

It is rehearsed: the creature hops on level ground with unlimited leg force until each jump is like
the one before.

Source: Sims 1987, 9.1 and 11.1 to 11.3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.hop_simulation import HopSimulation
from pipeline.simulation.locomotion.pronking.hop_state import HopState
from pipeline.simulation.locomotion.pronking.hopper import Hopper
from pipeline.simulation.terrain import Ground
from pipeline.spec.creature import Pronk

REHEARSAL_JUMPS = 3
"""Jumps after which they repeat."""

REHEARSAL_STEP, REHEARSAL_TIMEOUT = 1.0 / 96.0, 20.0
"""Step of a rehearsal, and its time limit beside the flights [s]."""


@dataclass(frozen=True, slots=True)
class ReferenceJump:
    """A jump within a regular sequence over level ground.

    Attributes:
        rise: of the body from crouch to lift-off [m].
        sinks: of the body from touch-down to crouch [m].
        push: duration of the push [s].
        flight: duration until all feet touch [s].
        landing: duration of the landing [s].
        push_force, landing_force: of one leg, in equal shares [N].
    """

    rise: float
    sinks: float
    push: float
    flight: float
    landing: float
    push_force: float
    landing_force: float

    @property
    def greatest_force(self) -> float:
        """Greatest force of one leg during the jump [N]."""
        return max(self.push_force, self.landing_force)


def rehearse_jump(hopper: Hopper, level: Ground, simulation: HopSimulation) -> ReferenceJump | None:
    """Return the jump of a creature on level ground; None if its legs cannot make it.

    Args:
        hopper: the creature.
        level: flat ground.
        simulation: the creature in its scene; supplies the fall model.
    """
    config = {
        name: getattr(hopper.config, name) for name in ("direction_deg", "turn_deg", "crouch")
    }
    strong = replace(
        hopper,
        config=Pronk(**config),
        max_leg_force=math.inf,
        max_balance_moment=math.inf,
        max_twist_moment=math.inf,
    )
    rehearsal = HopSimulation(strong, level, None, simulation.fall, simulation.read_joints)
    deadline = REHEARSAL_TIMEOUT + REHEARSAL_JUMPS * 2.0 * hopper.jump.up / GRAVITY
    states: dict[str, HopState] = {}
    while rehearsal.state.time < deadline and rehearsal.state.phase != "fallen":
        rehearsal.advance(rehearsal.state.time + REHEARSAL_STEP)
        state = rehearsal.state
        if state.jump_count == REHEARSAL_JUMPS and state.phase in ("landing", "pushing"):
            states[state.phase] = replace(state)
        elif state.jump_count > REHEARSAL_JUMPS:
            break
    touches = [h.time for h in rehearsal.events if h.kind == "touch"]
    lifts = [h.time for h in rehearsal.events if h.kind == "lift"]
    if len(states) < 2 or not touches:
        return None
    return _measure_jump(
        strong,
        states["landing"],
        states["pushing"],
        touches[-1] - _last_lift_off(lifts, touches[-1]),
    )


def _last_lift_off(lifts: list[float], touch: float) -> float:
    """Return the last lift-off before a touch [s]."""
    return max(time for time in lifts if time < touch)


def _measure_jump(
    hopper: Hopper, landing: HopState, pushing: HopState, flight: float
) -> ReferenceJump:
    """Return the measures of a jump from its two phases of constant acceleration."""
    fall_speed = GRAVITY * flight - float(landing.lift_off[1][1])
    a, b = float(landing.a[1]), float(pushing.a[1])
    up = hopper.jump.up
    return ReferenceJump(
        rise=0.5 * up * up / b,
        sinks=0.5 * fall_speed * fall_speed / a,
        push=up / b,
        flight=flight,
        landing=fall_speed / a,
        push_force=_leg_force(hopper, pushing),
        landing_force=_leg_force(hopper, landing),
    )


def _leg_force(hopper: Hopper, state: HopState) -> float:
    """Return the force of one leg in a phase [N]."""
    force = hopper.mass.mass * (state.a + np.array([0.0, GRAVITY, 0.0]))
    return float(np.linalg.norm(force)) / len(hopper.hips)
