"""Step sequencer: the feet of a herd and what plans their steps; `take_steps` moves them."""

from __future__ import annotations

from dataclasses import dataclass, field

from pipeline.simulation.locomotion.foot_placement.barrier_lookahead import (
    BarrierLookahead,
)
from pipeline.simulation.locomotion.foot_placement.foothold_planner import FootholdPlanner
from pipeline.simulation.locomotion.foot_state import FootState
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.route import Route
from pipeline.simulation.locomotion.routes.route_progress import (
    RouteProgress,
)
from pipeline.simulation.locomotion.routes.speed_forecast import SpeedForecast
from pipeline.simulation.locomotion.swing.foot_contacts import FootContacts
from pipeline.simulation.locomotion.swing.swing_planner import SwingPlanner
from pipeline.simulation.take import TakeNote
from pipeline.simulation.troupe import World


@dataclass(frozen=True, eq=False)
class StepSequencer:
    """The feet of a herd and the planners of their steps.

    Attributes:
        world, herd: their constants.
        progress: of the creatures on their routes.
        feet: where they are.
        planner: chooses footholds.
        lookahead: finds barriers.
        swings: plans swings, None if all are plain arches.
        contacts: of the feet with the ground.
        notes: about the last step.
        forecasts: last ones, by creature, with their steps and routes.
    """

    world: World
    herd: Herd
    progress: RouteProgress
    feet: FootState
    planner: FootholdPlanner
    lookahead: BarrierLookahead
    swings: SwingPlanner | None
    contacts: FootContacts
    notes: list[TakeNote] = field(default_factory=list)
    forecasts: dict[int, tuple[tuple[int, Route], SpeedForecast]] = field(default_factory=dict)

    @staticmethod
    def of(
        world: World, progress: RouteProgress, swings: SwingPlanner | None, contacts: FootContacts
    ) -> StepSequencer:
        """Prepare the steps of a herd; its feet are not placed yet."""
        herd = progress.herd
        planner = FootholdPlanner(herd, world.ground, progress.trajectory)
        lookahead = BarrierLookahead(planner.search, progress)
        feet = FootState.of(herd, None if swings is None else swings.no_bends)
        return StepSequencer(world, herd, progress, feet, planner, lookahead, swings, contacts)
