"""Jump summaries: how the creatures of a scene hop on level ground, resolved before it runs.

The jump is rehearsed: the creature hops on level ground with unlimited leg force until each jump is
like the one before.

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
from pipeline.simulation.locomotion.pronking.hopper_troupe import HopperTroupe
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.terrain import Ground, level_ground
from pipeline.spec import Scene
from pipeline.spec.creature import Pronk

CHOSEN_KEYS = ("distance", "height", "speed", "crouch", "max_force", "balance")
"""Keys of `pronk` that an author gives or leaves to be resolved."""

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


@dataclass(frozen=True, slots=True)
class JumpSummary:
    """The resolved jump of one creature.

    Attributes:
        name: of the creature.
        figure: name of its figure.
        mass: [kg].
        weight: [N].
        legs: number of legs.
        leg_length: [m].
        distance, height: of the jump [m].
        speed, up, forward: at lift-off [m/s].
        standing, crouch, lowest: heights of the body [m].
        max_force: of one leg [N].
        balance: moment that the legs can give [N m].
        is_aimed: whether `land_at` decides how far each jump goes.
        asked: keys that the author gave.
        rehearsal: the jump on level ground; None if the legs cannot make it.
    """

    name: str
    figure: str
    mass: float
    weight: float
    legs: int
    leg_length: float
    distance: float
    height: float
    speed: float
    up: float
    forward: float
    standing: float
    crouch: float
    lowest: float
    max_force: float
    balance: float
    is_aimed: bool
    asked: tuple[str, ...]
    rehearsal: ReferenceJump | None


def jump_summaries(scene: Scene) -> list[JumpSummary]:
    """Return the jump summary of every creature of a scene that hops.

    Raises:
        PronkError: the scene cannot start.
    """
    summaries = []
    for troupe in Simulation(scene).troupes:
        if not isinstance(troupe, HopperTroupe):
            continue
        level = level_ground(0.0, troupe.world.ground)
        for c, (hopper, simulation) in enumerate(
            zip(troupe.hoppers, troupe.simulations, strict=True)
        ):
            summaries.append(
                JumpSummary(
                    name=hopper.name,
                    figure=troupe.herd.figures[c].name,
                    mass=hopper.mass.mass,
                    weight=hopper.weight,
                    legs=len(hopper.hips),
                    leg_length=hopper.leg_length,
                    distance=hopper.jump.distance,
                    height=hopper.jump.height,
                    speed=hopper.jump.speed,
                    up=hopper.jump.up,
                    forward=hopper.jump.forward,
                    standing=hopper.standing_height,
                    crouch=hopper.crouch_height,
                    lowest=hopper.lowest_height,
                    max_force=hopper.max_leg_force,
                    balance=hopper.max_balance_moment,
                    is_aimed=bool(hopper.config.land_at),
                    asked=tuple(k for k in CHOSEN_KEYS if getattr(hopper.config, k) is not None),
                    rehearsal=rehearse_jump(hopper, level, simulation),
                )
            )
    return summaries


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
