"""Ordinary: the jump that a pronker makes on level ground, one like the other, and what it takes.

It is rehearsed: the creature hops on level ground with legs that are as strong as need be, until
it lands and leaves the ground as it did the time before.

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
"""Jumps after which one is like the other."""

REHEARSAL_STEP, REHEARSAL_TIMEOUT = 1.0 / 96.0, 20.0
"""Of a rehearsal, and how long a jump is waited for besides its flight [s]."""


@dataclass(frozen=True, slots=True)
class ReferenceJump:
    """A jump of a whole row of them over level ground.

    Attributes:
        rise: of the body from its crouch to its lift-off [m].
        sinks: of the body from its touch-down to its crouch [m].
        push: how long it pushes, with as much force as that takes [s].
        flight: how long it is in the air until all feet touch [s].
        landing: how long it sinks [s].
        push_force, landing_force: of one leg, if all share what there is to do [N].
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
        """Of one leg in all of the jump [N]."""
        return max(self.push_force, self.landing_force)


def rehearse_jump(of: Hopper, level: Ground, as_now: HopSimulation) -> ReferenceJump | None:
    """Return the jump that a creature makes on level ground, None if its legs cannot make it.

    Args:
        of: the creature.
        level: ground without ups and downs.
        as_now: it as it hops in its scene, whose fall it has, though with legs that are strong
            enough it does not.
    """
    words = {name: getattr(of.words, name) for name in ("direction_deg", "turn_deg", "crouch")}
    able = replace(of, words=Pronk(**words), most=math.inf, balance=math.inf, twist=math.inf)
    hopping = HopSimulation(able, level, None, as_now.fall, as_now.limbs)
    until = REHEARSAL_TIMEOUT + REHEARSAL_JUMPS * 2.0 * of.jump.up / GRAVITY
    found: dict[str, HopState] = {}
    while hopping.state.time < until and hopping.state.phase != "fallen":
        hopping.advance(hopping.state.time + REHEARSAL_STEP)
        state = hopping.state
        if state.jumps == REHEARSAL_JUMPS and state.phase in ("landing", "pushing"):
            found[state.phase] = replace(state)
        elif state.jumps > REHEARSAL_JUMPS:
            break
    touches = [h.time for h in hopping.happened if h.kind == "touch"]
    lifts = [h.time for h in hopping.happened if h.kind == "lift"]
    if len(found) < 2 or not touches:
        return None
    return _measure_jump(
        able, found["landing"], found["pushing"], touches[-1] - _last_lift_off(lifts, touches[-1])
    )


def _last_lift_off(lifts: list[float], touch: float) -> float:
    """Return the last lift-off before a touch [s]."""
    return max(time for time in lifts if time < touch)


def _measure_jump(of: Hopper, landing: HopState, pushing: HopState, flight: float) -> ReferenceJump:
    """Return what two phases of constant acceleration say of a jump."""
    fall = GRAVITY * flight - float(landing.lift[1][1])
    a, b = float(landing.a[1]), float(pushing.a[1])
    up = of.jump.up
    return ReferenceJump(
        rise=0.5 * up * up / b,
        sinks=0.5 * fall * fall / a,
        push=up / b,
        flight=flight,
        landing=fall / a,
        push_force=_leg_force(of, pushing),
        landing_force=_leg_force(of, landing),
    )


def _leg_force(of: Hopper, state: HopState) -> float:
    """Return the force of one leg in a phase [N]."""
    force = of.mass.mass * (state.a + np.array([0.0, GRAVITY, 0.0]))
    return float(np.linalg.norm(force)) / len(of.hips)
