"""Jump summaries: how the creatures of a scene hop on level ground, resolved before it runs."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.simulation.locomotion.pronking.hopper_troupe import HopperTroupe
from pipeline.simulation.locomotion.pronking.reference_jump import (
    ReferenceJump,
    rehearse_jump,
)
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.terrain import level_ground
from pipeline.spec import Scene

CHOSEN_KEYS = ("distance", "height", "speed", "crouch", "max_force", "balance")
"""Keys of `pronk` that an author gives or leaves to be resolved."""


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
